#include "geometry/predicates.hpp"

#include "base/random.hpp"
#include "geometry/expansion.hpp"

#include <gmpxx.h>
#include <gtest/gtest.h>

using namespace antumbra;

namespace {

// References over integers: the inputs below are doubles that hold integers.
using Integer = mpz_class;
struct Point {
    Integer x, y, z;
    explicit Point(const Vec3d& p) : x(p.x), y(p.y), z(p.z) {}
};
Integer determinant(const Vec3d& a_, const Vec3d& b_, const Vec3d& c_, const Vec3d& d_) {
    Point a(a_), b(b_), c(c_), d(d_);
    Integer ux = b.x - a.x, uy = b.y - a.y, uz = b.z - a.z, vx = c.x - a.x, vy = c.y - a.y, vz = c.z - a.z;
    Integer wx = d.x - a.x, wy = d.y - a.y, wz = d.z - a.z;
    return ux * (vy * wz - vz * wy) - uy * (vx * wz - vz * wx) + uz * (vx * wy - vy * wx);
}

Vec3d random_point(Random& random, double size) {
    Vec3d p;
    for (int k = 0; k < 3; ++k)
        p[k] = std::floor(random.uniform(-size, size));
    return p;
}

/// A point in or next to the plane of abc: rounded to integers, then moved by up to two.
Vec3d near_plane(Random& random, const Vec3d& a, const Vec3d& b, const Vec3d& c) {
    double s = random.uniform(-1, 1), t = random.uniform(-1, 1);
    if (random.below(4) == 0) { // on a lattice point of the plane, exactly
        s = double(random.below(4));
        t = double(random.below(4));
    }
    Vec3d p = a + (b - a) * s + (c - a) * t;
    for (int k = 0; k < 3; ++k)
        p[k] = std::floor(p[k]) + (random.below(2) ? double(random.below(5)) - 2 : 0.0);
    return p;
}

TEST(Predicates, orient3d_is_right_at_every_level_for_a_million_nearly_coplanar_points) {
    PredicateTally tally;
    std::uint64_t zeros = 0;
    const double sizes[] = {8, 0x1p12, 0x1p23, 0x1p40, 0x1p49};
    for (std::uint32_t i = 0; i < 1'000'000; ++i) {
        Random random(1, i);
        double size = sizes[i % 5];
        Vec3d a = random_point(random, size), b = random_point(random, size), c = random_point(random, size);
        Vec3d d = near_plane(random, a, b, c);
        int expected = sgn(determinant(a, b, c, d));
        ASSERT_EQ(orient3d(a, b, c, d, &tally), expected) << i;
        ASSERT_EQ(exact::orient3d(a, b, c, d), expected) << i;
        zeros += expected == 0;
    }
    EXPECT_EQ(tally.filtered + tally.exact, 1'000'000u);
    EXPECT_GT(tally.exact, 100'000u); // the inputs are as hard as they are meant to be
    EXPECT_GT(tally.filtered, 100'000u);
    EXPECT_GT(zeros, 50'000u);
    RecordProperty("filtered", std::to_string(tally.filtered));
    RecordProperty("exact", std::to_string(tally.exact));
}

TEST(Predicates, orient3d_is_positive_in_front_of_a_counter_clockwise_triangle) {
    EXPECT_EQ(orient3d({0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}), 1);
    EXPECT_EQ(orient3d({0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, -1}), -1);
    EXPECT_EQ(orient3d({0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {5, -7, 0}), 0);
}

TEST(Predicates, orient3d_sees_one_ulp_and_powers_of_two_do_not_matter) {
    Vec3d a{12, 12, 12}, b{24, 24, 24.5}, c{0.1, 7.3, 1.9};
    Vec3d on = a + (b - a) * 0.5;
    for (double scale : {0x1p-90, 1.0, 0x1p120}) {
        Vec3d up = on;
        up.z = std::nextafter(on.z, 1e9);
        Vec3d down = on;
        down.z = std::nextafter(on.z, -1e9);
        int above = orient3d(a * scale, b * scale, c * scale, up * scale);
        EXPECT_NE(above, 0);
        EXPECT_EQ(orient3d(a * scale, b * scale, c * scale, on * scale), 0);
        EXPECT_EQ(orient3d(a * scale, b * scale, c * scale, down * scale), -above);
    }
}

// Coordinates of very different sizes: the differences are not exact, so that all their tails count.
TEST(Predicates, orient3d_is_right_where_differences_round) {
    PredicateTally tally;
    auto rational = [](const Vec3d& p) { return std::array<mpq_class, 3>{p.x, p.y, p.z}; };
    for (std::uint32_t i = 0; i < 20'000; ++i) {
        Random random(2, i);
        auto point = [&] {
            Vec3d p;
            for (int k = 0; k < 3; ++k)
                p[k] = std::ldexp(random.uniform(-1, 1), int(random.below(60)) - 30);
            return p;
        };
        Vec3d a = point(), b = point(), c = point(),
              d = a + (b - a) * random.uniform() + (c - a) * random.uniform();
        auto p = rational(a), q = rational(b), r = rational(c), s = rational(d);
        mpq_class u[3], v[3], w[3];
        for (std::size_t k = 0; k < 3; ++k) {
            u[k] = q[k] - p[k];
            v[k] = r[k] - p[k];
            w[k] = s[k] - p[k];
        }
        mpq_class det = u[0] * (v[1] * w[2] - v[2] * w[1]) - u[1] * (v[0] * w[2] - v[2] * w[0]) +
                        u[2] * (v[0] * w[1] - v[1] * w[0]);
        ASSERT_EQ(orient3d(a, b, c, d, &tally), sgn(det)) << i;
        ASSERT_EQ(exact::orient3d(a, b, c, d), sgn(det)) << i;
    }
    EXPECT_GT(tally.exact, 5'000u);
}

TEST(Predicates, orient2d_is_right_for_nearly_collinear_points) {
    PredicateTally tally;
    for (std::uint32_t i = 0; i < 300'000; ++i) {
        Random random(3, i);
        double size = i % 2 ? 0x1p49 : 16;
        Vec3d a = random_point(random, size), b = random_point(random, size), c = near_plane(random, a, b, a);
        int axis = int(i % 3), j = (axis + 1) % 3, k = (axis + 2) % 3;
        Integer det = (Integer(b[j]) - Integer(a[j])) * (Integer(c[k]) - Integer(a[k])) -
                      (Integer(b[k]) - Integer(a[k])) * (Integer(c[j]) - Integer(a[j]));
        ASSERT_EQ(orient2d(a, b, c, axis, &tally), sgn(det)) << i;
        ASSERT_EQ(exact::orient2d(a, b, c, axis), sgn(det)) << i;
    }
    EXPECT_GT(tally.exact, 10'000u);
    EXPECT_GT(tally.filtered, 10'000u);
}

TEST(Predicates, crossings_are_ordered_right_where_planes_nearly_meet_on_the_line) {
    PredicateTally tally;
    int ties = 0, before = 0;
    for (std::uint32_t i = 0; i < 200'000; ++i) {
        Random random(4, i);
        double size = i % 3 == 0 ? 8 : i % 3 == 1 ? 0x1p20 : 0x1p45;
        TrianglePoints first{random_point(random, size), random_point(random, size),
                             random_point(random, size)};
        // The second plane is the first, moved by a grid step or not; or shares an edge that the line passes.
        TrianglePoints second{near_plane(random, first.a, first.b, first.c),
                              near_plane(random, first.a, first.b, first.c),
                              near_plane(random, first.a, first.b, first.c)};
        Vec3d p = random_point(random, size), q = random_point(random, size);
        if (random.below(2)) {
            second = {first.a, first.b, random_point(random, size)};
            q = near_plane(random, first.a, first.b, first.a); // on the shared edge, or nearly
        }
        Integer fp = determinant(first.a, first.b, first.c, p),
                fq = determinant(first.a, first.b, first.c, q);
        Integer sp = determinant(second.a, second.b, second.c, p),
                sq = determinant(second.a, second.b, second.c, q);
        if (fp == fq || sp == sq)
            continue;
        int expected = cmp(mpq_class(fp) / (fp - fq), mpq_class(sp) / (sp - sq));
        expected = expected > 0 ? 1 : expected < 0 ? -1 : 0;
        ASSERT_EQ(compare_crossings(p, q, first, second, &tally), expected) << i;
        ASSERT_EQ(exact::compare_crossings(p, q, first, second), expected) << i;
        ties += expected == 0;
        before += expected < 0;
    }
    EXPECT_GT(ties, 1'000);
    EXPECT_GT(before, 10'000);
    EXPECT_GT(tally.exact, 10'000u);
    EXPECT_GT(tally.filtered, 10'000u);
}

TEST(Predicates, exact_range_admits_scenes_and_refuses_what_may_underflow) {
    EXPECT_TRUE(in_exact_range({0, -1e15, 1e-20}));
    EXPECT_FALSE(in_exact_range({0, 1e-300, 1}));
    EXPECT_FALSE(in_exact_range({1e100, 0, 0}));
    EXPECT_FALSE(in_exact_range({0, 0, std::numeric_limits<double>::quiet_NaN()}));
    EXPECT_FALSE(in_exact_range({0, std::numeric_limits<double>::infinity(), 0}));
}

TEST(Expansion, products_and_sums_are_exact) {
    for (std::uint32_t i = 0; i < 20'000; ++i) {
        Random random(6, i);
        auto number = [&] { return std::ldexp(random.uniform(-1, 1), int(random.below(80)) - 40); };
        double a = number(), b = number(), c = number(), d = number();
        auto e = Expansion<2>::difference(a, b), f = Expansion<2>::difference(c, d);
        auto h = (e * f + e) * f - f;
        mpq_class sum = 0;
        double last = 0;
        for (double term : h.terms()) {
            EXPECT_GT(std::abs(term), std::abs(last)); // grows: the last carries the sign
            last = term;
            sum += mpq_class(term);
        }
        mpq_class x = mpq_class(a) - mpq_class(b), y = mpq_class(c) - mpq_class(d);
        ASSERT_EQ(sum, (x * y + x) * y - y) << i;
    }
}

} // namespace
