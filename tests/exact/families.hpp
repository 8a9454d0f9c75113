// Families of exact queries with known or comparable answers (docs/methods/exact.md, "Tests").
#pragma once

#include "base/random.hpp"
#include "bake/exact/query.hpp"
#include "certify/verifier.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <string>
#include <vector>

namespace antumbra::exact::testing {

using certify::Polygon;

struct Case {
    std::vector<GridPoint> s, t;
    std::vector<Polygon> occluders;
};

inline constexpr std::int64_t kOne = 1 << 20;

inline GridPoint grid(double x, double y, double z) {
    return {std::llround(x * kOne), std::llround(y * kOne), std::llround(z * kOne)};
}

inline bool has_area(const std::vector<GridPoint>& p) {
    GridPoint n = cross(p[1] - p[0], p[2] - p[0]);
    return n.x != 0 || n.y != 0 || n.z != 0;
}

/// Turns a polygon so that more of `other` lies in front of it than behind.
inline void face_towards(std::vector<GridPoint>& polygon, const std::vector<GridPoint>& other) {
    GridPoint n = cross(polygon[1] - polygon[0], polygon[2] - polygon[0]);
    Int128 sum = 0;
    for (const GridPoint& p : other)
        sum += static_cast<Int128>(n.x) * (p.x - polygon[0].x) + static_cast<Int128>(n.y) * (p.y - polygon[0].y) +
               static_cast<Int128>(n.z) * (p.z - polygon[0].z);
    if (sum < 0)
        std::reverse(polygon.begin(), polygon.end());
}

inline void face_each_other(Case& c) {
    face_towards(c.s, c.t);
    face_towards(c.t, c.s);
}

inline void add_triangle(Case& c, GridPoint a, GridPoint b, GridPoint d) {
    if (has_area({a, b, d}))
        c.occluders.push_back({{a, b, d}, true});
}
inline void add_quad(Case& c, GridPoint a, GridPoint b, GridPoint d, GridPoint e) {
    add_triangle(c, a, b, d);
    add_triangle(c, a, d, e);
}

/// The unit square below a tilted triangle.
inline Case square_and_triangle(Random& random, double size = 0.5) {
    Case c;
    c.s = {grid(0, 0, 0), grid(1, 0, 0), grid(1, 1, 0), grid(0, 1, 0)};
    double x = random.uniform(-0.5, 1), y = random.uniform(-0.5, 1), z = random.uniform(1.5, 3);
    double u = random.uniform(-0.6, 0.6), v = random.uniform(-0.6, 0.6);
    for (int i = 0; i < 3; ++i) {
        double angle = 2.1 * i + random.uniform(0, 0.6);
        double dx = size * std::cos(angle), dy = size * std::sin(angle);
        c.t.push_back(grid(x + dx, y + dy, z + u * dx + v * dy));
    }
    face_each_other(c);
    return c;
}

using Grid = std::vector<std::vector<GridPoint>>;

/// Adds a closed wall of n x n jittered cells with shared corners.
inline Grid add_wall(Case& c, Random& random, int n, double z, double jitter = 0.25) {
    Grid g(static_cast<std::size_t>(n) + 1, std::vector<GridPoint>(static_cast<std::size_t>(n) + 1));
    double low = -1.2, high = 2.2, cell = (high - low) / n;
    for (int i = 0; i <= n; ++i)
        for (int j = 0; j <= n; ++j) {
            bool rim = i == 0 || j == 0 || i == n || j == n;
            auto shake = [&](double by) { return rim ? 0 : random.uniform(-by, by); };
            double x = low + cell * i + shake(jitter * cell), y = low + cell * j + shake(jitter * cell);
            g[static_cast<std::size_t>(i)][static_cast<std::size_t>(j)] = grid(x, y, z + shake(0.1));
        }
    for (std::size_t i = 0; i + 1 < g.size(); ++i)
        for (std::size_t j = 0; j + 1 < g.size(); ++j)
            add_quad(c, g[i][j], g[i + 1][j], g[i + 1][j + 1], g[i][j + 1]);
    return g;
}

/// Uniform in low..high.
inline std::int64_t pick(Random& random, std::int64_t low, std::int64_t high) {
    return low + random.below(static_cast<std::uint32_t>(high - low + 1));
}

/// Small random integers: everything coincides with everything.
inline Case tiny_soup(Random& random, int size, int triangles, bool fans) {
    auto point = [&](int low, int high) {
        std::int64_t x = pick(random, 0, size), y = pick(random, 0, size);
        return GridPoint{x, y, pick(random, low, high)};
    };
    auto triangle = [&](int low, int high) {
        std::vector<GridPoint> t(3);
        do
            for (GridPoint& p : t)
                p = point(low, high);
        while (!has_area(t));
        return t;
    };
    Case c;
    c.s = triangle(0, size / 4);
    c.t = triangle(size - size / 4, size);
    face_each_other(c);
    for (int i = 0; i < triangles; ++i) {
        std::vector<GridPoint> t = triangle(0, size);
        if (fans && i % 2)
            do
                t = {c.occluders.back().corners[0], c.occluders.back().corners[1], point(0, size)};
            while (!has_area(t));
        c.occluders.push_back({t, true});
    }
    return c;
}

/// Triangles over a pool of shared corners, many sharing edges; larger than the shaft.
inline Case vertex_pool(Random& random, int size, int triangles) {
    auto point = [&](int low, int high, int z0, int z1) {
        std::int64_t x = pick(random, low, high), y = pick(random, low, high);
        return GridPoint{x, y, pick(random, z0, z1)};
    };
    int q = size / 4;
    Case c;
    do
        c.s = {point(0, size, 0, q), point(0, size, 0, q), point(0, size, 0, q)};
    while (!has_area(c.s));
    do
        c.t = {point(0, size, size - q, size), point(0, size, size - q, size), point(0, size, size - q, size)};
    while (!has_area(c.t));
    face_each_other(c);
    std::vector<GridPoint> pool;
    for (int i = 0; i < triangles / 2 + 3; ++i)
        pool.push_back(point(-2 * size, 3 * size, q, size - q));
    for (int i = 0; i < triangles / 4 + 1; ++i)
        pool.push_back(point(0, size, q, size - q));
    auto any = [&] { return pool[random.below(static_cast<std::uint32_t>(pool.size()))]; };
    for (int i = 0; i < triangles; ++i) {
        std::vector<GridPoint> t(3);
        for (int tries = 0; tries < 50 && !has_area(t); ++tries) {
            for (GridPoint& p : t)
                p = any();
            if (!c.occluders.empty() && random.below(2)) {
                const auto& o = c.occluders[random.below(static_cast<std::uint32_t>(c.occluders.size()))].corners;
                t[0] = o[1];
                t[1] = o[0];
            }
        }
        if (has_area(t))
            c.occluders.push_back({t, true});
    }
    return c;
}

/// A wall over the integer lattice with S and T close to its planes; `missing` triangles removed from its middle.
inline Case lattice_wall(Random& random, int missing) {
    Case c;
    auto point = [&](int z) {
        std::int64_t x = pick(random, 0, 6), y = pick(random, 0, 6);
        return GridPoint{x, y, pick(random, z, z + 1)};
    };
    do
        c.s = {point(0), point(0), point(0)};
    while (!has_area(c.s));
    do
        c.t = {point(6), point(6), point(6)};
    while (!has_area(c.t));
    face_each_other(c);
    std::int64_t h[6][6];
    for (auto& row : h)
        for (auto& z : row)
            z = pick(random, 3, 4);
    for (int i = 0; i < 5; ++i)
        for (int j = 0; j < 5; ++j) {
            auto at = [&](int a, int b) { return GridPoint{2 * a - 2, 2 * b - 2, h[a][b]}; };
            if (random.below(2))
                add_quad(c, at(i, j), at(i + 1, j), at(i + 1, j + 1), at(i, j + 1));
            else
                add_quad(c, at(i + 1, j), at(i + 1, j + 1), at(i, j + 1), at(i, j));
        }
    auto middle = c.occluders.begin() + static_cast<std::ptrdiff_t>(c.occluders.size() / 2) - 4;
    c.occluders.erase(middle, middle + missing);
    return c;
}

inline QueryResult ask(const Case& c, const QueryOptions& options) {
    static thread_local Query query;
    OccluderList list(c.occluders);
    return query.run(c.s, c.t, list, options);
}

/// Any family, by number.
inline Case draw(Random& random) {
    static const int sizes[] = {4, 8, 16, 40};
    switch (random.below(7)) {
    case 0:
        return tiny_soup(random, sizes[random.below(3)], 3 + static_cast<int>(random.below(8)), false);
    case 1:
        return tiny_soup(random, sizes[random.below(3)], 20, true);
    case 2:
        return vertex_pool(random, sizes[random.below(4)], 4 + static_cast<int>(random.below(14)));
    case 3:
        return lattice_wall(random, static_cast<int>(random.below(3)));
    case 4: {
        Case c = square_and_triangle(random, 0.2 + 0.5 * random.uniform());
        add_wall(c, random, 1 + static_cast<int>(random.below(4)), random.uniform(0.3, 1.0));
        if (random.below(2))
            c.occluders.erase(c.occluders.begin() + random.below(static_cast<std::uint32_t>(c.occluders.size())));
        return c;
    }
    case 5: { // boxes on a coarse grid between axis-aligned faces, as a cell and a node of a tree are
        Case c;
        auto face = [&](std::int64_t base) {
            std::int64_t x = pick(random, 0, 6), y = pick(random, 0, 6), z = base + pick(random, 0, 2);
            std::int64_t w = pick(random, 1, 4), h = pick(random, 1, 4);
            std::vector<GridPoint> quad;
            switch (random.below(3)) {
            case 0: quad = {{x, y, z}, {x + w, y, z}, {x + w, y + h, z}, {x, y + h, z}}; break;
            case 1: quad = {{x, y, z}, {x + w, y, z}, {x + w, y, z + h}, {x, y, z + h}}; break;
            default: quad = {{x, y, z}, {x, y + w, z}, {x, y + w, z + h}, {x, y, z + h}}; break;
            }
            return quad;
        };
        c.s = face(0);
        c.t = face(8);
        face_each_other(c);
        for (int k = 0; k < 6; ++k) {
            std::vector<GridPoint> quad = face(3);
            c.occluders.push_back({quad, true});
        }
        return c;
    }
    default: { // single-sided soups
        Case c = tiny_soup(random, 8, 12, true);
        for (Polygon& o : c.occluders)
            o.both_sides = random.below(2) != 0;
        return c;
    }
    }
}

inline QueryOptions fast() { return {}; }
inline QueryOptions oracle() {
    QueryOptions o;
    o.filtered = false;
    o.rays = 0;
    o.start = Start::prism_or_hull;
    return o;
}
inline QueryOptions with_certificate() {
    QueryOptions o;
    o.certificate = true;
    o.rays = 2;
    return o;
}

inline QueryOptions as_published(std::uint32_t rays) {
    QueryOptions o;
    o.form = ExactForm::published;
    o.rays = rays;
    return o;
}

inline certify::WitnessSegment witness_of(const QueryResult& result) { return to_rational(result.witness); }

/// The answer, after its proof has been checked by the independent verifier. Undecided and rejected proofs fail.
inline bool proved_visible(const Case& c, const QueryOptions& options = with_certificate()) {
    QueryResult result = ask(c, options);
    EXPECT_NE(result.answer, Answer::undecided);
    EXPECT_EQ(result.counters.broken, 0u);
    if (result.answer == Answer::visible) {
        Status status = certify::verify_witness({c.s, true}, {c.t, true}, c.occluders, witness_of(result));
        EXPECT_TRUE(status.ok()) << status.message();
        return true;
    }
    if (options.certificate) {
        std::vector<Polygon> blockers;
        for (OccluderId id : result.blockers)
            blockers.push_back(c.occluders[id]);
        Status status = certify::verify_hidden({c.s, true}, {c.t, true}, blockers, result.tree);
        EXPECT_TRUE(status.ok()) << status.message();
    }
    return false;
}

} // namespace antumbra::exact::testing
