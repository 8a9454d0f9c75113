#include "certify/rational_geometry.hpp"
#include "certify/verifier.hpp"

namespace antumbra::certify {
namespace {

Status rejected(const std::string& why) { return {ErrorCode::mismatch, "witness rejected: " + why}; }

/// Six times the volume of the tetrahedron, signed.
Rational volume(const Point& a, const Point& b, const Point& c, const Point& d) {
    return dot(cross(b - a, c - a), d - a);
}

/// Is the point, known to lie in the polygon's plane, strictly inside?
bool strictly_inside(const std::vector<Point>& polygon, const RationalPlane& plane, const Point& p) {
    for (std::size_t i = 0; i < polygon.size(); ++i) {
        const Point &a = polygon[i], &b = polygon[(i + 1) % polygon.size()];
        if (dot(plane.normal, cross(b - a, p - a)) <= 0)
            return false;
    }
    return true;
}

/// The same for a segment that lies in the polygon's plane: they are apart iff an edge of the polygon or the segment's own line
/// separates them strictly (the edges of their Minkowski difference are edges of either).
bool meets_in_plane(const std::vector<Point>& polygon, const RationalPlane& plane, const Point& p, const Point& q) {
    bool left = false, right = false; // corners on either side of the segment's line, or on it
    for (std::size_t i = 0; i < polygon.size(); ++i) {
        const Point &a = polygon[i], &b = polygon[(i + 1) % polygon.size()];
        if (dot(plane.normal, cross(b - a, p - a)) < 0 && dot(plane.normal, cross(b - a, q - a)) < 0)
            return false;
        Rational side = dot(plane.normal, cross(q - p, a - p));
        left |= side >= 0;
        right |= side <= 0;
    }
    return left && right;
}

/// Does the closed segment p..q meet the closed convex polygon?
bool meets(const std::vector<Point>& polygon, const RationalPlane& plane, const Point& p, const Point& q) {
    Rational at_p = plane.at(p), at_q = plane.at(q);
    if (at_p == 0 && at_q == 0)
        return meets_in_plane(polygon, plane, p, q);
    if (at_p * at_q > 0)
        return false;
    bool left = false, right = false;
    for (std::size_t i = 0; i < polygon.size(); ++i) {
        Rational v = volume(p, q, polygon[i], polygon[(i + 1) % polygon.size()]);
        left |= v > 0;
        right |= v < 0;
    }
    return !(left && right);
}

} // namespace

Status verify_witness(const Polygon& s, const Polygon& t, std::span<const Polygon> occluders,
                      const WitnessSegment& witness) {
    if (s.corners.size() < 3 || t.corners.size() < 3)
        return rejected("a polygon has fewer than three corners");
    std::vector<Point> source = to_points(s), target = to_points(t);
    RationalPlane source_plane = plane_through(source), target_plane = plane_through(target);
    if (source_plane.at(witness.p) != 0 || !strictly_inside(source, source_plane, witness.p))
        return rejected("its start is not strictly inside the source polygon");
    if (target_plane.at(witness.q) != 0 || !strictly_inside(target, target_plane, witness.q))
        return rejected("its end is not strictly inside the target polygon");
    if (source_plane.at(witness.q) <= 0 || target_plane.at(witness.p) <= 0)
        return rejected("it does not run from front to front");
    for (std::size_t k = 0; k < occluders.size(); ++k) {
        std::vector<Point> whole = to_points(occluders[k]);
        RationalPlane plane = plane_through(whole);
        if (!occluders[k].both_sides && dot(plane.normal, witness.q - witness.p) > 0)
            continue; // comes from its back
        std::vector<Point> part = part_in_front(part_in_front(whole, source_plane), target_plane);
        if (part.size() >= 3 && meets(part, plane, witness.p, witness.q))
            return rejected("occluder " + std::to_string(k) + " is in the way");
    }
    return {};
}

} // namespace antumbra::certify
