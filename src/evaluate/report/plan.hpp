// The scene from above, cut open a little over the viewer's head, so that a walk through rooms is seen in them.
#pragma once

#include "rays/tracer.hpp"

#include <antumbra/evaluate.hpp>

#include <string>
#include <vector>

namespace antumbra {

/// One cut. Pixel (i, j) looks straight down at local x = x0 + (i + 0.5) * scale, z = z0 + (j + 0.5) * scale.
struct Plan {
    std::uint32_t width = 0, height = 0;
    double x0 = 0, z0 = 0, scale = 1;
    double cut = 0; ///< local height of the cut
    /// Pixels row by row as runs, each two numbers: 0 for nothing, else 1 + 8 * object + shade, then the length.
    /// Shades go from 0 (steep) to 6 (level); 7 is matter that the cut runs through. Numbers are little-endian
    /// groups of seven bits, the top bit set on all but the last.
    std::vector<std::byte> runs;
};

struct Plans {
    bool outdoors = false;               ///< seen whole from above, without a cut
    std::vector<Plan> plans;             ///< at most seven
    std::vector<std::uint32_t> of_frame; ///< which plan belongs to each frame
};

Plans make_plans(const Tracer& tracer, const WalkResult& result, std::uint32_t pixels, const Job& job);

} // namespace antumbra
