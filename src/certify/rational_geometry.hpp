// Points, planes and polygons in exact rationals: what both verifiers stand on.
#pragma once

#include "certify/certificate.hpp"

namespace antumbra::certify {

using Point = Vec3<Rational>;

/// normal . x = offset; the front is where normal . x > offset.
struct RationalPlane {
    Point normal;
    Rational offset;
    Rational at(const Point& p) const { return dot(normal, p) - offset; }
};

inline Point to_point(const GridPoint& p) { return {Rational(p.x), Rational(p.y), Rational(p.z)}; }

/// The polygon's corners as points, and its plane by Newell's sum, which needs no choice of corners.
inline std::vector<Point> to_points(const Polygon& polygon) {
    std::vector<Point> points;
    for (const GridPoint& corner : polygon.corners)
        points.push_back(to_point(corner));
    return points;
}
inline RationalPlane plane_through(const std::vector<Point>& corners) {
    RationalPlane plane;
    for (std::size_t i = 0; i < corners.size(); ++i)
        plane.normal = plane.normal + cross(corners[i], corners[(i + 1) % corners.size()]);
    plane.offset = dot(plane.normal, corners[0]);
    return plane;
}

/// The part of a convex polygon in front of (or on) a plane. Empty if no corner lies strictly in front.
inline std::vector<Point> part_in_front(const std::vector<Point>& polygon, const RationalPlane& plane) {
    std::vector<Point> part;
    bool any = false;
    for (std::size_t i = 0; i < polygon.size(); ++i) {
        const Point &a = polygon[i], &b = polygon[(i + 1) % polygon.size()];
        Rational at_a = plane.at(a), at_b = plane.at(b);
        any |= at_a > 0;
        if (at_a >= 0)
            part.push_back(a);
        if (at_a * at_b < 0)
            part.push_back(a + (b - a) * Rational(at_a / (at_a - at_b)));
    }
    if (!any)
        part.clear();
    return part;
}

} // namespace antumbra::certify
