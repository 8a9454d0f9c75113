#include "occluder_finding/polytope.hpp"

#include <algorithm>
#include <cmath>

namespace antumbra {
namespace {

using grid::Point;
using grid::Triangle;
using grid::Wide;

constexpr std::size_t kMostPoints = 64;

bool is_zero(const Point& p) { return p == Point{0, 0, 0}; }

/// The corners of the plane's points, counter-clockwise seen against `normal`: gift wrapping, which drops points within
/// edges.
std::vector<std::uint32_t> wrap(const std::vector<Point>& points, const std::vector<std::uint32_t>& on, const Point& normal) {
    // The first in the order of coordinates is a corner.
    std::uint32_t first = *std::min_element(on.begin(), on.end(), [&](std::uint32_t a, std::uint32_t b) { return points[a] < points[b]; });
    std::vector<std::uint32_t> loop;
    std::uint32_t at = first;
    do {
        loop.push_back(at);
        std::uint32_t next = at;
        for (std::uint32_t candidate : on) {
            if (candidate == at)
                continue;
            if (next == at) {
                next = candidate;
                continue;
            }
            Point to_next = grid::minus(points[next], points[at]), to_candidate = grid::minus(points[candidate], points[at]);
            Wide side = grid::dot(normal, grid::cross(to_next, to_candidate));
            if (side < 0 || (side == 0 && grid::dot(to_candidate, to_candidate) > grid::dot(to_next, to_next)))
                next = candidate;
        }
        at = next;
    } while (at != first && loop.size() <= on.size());
    return loop;
}

} // namespace

double GridPolytope::worth() const {
    double sum = 0;
    for (const auto& face : faces)
        for (std::size_t i = 2; i < face.size(); ++i) {
            Point n = grid::cross(grid::minus(points[face[i - 1]], points[face[0]]), grid::minus(points[face[i]], points[face[0]]));
            sum += std::sqrt(double(n[0]) * double(n[0]) + double(n[1]) * double(n[1]) + double(n[2]) * double(n[2]));
        }
    return sum / 4;
}

std::optional<GridPolytope> convex_hull(std::vector<Point> points) {
    std::sort(points.begin(), points.end());
    points.erase(std::unique(points.begin(), points.end()), points.end());
    auto count = static_cast<std::uint32_t>(points.size());
    if (count < 4 || count > kMostPoints)
        return {};
    GridPolytope hull;
    std::vector<std::uint32_t> on;
    for (std::uint32_t i = 0; i < count; ++i)
        for (std::uint32_t j = i + 1; j < count; ++j)
            for (std::uint32_t k = j + 1; k < count; ++k) {
                Point normal = grid::cross(grid::minus(points[j], points[i]), grid::minus(points[k], points[i]));
                if (is_zero(normal))
                    continue;
                bool above = false, below = false, is_first = true;
                on.clear();
                for (std::uint32_t p = 0; p < count && !(above && below) && is_first; ++p) {
                    Wide side = grid::dot(normal, grid::minus(points[p], points[i]));
                    above = above || side > 0;
                    below = below || side < 0;
                    if (side != 0)
                        continue;
                    // Each plane once: from its first three points that span it.
                    is_first = !(p < i || (p > i && p < j) ||
                                 (p > j && p < k && !is_zero(grid::cross(grid::minus(points[j], points[i]), grid::minus(points[p], points[i])))));
                    on.push_back(p);
                }
                if ((above && below) || !is_first)
                    continue;
                if (!above && !below)
                    return {};
                hull.faces.push_back(wrap(points, on, above ? Point{-normal[0], -normal[1], -normal[2]} : normal));
            }
    if (hull.faces.empty()) // all on a line
        return {};
    // Only corners of faces are corners of the solid.
    std::vector<std::uint32_t> number(count, ~0u);
    for (auto& face : hull.faces)
        for (std::uint32_t& corner : face) {
            if (number[corner] == ~0u) {
                number[corner] = static_cast<std::uint32_t>(hull.points.size());
                hull.points.push_back(points[corner]);
            }
            corner = number[corner];
        }
    return hull;
}

PolytopeTest::PolytopeTest(const GridPolytope& polytope) : polytope_(polytope), min_(polytope.points[0]), max_(min_) {
    for (const Point& p : polytope.points)
        for (std::size_t k = 0; k < 3; ++k) {
            min_[k] = std::min(min_[k], p[k]);
            max_[k] = std::max(max_[k], p[k]);
        }
    for (const auto& face : polytope.faces) {
        const Point& a = polytope.points[face[0]];
        normals_.push_back(grid::cross(grid::minus(polytope.points[face[1]], a), grid::minus(polytope.points[face[2]], a)));
        for (std::size_t i = 0; i < face.size(); ++i)
            if (std::uint32_t from = face[i], to = face[(i + 1) % face.size()]; from < to)
                edges_.push_back(grid::minus(polytope.points[to], polytope.points[from]));
    }
}

bool PolytopeTest::separates(const Point& axis, const Triangle& triangle) const {
    if (is_zero(axis))
        return false;
    Wide a = grid::dot(axis, triangle[0]), b = grid::dot(axis, triangle[1]), c = grid::dot(axis, triangle[2]);
    Wide low = std::min({a, b, c}), high = std::max({a, b, c});
    bool below = true, above = true; // the solid
    for (const Point& p : polytope_.points) {
        Wide at = grid::dot(axis, p);
        below = below && at <= low;
        above = above && at >= high;
        if (!below && !above)
            return false;
    }
    return true;
}

bool PolytopeTest::is_entered_by(const Triangle& triangle) const {
    for (std::size_t k = 0; k < 3; ++k)
        if (std::max({triangle[0][k], triangle[1][k], triangle[2][k]}) <= min_[k] ||
            std::min({triangle[0][k], triangle[1][k], triangle[2][k]}) >= max_[k])
            return false;
    Point sides[3];
    for (std::size_t c = 0; c < 3; ++c)
        sides[c] = grid::minus(triangle[(c + 1) % 3], triangle[c]);
    if (separates(grid::cross(sides[0], sides[1]), triangle))
        return false;
    for (const Point& normal : normals_)
        if (separates(normal, triangle))
            return false;
    for (const Point& edge : edges_)
        for (const Point& side : sides)
            if (separates(grid::cross(edge, side), triangle))
                return false;
    return true;
}

} // namespace antumbra
