#include "rays/arbiter.hpp"

#include <algorithm>
#include <cmath>
#include <vector>

namespace antumbra {
namespace {

/// How a line, seen as infinite, passes a triangle.
enum class Pass : std::uint8_t {
    misses,   ///< strictly outside
    crosses,  ///< strictly through the interior
    touches,  ///< through an edge or a vertex, not in the plane
    in_plane, ///< lies in the triangle's plane
};

struct Passing {
    Pass pass = Pass::misses;
    int fall =
        0; ///< 1: the line goes from front to back of the triangle, -1: from back to front; 0: in its plane
};

/// One line of sight and what bounds it: the plane of a target, or the point q itself.
class Sight {
  public:
    Sight(const Scene& scene, const Vec3d& p, const Vec3d& q, PredicateTally* tally)
        : scene_(scene), p_(p), q_(q), tally_(tally) {}

    TrianglePoints points(std::uint32_t triangle) const {
        return {scene_.vertex(triangle, 0), scene_.vertex(triangle, 1), scene_.vertex(triangle, 2)};
    }
    int height_of_p(const TrianglePoints& t) const { return orient3d(t.a, t.b, t.c, p_, tally_); }
    int height_of_q(const TrianglePoints& t) const { return orient3d(t.a, t.b, t.c, q_, tally_); }

    Passing passing(const TrianglePoints& t) const {
        // All three negative: the line goes from front to back through the inside.
        int ab = orient3d(p_, q_, t.a, t.b, tally_);
        int bc = orient3d(p_, q_, t.b, t.c, tally_);
        if (ab * bc < 0)
            return {};
        int ca = orient3d(p_, q_, t.c, t.a, tally_);
        int low = std::min({ab, bc, ca}), high = std::max({ab, bc, ca});
        if (low < 0 && high > 0)
            return {};
        int fall = low + high < 0 ? 1 : low + high > 0 ? -1 : 0;
        return {low * high > 0 ? Pass::crosses : fall != 0 ? Pass::touches : Pass::in_plane, fall};
    }

    /// Ends the sight where it meets this triangle's plane.
    void end_at(const TrianglePoints& target) {
        target_ = target;
        at_target_ = true;
    }

    /// What one occluding triangle does to the sight: clear if nothing.
    Verdict blocker(const TrianglePoints& t, bool double_sided) const {
        Passing passing = this->passing(t);
        if (passing.pass == Pass::misses)
            return Verdict::clear;
        if (passing.pass == Pass::in_plane)
            return coplanar_touch(t) ? Verdict::degenerate : Verdict::clear;
        if (!double_sided && passing.fall < 0)
            return Verdict::clear;                 // it shows its back
        int start = height_of_p(t) * passing.fall; // > 0: the plane lies ahead
        if (start < 0)
            return Verdict::clear;
        int order = compare_with_end(t, passing.fall); // of the crossing
        if (order > 0 || (at_target_ && order == 0 && coplanar_with_target(t)))
            return Verdict::clear;
        return passing.pass == Pass::crosses && start > 0 && order < 0 ? Verdict::blocked
                                                                       : Verdict::degenerate;
    }

  private:
    /// Sign of (crossing with t's plane) - (end of the sight).
    int compare_with_end(const TrianglePoints& t, int fall) const {
        if (at_target_)
            return compare_crossings(p_, q_, t, target_, tally_);
        return height_of_q(t) * fall; // still before the plane: the crossing lies beyond
    }

    bool coplanar_with_target(const TrianglePoints& t) const {
        const TrianglePoints& s = target_;
        return orient3d(s.a, s.b, s.c, t.a, tally_) == 0 && orient3d(s.a, s.b, s.c, t.b, tally_) == 0 &&
               orient3d(s.a, s.b, s.c, t.c, tally_) == 0;
    }

    /// The line lies in the plane of `t`: does the closed stretch from p to the end touch the closed
    /// triangle?
    bool coplanar_touch(const TrianglePoints& t) const {
        // Drop an axis along which the triangle keeps its area.
        int axis = 0;
        while (axis < 2 && orient2d(t.a, t.b, t.c, axis, tally_) == 0)
            ++axis;
        const Vec3d* corner[3] = {&t.a, &t.b, &t.c};
        int turn = orient2d(t.a, t.b, t.c, axis, tally_);
        bool p_inside = true, enters = false;
        for (int e = 0; e < 3; ++e) {
            const Vec3d &a = *corner[e], &b = *corner[(e + 1) % 3];
            int start = orient2d(a, b, p_, axis, tally_) * turn; // < 0: p lies outside of this edge
            p_inside = p_inside && start >= 0;
            enters = enters || edge_within(a, b, axis);
        }
        return p_inside || enters;
    }

