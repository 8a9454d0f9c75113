#include "bake/sampled/neighbours.hpp"
#include "bake/sampled/region_sampler.hpp"

#include "support/make_scene.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <bit>
#include <set>

namespace antumbra {
namespace {

/// Many small boxes scattered on the floor of a room.
Scene clutter(std::uint64_t seed, int count) {
    test::SceneMaker maker;
    Random random(seed);
    maker.object("room").box({0, 0, 0}, {64, 16, 64}, true);
    for (int i = 0; i < count; ++i) {
        Vec3d low{random.uniform(1, 62), random.uniform(0, 14), random.uniform(1, 62)};
        maker.object("thing").box(low, low + Vec3d{random.uniform(0.05, 0.4), random.uniform(0.05, 0.4), 0.2});
    }
    return maker.scene();
}

double squared_distance(const Box3f& a, const Box3f& b) {
    double sum = 0;
    for (int k = 0; k < 3; ++k) {
        double apart = std::max({0.0, double(b.min[k]) - a.max[k], double(a.min[k]) - b.max[k]});
        sum += apart * apart;
    }
    return sum;
}

TEST(ObjectNeighbours, AreTheNearestByBruteForce) {
    Scene scene = clutter(3, 300);
    ObjectNeighbours neighbours(scene);
    for (std::uint32_t o = 0; o < scene.objects().size(); ++o) {
        std::vector<double> all, listed;
        for (std::uint32_t other = 0; other < scene.objects().size(); ++other)
            if (other != o)
                all.push_back(squared_distance(scene.objects()[o].bounds, scene.objects()[other].bounds));
        for (std::uint32_t other : neighbours.of(o)) {
            ASSERT_NE(other, o);
            listed.push_back(squared_distance(scene.objects()[o].bounds, scene.objects()[other].bounds));
        }
        std::sort(all.begin(), all.end());
        all.resize(ObjectNeighbours::kMost);
        ASSERT_EQ(listed, all) << o;
    }
}

TEST(ObjectNeighbours, FewObjectsHaveFewNeighbours) {
    Scene scene = clutter(3, 2);
    ObjectNeighbours neighbours(scene);
    EXPECT_EQ(neighbours.of(0).size(), 2u);
}

std::uint64_t found(const SamplingScene& shared, bool guided, std::uint32_t rays) {
    RegionSampler sampler(shared, SamplingRegion::all_directions({{30, 6, 30}, {33, 9, 33}}), 5);
    guided ? sampler.look_guided(rays) : sampler.look_around(rays);
    std::uint64_t count = 0;
    for (std::uint64_t word : std::move(sampler).finish().visible)
        count += std::uint64_t(std::popcount(word));
    return count;
}

// What guided sampling is for: more pairs with the same rays.
TEST(GuidedSampling, FindsMoreThanUniformWithATenthOfTheRays) {
    Scene scene = clutter(7, 400);
    Tracer tracer = Tracer::build(scene);
    BakeOptions options;
    options.sampling = Sampling::guided;
    SamplingScene shared(tracer, options);
    EXPECT_GT(found(shared, true, 800), found(shared, false, 8000));
}

} // namespace
} // namespace antumbra
