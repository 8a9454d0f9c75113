// Exact tests that decide whether a box lies inside a closed mesh.
#pragma once

#include "occluder_finding/grid_geometry.hpp"

#include <vector>

namespace antumbra {

/// Closed box min..max and triangle have a point in common. Exact for coordinates below 2^26.
bool touches(const grid::Point& min, const grid::Point& max, const std::array<grid::Point, 3>& triangle);

/// The inside of the box (not empty: min < max) and the triangle have a point in common: one that lies in a face of the
/// box does not enter it. Exact for coordinates below 2^26.
bool enters(const grid::Point& min, const grid::Point& max, const std::array<grid::Point, 3>& triangle);

/// Winding number of a closed oriented surface at `point`; undecided (false) if the ray along +x grazes an edge.
/// The surface must not contain the point.
bool winding_number(const grid::Point& point, const std::vector<std::array<grid::Point, 3>>& surface, int& winding);

} // namespace antumbra