    /// Does the line meet the closed edge ab at a parameter from 0 to the end?
    bool edge_within(const Vec3d& a, const Vec3d& b, int axis) const {
        int side_a = orient2d(p_, q_, a, axis, tally_), side_b = orient2d(p_, q_, b, axis, tally_);
        if (side_a * side_b > 0 || (side_a == 0 && side_b == 0))
            return false; // beside the edge; or along it, which the two other edges notice
        // Heights over the edge: h(x) = orient2d(a, b, x). The line meets it at t = h(p) / (h(p) - h(q)), and
        // h(p) - h(q) = (b - a) x (p - q) = side(b) - side(a).
        int fall = side_b > side_a ? 1 : -1;
        if (orient2d(a, b, p_, axis, tally_) * fall < 0)
            return false; // behind p
        if (at_target_)
            return compare_edge_crossing(p_, q_, a, b, axis, target_, tally_) <= 0;
        return orient2d(a, b, q_, axis, tally_) * fall <= 0;
    }

    const Scene& scene_;
    Vec3d p_, q_;
    PredicateTally* tally_;
    TrianglePoints target_;
    bool at_target_ = false;
};

/// The worst over all blockers: blocked beats degenerate beats clear.
Verdict judge(const Scene& scene, const Sight& sight, const std::vector<std::uint32_t>& near,
              std::uint32_t target) {
    Verdict verdict = Verdict::clear;
    for (std::uint32_t triangle : near) {
        if (triangle == target)
            continue;
        Verdict one = sight.blocker(sight.points(triangle), scene.object_of(triangle).has(kDoubleSided));
        if (one == Verdict::blocked)
            return one;
        if (one == Verdict::degenerate)
            verdict = one;
    }
    return verdict;
}

/// Not before the point where the ray from p along d meets the triangle, in units of d. Measured along the
/// largest component, where it is well conditioned whatever the angle: a few roundings, which the factor
/// outweighs.
double end_beyond(const TrianglePoints& t, const Vec3d& p, const Vec3d& d) {
    int axis = std::abs(d.x) >= std::max(std::abs(d.y), std::abs(d.z)) ? 0
               : std::abs(d.y) >= std::abs(d.z)                        ? 1
                                                                       : 2;
    double end = std::max({(t.a[axis] - p[axis]) / d[axis], (t.b[axis] - p[axis]) / d[axis],
                           (t.c[axis] - p[axis]) / d[axis], 0.0});
    return end * (1 + 0x1p-48);
}

/// Room for one call's candidates; kept by the thread, so that a verdict does not allocate.
std::vector<std::uint32_t>& candidates() {
    thread_local std::vector<std::uint32_t> near;
    return near;
}

} // namespace

Verdict Arbiter::sees(const Vec3d& eye, const Vec3d& toward, std::uint32_t target,
                      PredicateTally* tally) const {
    const Scene& scene = tracer_.scene();
    if (!in_exact_range(eye) || !in_exact_range(toward) || eye == toward)
        return Verdict::degenerate;
    Sight sight(scene, eye, toward, tally);
    TrianglePoints points = sight.points(target);
    Passing passing = sight.passing(points);
    if (passing.pass == Pass::misses)
        return Verdict::blocked;
    if (passing.pass != Pass::crosses)
        return Verdict::degenerate;
    int start = sight.height_of_p(points) * passing.fall;
    if (start < 0 || (passing.fall < 0 && !scene.object_of(target).has(kDoubleSided)))
        return Verdict::blocked;
    if (start == 0)
        return Verdict::degenerate;
    sight.end_at(points);
    Vec3d direction = toward - eye;
    tracer_.collect_near_ray(eye, direction, end_beyond(points, eye, direction), candidates());
    return judge(scene, sight, candidates(), target);
}

Verdict Arbiter::segment(const Vec3d& p, const Vec3d& q, PredicateTally* tally) const {
    if (!in_exact_range(p) || !in_exact_range(q) || p == q)
        return Verdict::degenerate;
    const Scene& scene = tracer_.scene();
    tracer_.collect_near_ray(p, q - p, 1, candidates());
    return judge(scene, Sight(scene, p, q, tally), candidates(), kNoTriangle);
}

} // namespace antumbra
