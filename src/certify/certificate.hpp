// Certificates: what an exact bake claims, in a form that can be checked without trusting the solver.
//
// Everything is in grid coordinates (integers, see GridPoint). S is a convex polygon from whose front lines leave,
// T one at whose front they arrive; "front" is the side from which the corners run counter-clockwise.
#pragma once

#include "geometry/pluecker.hpp"

#include <boost/multiprecision/cpp_int.hpp>

#include <cstdint>
#include <string>
#include <vector>

namespace antumbra::certify {

using Integer = boost::multiprecision::cpp_int;
using Rational = boost::multiprecision::cpp_rational;

/// A convex planar polygon, counter-clockwise seen from its front.
struct Polygon {
    std::vector<GridPoint> corners;
    bool both_sides = true; ///< as an occluder: blocks lines from its back too
};

/// "This segment is unblocked": p strictly inside S, q strictly inside T.
struct WitnessSegment {
    Vec3<Rational> p, q;
};

/// "Every line from S to T is blocked": a binary subdivision of line space. Node 0 is the root: all lines from S
/// to T. A split's children hold the lines with line . x >= 0 and line . x <= 0; a leaf is empty of real lines (the
/// quadric keeps one sign on it) or wholly blocked by one occluder.
struct HiddenTree {
    enum class Kind : std::uint8_t { split, empty, blocked };
    struct Node {
        Kind kind = Kind::empty;
        std::array<Integer, 6> hyperplane; ///< split: any hyperplane of Pluecker space, (m, d) of an edge mostly
        std::int32_t child[2] = {-1, -1};  ///< split: the non-negative side first
        std::uint32_t occluder = 0;        ///< blocked: index into the polygons given to the verifier
        std::int8_t crossing = 0;          ///< blocked: +1 the lines cross it from its back, -1 from its front
    };
    std::vector<Node> nodes;
};

} // namespace antumbra::certify
