// The two polygons of a query, made ready: moved to a common origin, clipped to the fronts of each other, their
// planes, corners, edges and corner lines.
#pragma once

#include "bake/exact/line_store.hpp"

#include <span>
#include <vector>

namespace antumbra::exact {

/// n . x = c, with n primitive. Coordinates of the frame: |x| <= 2^25, |n| < 2^52, |c| < 2^79.
struct GridPlane {
    Vec3<std::int64_t> n;
    Int128 c = 0;

    Int128 at(const GridPoint& p) const {
        return static_cast<Int128>(n.x) * p.x + static_cast<Int128>(n.y) * p.y + static_cast<Int128>(n.z) * p.z - c;
    }
    Integer at(const Homogeneous& p) const { return p[0] * n.x + p[1] * n.y + p[2] * n.z - p[3] * Integer(c); }
};

/// The plane of a polygon; n is zero if all corners are collinear. `triple`: three corners that span it.
GridPlane plane_of(std::span<const GridPoint> corners, std::size_t (&triple)[3]);

/// The line where two planes meet, directed along a.n x b.n: of it, a's front lies to the left in b's plane seen
/// from b's front.
Six meet(const GridPlane& a, const GridPlane& b);

/// The line through two homogeneous points.
Six line_through(const Homogeneous& p, const Homogeneous& q);

/// One polygon of the pair.
struct Face {
    std::vector<GridPoint> corners; ///< in the frame, unclipped
    GridPlane plane;
    std::size_t triple[3] = {0, 1, 2};
    std::vector<Homogeneous> clipped; ///< corners of the part in front of the other plane
    std::vector<int> edge;            ///< per clipped corner: index of the original edge that leaves it, -1: the cut
    std::vector<bool> touches;        ///< per clipped corner: lies in the other plane
    bool is_clipped = false;
    std::vector<HalfSpace> half_spaces; ///< per clipped edge: where lines must be to cross the polygon
};

struct Frame {
    GridPoint origin;
    int scale_bits = 1; ///< coordinates of S and T in the frame are below 2^scale_bits
    Face s, t;
    Six common_line;          ///< where the planes of S and T meet
    HyperplaneId common = -1; ///< its hyperplane, if some clipped polygon has an edge on it
    std::vector<VertexId> lines; ///< line from corner i of S to corner j of T: lines[i * t.clipped.size() + j]

    /// False if no line leaves the front of S for the front of T: nothing is left of one of them.
    bool set(std::span<const GridPoint> s_corners, std::span<const GridPoint> t_corners);
    /// Registers edges and corner lines.
    template <bool F>
    void fill(LineStore<F>& store);

    /// Planes of the convex hull of S and T, each with all of both behind or on it, and the planes of S and T, turned.
    std::vector<GridPlane> planes_around() const;

    VertexId line(std::size_t i, std::size_t j) const { return lines[i * t.clipped.size() + j]; }
    bool s_touches() const;
    bool t_touches() const;
};

} // namespace antumbra::exact
