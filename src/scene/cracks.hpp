// Cracks between surfaces that were meant to be one: found where snapping opens them, closed where a user asks for it.
#pragma once

#include <antumbra/scene.hpp>

namespace antumbra {

/// Triangles on their way into a Scene: positions in whole steps of its grid, exact in double.
struct GridMesh {
    std::vector<Vec3d> positions;
    std::vector<TriangleIndices> triangles;
    std::vector<std::uint32_t> object_of; ///< per triangle, ascending
};

struct CrackClosing {
    std::uint64_t moved = 0; ///< points that became one with another
    std::uint64_t seals = 0; ///< triangles added
};

/// Closes what gapes by no more than `width` steps between triangles of objects with `occludes` set (by object):
///
/// 1. The ends of open edges (those of one such triangle only) become one where they are nearer than that: each goes to the
///    nearest of those before it, in the order of x, y, z. An end whose triangles would lose their area, or turn over,
///    stays where it is.
/// 2. Where ends of open edges then lie that near to another open edge, between its ends, a fan of triangles joins the edge to
///    these points (a T-junction is closed). It belongs to the object of the edge's triangle, and looks the way that this
///    does.
///
/// Triangles of one object stay together, those of the mesh before the added ones. ErrorCode::usage if more would be added than
/// twice the triangles there are: then the width is no crack's. O(n log n) for widths small against edges. Deterministic.
Result<CrackClosing> close_cracks(GridMesh& mesh, const std::vector<bool>& occludes, double width);

/// Points of a scene before and after snapping.
struct SnappedPoint {
    Vec3d before, after; ///< in steps of the grid, from its origin
    std::uint32_t object = 0;
};

/// How many pairs of places, of different objects, lay nearer than half a step along every axis before snapping, and are two
/// places after it. O(n log n).
struct OpenedCracks {
    std::uint64_t count = 0;
    std::uint32_t a = 0, b = 0; ///< objects of one of them
};
OpenedCracks count_opened_cracks(std::vector<SnappedPoint> points);

} // namespace antumbra
