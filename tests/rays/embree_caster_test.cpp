#include "rays/embree_caster.hpp"
#include "rays/tracer.hpp"

#include "soups.hpp"

#include <gtest/gtest.h>

#include <cfloat>

using namespace antumbra;

namespace {

std::vector<Ray> random_rays(Random& random, std::size_t count) {
    std::vector<Ray> rays(count);
    for (Ray& ray : rays)
        for (int k = 0; k < 3; ++k) {
            ray.origin[k] = random.uniform(-12, 12);
            ray.direction[k] = random.uniform(-1, 1);
        }
    return rays;
}

// Random rays pass edges at distances far above float rounding, but for a few in a million.
TEST(EmbreeCaster, proposes_what_the_strict_tracer_finds_but_for_rounding) {
    std::size_t differ = 0, hit = 0;
    for (int s = 0; s < 10; ++s) {
        Random random(17, std::uint64_t(s));
        Scene scene =
            soups::small_soup(random, 10, 500, 3, {}, true); // with single-sided and non-occluding ones
        Tracer tracer = Tracer::build(scene);
        Result<EmbreeCaster> embree = EmbreeCaster::build(scene);
        ASSERT_TRUE(embree.ok());
        std::vector<Ray> rays = random_rays(random, 5000);
        std::vector<Hit> strict(rays.size()), proposed(rays.size());
        tracer.first_hits(rays, strict);
        embree->first_hits(rays, proposed);
        for (std::size_t i = 0; i < rays.size(); ++i) {
            differ += strict[i].triangle != proposed[i].triangle;
            hit += bool(strict[i]);
        }
    }
    EXPECT_GT(hit, 15000u);
    EXPECT_LE(differ, 10u);
}

TEST(EmbreeCaster, passes_backs_and_non_occluders) {
    soups::Soup soup;
    Vec3d a{-1, -1, 0}, b{1, -1, 0}, c{0, 1, 0}, up{0, 0, 1};
    soup.add(a + up, b + up, c + up, kDoubleSided); // lets the ray pass
    soup.add(a, c, b, kOccludes);                   // shows its back to a ray from above
    soup.add(a - up, b - up, c - up, kOccludes);    // its front
    soup.add(a - up * 2, b - up * 2, c - up * 2, kOccludes | kDoubleSided);
    Scene scene = soup.scene();
    Result<EmbreeCaster> embree = EmbreeCaster::build(scene);
    ASSERT_TRUE(embree.ok());
    Ray rays[2] = {{scene.to_local({0, 0, 5}), {0, 0, -1}}, {scene.to_local({0, 0, -5}), {0, 0, 1}}};
    Hit hits[2];
    embree->first_hits(rays, hits);
    EXPECT_EQ(hits[0].triangle, 2u);
    EXPECT_EQ(hits[0].t, 6);
    EXPECT_EQ(hits[1].triangle, 3u);
}

TEST(EmbreeCaster, leaves_denormals_alone_outside_of_its_calls) {
    soups::Soup soup;
    soup.add({0, 0, 0}, {1, 0, 0}, {0, 1, 0});
    Scene scene = soup.scene();
    Result<EmbreeCaster> embree = EmbreeCaster::build(scene);
    ASSERT_TRUE(embree.ok());
    Ray ray{{0, 0, 1}, {0, 0, -1}};
    Hit hit;
    embree->first_hits({&ray, 1}, {&hit, 1});
    volatile double small = DBL_MIN;
    EXPECT_GT(small / 4, 0.0);
}

} // namespace
