// Boxes inside closed meshes: what hides as much as a detailed shell but costs six faces.
#pragma once

#include "occluder_finding/inner_solids.hpp"

#include <antumbra/occluder_finding.hpp>

#include <vector>

namespace antumbra {

/// A box on the grid inside of what one object, or several together, enclose.
struct InnerBox {
    grid::Point min, max;
    grid::Point shell_min, shell_max; ///< bounds of the meshes around it
    std::uint32_t object = 0;         ///< one of them
    std::uint32_t triangles = 0;      ///< of the mesh around it; of several: how many there are, not their triangles
    Opening opening;                  ///< of the meshes; joined ones have all theirs to one side
    double worth() const { // half the surface: what it can hide from somewhere
        double x = double(max[0] - min[0]), y = double(max[1] - min[1]), z = double(max[2] - min[2]);
        return x * y + y * z + z * x;
    }
    bool holds(const InnerBox& other) const {
        for (std::size_t k = 0; k < 3; ++k)
            if (other.min[k] < min[k] || other.max[k] > max[k])
                return false;
        return true;
    }
};

struct InnerBoxes {
    std::vector<InnerBox> boxes;
    std::vector<InnerSolid> solids; ///< oriented boxes and convex solids that hide more than the boxes of their mesh
    std::uint64_t closed_objects = 0;
    std::uint64_t enclosures = 0; ///< these, and groups of objects that are closed together or but for one side
};

/// For enclosures (closed_objects.hpp), the `most_solids` largest of them: up to `boxes_per_solid` boxes each, largest
/// first, and as many convex solids (inner_solids.hpp) for meshes of enough triangles. A box is certified by two exact tests: no
/// triangle enters it, or only such as part it into cells that all pass the second one; and the winding number in it is
/// positive (not zero for double-sided objects). Then almost every line of sight that enters the box from outside the
/// mesh's bounds, on the whole side of an opening, crosses a drawn front face before, or there. `points`: the welded
/// vertices on the grid.
InnerBoxes find_inner_boxes(const Scene& scene, const std::vector<std::uint32_t>& welded,
                            const std::vector<grid::Point>& points,
                            const OccluderOptions& options);

/// Boxes that several boxes cover together, such as a row of houses up to its lowest roof: each box is grown along the
/// axes, in every order, while those of `boxes` cover all of it (decided on whole numbers); what another result holds is left
/// out, and so is what gains little over its best box or has a shell much larger than itself. The `most` largest. Each
/// lies in the union of what encloses the boxes, so that the same holds for lines of sight from outside all of them. O(n
/// log n) for boxes that overlap few others.
std::vector<InnerBox> join_boxes(const std::vector<InnerBox>& boxes, std::uint32_t most);

} // namespace antumbra
