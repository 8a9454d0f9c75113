// Exact tests that decide whether a box lies inside a closed mesh.
#pragma once

#include "occluder_finding/grid_geometry.hpp"

#include <vector>

namespace antumbra {

/// Closed box min..max and triangle have a point in common. Exact for coordinates below 2^26.
bool touches(const grid::Point& min, const grid::Point& max, const grid::Triangle& triangle);

/// The inside of the box (not empty: min < max) and the triangle have a point in common: one that lies in a face of the
/// box does not enter it. Exact for coordinates below 2^26.
bool enters(const grid::Point& min, const grid::Point& max, const grid::Triangle& triangle);

/// No point in common, for certain: a plane between the two, found among those of their faces and those along an edge of
/// each. Triangles of one plane are never found apart. Exact for coordinates below 2^25.
bool are_apart(const grid::Triangle& a, const grid::Triangle& b);

/// Winding number of a closed oriented surface at `point`; undecided (false) if the ray along +x grazes an edge.
/// The surface must not contain the point.
bool winding_number(const grid::Point& point, const std::vector<grid::Triangle>& surface, int& winding);

} // namespace antumbra
