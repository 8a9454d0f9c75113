#include "rays/tracer.hpp"

#include "reference.hpp"
#include "soups.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <set>
#include <thread>

using namespace antumbra;
using soups::Soup;

namespace {

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
            Ray ray{soups::random_point(random, 12), soups::random_direction(random)};
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

/// A closed surface around the origin: a cube's faces cut into n x n x 2 triangles, pushed outward at random
/// (corners on a lattice), every triangle with its corners in random order.
Scene closed_surface(Random& random, int n, double lattice) {
    Soup soup;
    auto corner = [&](int face, int i, int j) {
        double u = 2.0 * i / n - 1, v = 2.0 * j / n - 1;
        Vec3d p;
        p[face % 3] = face < 3 ? 1 : -1;
        p[(face + 1) % 3] = u;
        p[(face + 2) % 3] = v;
        // The same corner of two faces must move alike: derive the push from its position.
        auto key = [](double x) { return std::uint64_t(std::llround((x + 1) * 1024)); };
        Random push(99, key(p.x) << 42 | key(p.y) << 21 | key(p.z));
        p = p * (1 + push.uniform(0, 0.7));
        for (int k = 0; k < 3; ++k)
            p[k] = std::floor(p[k] * lattice);
        return p;
    };
    for (int face = 0; face < 6; ++face)
        for (int i = 0; i < n; ++i)
            for (int j = 0; j < n; ++j) {
                Vec3d q[4] = {corner(face, i, j), corner(face, i + 1, j), corner(face, i + 1, j + 1),
                              corner(face, i, j + 1)};
                for (int half = 0; half < 2; ++half) {
                    Vec3d t[3] = {q[0], q[half + 1], q[half + 2]};
                    std::swap(t[0], t[random.below(3)]);
                    std::swap(t[1], t[1 + random.below(2)]);
                    soup.add(t[0], t[1], t[2]);
                }
            }
    return soup.scene();
}

// Aimed at vertices, at points of edges and at random, along directions that round: not one ray may leave.
TEST(Tracer, no_ray_leaks_out_of_a_closed_surface) {
    std::size_t rays = 0;
    for (double lattice : {8.0, 1000.0, 0x1p20}) {
        Random random(5, std::uint64_t(lattice));
        Scene scene = closed_surface(random, 12, lattice);
        Tracer tracer = Tracer::build(scene);
        auto corner = [&] {
            return scene.vertex(random.below(std::uint32_t(scene.triangles().size())), int(random.below(3)));
        };
        Vec3d middle = scene.to_local({0, 0, 0});
        for (int i = 0; i < 60000; ++i, ++rays) {
            Vec3d origin = middle;
            if (i % 3)
                for (int k = 0; k < 3; ++k)
                    origin[k] += random.uniform(-0.3, 0.3) * lattice;
            Ray ray{origin, soups::random_direction(random)};
            if (i % 4 == 1)
                ray.direction = corner() - origin;
            else if (i % 4 >= 2) {
                auto t = random.below(std::uint32_t(scene.triangles().size()));
                double s = i % 4 == 2 ? 0.5 : random.uniform();
                ray.direction = scene.vertex(t, 0) * s + scene.vertex(t, 1) * (1 - s) - origin;
            }
            ASSERT_TRUE(tracer.first_hit(ray)) << "lattice " << lattice << " ray " << i;
        }
    }
    EXPECT_EQ(rays, 180000u);
}

// Rays that run along an axis, exactly through shared edges and vertices, with origins on planes of boxes.
TEST(Tracer, axis_parallel_rays_through_lattice_points_hit_the_floor) {
    Soup soup;
    for (int i = 0; i < 8; ++i)
        for (int j = 0; j < 8; ++j) {
            Vec3d a(i, j, 0), b(i + 1, j, 0), c(i + 1, j + 1, 0), d(i, j + 1, 0);
            soup.add(a, b, c);
            soup.add(c, d, a);
        }
    soup.add({20, 20, 9}, {21, 20, 9}, {20, 21, 9});
    Scene scene = soup.scene();
    Tracer tracer = Tracer::build(scene);
    for (int i = 0; i <= 16; ++i)
        for (int j = 0; j <= 16; ++j)
            for (double sign : {0.0, -0.0, 1e-300, -1e-40}) {
                bool rim = i == 0 || j == 0 || i == 16 || j == 16;
                if (rim && sign != 0)
                    continue; // these pass beside the floor, if barely
                Vec3d from = scene.to_local({i * 0.5, j * 0.5, 7});
                Hit hit = tracer.first_hit({from, {sign, -sign, -1}});
                ASSERT_TRUE(hit) << i << " " << j;
                ASSERT_EQ(hit.t, 7);
                ASSERT_FALSE(tracer.first_hit({from, {sign, sign, 1}}));
            }
    // In the floor's own plane and beside it.
    EXPECT_FALSE(tracer.first_hit({scene.to_local({-1, 3, 1}), {1, 0, 0}}));
    EXPECT_FALSE(tracer.first_hit({scene.to_local({-1, 9, 0}), {1, 0, 0}}));
}

TEST(Tracer, powers_of_two_in_the_direction_scale_t_exactly) {
    Random random(3);
    Scene scene = soups::small_soup(random, 10, 200, 4);
    Tracer tracer = Tracer::build(scene);
    int hits = 0;
    for (int i = 0; i < 500; ++i) {
        Ray ray{soups::random_point(random, 12), soups::random_direction(random)};
        Hit hit = tracer.first_hit(ray);
        hits += bool(hit);
        for (double power : {0x1p-1000, 0x1p-950, 0x1p-30, 0x1p900, 0x1p1022}) {
            Hit other = tracer.first_hit({ray.origin, ray.direction * power});
            ASSERT_EQ(other.triangle, hit.triangle);
            ASSERT_EQ(other.t, hit.t / power);
        }
    }
    EXPECT_GT(hits, 100);
}

TEST(Tracer, powers_of_two_in_the_scene_scale_t_exactly) {
    for (double power : {0x1p-45, 0x1p-10, 0x1p40}) {
        Soup plain, scaled;
        Random random(4);
        for (int i = 0; i < 200; ++i) {
            Vec3d a = soups::random_point(random, 10), b = a + soups::random_point(random, 3),
                  c = a + soups::random_point(random, 3);
            plain.add(a, b, c);
            scaled.add(a * power, b * power, c * power);
        }
        Scene scene = plain.scene(), scaled_scene = scaled.scene();
        ASSERT_EQ(scaled_scene.step(), scene.step() * power);
        Tracer tracer = Tracer::build(scene), scaled_tracer = Tracer::build(scaled_scene);
        int hits = 0;
        for (int i = 0; i < 500; ++i) {
            Ray ray{soups::random_point(random, 12), soups::random_direction(random)};
            Hit hit = tracer.first_hit(ray),
                other = scaled_tracer.first_hit({ray.origin * power, ray.direction});
            ASSERT_EQ(other.triangle, hit.triangle);
            ASSERT_EQ(other.t, hit.t * power);
            hits += bool(hit);
        }
        EXPECT_GT(hits, 100);
    }
}

TEST(Tracer, hits_from_far_away) {
    Soup soup;
    soup.add({-1, -1, 0}, {1, -1, 0}, {0, 1, 0});
    soup.add({-1, -1, -1}, {1, -1, -1}, {0, 1, -1});
    Scene scene = soup.scene();
    Tracer tracer = Tracer::build(scene);
    for (double far : {10.0, 1e6, 1e12}) {
        Vec3d middle = scene.to_local({0, -0.25, 0});
        Hit hit = tracer.first_hit({middle + Vec3d{0, 0, far}, {0, 0, -1}});
        EXPECT_EQ(hit.triangle, 0u);
        EXPECT_EQ(hit.t, far);
        EXPECT_FALSE(tracer.first_hit({middle + Vec3d{0, 0, far}, {0, 0, 1}}));
    }
}

TEST(Tracer, senseless_rays_hit_nothing) {
    Soup soup;
    soup.add({-1, -1, 0}, {1, -1, 0}, {0, 1, 0});
    Scene scene = soup.scene();
    Tracer tracer = Tracer::build(scene);
    const double nan = std::numeric_limits<double>::quiet_NaN(),
                 inf = std::numeric_limits<double>::infinity();
    for (const Vec3d& bad :
         {Vec3d{nan, 0, -1}, Vec3d{0, nan, 0}, Vec3d{0, 0, -inf}, Vec3d{inf, -inf, 1}, Vec3d{0, 0, 0}})
        EXPECT_FALSE(tracer.first_hit({{0, 0, 1}, bad}));
    for (const Vec3d& bad : {Vec3d{nan, 0, 1}, Vec3d{0, 0, inf}, Vec3d{1e200, 0, 1}})
        EXPECT_FALSE(tracer.first_hit({bad, {0, 0, -1}}));
    bool back = true;
    EXPECT_FALSE(tracer.nearest_surface({{nan, 0, 1}, {0, 0, -1}}, back));
    EXPECT_FALSE(back);
}

TEST(Tracer, duplicates_tie_exactly_and_the_lowest_index_wins) {
    Random random(8);
    Soup soup;
    for (int i = 0; i < 50; ++i) {
        Vec3d a = soups::random_point(random, 10), b = soups::random_point(random, 10),
              c = soups::random_point(random, 10);
        soup.add(a, b, c);
        soup.add(b, c, a);
        soup.add(c, b, a);
    }
    Scene scene = soup.scene();
    Tracer tracer = Tracer::build(scene);
    int hits = 0;
    for (int i = 0; i < 2000; ++i) {
        Ray ray{soups::random_point(random, 12), soups::random_direction(random)};
        std::vector<std::uint32_t> seen;
        Hit hit = tracer.seen(ray, seen);
        if (!hit)
            continue;
        ++hits;
        EXPECT_EQ(hit.triangle % 3, 0u);
        EXPECT_EQ(seen, (std::vector<std::uint32_t>{hit.triangle, hit.triangle + 1, hit.triangle + 2}));
    }
    EXPECT_GT(hits, 500);
}

TEST(Tracer, sees_every_non_occluder_up_to_the_first_occluder) {
    Soup soup;
    auto layer = [&](double z, std::uint32_t flags, bool turned = false) {
        Vec3d a{-2, -1, z}, b{2, -1, z}, c{0, 2, z};
        soup.add(a, turned ? c : b, turned ? b : c, flags);
    };
    layer(5, kDoubleSided);             // 0: glass
    layer(4, 0);                        // 1: glass, front up
    layer(3, 0, true);                  // 2: glass, back up: not drawn
    layer(2, kOccludes, true);          // 3: wall, back up: not there
    layer(1, kOccludes | kDoubleSided); // 4: wall
    layer(1, kDoubleSided);             // 5: a decal on the wall
    layer(0, kDoubleSided);             // 6: behind it
    Scene scene = soup.scene();
    Tracer tracer = Tracer::build(scene);
    Vec3d up = scene.to_local({0, 0, 9}), below = scene.to_local({0, 0, -9});
    std::vector<std::uint32_t> seen{77};
    Hit hit = tracer.seen({up, {0, 0, -1}}, seen);
    EXPECT_EQ(hit.triangle, 4u);
    EXPECT_EQ(hit.t, 8);
    EXPECT_EQ(seen, (std::vector<std::uint32_t>{77, 0, 1, 4, 5})); // appended, sorted by object
    EXPECT_EQ(tracer.first_hit({up, {0, 0, -1}}).triangle, 4u);
    seen.clear();
    EXPECT_EQ(tracer.seen({below, {0, 0, 1}}, seen).triangle, 4u);
    EXPECT_EQ(seen, (std::vector<std::uint32_t>{4, 5, 6}));
    seen.clear();
    EXPECT_FALSE(tracer.seen({up, {0, 0, 1}}, seen));
    EXPECT_TRUE(seen.empty());
}

TEST(Tracer, seen_gives_one_triangle_per_object_the_nearest) {
    RawScene raw;
    raw.positions = {{-2, -1, 0}, {2, -1, 0}, {0, 2, 0}, {-2, -1, 1}, {2, -1, 1}, {0, 2, 1}};
    raw.triangles = {{0, 1, 2}, {3, 4, 5}};
    RawObject glass;
    glass.name = "glass";
    glass.flags = kDoubleSided;
    glass.triangle_count = 2;
    raw.objects = {glass};
    Result<Scene> scene = Scene::create(raw);
    ASSERT_TRUE(scene.ok());
    Tracer tracer = Tracer::build(*scene);
    std::vector<std::uint32_t> seen;
    EXPECT_FALSE(tracer.seen({scene->to_local({0, 0, 5}), {0, 0, -1}}, seen));
    EXPECT_EQ(seen, std::vector<std::uint32_t>{1});
    seen.clear();
    EXPECT_FALSE(tracer.seen({scene->to_local({0, 0, -5}), {0, 0, 1}}, seen));
    EXPECT_EQ(seen, std::vector<std::uint32_t>{0});
}

TEST(Tracer, a_batch_sees_what_its_rays_see_alone) {
    Random random(61);
    Scene scene = soups::small_soup(random, 10, 3000, 1, {}, true);
    Tracer tracer = Tracer::build(scene);
    std::vector<Ray> rays;
    for (int bundle = 0; bundle < 60; ++bundle) {
        Ray ray{soups::random_point(random, 12), soups::random_direction(random)};
        for (std::uint32_t i = random.below(40); i > 0; --i)
            rays.push_back({ray.origin, ray.direction + soups::random_point(random, 0.05)});
        rays.push_back({ray.origin, {0, 0, 0}}); // sees nothing
    }
    SeenBatch batch;
    for (std::size_t count :
         {rays.size(), std::size_t(1), std::size_t(0), std::size_t(64), std::size_t(65)}) {
        std::span<const Ray> part(rays.data(), count);
        tracer.seen_batch(part, batch);
        ASSERT_EQ(batch.hits.size(), count);
        ASSERT_EQ(batch.begin.size(), count + 1);
        std::size_t total = 0;
        for (std::size_t i = 0; i < count; ++i) {
            std::vector<std::uint32_t> seen;
            Hit hit = tracer.seen(rays[i], seen);
            ASSERT_EQ(hit.triangle, batch.hits[i].triangle) << i;
            ASSERT_EQ(hit.t, batch.hits[i].t) << i;
            ASSERT_EQ(seen, std::vector<std::uint32_t>(batch.of(i).begin(), batch.of(i).end())) << i;
            total += seen.size();
        }
        ASSERT_EQ(total, batch.triangles.size());
        if (count == rays.size()) {
            EXPECT_GT(total, count / 4);
        }
    }
}

TEST(Tracer, nearest_surface_ignores_sides_and_tells_backs) {
    Soup soup;
    auto layer = [&](double z, std::uint32_t flags, bool turned) {
        Vec3d a{-2, -1, z}, b{2, -1, z}, c{0, 2, z};
        soup.add(a, turned ? c : b, turned ? b : c, flags);
    };
    layer(1, kOccludes, true);                // 0
    layer(0, kOccludes | kDoubleSided, true); // 1
    layer(-1, 0, false);                      // 2
    Scene scene = soup.scene();
    Tracer tracer = Tracer::build(scene);
    auto nearest = [&](double z, double direction, std::uint32_t triangle, bool expect_back) {
        bool back = !expect_back;
        Hit hit = tracer.nearest_surface({scene.to_local({0, 0, z}), {0, 0, direction}}, back);
        EXPECT_EQ(hit.triangle, triangle);
        EXPECT_EQ(back, expect_back);
    };
    nearest(5, -1, 0, true);   // meets the back of a single-sided occluder
    nearest(0.5, 1, 0, false); // meets its front
    nearest(0.5, -1, 1, false);
    nearest(-5, 1, 2, false); // meets a back that does not occlude
    nearest(-5, -1, kNoTriangle, false);
}

TEST(Tracer, near_segment_finds_all_triangles_that_the_segment_meets) {
    std::size_t touched = 0, visited = 0;
    for (int s = 0; s < 30; ++s) {
        Random random(23, std::uint64_t(s));
        Scene scene = soups::grid_soup(random, 8, 60, true);
        Tracer tracer = Tracer::build(scene);
        for (int i = 0; i < 50; ++i) {
            Vec3d p = scene.to_local(soups::grid_point(random, 8)),
                  q = scene.to_local(soups::grid_point(random, 8));
            if (i % 7 == 0)
                q = p;
            std::set<std::uint32_t> near;
            tracer.for_each_near_segment(p, q, [&](std::uint32_t t) {
                EXPECT_TRUE(near.insert(t).second); // once each
                return true;
            });
            visited += near.size();
            reference::Vector start = reference::vector(p), d = reference::minus(reference::vector(q), start);
            for (std::uint32_t t = 0; t < scene.triangles().size(); ++t) {
                reference::Triangle triangle(scene, t);
                triangle.double_sided = true;
                bool meets = p == q ? reference::dot(triangle.normal,
                                                     reference::minus(start, triangle.corner[0])) == 0 &&
                                          triangle.place(start) >= 0
                                    : reference::blocker(triangle, start, d, 1, nullptr) != Verdict::clear;
                touched += meets;
                ASSERT_TRUE(!meets || near.count(t))
                    << "scene " << s << " segment " << i << " triangle " << t;
            }
        }
    }
    EXPECT_GT(touched, 2000u);
    EXPECT_LT(visited, 8 * touched);
}

TEST(Tracer, near_segment_stops_when_told_and_may_nest) {
    Random random(2);
    Scene scene = soups::grid_soup(random, 4, 40, false);
    Tracer tracer = Tracer::build(scene);
    Vec3d p = scene.to_local({0, 0, 0}), q = scene.to_local({4, 4, 4});
    int outer = 0, inner = 0, first = 0;
    tracer.for_each_near_segment(p, q, [&](std::uint32_t) {
        ++outer;
        tracer.for_each_near_segment(p, q, [&](std::uint32_t) { return ++inner, true; });
        return true;
    });
    tracer.for_each_near_segment(p, q, [&](std::uint32_t) { return ++first, false; });
    EXPECT_GT(outer, 5);
    EXPECT_EQ(inner, outer * outer);
    EXPECT_EQ(first, 1);
}

TEST(Tracer, gives_the_same_hits_to_all_threads) {
    Random random(4);
    Scene scene = soups::small_soup(random, 10, 2000, 1, {}, true);
    Tracer tracer = Tracer::build(scene);
    std::vector<Ray> rays(3000);
    for (Ray& ray : rays)
        ray = {soups::random_point(random, 12), soups::random_direction(random)};
    std::vector<std::vector<std::uint32_t>> seen(4);
    std::vector<std::thread> threads;
    for (auto& list : seen)
        threads.emplace_back([&] {
            for (const Ray& ray : rays)
                tracer.seen(ray, list);
        });
    for (std::thread& thread : threads)
        thread.join();
    EXPECT_GT(seen[0].size(), 500u);
    for (const auto& list : seen)
        EXPECT_EQ(list, seen[0]);
}

} // namespace
