// Simplified shells: every point of every triangle lies inside the mesh that it stands for.
#include "base/random.hpp"
#include "occluder_finding/inside_tests.hpp"
#include "support/ball.hpp"

#include <antumbra/occluder_finding.hpp>

#include <gmpxx.h>
#include <gtest/gtest.h>

namespace antumbra {
namespace {

using grid::Point;
using grid::Triangle;

using test::ball;

OccluderOptions with_shells() {
    OccluderOptions options;
    options.inner_boxes = false;
    options.inner_shells = true;
    return options;
}

TEST(InnerShells, of_a_ball_lie_within_it_and_fill_most_of_it) {
    Scene scene = ball(48, 0).scene();
    OccluderStatistics statistics;
    OccluderSet set = find_occluders(scene, with_shells(), &statistics);
    ASSERT_EQ(statistics.inner_shells, 1u);
    EXPECT_GT(statistics.inner_shell_triangles, 40u);
    EXPECT_LT(statistics.inner_shell_triangles, 200u);
    double area = 0;
    for (const OccluderPolygon& polygon : set.polygons) {
        if (!polygon.synthetic)
            continue;
        area += polygon.area;
        for (std::uint32_t v : set.loop(polygon))
            EXPECT_LT(length(scene.to_world(to_double(set.vertices[v]))), 4.0);
        EXPECT_GT(dot(polygon.normal, scene.to_world(polygon.centre)), 0) << "faces outward";
    }
    EXPECT_GT(area, 0.6 * 4 * 3.14159265 * 16);
    EXPECT_TRUE(check_occluders(set).ok());
}

TEST(InnerShells, open_inverted_and_see_through_meshes_have_none) {
    OccluderStatistics statistics;
    RawScene open = ball(48, 0).raw();
    open.triangles.pop_back();
    --open.objects[0].triangle_count;
    find_occluders(*Scene::create(open), with_shells(), &statistics);
    EXPECT_EQ(statistics.inner_shells, 0u);
    RawScene inverted = ball(48, 0).raw();
    for (TriangleIndices& t : inverted.triangles)
        std::swap(t[0], t[1]);
    find_occluders(*Scene::create(inverted), with_shells(), &statistics);
    EXPECT_EQ(statistics.inner_shells, 0u);
    find_occluders(ball(48, 0, 0).scene(), with_shells(), &statistics);
    EXPECT_EQ(statistics.inner_shells, 0u);
    find_occluders(ball(48, 0).scene(), {}, &statistics);
    EXPECT_EQ(statistics.inner_shells, 0u) << "an option";
}

/// A point of an inner triangle, against the winding number of the whole mesh in double arithmetic: solid angles.
TEST(InnerShells, of_waving_balls_are_matter_at_every_point) {
    std::size_t points = 0;
    for (double wave : {0.5, 1.5, 3.0}) {
        Scene scene = ball(40, wave).scene();
        OccluderSet set = find_occluders(scene, with_shells());
        Random random(5);
        for (const OccluderPolygon& polygon : set.polygons) {
            if (!polygon.synthetic)
                continue;
            for (int k = 0; k < 8; ++k, ++points) {
                double a = random.uniform(), b = random.uniform() * (1 - a);
                Vec3d p[3];
                for (int c = 0; c < 3; ++c)
                    p[c] = to_double(set.vertices[set.loop(polygon)[std::size_t(c)]]);
                Vec3d at = p[0] + (p[1] - p[0]) * a + (p[2] - p[0]) * b;
                double angle = 0;
                for (std::uint32_t t = 0; t < scene.triangles().size(); ++t) {
                    Vec3d x = scene.vertex(t, 0) - at, y = scene.vertex(t, 1) - at, z = scene.vertex(t, 2) - at;
                    double lx = length(x), ly = length(y), lz = length(z);
                    angle += 2 * std::atan2(dot(x, cross(y, z)), lx * ly * lz + dot(x, y) * lz + dot(y, z) * lx + dot(z, x) * ly);
                }
                ASSERT_NEAR(angle / (4 * 3.14159265358979), 1, 1e-6) << "wave " << wave;
            }
        }
    }
    EXPECT_GT(points, 1000u);
}

/// Rational arithmetic: do two triangles have a point in common? By clipping one to the plane of the other.
bool have_common_point(const Triangle& a, const Triangle& b) {
    using Q = mpq_class;
    auto side = [](const Triangle& plane, const std::array<Q, 3>& p) {
        Point n = grid::cross(grid::minus(plane[1], plane[0]), grid::minus(plane[2], plane[0]));
        Q sum = 0;
        for (std::size_t k = 0; k < 3; ++k)
            sum += Q(long(n[k])) * (p[k] - Q(long(plane[0][k])));
        return sum;
    };
    // Clips a, as a polygon, to plane b (both sides closed), then to the three edges of b.
    std::vector<std::array<Q, 3>> polygon;
    for (const Point& p : a)
        polygon.push_back({Q(long(p[0])), Q(long(p[1])), Q(long(p[2]))});
    Point n = grid::cross(grid::minus(b[1], b[0]), grid::minus(b[2], b[0]));
    auto clip = [&](auto&& value) {
        std::vector<std::array<Q, 3>> out;
        for (std::size_t i = 0; i < polygon.size(); ++i) {
            const auto &p = polygon[i], &q = polygon[(i + 1) % polygon.size()];
            Q vp = value(p), vq = value(q);
            if (vp >= 0)
                out.push_back(p);
            if ((vp > 0 && vq < 0) || (vp < 0 && vq > 0)) {
                Q s = vp / (vp - vq);
                out.push_back({p[0] + (q[0] - p[0]) * s, p[1] + (q[1] - p[1]) * s, p[2] + (q[2] - p[2]) * s});
            }
        }
        polygon = out;
    };
    clip([&](const auto& p) { return side(b, p); });
    clip([&](const auto& p) { return Q(-side(b, p)); });
    for (std::size_t c = 0; c < 3; ++c) {
        Point edge = grid::minus(b[(c + 1) % 3], b[c]);
        clip([&](const auto& p) {
            Q x = p[0] - Q(long(b[c][0])), y = p[1] - Q(long(b[c][1])), z = p[2] - Q(long(b[c][2]));
            Q cx = Q(long(edge[1])) * z - Q(long(edge[2])) * y, cy = Q(long(edge[2])) * x - Q(long(edge[0])) * z,
              cz = Q(long(edge[0])) * y - Q(long(edge[1])) * x;
            return Q(cx * long(n[0]) + cy * long(n[1]) + cz * long(n[2]));
        });
    }
    return !polygon.empty();
}

TEST(AreApart, agrees_with_rational_clipping) {
    std::size_t apart = 0, together = 0;
    for (std::uint32_t trial = 0; trial < 4000; ++trial) {
        Random random(6, trial);
        std::int64_t size = trial % 3 ? 6 : 1 << 24; // small numbers touch often
        auto coordinate = [&] { return std::int64_t(random.below(std::uint32_t(2 * size + 1))) - size; };
        Triangle a, b;
        for (std::size_t c = 0; c < 3; ++c) {
            a[c] = {coordinate(), coordinate(), coordinate()};
            b[c] = {coordinate(), coordinate(), coordinate()};
        }
        Point na = grid::cross(grid::minus(a[1], a[0]), grid::minus(a[2], a[0]));
        Point nb = grid::cross(grid::minus(b[1], b[0]), grid::minus(b[2], b[0]));
        if (na == Point{} || nb == Point{})
            continue;
        bool common = have_common_point(a, b);
        if (are_apart(a, b)) {
            EXPECT_FALSE(common) << trial;
            ++apart;
        } else {
            together += common;
            if (!common) { // only triangles of one plane may be told together though they are not
                Point across = grid::cross({na[0] >> 26, na[1] >> 26, na[2] >> 26}, {nb[0] >> 26, nb[1] >> 26, nb[2] >> 26});
                EXPECT_TRUE(across == Point{} ) << trial;
            }
        }
    }
    EXPECT_GT(apart, 1000u);
    EXPECT_GT(together, 200u);
}

} // namespace
} // namespace antumbra
