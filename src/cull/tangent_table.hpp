// Tangent vertices of an axis-aligned box for the line of an occluder edge, by table look-up (Coorg, Teller 1997,
// section "computing supporting and separating planes").
//
// One end of the edge is taken as the origin. Its place among the 27 regions around the box gives the silhouette of
// the box from there: 4 or 6 vertices. The edge's direction lies on one side or the other of the plane through the
// origin and each silhouette edge; the signs, as a bit code, give the two vertices where the sides change. Those
// carry the two planes through the line of the edge that touch the box.
#pragma once

#include <antumbra/math.hpp>

#include <cstdint>

namespace antumbra {

/// Corner numbers as in Box3::corner. Not valid if the origin is in the box or its line meets the box.
struct Tangents {
    bool valid = false;
    std::uint8_t first = 0, second = 0;
};

Tangents find_tangents(const Box3d& box, const Vec3d& origin, const Vec3d& direction);

/// The same by trying all eight vertices against all others: what the table is measured and tested against.
Tangents find_tangents_naive(const Box3d& box, const Vec3d& origin, const Vec3d& direction);

} // namespace antumbra
