// What the k occluders hide of a box, by brute force in rational arithmetic: every face that the eye sees, minus the
// shadow of every occluder. Shares nothing with the tree: no picture, no lines, polygons in space.
#pragma once

#include <antumbra/math.hpp>

#include "occlusion_tree/occlusion_tree.hpp"

#include <gmpxx.h>

#include <algorithm>
#include <cmath>
#include <optional>
#include <vector>

namespace antumbra::test {

using Number = mpq_class;
struct Point {
    Number x, y, z;
    Number& operator[](int i) { return i == 0 ? x : i == 1 ? y : z; }
    const Number& operator[](int i) const { return i == 0 ? x : i == 1 ? y : z; }
};
inline Point minus(const Point& a, const Point& b) { return {a.x - b.x, a.y - b.y, a.z - b.z}; }
inline Number dot(const Point& a, const Point& b) { return a.x * b.x + a.y * b.y + a.z * b.z; }
inline Point cross(const Point& a, const Point& b) {
    return {a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x};
}
inline Point exactly(const Vec3d& p) { return {p.x, p.y, p.z}; }

using Loop = std::vector<Point>;

struct HalfSpace {
    Point normal, at;
    double n[3] = {0, 0, 0}, offset = 0; ///< rounded, see is_far_outside()
    Number value(const Point& p) const { return dot(normal, minus(p, at)); }
    void round() {
        for (int i = 0; i < 3; ++i)
            n[i] = normal[i].get_d();
        offset = dot(normal, at).get_d();
    }
};

/// Beyond the plane by far more than doubles can be wrong: then the shadow takes nothing, and no rational number is needed to
/// say so. That is so for most pairs.
inline bool is_far_outside(const Loop& polygon, const HalfSpace& plane) {
    for (const Point& p : polygon) {
        double sum = -plane.offset, size = std::abs(plane.offset);
        for (int i = 0; i < 3; ++i) {
            double product = plane.n[i] * p[i].get_d();
            sum += product;
            size += std::abs(product);
        }
        if (!(sum < -1e-9 * size))
            return false;
    }
    return true;
}

/// The part with sign * value >= 0; empty unless some corner is strictly there.
inline Loop part(const Loop& polygon, const HalfSpace& plane, int sign) {
    Loop result;
    bool any = false;
    std::vector<Number> values;
    for (const Point& p : polygon)
        values.push_back(plane.value(p) * sign);
    for (std::size_t i = 0; i < polygon.size(); ++i) {
        std::size_t j = (i + 1) % polygon.size();
        any |= values[i] > 0;
        if (values[i] >= 0)
            result.push_back(polygon[i]);
        if (sgn(values[i]) * sgn(values[j]) < 0) {
            Number t = values[i] / (values[i] - values[j]);
            Point d = minus(polygon[j], polygon[i]);
            result.push_back({polygon[i].x + d.x * t, polygon[i].y + d.y * t, polygon[i].z + d.z * t});
        }
    }
    if (!any)
        result.clear();
    return result;
}

/// The occluder's frustum behind its plane, open; nullopt if the eye is not strictly on a blocking side.
inline std::optional<std::vector<HalfSpace>> shadow_of(const Loop& loop, bool double_sided, const Point& eye) {
    Point normal{0, 0, 0};
    for (std::size_t i = 1; i + 1 < loop.size(); ++i) {
        Point n = cross(minus(loop[i], loop[0]), minus(loop[i + 1], loop[0]));
        normal = {normal.x + n.x, normal.y + n.y, normal.z + n.z};
    }
    Number before = dot(normal, minus(eye, loop[0]));
    if (before == 0 || (before < 0 && !double_sided))
        return std::nullopt;
    std::vector<HalfSpace> shadow;
    Point inner = loop[0]; // strictly inside the loop
    for (std::size_t i = 1; i < loop.size(); ++i)
        inner = {inner.x + loop[i].x, inner.y + loop[i].y, inner.z + loop[i].z};
    auto n = static_cast<unsigned long>(loop.size());
    inner = {inner.x / n, inner.y / n, inner.z / n};
    int side = before > 0 ? -1 : 1;
    shadow.push_back({{normal.x * side, normal.y * side, normal.z * side}, loop[0]});
    for (std::size_t i = 0; i < loop.size(); ++i) {
        Point a = minus(loop[i], eye), b = minus(loop[(i + 1) % loop.size()], eye);
        HalfSpace plane{cross(a, b), eye};
        int sign = sgn(plane.value(inner));
        plane.normal = {plane.normal.x * sign, plane.normal.y * sign, plane.normal.z * sign};
        shadow.push_back(plane);
    }
    for (HalfSpace& plane : shadow)
        plane.round();
    return shadow;
}

struct OracleAnswer {
    Visibility visibility = Visibility::partial;
    std::vector<Loop> unblocked; ///< of the faces
    bool has_faces = false;      ///< false: nothing of the box has extent in the picture, nothing is known
};

inline OracleAnswer ask_oracle(const Box3d& box, const Vec3d& eye, const std::vector<std::vector<HalfSpace>>& shadows) {
    OracleAnswer answer;
    if (box.contains(eye))
        return answer;
    bool removed = false;
    for (int axis = 0; axis < 3; ++axis) {
        int b = (axis + 1) % 3, c = (axis + 2) % 3;
        bool below = eye[axis] < box.min[axis];
        if ((!below && !(eye[axis] > box.max[axis])) || !(box.min[b] < box.max[b]) || !(box.min[c] < box.max[c]))
            continue;
        answer.has_faces = true;
        Loop face;
        for (int i = 0; i < 4; ++i) {
            Vec3d p;
            p[axis] = below ? box.min[axis] : box.max[axis];
            p[b] = i == 1 || i == 2 ? box.max[b] : box.min[b];
            p[c] = i >= 2 ? box.max[c] : box.min[c];
            face.push_back(exactly(p));
        }
        std::vector<Loop> pieces{face};
        for (const std::vector<HalfSpace>& shadow : shadows) {
            std::vector<Loop> left;
            for (Loop& piece : pieces) {
                if (std::any_of(shadow.begin(), shadow.end(), [&](const HalfSpace& plane) { return is_far_outside(piece, plane); })) {
                    left.push_back(std::move(piece));
                    continue;
                }
                Loop rest = piece;
                std::vector<Loop> outer;
                for (const HalfSpace& plane : shadow) {
                    Loop outside = part(rest, plane, -1), inside = part(rest, plane, 1);
                    rest = inside;
                    if (rest.empty())
                        break;
                    if (!outside.empty())
                        outer.push_back(std::move(outside));
                }
                if (rest.empty()) {
                    left.push_back(std::move(piece)); // untouched
                } else {
                    removed = true;
                    left.insert(left.end(), outer.begin(), outer.end());
                }
            }
            pieces = std::move(left);
        }
        answer.unblocked.insert(answer.unblocked.end(), pieces.begin(), pieces.end());
    }
    if (answer.has_faces)
        answer.visibility = answer.unblocked.empty() ? Visibility::invisible : removed ? Visibility::partial : Visibility::full;
    return answer;
}

} // namespace antumbra::test
