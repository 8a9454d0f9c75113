// Simplified shells inside closed dense meshes: rocks, statues, machines that no box fills.
#pragma once

#include "occluder_finding/inside_tests.hpp"

#include <antumbra/occluder_finding.hpp>

#include <vector>

namespace antumbra {

/// Triangles on the grid, each of them inside of what one object encloses.
struct InnerShell {
    std::uint32_t object = 0;
    std::vector<grid::Point> points;
    std::vector<std::array<std::uint32_t, 3>> triangles; ///< counter-clockwise seen from outside
    grid::Point shell_min{}, shell_max{};                ///< bounds of the mesh
    std::uint32_t dropped = 0;                           ///< triangles that could not be certified
};

/// For the `most_solids` largest closed objects that occlude and have at least `inner_shell_least` triangles: the mesh is
/// simplified to about `inner_shell_triangles` by meshoptimizer, its vertices are moved inward by a few times the error
/// and rounded to the grid, and each triangle is certified by exact tests: it has no point in common with any triangle
/// of the mesh, and the winding number at a corner is positive (not zero for double-sided objects). What cannot be
/// certified is dropped; of several distances the one that keeps the largest area is taken. Then every line of sight
/// from outside the mesh's bounds crosses a drawn front face before it meets a triangle.
std::vector<InnerShell> find_inner_shells(const Scene& scene, const std::vector<std::uint32_t>& welded,
                                          const OccluderOptions& options);

} // namespace antumbra
