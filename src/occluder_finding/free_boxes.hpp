// The largest boxes inside of a closed mesh, found on cells of its bounds.
#pragma once

#include "occluder_finding/closed_objects.hpp"

#include <vector>

namespace antumbra {

struct GridBox {
    grid::Point min, max;
    double worth() const { // half the surface: what it can hide from somewhere
        double x = double(max[0] - min[0]), y = double(max[1] - min[1]), z = double(max[2] - min[2]);
        return x * y + y * z + z * x;
    }
};

/// Up to `most` boxes, largest first, none below a fifth of the first. The bounds are cut into at most `resolution` cells a
/// side; a cell is free if no triangle enters it and its winding number is positive (`any_winding`: not zero); the largest box
/// of free cells is taken, again and again, and its faces are pushed outward while no triangle enters. Exact: the inside of
/// each box has the winding number of the inside almost everywhere. O(triangles * cells that they touch).
std::vector<GridBox> largest_free_boxes(const GridMesh& mesh, std::uint32_t resolution, bool any_winding,
                                        std::uint32_t most);

} // namespace antumbra
