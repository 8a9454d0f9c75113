// The sides of a line on which the corners of a polygon certainly lie. All kernels do the same operations in the same order
// for each corner: their answers are identical bit for bit.
#pragma once

#include <antumbra/math.hpp>

#include <cstdint>

namespace antumbra {

struct PicturePolygon;

/// A line as the filter sees it: the value n . d of a corner is certain where it exceeds
/// corner.size * size_factor + corner.error * error_factor.
struct LineFilter {
    Vec3d n;
    double size_factor, error_factor;
};

/// A bit per corner. Corners in neither are for exact numbers.
struct SideMasks {
    std::uint64_t positive, negative;
};

using SideKernel = SideMasks (*)(const LineFilter& line, const PicturePolygon& polygon);

SideMasks certain_sides_scalar(const LineFilter& line, const PicturePolygon& polygon);

enum class SideKernelKind : std::uint8_t { best, scalar, avx2, avx512 };

/// nullptr if the processor lacks it.
SideKernel side_kernel(SideKernelKind kind);

} // namespace antumbra
