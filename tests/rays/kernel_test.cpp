// The kernels against their scalar twin, and the answer's independence of the tree.
#include "rays/kernel.hpp"

#include "soups.hpp"

#include <gtest/gtest.h>

#include <array>
#include <bit>
#include <cmath>
#include <numeric>

using namespace antumbra;
using namespace antumbra::rays;

namespace {

std::vector<const Kernel*> all_kernels() {
    std::vector<const Kernel*> kernels{&scalar_kernel()};
    for (const Kernel* kernel : {avx2_kernel(), avx512_kernel()})
        if (kernel)
            kernels.push_back(kernel);
    return kernels;
}

std::vector<std::uint32_t> all_triangles(const Scene& scene) {
    std::vector<std::uint32_t> triangles(scene.triangles().size());
    std::iota(triangles.begin(), triangles.end(), 0u);
    return triangles;
}

/// Rays that like trouble: from and towards lattice points, along axes, and some at random.
Ray awkward_ray(Random& random, const Scene& scene, std::uint32_t size) {
    Ray ray{scene.to_local(soups::grid_point(random, size)), soups::random_direction(random)};
    switch (random.below(5)) {
    case 0:
        ray.direction = scene.to_local(soups::grid_point(random, size)) - ray.origin;
        break;
    case 1:
        ray.direction = {0, 0, 0}, ray.direction[int(random.below(3))] = random.below(2) ? 1 : -1;
        break;
    case 2:
        ray.direction[int(random.below(3))] = 0;
        break;
    case 3:
        ray.origin = soups::random_point(random, size);
        break;
    default:
        ray.direction = ray.direction * std::ldexp(1.0, int(random.below(100)) - 50);
    }
    return ray;
}

struct Event {
    double t;
    std::uint32_t triangle;
    bool front, double_sided;
    bool operator==(const Event&) const = default;
    bool operator<(const Event& b) const { return t != b.t ? t < b.t : triangle < b.triangle; }
};
/// What was reported for each ray of a batch.
struct Record {
    std::vector<std::vector<Event>> events = std::vector<std::vector<Event>>(kBatch);
    HitSink sink() {
        return {[](void* self, int ray, double t, std::uint32_t triangle, bool front, bool double_sided) {
                    static_cast<Record*>(self)->events[std::size_t(ray)].push_back(
                        {t, triangle, front, double_sided});
                },
                this};
    }
    /// Sorted; those beyond the limits are left out, for which is reported of them depends on the walk.
    std::vector<std::vector<Event>> within(const double* limits) {
        for (std::size_t i = 0; i < events.size(); ++i) {
            std::erase_if(events[i], [&](const Event& event) { return event.t > limits[i]; });
            std::sort(events[i].begin(), events[i].end());
        }
        return events;
    }
};

/// Everything that a kernel can say about a batch of rays.
struct Answer {
    std::vector<std::vector<Event>> nearest, surface, all;
    bool operator==(const Answer& b) const = default;
    std::size_t hits() const {
        return std::size_t(
            std::count_if(nearest.begin(), nearest.end(), [](auto& events) { return !events.empty(); }));
    }
};
Answer ask(const Kernel& kernel, const TreeView& tree, const std::vector<PreparedRay>& rays) {
    Answer answer;
    double limits[kBatch];
    auto call = [&](auto function) {
        Record record;
        std::fill(limits, limits + kBatch, std::numeric_limits<double>::infinity());
        function(tree, rays.data(), int(rays.size()), limits, record.sink());
        return record.within(limits);
    };
    answer.nearest = call(kernel.nearest);
    answer.surface = call(kernel.surface);
    answer.all = call(kernel.all);
    return answer;
}

double size_of(const Scene& scene) {
    double size = 0;
    for (int k = 0; k < 3; ++k)
        size = std::max({size, std::abs(double(scene.local_bounds().min[k])),
                         std::abs(double(scene.local_bounds().max[k]))});
    return size;
}

/// Prepared rays, some in bundles that may share a walk.
std::vector<PreparedRay> awkward_batch(Random& random, const Scene& scene, std::uint32_t size) {
    std::vector<PreparedRay> rays;
    Ray ray;
    for (int bundle = 0; rays.size() < kBatch; bundle = bundle > 0 ? bundle - 1 : int(random.below(24))) {
        if (bundle == 0) {
            ray = awkward_ray(random, scene, size);
        } else {
            ray.direction = ray.direction + soups::random_point(random, 0.02) * length(ray.direction);
            if (random.below(2))
                ray.origin = ray.origin + soups::random_point(random, 0.1);
        }
        PreparedRay prepared;
        if (prepare(ray.origin, ray.direction, size_of(scene), prepared))
            rays.push_back(prepared);
    }
    return rays;
}

/// All blocks in leaves whose boxes are everything: no pruning at all.
TriangleTree without_pruning(const TriangleTree& tree) {
    TriangleTree flat;
    flat.blocks = tree.blocks;
    std::size_t leaves = flat.blocks.size();
    // A chain of nodes, each with up to seven leaves and the next node.
    for (std::size_t at = 0; at < leaves; at += kWidth - 1) {
        Node node;
        for (int i = 0; i < kWidth; ++i) {
            bool next = i == kWidth - 1,
                 used = next ? at + kWidth - 1 < leaves : at + std::size_t(i) < leaves;
            for (int k = 0; k < 6; ++k)
                node.bounds[k][i] = (k % 2 == 0) == used ? -1e30f : 1e30f;
            node.first[i] = std::uint32_t(next ? flat.nodes.size() + 1 : at + std::size_t(i));
            node.count[i] = used && !next ? 1 : 0;
        }
        flat.nodes.push_back(node);
    }
    return flat;
}

TEST(Kernel, instruction_sets_give_the_same_bits) {
    std::size_t hits = 0;
    for (int s = 0; s < 40; ++s) {
        Random random(31, std::uint64_t(s));
        std::uint32_t size = s % 2 ? 6 : 1000;
        Scene scene = soups::grid_soup(random, size, 50 + std::uint32_t(s) * 20, true);
        TriangleTree tree = build_triangle_tree(scene, all_triangles(scene));
        for (int i = 0; i < 20; ++i) {
            std::vector<PreparedRay> rays = awkward_batch(random, scene, size);
            Answer expected = ask(scalar_kernel(), tree.view(), rays);
            hits += expected.hits();
            for (const Kernel* kernel : all_kernels())
                ASSERT_TRUE(ask(*kernel, tree.view(), rays) == expected)
                    << kernel->name << " scene " << s << " ray " << i;
        }
    }
    EXPECT_GT(hits, 5000u);
}

/// The parts of a prepared ray that tests look at; bit patterns, so that signed zeros count.
auto bits(const PreparedRay& ray) {
    std::array<std::uint64_t, 40> out{};
    std::size_t n = 0;
    for (int k = 0; k < 3; ++k) {
        for (double x : {ray.origin[k], ray.direction[k], ray.inverse[k]})
            out[n++] = std::bit_cast<std::uint64_t>(x);
        for (float x : {ray.near_origin[k], ray.far_origin[k], ray.near_inverse[k], ray.far_inverse[k]})
            out[n++] = std::bit_cast<std::uint32_t>(x);
        out[n++] = std::uint64_t(ray.near_row[k] * 10 + ray.far_row[k]);
    }
    for (double x : {ray.shear_x, ray.shear_y, ray.shear_z, ray.margin, ray.unit})
        out[n++] = std::bit_cast<std::uint64_t>(x);
    out[n++] = std::uint64_t(ray.axis_x * 100 + ray.axis_y * 10 + ray.axis_z) * 2 + ray.against;
    return out;
}

TEST(Kernel, instruction_sets_prepare_rays_alike) {
    const double odd[] = {0.0,
                          -0.0,
                          1.0,
                          -1.0,
                          0x1p-64,
                          -0x1p-65,
                          1e-310,
                          -5e-324,
                          0x1p-900,
                          0x1.8p-901,
                          0x1.8p1023,
                          -1e300,
                          0x1p100,
                          0x1.1p100,
                          std::numeric_limits<double>::infinity(),
                          std::numeric_limits<double>::quiet_NaN()};
    std::size_t possible = 0;
    for (std::uint32_t i = 0; i < 200'000; ++i) {
        Random random(53, i);
        auto number = [&] {
            return random.below(3) ? std::ldexp(random.uniform(-1, 1), int(random.below(80)) - 40)
                                   : odd[random.below(std::size(odd))];
        };
        Ray ray{{number(), number(), number()}, {number(), number(), number()}};
        PreparedRay expected, prepared;
        bool can = scalar_kernel().prepare(ray, 100, expected);
        possible += can;
        for (const Kernel* kernel : all_kernels()) {
            ASSERT_EQ(kernel->prepare(ray, 100, prepared), can) << kernel->name << " " << i;
            if (can) {
                ASSERT_EQ(bits(prepared), bits(expected)) << kernel->name << " " << i;
            }
        }
    }
    EXPECT_GT(possible, 50'000u);
    EXPECT_LT(possible, 150'000u);
}

// The proof in code of what clamp_to_box() promises.
TEST(Kernel, the_tree_never_changes_an_answer) {
    const Kernel& kernel = *all_kernels().back();
    std::size_t hits = 0;
    for (int s = 0; s < 40; ++s) {
        Random random(37, std::uint64_t(s));
        std::uint32_t size = s % 2 ? 6 : 1000;
        Scene scene = soups::grid_soup(random, size, 40 + std::uint32_t(s) * 4, true);
        std::vector<TriangleTree> trees;
        for (std::uint32_t leaf : {1u, 4u, 8u, 64u}) {
            BvhOptions options;
            options.leaf_size = leaf;
            trees.push_back(build_triangle_tree(scene, all_triangles(scene), options));
        }
        TriangleTree flat = without_pruning(trees[0]);
        for (int i = 0; i < 20; ++i) {
            std::vector<PreparedRay> rays = awkward_batch(random, scene, size);
            Answer expected = ask(kernel, flat.view(), rays);
            hits += expected.hits();
            for (const TriangleTree& tree : trees)
                ASSERT_TRUE(ask(kernel, tree.view(), rays) == expected) << "scene " << s << " ray " << i;
        }
    }
    EXPECT_GT(hits, 5000u);
}

/// Triangles in the plane 3x + 5y + 7z = 0.
Vec3d point_of_plane(Random& random, int size) {
    double i = std::floor(random.uniform(-size, size)), j = std::floor(random.uniform(-size, size));
    return Vec3d{5, -3, 0} * i + Vec3d{0, 7, -5} * j;
}

// Rays within the plane of the triangles: all edge functions are noise, and the sum of noises may look like a
// hit anywhere. No such hit may lie outside of the triangle's box, nor depend on the tree.
TEST(Kernel, rays_in_the_plane_of_triangles_hit_them_in_their_boxes_or_not_at_all) {
    const Kernel& kernel = *all_kernels().back();
    std::size_t hits = 0;
    for (int s = 0; s < 60; ++s) {
        Random random(83, std::uint64_t(s));
        int size = 100000;
        soups::Soup soup;
        while (soup.size() < 60) {
            Vec3d a = point_of_plane(random, size);
            soup.add(a, a + point_of_plane(random, 1000), a + point_of_plane(random, 1000));
        }
        Scene scene = soup.scene();
        BvhOptions small;
        small.leaf_size = 1;
        TriangleTree tree = build_triangle_tree(scene, all_triangles(scene), small);
        TriangleTree flat = without_pruning(tree);
        for (int i = 0; i < 60; ++i) {
            std::vector<PreparedRay> rays;
            std::vector<Ray> sources;
            for (int r = 0; r < kBatch; ++r) {
                // Past a triangle, through its box if it comes near.
                Vec3d from = scene.to_local(point_of_plane(random, size) * random.uniform());
                Vec3d to = scene.vertex(random.below(std::uint32_t(scene.triangles().size())), 0) +
                           point_of_plane(random, 1000) * random.uniform();
                Ray ray{from, to - from};
                PreparedRay prepared;
                ASSERT_TRUE(prepare(ray.origin, ray.direction, size_of(scene), prepared));
                rays.push_back(prepared);
                sources.push_back(ray);
            }
            Answer expected = ask(kernel, flat.view(), rays);
            ASSERT_TRUE(ask(kernel, tree.view(), rays) == expected) << "scene " << s << " batch " << i;
            for (std::size_t r = 0; r < rays.size(); ++r)
                for (const Event& event : expected.all[r]) {
                    ++hits;
                    Vec3d at = sources[r].origin + sources[r].direction * (event.t * rays[r].unit);
                    for (int k = 0; k < 3; ++k) {
                        double a = scene.vertex(event.triangle, 0)[k], b = scene.vertex(event.triangle, 1)[k],
                               c = scene.vertex(event.triangle, 2)[k];
                        ASSERT_GE(at[k], std::min({a, b, c}) - 2 * rays[r].margin);
                        ASSERT_LE(at[k], std::max({a, b, c}) + 2 * rays[r].margin);
                    }
                }
        }
    }
    EXPECT_GT(hits, 1000u); // the noise does make hits
}

// The same rays alone, in bundles and in any order: a batch is a matter of speed only.
TEST(Kernel, a_batch_says_what_its_rays_say_alone) {
    Random random(71);
    Scene scene = soups::grid_soup(random, 1000, 2000, true);
    TriangleTree tree = build_triangle_tree(scene, all_triangles(scene));
    std::size_t hit_count = 0;
    for (const Kernel* kernel : all_kernels()) {
        std::vector<Ray> rays(5000);
        for (std::size_t i = 0; i < rays.size(); ++i) {
            rays[i] = awkward_ray(random, scene, 1000);
            if (i % 100 > 3) // mostly bundles
                rays[i] = {rays[i - 1].origin, rays[i - 1].direction + soups::random_point(random, 1e-3) *
                                                                           length(rays[i - 1].direction)};
            if (i % 100 == 50)
                rays[i].direction.x =
                    std::numeric_limits<double>::quiet_NaN(); // hits nothing, spoils nothing
        }
        std::vector<Hit> hits(rays.size());
        kernel->first_hits(tree.view(), size_of(scene), rays, hits);
        for (std::size_t i = 0; i < rays.size(); ++i) {
            Hit alone;
            kernel->first_hits(tree.view(), size_of(scene), {&rays[i], 1}, {&alone, 1});
            ASSERT_EQ(hits[i].triangle, alone.triangle) << kernel->name << " " << i;
            ASSERT_EQ(hits[i].t, alone.t) << kernel->name << " " << i;
            hit_count += bool(alone);
        }
    }
    EXPECT_GT(hit_count, 2000u);
}

TEST(Kernel, the_best_one_is_offered) {
    EXPECT_EQ(&best_kernel(), all_kernels().back());
}

} // namespace
