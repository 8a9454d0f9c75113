// Boxes inside closed meshes: what hides as much as a detailed shell but costs six faces.
#pragma once

#include "occluder_finding/grid_geometry.hpp"

#include <antumbra/occluder_finding.hpp>

#include <vector>

namespace antumbra {

struct InnerBox {
    std::uint32_t object = 0;
    Box3f box;   ///< local, on the grid
    Box3f shell; ///< bounds of the mesh around it
};

struct InnerBoxes {
    std::vector<InnerBox> boxes;
    std::uint64_t closed_objects = 0;
};

/// For objects that occlude, have enough triangles, and whose surface is a closed oriented one (every edge is run
/// through equally often in both directions). A box is certified by two exact tests: no triangle touches it, and
/// the winding number in it is positive (not zero for double-sided objects). Then every line of sight that enters
/// the box from outside the mesh's bounds crosses a drawn front face before.
InnerBoxes find_inner_boxes(const Scene& scene, const std::vector<std::uint32_t>& welded,
                            const OccluderOptions& options);

/// Closed box min..max and triangle have a point in common. Exact for coordinates below 2^26.
bool touches(const grid::Point& min, const grid::Point& max, const std::array<grid::Point, 3>& triangle);

/// Winding number of a closed oriented surface at `point`; undecided (false) if the ray along +x grazes an edge.
/// The surface must not contain the point.
bool winding_number(const grid::Point& point, const std::vector<std::array<grid::Point, 3>>& surface, int& winding);

} // namespace antumbra
