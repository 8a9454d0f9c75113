#include "certify/cone.hpp"
#include "certify/rational_geometry.hpp"
#include "certify/verifier.hpp"

namespace antumbra::certify {
namespace {

Status rejected(std::size_t node, const std::string& why) {
    return {ErrorCode::mismatch, "hidden certificate rejected at node " + std::to_string(node) + ": " + why};
}

Vector6 to_integers(const std::array<Rational, 6>& values) {
    Integer multiple = 1;
    for (const Rational& v : values)
        multiple = lcm(multiple, denominator(v));
    Vector6 out;
    for (std::size_t k = 0; k < 6; ++k)
        out[k] = numerator(Rational(values[k] * multiple));
    return out;
}

/// The line from a to b as (direction, moment).
Vector6 line_of(const Point& a, const Point& b) {
    Point d = b - a, m = cross(a, b);
    return to_integers({d.x, d.y, d.z, m.x, m.y, m.z});
}

/// Twice the value of the quadric's bilinear form: zero iff two lines meet.
Integer bilinear(const Vector6& a, const Vector6& b) {
    return a[0] * b[3] + a[1] * b[4] + a[2] * b[5] + a[3] * b[0] + a[4] * b[1] + a[5] * b[2];
}

/// Is the quadratic form with these values nonnegative on all nonnegative weights of three rays? Each pair is known
/// to be fine. If it is negative anywhere it is so at a stationary point inside: the solution of M w = -(1,1,1)
/// with all weights positive (then w M w = -sum w < 0).
bool triple_is_nonnegative(const Integer (&m)[3][3]) {
    Integer det = 0, minor[3][3];
    for (int i = 0; i < 3; ++i)
        for (int j = 0; j < 3; ++j) {
            int a = (i + 1) % 3, b = (i + 2) % 3, c = (j + 1) % 3, d = (j + 2) % 3;
            minor[i][j] = m[a][c] * m[b][d] - m[a][d] * m[b][c];
        }
    for (int j = 0; j < 3; ++j)
        det += m[0][j] * minor[0][j];
    if (det == 0)
        return true; // a singular form that dips inside dips on a pair too
    for (int i = 0; i < 3; ++i) {
        Integer w = -(minor[i][0] + minor[i][1] + minor[i][2]);
        if (det < 0)
            w = -w;
        if (w <= 0)
            return true;
    }
    return false;
}

/// Does sign * quadric stay nonnegative on the cone of the rays? (Extrema lie on faces of at most three rays.)
bool nonnegative(const std::vector<Vector6>& rays, int sign) {
    std::size_t n = rays.size();
    std::vector<std::vector<Integer>> m(n, std::vector<Integer>(n));
    for (std::size_t i = 0; i < n; ++i)
        for (std::size_t j = i; j < n; ++j)
            m[i][j] = m[j][i] = sign * bilinear(rays[i], rays[j]);
    for (std::size_t i = 0; i < n; ++i)
        if (m[i][i] < 0)
            return false;
    for (std::size_t i = 0; i < n; ++i)
        for (std::size_t j = i + 1; j < n; ++j)
            if (m[i][j] < 0 && m[i][j] * m[i][j] > m[i][i] * m[j][j])
                return false;
    for (std::size_t i = 0; i < n; ++i)
        for (std::size_t j = i + 1; j < n; ++j)
            for (std::size_t k = j + 1; k < n; ++k) {
                int negative = (m[i][j] < 0) + (m[i][k] < 0) + (m[j][k] < 0);
                if (negative < 2)
                    continue;
                Integer part[3][3] = {{m[i][i], m[i][j], m[i][k]}, {m[j][i], m[j][j], m[j][k]},
                                      {m[k][i], m[k][j], m[k][k]}};
                if (!triple_is_nonnegative(part))
                    return false;
            }
    return true;
}

/// Do all lines of the cone cross this polygon, in this direction?
bool all_cross(const std::vector<Vector6>& rays, const std::vector<Point>& polygon, int crossing) {
    for (std::size_t e = 0; e < polygon.size(); ++e) {
        Vector6 edge = line_of(polygon[e], polygon[(e + 1) % polygon.size()]);
        for (const Vector6& ray : rays)
            if (crossing * bilinear(edge, ray) < 0)
                return false;
    }
    return true;
}

/// The cone of all lines from one polygon to the other: first the dual cone of functionals that are nonnegative on
/// the corner lines, whose rays are the facets; then the cone that those facets bound.
Cone cone_of_lines(const std::vector<Point>& source, const std::vector<Point>& target) {
    Cone dual;
    for (const Point& p : source)
        for (const Point& q : target)
            dual.insert(line_of(p, q));
    Cone cone;
    for (const Vector6& facet : dual.rays())
        cone.insert(facet);
    for (const Vector6& equality : dual.lines()) {
        cone.insert(equality);
        Vector6 opposite = equality;
        for (Integer& c : opposite)
            c = -c;
        cone.insert(opposite);
    }
    return cone;
}

} // namespace

Status verify_hidden(const Polygon& s, const Polygon& t, std::span<const Polygon> occluders,
                     const HiddenTree& tree) {
    if (s.corners.size() < 3 || t.corners.size() < 3)
        return rejected(0, "a polygon has fewer than three corners");
    std::vector<Point> source = to_points(s), target = to_points(t);
    RationalPlane source_plane = plane_through(source), target_plane = plane_through(target);
    source = part_in_front(source, target_plane);
    target = part_in_front(target, source_plane);
    if (source.size() < 3 || target.size() < 3)
        return {}; // nothing of them faces each other
    if (tree.nodes.empty())
        return rejected(0, "the tree is empty");

    std::vector<std::vector<Point>> parts(occluders.size());
    for (std::size_t k = 0; k < occluders.size(); ++k)
        parts[k] = part_in_front(part_in_front(to_points(occluders[k]), source_plane), target_plane);

    std::vector<bool> reached(tree.nodes.size(), false);
    std::vector<std::pair<std::size_t, Cone>> open;
    open.emplace_back(0, cone_of_lines(source, target));
    while (!open.empty()) {
        auto [at, cone] = std::move(open.back());
        open.pop_back();
        if (reached[at])
            return rejected(at, "reached twice");
        reached[at] = true;
        const HiddenTree::Node& node = tree.nodes[at];
        switch (node.kind) {
        case HiddenTree::Kind::split:
            for (int side = 0; side < 2; ++side) {
                auto child = static_cast<std::size_t>(node.child[side]);
                if (node.child[side] < 0 || child >= tree.nodes.size())
                    return rejected(at, "a child is missing");
                Vector6 half = node.hyperplane;
                if (side == 1)
                    for (Integer& c : half)
                        c = -c;
                Cone part = cone;
                part.insert(half);
                open.emplace_back(child, std::move(part));
            }
            break;
        case HiddenTree::Kind::empty:
            if (!cone.lines().empty() || !(nonnegative(cone.rays(), 1) || nonnegative(cone.rays(), -1)))
                return rejected(at, "it is said to be empty, but real lines cross it");
            break;
        case HiddenTree::Kind::blocked:
            if (node.occluder >= occluders.size() || (node.crossing != 1 && node.crossing != -1))
                return rejected(at, "it names no occluder");
            if (node.crossing == 1 && !occluders[node.occluder].both_sides)
                return rejected(at, "a single-sided occluder does not block lines from its back");
            if (parts[node.occluder].size() < 3 || !cone.lines().empty() ||
                !all_cross(cone.rays(), parts[node.occluder], node.crossing))
                return rejected(at, "occluder " + std::to_string(node.occluder) + " does not block all of it");
            break;
        default:
            return rejected(at, "unknown kind");
        }
    }
    return {};
}

} // namespace antumbra::certify
