// Coplanar triangles to convex polygons.
#pragma once

#include "occluder_finding/grid_geometry.hpp"

#include <vector>

namespace antumbra {

/// A polygon being grown: welded vertices in order, and what must be equal for two to be merged.
struct GrowingPolygon {
    std::vector<std::uint32_t> loop;
    grid::Point normal; ///< of the first triangle, not reduced
    std::uint32_t object = 0;
    bool double_sided = false;
};

/// Merges neighbours greedily, across long edges first, while the union is convex, has no more than `most_corners`
/// corners and lies in one plane exactly. O(n log n) in the number of triangles. Emptied loops were swallowed.
void merge_coplanar(std::vector<GrowingPolygon>& polygons, const std::vector<grid::Point>& points,
                    std::uint32_t most_corners);

/// The union of two convex polygons of one plane that share a chain of edges in opposite directions, if it is
/// convex; else empty.
std::vector<std::uint32_t> merged_loop(const std::vector<std::uint32_t>& a, const std::vector<std::uint32_t>& b,
                                       const grid::Point& normal, const std::vector<grid::Point>& points);

} // namespace antumbra
