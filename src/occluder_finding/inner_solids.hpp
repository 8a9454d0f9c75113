// Convex solids inside closed meshes: oriented boxes, and what grows until the mesh's own planes stop it.
#pragma once

#include "occluder_finding/free_boxes.hpp"
#include "occluder_finding/polytope.hpp"

#include <antumbra/occluder_finding.hpp>

#include <vector>

namespace antumbra {

/// A convex solid on the grid inside of what some objects enclose.
struct InnerSolid {
    GridPolytope shape;
    grid::Point shell_min, shell_max; ///< bounds of the meshes around it
    Opening opening;
    std::uint32_t object = 0; ///< one of them
    bool is_box = false;      ///< an oriented box, but for rounding
};

/// Up to `boxes_per_solid` solids, the one of the largest surface first, none of which hides less than 1.2 times what the
/// largest of `boxes` (those found along the axes) does.
///
/// Frames: the directions of the mesh's normals, three at right angles that hold most of its area. In each frame the
/// largest free boxes are looked for as along the axes. Each of all these boxes, shrunk to half, is a seed: it grows to
/// the bounds of the mesh, and while a triangle reaches into what is left, the nearest one to the seed cuts it off: by its own
/// plane if the seed lies behind that, else by the plane halfway round (Deits, Tedrake 2015: planes of tangency). Corners
/// are rounded to the grid. All this is floating point and proposes; a solid counts if, by exact tests, no triangle enters
/// the hull of its corners and the winding number inside is positive (`any_winding`: not zero).
std::vector<InnerSolid> find_inner_solids(const Enclosure& enclosure, const GridMesh& mesh,
                                          const std::vector<GridBox>& boxes, const OccluderOptions& options);

} // namespace antumbra
