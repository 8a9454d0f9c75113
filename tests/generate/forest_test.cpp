#include "generate/laws.hpp"

namespace antumbra {
namespace {

using test::made;

TEST(Forest, has_1450_trees_of_1000_triangles) {
    RawScene scene = made("forest");
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

TEST(Forest, the_wanted_size_is_the_number_of_trees) {
    for (std::uint64_t size : {20'000, 77'400, 300'000}) {
        RawScene scene = made("forest", {size, 1});
        EXPECT_EQ(test::count_named(scene, "tree "), (size + 500) / 1000);
        EXPECT_NEAR(double(scene.triangles.size()), double(size), double(size) * 0.1);
    }
    EXPECT_EQ(generate("forest", {10'000, 1}).status().code(), ErrorCode::usage);
    EXPECT_EQ(generate("forest", {1'000'000'000'000, 1}).status().code(), ErrorCode::usage);
}

/// Trees stand on the ground (crowns may reach beyond it by 3 m).
TEST(Forest, is_sound_for_any_seed_and_size) {
    for (auto [size, seed] : {std::pair<std::uint64_t, std::uint64_t>{20'000, 5}, {100'000, 2}, {0, 1}}) {
        RawScene scene = made("forest", {size, seed});
        Box3d ground;
        for (const RawObject& object : scene.objects)
            if (object.name.starts_with("ground "))
                ground.extend(test::bounds_of(scene, object));
        Box3d world = ground;
        world.min += Vec3d{-3, 0, -3};
        world.max += Vec3d{3, 16, 3};
        test::expect_sound(scene, world);
        for (const RawObject& object : scene.objects)
            if (object.name.starts_with("tree ")) {
                Vec3d foot = scene.positions[scene.triangles[object.first_triangle][0]];
                EXPECT_TRUE(ground.contains(foot)) << object.name;
            }
    }
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
    EXPECT_NE(test::sha256_of(made("forest", {20'000, 2})), test::sha256_of(made("forest", {20'000, 1})));
}

} // namespace
} // namespace antumbra
