#include "bake/sampled/sampling_region.hpp"

#include <gtest/gtest.h>

namespace antumbra {
namespace {

TEST(ViewAngles, QuarterTurnsAndPoles) {
    EXPECT_EQ(view_angles({1, 0, 0}), (std::array<double, 2>{0, 0}));
    EXPECT_EQ(view_angles({0, 0, 2}), (std::array<double, 2>{1, 0}));
    EXPECT_EQ(view_angles({-3, 0, 0}), (std::array<double, 2>{2, 0}));
    EXPECT_EQ(view_angles({0, 0, -1}), (std::array<double, 2>{3, 0}));
    EXPECT_EQ(view_angles({1, 0, 1})[0], 0.5);
    EXPECT_EQ(view_angles({-1, 0, -1})[0], 2.5);
    EXPECT_EQ(view_angles({0, 5, 0}), (std::array<double, 2>{0, 1}));
    EXPECT_EQ(view_angles({0, -5, 0}), (std::array<double, 2>{0, -1}));
    EXPECT_EQ(view_angles({1, 0, -1e-300})[0], 0); // a full turn is none
}

TEST(ViewAngles, ElevationOfTheOctahedron) {
    EXPECT_EQ(view_angles({1, 1, 0})[1], 0.5);
    EXPECT_EQ(view_angles({1, -2, 1})[1], -0.5);
}

TEST(ViewAngles, GrowWithTheAngle) {
    double last = -1;
    for (int i = 0; i < 720; ++i) {
        double angle = i * 3.14159265358979 / 360;
        double theta = view_angles({std::cos(angle), 0.3, std::sin(angle)})[0];
        ASSERT_GT(theta, last);
        last = theta;
    }
    EXPECT_LT(last, 4);
}

SamplingRegion random_box(Random& random) {
    SamplingRegion box;
    for (std::size_t k = 0; k < 3; ++k) {
        box.min[k] = random.uniform(-2, 2);
        box.max[k] = box.min[k] + random.uniform(0, 1);
    }
    static constexpr double widths[] = {0.5, 1, 2, 4};
    double width = widths[random.below(4)];
    box.min[3] = width * random.below(std::uint32_t(4 / width));
    box.max[3] = box.min[3] + width;
    static constexpr double cuts[] = {-1, -0.5, 0, 0.5, 1};
    std::uint32_t low = random.below(4);
    box.min[4] = cuts[low];
    box.max[4] = cuts[low + 1 + random.below(4 - low)];
    return box;
}

TEST(SamplingRegion, UniformDirectionsLieInTheBox) {
    Random random(1);
    for (int i = 0; i < 200; ++i) {
        SamplingRegion box = random_box(random);
        for (int r = 0; r < 50; ++r)
            ASSERT_TRUE(box.holds_direction(uniform_direction(box, random)));
    }
}

// By symmetry in y and x = -z, half of the directions lie in either half of an upright lune, and of its headings.
TEST(SamplingRegion, UniformDirectionsAreUniform) {
    Random random(2);
    SamplingRegion box;
    box.min[3] = 1, box.max[3] = 2;
    int upper = 0, left = 0, n = 40000;
    for (int i = 0; i < n; ++i) {
        auto [theta, phi] = view_angles(uniform_direction(box, random));
        upper += phi > 0;
        left += theta > 1.5;
    }
    EXPECT_NEAR(upper, n / 2, 500);
    EXPECT_NEAR(left, n / 2, 500);
}

// Law: a direction that was actually found is never ruled out.
TEST(SamplingRegion, MayLookAtIsConservative) {
    Random random(3);
    int inside = 0, ruled_out = 0;
    for (int i = 0; i < 20000; ++i) {
        SamplingRegion box = random_box(random);
        Box3d target;
        Vec3d low{random.uniform(-4, 4), random.uniform(-4, 4), random.uniform(-4, 4)};
        target.extend(low);
        target.extend(low + Vec3d{random.uniform(), random.uniform(), random.uniform()});
        bool may = may_look_at(box, target);
        ruled_out += !may;
        for (int r = 0; r < 20; ++r)
            if (box.holds_direction(uniform_point(target, random) - uniform_point(box.space(), random))) {
                ++inside;
                ASSERT_TRUE(may);
            }
    }
    EXPECT_GT(inside, 10000);
    EXPECT_GT(ruled_out, 5000);
}

} // namespace
} // namespace antumbra
