#include "generate/laws.hpp"

#include "base/random.hpp"
#include "rays/tracer.hpp"

namespace antumbra {
namespace {

using test::made;

constexpr const char* kKinds[] = {"forest", "forest-dense"};

void expect_1450_trees(const char* kind) {
    RawScene scene = made(kind);
    std::size_t trees = 0;
    for (const RawObject& object : scene.objects)
        if (object.name.starts_with("tree ")) {
            ASSERT_EQ(object.triangle_count, 1000u) << object.name;
            ASSERT_TRUE(object.flags & kDoubleSided);
            ++trees;
        }
    EXPECT_EQ(trees, 1450u);
    EXPECT_EQ(scene.triangles.size(), 1'450'000u + 320 * test::count_named(scene, "ground "));
}

TEST(Forest, has_1450_trees_of_1000_triangles) {
    for (const char* kind : kKinds)
        expect_1450_trees(kind);
}

TEST(Forest, the_wanted_size_is_the_number_of_trees) {
    for (const char* kind : kKinds) {
        for (std::uint64_t size : {20'000, 77'400, 300'000}) {
            RawScene scene = made(kind, {size, 1});
            EXPECT_EQ(test::count_named(scene, "tree "), (size + 500) / 1000);
            EXPECT_NEAR(double(scene.triangles.size()), double(size), double(size) * 0.1);
        }
        EXPECT_EQ(generate(kind, {10'000, 1}).status().code(), ErrorCode::usage);
        EXPECT_EQ(generate(kind, {1'000'000'000'000, 1}).status().code(), ErrorCode::usage);
    }
}

/// Trees stand on the ground (crowns may reach beyond it by `beyond`).
void expect_sound_forest(const char* kind, double beyond) {
    for (auto [size, seed] : {std::pair<std::uint64_t, std::uint64_t>{20'000, 5}, {100'000, 2}, {0, 1}}) {
        RawScene scene = made(kind, {size, seed});
        Box3d ground;
        for (const RawObject& object : scene.objects)
            if (object.name.starts_with("ground "))
                ground.extend(test::bounds_of(scene, object));
        Box3d world = ground;
        world.min += Vec3d{-beyond, 0, -beyond};
        world.max += Vec3d{beyond, 16, beyond};
        test::expect_sound(scene, world);
        for (const RawObject& object : scene.objects)
            if (object.name.starts_with("tree ")) {
                Vec3d foot = scene.positions[scene.triangles[object.first_triangle][0]];
                EXPECT_TRUE(ground.contains(foot)) << object.name;
            }
    }
}

TEST(Forest, is_sound_for_any_seed_and_size) {
    expect_sound_forest("forest", 3);
    expect_sound_forest("forest-dense", 5);
}

/// Triangles that 100,000 rays from a box in the middle of a forest of 100 trees meet.
std::size_t seen_from_the_middle(const char* kind) {
    Scene scene = std::move(*Scene::create(made(kind, {100'000, 1})));
    Tracer tracer = Tracer::build(scene);
    Vec3d middle = (to_double(scene.local_bounds()).min + to_double(scene.local_bounds()).max) * 0.5;
    Random random(1);
    std::vector<bool> seen(scene.triangles().size());
    for (int r = 0; r < 100'000; ++r) {
        Vec3d eye = middle + Vec3d{random.uniform(-2, 2), random.uniform(-2, 2), random.uniform(-2, 2)};
        if (Hit hit = tracer.first_hit({eye, {random.uniform(-1, 1), random.uniform(-1, 1), random.uniform(-1, 1)}}))
            seen[hit.triangle] = true;
    }
    return static_cast<std::size_t>(std::count(seen.begin(), seen.end(), true));
}

TEST(Forest, dense_crowns_hide_more) {
    EXPECT_LT(2 * seen_from_the_middle("forest-dense"), seen_from_the_middle("forest"));
}

/// Ground tiles meet without a gap: every vertex of a shared border is one of the neighbour's too.
TEST(Forest, ground_tiles_share_their_borders) {
    RawScene scene = made("forest", {20'000, 1});
    std::vector<std::array<double, 3>> top;
    double border = 8 * 2.75;
    for (const RawObject& object : scene.objects)
        if (object.name == "ground 0,0" || object.name == "ground 1,0")
            for (std::uint32_t t = 0; t < object.triangle_count; ++t)
                for (std::uint32_t v : scene.triangles[object.first_triangle + t])
                    if (scene.positions[v].x == border)
                        top.push_back({double(object.name == "ground 0,0"), scene.positions[v].y,
                                       scene.positions[v].z});
    std::sort(top.begin(), top.end());
    top.erase(std::unique(top.begin(), top.end()), top.end());
    ASSERT_EQ(top.size(), 2u * 2 * 9);
    for (std::size_t i = 0; i < 18; ++i) {
        EXPECT_EQ(top[i][1], top[i + 18][1]);
        EXPECT_EQ(top[i][2], top[i + 18][2]);
    }
}

TEST(Forest, the_default_is_the_published_file) {
    EXPECT_EQ(test::sha256_of(made("forest")), test::published("forest"));
    EXPECT_EQ(test::sha256_of(made("forest-dense")), test::published("forest-dense"));
    EXPECT_NE(test::sha256_of(made("forest", {20'000, 2})), test::sha256_of(made("forest", {20'000, 1})));
}

} // namespace
} // namespace antumbra
