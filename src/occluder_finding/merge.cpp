#include "occluder_finding/merge.hpp"

#include <algorithm>
#include <numeric>

namespace antumbra {
namespace {

using grid::Point;

struct EdgeUse {
    std::uint32_t low, high, polygon;
    bool forward;
};

struct Candidate {
    std::uint32_t a, b;
    std::int64_t length_squared;
};

/// Twice the signed area of (a, b, c) seen against `normal`, along its dominant axis. Fits: differences are below
/// 2^25, products below 2^50.
std::int64_t turn(const Point& a, const Point& b, const Point& c, const Point& normal) {
    auto magnitude = [&](std::size_t k) { return normal[k] < 0 ? -normal[k] : normal[k]; };
    std::size_t axis = magnitude(0) >= magnitude(1) && magnitude(0) >= magnitude(2) ? 0
                       : magnitude(1) >= magnitude(2)                               ? 1
                                                                                    : 2;
    std::size_t u = (axis + 1) % 3, v = (axis + 2) % 3;
    std::int64_t area = (b[u] - a[u]) * (c[v] - b[v]) - (b[v] - a[v]) * (c[u] - b[u]);
    return normal[axis] > 0 ? area : -area;
}

/// Left turn, or straight on.
bool is_convex_corner(const Point& a, const Point& b, const Point& c, const Point& normal) {
    std::int64_t t = turn(a, b, c, normal);
    return t > 0 || (t == 0 && grid::dot(grid::minus(b, a), grid::minus(c, b)) > 0);
}

std::vector<Candidate> candidates(const std::vector<GrowingPolygon>& polygons, const std::vector<Point>& points) {
    std::vector<EdgeUse> uses;
    for (std::uint32_t p = 0; p < polygons.size(); ++p) {
        const std::vector<std::uint32_t>& loop = polygons[p].loop;
        for (std::size_t i = 0; i < loop.size(); ++i) {
            std::uint32_t a = loop[i], b = loop[(i + 1) % loop.size()];
            uses.push_back({std::min(a, b), std::max(a, b), p, a < b});
        }
    }
    std::sort(uses.begin(), uses.end(), [](const EdgeUse& a, const EdgeUse& b) {
        return a.low != b.low ? a.low < b.low : a.high != b.high ? a.high < b.high : a.polygon < b.polygon;
    });
    std::vector<Candidate> found;
    for (std::size_t i = 0; i < uses.size(); ++i)
        for (std::size_t j = i + 1; j < uses.size() && j < i + 8; ++j) {
            if (uses[j].low != uses[i].low || uses[j].high != uses[i].high)
                break;
            const GrowingPolygon& a = polygons[uses[i].polygon];
            const GrowingPolygon& b = polygons[uses[j].polygon];
            if (uses[i].forward == uses[j].forward || a.double_sided != b.double_sided ||
                !grid::same_direction(a.normal, b.normal))
                continue;
            Point edge = grid::minus(points[uses[i].high], points[uses[i].low]);
            found.push_back({uses[i].polygon, uses[j].polygon, static_cast<std::int64_t>(grid::dot(edge, edge))});
        }
    std::sort(found.begin(), found.end(), [](const Candidate& a, const Candidate& b) {
        return a.length_squared != b.length_squared ? a.length_squared > b.length_squared
               : a.a != b.a                         ? a.a < b.a
                                                    : a.b < b.b;
    });
    return found;
}

std::uint32_t root(std::vector<std::uint32_t>& parents, std::uint32_t polygon) {
    while (parents[polygon] != polygon)
        polygon = parents[polygon] = parents[parents[polygon]];
    return polygon;
}

} // namespace

std::vector<std::uint32_t> merged_loop(const std::vector<std::uint32_t>& a, const std::vector<std::uint32_t>& b,
                                       const Point& normal, const std::vector<Point>& points) {
    std::size_t n = a.size(), m = b.size();
    // match[i]: where in b the corner a[i + 1] starts the reverse of the edge a[i] -> a[i + 1]; m: not shared.
    std::vector<std::size_t> match(n, m);
    std::size_t shared = 0;
    for (std::size_t i = 0; i < n; ++i)
        for (std::size_t j = 0; j < m; ++j)
            if (b[j] == a[(i + 1) % n] && b[(j + 1) % m] == a[i]) {
                match[i] = j;
                ++shared;
            }
    std::size_t begin = n;
    for (std::size_t i = 0; i < n; ++i)
        if (match[i] != m && match[(i + n - 1) % n] == m) {
            if (begin != n)
                return {}; // two separate chains: the union would have a hole
            begin = i;
        }
    if (begin == n)
        return {};
    std::vector<std::uint32_t> loop;
    for (std::size_t k = 0; k + shared <= n; ++k)
        loop.push_back(a[(begin + shared + k) % n]);
    // loop now ends with a[begin]; b goes on from there to a[begin + shared], which the loop started with.
    std::size_t at = (match[begin] + 1) % m;
    for (std::size_t k = 1; k + shared < m; ++k)
        loop.push_back(b[(at + k) % m]);
    for (std::size_t i = 0; i < loop.size(); ++i) {
        if (std::count(loop.begin(), loop.end(), loop[i]) != 1)
            return {};
        if (!is_convex_corner(points[loop[i]], points[loop[(i + 1) % loop.size()]],
                              points[loop[(i + 2) % loop.size()]], normal))
            return {};
    }
    return loop;
}

void merge_coplanar(std::vector<GrowingPolygon>& polygons, const std::vector<Point>& points,
                    std::uint32_t most_corners) {
    std::vector<Candidate> list = candidates(polygons, points);
    std::vector<std::uint32_t> parents(polygons.size());
    std::iota(parents.begin(), parents.end(), 0u);
    // A union that is not convex now may be so once a neighbour has filled the notch.
    for (int pass = 0; pass < 4 && !list.empty(); ++pass) {
        std::vector<Candidate> open;
        for (const Candidate& candidate : list) {
            std::uint32_t a = root(parents, candidate.a), b = root(parents, candidate.b);
            if (a == b)
                continue;
            std::vector<std::uint32_t> loop =
                merged_loop(polygons[a].loop, polygons[b].loop, polygons[a].normal, points);
            if (loop.empty() || loop.size() > most_corners) {
                open.push_back(candidate);
                continue;
            }
            polygons[a].loop = std::move(loop);
            polygons[b].loop.clear();
            parents[b] = a;
        }
        if (open.size() == list.size())
            break;
        list = std::move(open);
    }
}

} // namespace antumbra
