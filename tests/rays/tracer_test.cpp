#include "rays/tracer.hpp"

#include "reference.hpp"
#include "soups.hpp"

#include <gtest/gtest.h>

using namespace antumbra;
using soups::Soup;

namespace {

Vec3d random_direction(Random& random) {
    for (;;) {
        Vec3d d{random.uniform(-1, 1), random.uniform(-1, 1), random.uniform(-1, 1)};
        if (dot(d, d) > 0.01 && dot(d, d) < 1)
            return d;
    }
}

/// The first occluding triangle drawn towards the ray, in rationals.
struct ExactHit {
    reference::Rational t;
    std::uint32_t triangle = kNoTriangle;
};
ExactHit exact_first_hit(const Scene& scene, const Ray& ray) {
    ExactHit best;
    reference::Vector p = reference::vector(ray.origin), d = reference::vector(ray.direction);
    for (std::uint32_t i = 0; i < scene.triangles().size(); ++i) {
        if (!scene.object_of(i).has(kOccludes))
            continue;
        reference::Triangle triangle(scene, i);
        auto t = triangle.crossing(p, d);
        if (!t || *t <= 0 || triangle.place(reference::along(p, d, *t)) < 0)
            continue;
        if (!triangle.double_sided && reference::dot(triangle.normal, d) > 0)
            continue;
        if (best.triangle == kNoTriangle || *t < best.t)
            best = {*t, i};
    }
    return best;
}

TEST(Tracer, first_hits_of_random_rays_are_those_of_rational_brute_force) {
    int hits = 0;
    for (int s = 0; s < 20; ++s) {
        Random random(11, std::uint64_t(s));
        Scene scene = soups::small_soup(random, 10, 100, 4, {}, s % 2 == 1);
        Tracer tracer = Tracer::build(scene);
        for (int i = 0; i < 200; ++i) {
            Ray ray{{random.uniform(-12, 12), random.uniform(-12, 12), random.uniform(-12, 12)}, random_direction(random)};
            Hit hit = tracer.first_hit(ray);
            ExactHit exact = exact_first_hit(scene, ray);
            ASSERT_EQ(hit.triangle, exact.triangle) << "scene " << s << " ray " << i;
            if (hit) {
                ASSERT_NEAR(hit.t, exact.t.get_d(), 1e-9 * (1 + hit.t));
                ++hits;
            }
        }
    }
    EXPECT_GT(hits, 500);
}

} // namespace
