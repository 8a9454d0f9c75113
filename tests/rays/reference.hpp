// Brute force in rational numbers (GMP): every triangle, no tree, no filter, and other formulas than the
// library's (parameters and inward edge normals instead of orientation determinants).
#pragma once

#include "rays/arbiter.hpp"

#include <antumbra/scene.hpp>

#include <gmpxx.h>

#include <array>
#include <optional>
#include <vector>

namespace reference {

using antumbra::Scene;
using antumbra::Vec3d;
using antumbra::Verdict;
using Rational = mpq_class;
using Vector = std::array<Rational, 3>;

inline Vector vector(const Vec3d& v) {
    return {Rational(v.x), Rational(v.y), Rational(v.z)};
}
inline Vector minus(const Vector& a, const Vector& b) {
    return {a[0] - b[0], a[1] - b[1], a[2] - b[2]};
}
inline Rational dot(const Vector& a, const Vector& b) {
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}
inline Vector cross(const Vector& a, const Vector& b) {
    return {a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]};
}
inline Vector along(const Vector& p, const Vector& d, const Rational& t) {
    return {p[0] + t * d[0], p[1] + t * d[1], p[2] + t * d[2]};
}

/// A triangle with its normal and, per edge, the in-plane normal that points inward.
struct Triangle {
    std::array<Vector, 3> corner;
    Vector normal;
    std::array<Vector, 3> inward;
    bool double_sided;

    Triangle(const Scene& scene, std::uint32_t t) {
        for (int c = 0; c < 3; ++c)
            corner[std::size_t(c)] = vector(scene.vertex(t, c));
        normal = cross(minus(corner[1], corner[0]), minus(corner[2], corner[0]));
        for (std::size_t e = 0; e < 3; ++e)
            inward[e] = cross(normal, minus(corner[(e + 1) % 3], corner[e]));
        double_sided = scene.object_of(t).has(antumbra::kDoubleSided);
    }
    /// 1 strictly inside, 0 on the border, -1 outside, for a point of the plane.
    int place(const Vector& x) const {
        int place = 1;
        for (std::size_t e = 0; e < 3; ++e)
            place = std::min(place, sgn(dot(inward[e], minus(x, corner[e]))));
        return place;
    }
    /// Parameter of the crossing of p + t d with the plane, if there is exactly one.
    std::optional<Rational> crossing(const Vector& p, const Vector& d) const {
        Rational fall = dot(normal, d);
        if (fall == 0)
            return {};
        return Rational(dot(normal, minus(corner[0], p)) / fall);
    }
    /// For a line within the plane: does the stretch 0 <= t <= end touch the closed triangle?
    bool touched_in_plane(const Vector& p, const Vector& d, Rational end) const {
        Rational begin = 0;
        for (std::size_t e = 0; e < 3; ++e) {
            Rational height = dot(inward[e], minus(p, corner[e])), slope = dot(inward[e], d);
            if (slope == 0) {
                if (height < 0)
                    return false;
                continue;
            }
            Rational t = -height / slope;
            if (slope > 0)
                begin = std::max(begin, t);
            else
                end = std::min(end, t);
        }
        return begin <= end;
    }
    bool coplanar(const Triangle& other) const {
        for (const Vector& x : other.corner)
            if (dot(normal, minus(x, corner[0])) != 0)
                return false;
        return true;
    }
};

/// What one occluding triangle does to the stretch 0..end of the ray.
inline Verdict blocker(const Triangle& triangle, const Vector& p, const Vector& d, const Rational& end,
                       const Triangle* target) {
    std::optional<Rational> t = triangle.crossing(p, d);
    if (!t) {
        bool in_plane = dot(triangle.normal, minus(p, triangle.corner[0])) == 0;
        return in_plane && triangle.touched_in_plane(p, d, end) ? Verdict::degenerate : Verdict::clear;
    }
    int place = triangle.place(along(p, d, *t));
    if (place < 0 || *t < 0 || *t > end)
        return Verdict::clear;
    if (!triangle.double_sided && dot(triangle.normal, d) > 0)
        return Verdict::clear;
    if (target && *t == end && target->coplanar(triangle))
        return Verdict::clear;
    return place > 0 && *t > 0 && *t < end ? Verdict::blocked : Verdict::degenerate;
}

/// The brute-force arbiter of a scene.
class Judge {
  public:
    explicit Judge(const Scene& scene) : scene_(scene) {
        for (std::uint32_t t = 0; t < scene.triangles().size(); ++t)
            triangles_.emplace_back(scene, t);
    }

    Verdict sees(const Vec3d& eye, const Vec3d& toward, std::uint32_t target) const {
        Vector p = vector(eye), d = minus(vector(toward), p);
        const Triangle& triangle = triangles_[target];
        std::optional<Rational> t = triangle.crossing(p, d);
        if (!t)
            return dot(triangle.normal, minus(p, triangle.corner[0])) == 0 ? Verdict::degenerate
                                                                           : Verdict::blocked;
        int place = triangle.place(along(p, d, *t));
        if (place < 0)
            return Verdict::blocked;
        if (place == 0)
            return Verdict::degenerate;
        if (*t < 0 || (!triangle.double_sided && dot(triangle.normal, d) > 0))
            return Verdict::blocked;
        if (*t == 0)
            return Verdict::degenerate;
        return judge(p, d, *t, target, &triangle);
    }

    Verdict segment(const Vec3d& p, const Vec3d& q) const {
        Vector start = vector(p);
        return judge(start, minus(vector(q), start), 1, antumbra::kNoTriangle, nullptr);
    }

  private:
    Verdict judge(const Vector& p, const Vector& d, const Rational& end, std::uint32_t target,
                  const Triangle* target_triangle) const {
        Verdict verdict = Verdict::clear;
        for (std::uint32_t t = 0; t < triangles_.size(); ++t) {
            if (t == target || !scene_.object_of(t).has(antumbra::kOccludes))
                continue;
            Verdict one = blocker(triangles_[t], p, d, end, target_triangle);
            if (one == Verdict::blocked)
                return one;
            if (one == Verdict::degenerate)
                verdict = one;
        }
        return verdict;
    }

    const Scene& scene_;
    std::vector<Triangle> triangles_;
};

} // namespace reference
