// Objects that enclose something, alone or together.
#pragma once

#include "occluder_finding/grid_geometry.hpp"

#include <vector>

namespace antumbra {

/// One object on the grid, or several.
struct GridMesh {
    std::vector<grid::Triangle> triangles;
    grid::Point min, max;
};
GridMesh mesh_of(const Scene& scene, const Object& object);

/// Where a surface that is not closed ends: all of its boundary lies at or beyond a plane along two of the axes.
struct Opening {
    int axis = -1;        ///< none: the surface is closed
    bool above = true;    ///< the surface is whole above `at`, else below
    std::int64_t at = 0;
    bool is_open() const { return axis >= 0; }
    /// Of the box, what lies on the whole side, one step off the plane. Empty (min >= max) if nothing does.
    void cut(grid::Point& min, grid::Point& max) const;
};

/// Objects whose surfaces together are closed and oriented: every edge, of welded vertices, is run through equally often
/// in both directions; but for an opening that `cap` closes, which nobody sees. Such a surface has a winding number
/// everywhere off itself.
///
/// Why an opening does no harm: a line of sight that begins on the whole side of the opening's plane and ends there does not
/// leave it, and the cap lies beyond. So where it comes from outside of surface and cap to a point of positive winding
/// number, it has crossed a front face that is drawn.
struct Enclosure {
    std::vector<std::uint32_t> objects; ///< ascending
    std::uint32_t triangles = 0;        ///< of the objects
    bool any_winding = false;           ///< all are double-sided
    Opening opening;
    std::vector<grid::Triangle> cap;
    double size = 0; ///< half the surface of the bounds
};
/// Objects and cap.
GridMesh mesh_of(const Scene& scene, const Enclosure& enclosure);

/// Objects that occlude and whose surface is closed by itself. The largest first. O(triangles log triangles).
std::vector<std::uint32_t> closed_objects(const Scene& scene, const std::vector<std::uint32_t>& welded);

/// Those, and of the other objects that occlude the groups that share open edges and are closed together or have an opening
/// to one side that leaves at least half of them. Where a group is neither, its largest object is taken out (terrain that
/// houses stand on) and the rest looked at again. The largest first. O(triangles log triangles).
std::vector<Enclosure> find_enclosures(const Scene& scene, const std::vector<std::uint32_t>& welded,
                                       const std::vector<grid::Point>& points);

} // namespace antumbra
