// A convex region that grows from a seed until triangles stop it. Floating point: it proposes.
#pragma once

#include <antumbra/math.hpp>

#include <array>
#include <cstdint>
#include <optional>
#include <vector>

namespace antumbra {

/// Inside: normal . p <= offset. The normal has unit length.
struct HalfSpace {
    Vec3d normal;
    double offset = 0;
    bool on_grid = false; ///< along an axis at a whole number: corners on it need no rounding
};

/// The half-spaces that remain of `bounds` when whatever triangle reaches into them, the nearest to the seed first, has
/// cut off its side. Nothing if more than `most` would be needed. O(triangles * planes^2).
std::optional<std::vector<HalfSpace>> grow_convex(const std::vector<std::array<Vec3d, 3>>& triangles, const Box3d& seed,
                                                  std::vector<HalfSpace> bounds, std::size_t most);

/// Corners of the intersection after planes that are not `on_grid` have moved inward by `inset`; empty if there are none or
/// it is unbounded.
std::vector<Vec3d> corners_of(std::vector<HalfSpace> planes, double inset);

} // namespace antumbra
