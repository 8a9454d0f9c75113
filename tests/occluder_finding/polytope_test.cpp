// Hulls of points on the grid, and which triangles enter them, against clipping.
#include "base/random.hpp"
#include "occluder_finding/polytope.hpp"

#include <gtest/gtest.h>

#include <map>

namespace antumbra {
namespace {

using grid::Point;
using grid::Triangle;

Point random_point(Random& random, int size) {
    Point p;
    for (std::int64_t& v : p)
        v = std::int64_t(random.below(std::uint32_t(2 * size + 1))) - size;
    return p;
}

TEST(ConvexHull, of_a_cube_has_six_faces_whatever_lies_in_and_on_it) {
    std::vector<Point> points{{5, 5, 5}, {0, 5, 5}, {0, 0, 5}, {10, 10, 5}, {3, 10, 7}};
    for (int corner = 0; corner < 8; ++corner)
        points.push_back({corner & 1 ? 10 : 0, corner & 2 ? 10 : 0, corner & 4 ? 10 : 0});
    std::optional<GridPolytope> hull = convex_hull(points);
    ASSERT_TRUE(hull);
    EXPECT_EQ(hull->points.size(), 8u);
    EXPECT_EQ(hull->faces.size(), 6u);
    for (const auto& face : hull->faces)
        EXPECT_EQ(face.size(), 4u);
    EXPECT_DOUBLE_EQ(hull->worth(), 300);
}

TEST(ConvexHull, flat_and_few_points_have_none) {
    EXPECT_FALSE(convex_hull({{0, 0, 0}, {1, 0, 0}, {0, 1, 0}}));
    EXPECT_FALSE(convex_hull({{0, 0, 0}, {9, 0, 0}, {0, 9, 0}, {9, 9, 0}, {3, 4, 0}}));
    EXPECT_FALSE(convex_hull({{0, 0, 0}, {1, 1, 1}, {2, 2, 2}, {3, 3, 3}}));
    EXPECT_FALSE(convex_hull({{0, 0, 0}, {0, 0, 0}, {0, 0, 0}, {1, 0, 0}}));
}

/// Faces look outward, hold all points, and meet two at each edge, as Euler wants them to.
TEST(ConvexHull, of_random_points_is_closed_and_holds_them) {
    for (std::uint32_t trial = 0; trial < 500; ++trial) {
        Random random(91, trial);
        std::vector<Point> points;
        int size = trial % 3 == 0 ? 2 : trial % 3 == 1 ? 9 : (1 << 23); // many of one plane; few; far apart
        for (std::uint32_t n = 4 + random.below(16); n > 0; --n)
            points.push_back(random_point(random, size));
        std::optional<GridPolytope> hull = convex_hull(points);
        if (!hull)
            continue;
        std::map<std::pair<std::uint32_t, std::uint32_t>, int> edges;
        for (const auto& face : hull->faces) {
            ASSERT_GE(face.size(), 3u);
            const Point& a = hull->points[face[0]];
            Point normal = grid::cross(grid::minus(hull->points[face[1]], a), grid::minus(hull->points[face[2]], a));
            for (const Point& p : points)
                ASSERT_LE(int(grid::dot(normal, grid::minus(p, a)) > 0), 0) << trial;
            for (std::size_t i = 0; i < face.size(); ++i) {
                ++edges[{face[i], face[(i + 1) % face.size()]}];
                ASSERT_EQ(int(grid::dot(normal, grid::minus(hull->points[face[i]], a)) != 0), 0) << "planar " << trial;
            }
        }
        for (auto [edge, uses] : edges) {
            ASSERT_EQ(uses, 1) << trial;
            ASSERT_TRUE(edges.count({edge.second, edge.first})) << trial;
        }
        EXPECT_EQ(hull->points.size() + hull->faces.size(), edges.size() / 2 + 2) << trial;
    }
}

/// The part of the triangle strictly inside, by clipping in double: exact enough for whole numbers below ten.
bool enters_by_clipping(const GridPolytope& hull, const Triangle& triangle) {
    std::vector<std::array<double, 3>> polygon, next;
    for (const Point& p : triangle)
        polygon.push_back({double(p[0]), double(p[1]), double(p[2])});
    for (const auto& face : hull.faces) {
        const Point& a = hull.points[face[0]];
        Point n = grid::cross(grid::minus(hull.points[face[1]], a), grid::minus(hull.points[face[2]], a));
        auto height = [&](const std::array<double, 3>& p) {
            double sum = 1e-7; // strictly inside
            for (std::size_t k = 0; k < 3; ++k)
                sum += double(n[k]) * (p[k] - double(a[k]));
            return sum;
        };
        next.clear();
        for (std::size_t i = 0; i < polygon.size(); ++i) {
            const auto &p = polygon[i], &q = polygon[(i + 1) % polygon.size()];
            double hp = height(p), hq = height(q);
            if (hp < 0)
                next.push_back(p);
            if ((hp < 0) != (hq < 0))
                next.push_back({p[0] + (q[0] - p[0]) * hp / (hp - hq), p[1] + (q[1] - p[1]) * hp / (hp - hq),
                                p[2] + (q[2] - p[2]) * hp / (hp - hq)});
        }
        polygon = next;
        if (polygon.empty())
            return false;
    }
    return true;
}

TEST(PolytopeTest, agrees_with_clipping) {
    int entered = 0, out = 0;
    for (std::uint32_t trial = 0; trial < 6000; ++trial) {
        Random random(92, trial);
        std::vector<Point> points;
        for (std::uint32_t n = 4 + random.below(7); n > 0; --n)
            points.push_back(random_point(random, 5));
        std::optional<GridPolytope> hull = convex_hull(points);
        Triangle triangle{random_point(random, 8), random_point(random, 8), random_point(random, 8)};
        if (trial % 4 == 0) // shares a corner, or lies in a face
            triangle[0] = points[0];
        if (trial % 8 == 0)
            triangle[1] = points[1];
        if (!hull || grid::cross(grid::minus(triangle[1], triangle[0]), grid::minus(triangle[2], triangle[0])) == Point{0, 0, 0})
            continue;
        bool enters = PolytopeTest(*hull).is_entered_by(triangle);
        ASSERT_EQ(enters, enters_by_clipping(*hull, triangle)) << trial;
        ++(enters ? entered : out);
    }
    EXPECT_GT(entered, 500);
    EXPECT_GT(out, 500);
}

} // namespace
} // namespace antumbra
