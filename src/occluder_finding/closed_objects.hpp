// Objects that enclose something.
#pragma once

#include "occluder_finding/grid_geometry.hpp"

#include <vector>

namespace antumbra {

/// One object on the grid.
struct GridMesh {
    std::vector<grid::Triangle> triangles;
    grid::Point min, max;
};
GridMesh mesh_of(const Scene& scene, const Object& object);

/// Objects that occlude and whose surface is closed and oriented: every edge, of welded vertices, is run through equally
/// often in both directions. Such a surface has a winding number everywhere off itself. The largest first. O(triangles
/// log triangles).
std::vector<std::uint32_t> closed_objects(const Scene& scene, const std::vector<std::uint32_t>& welded);

} // namespace antumbra
