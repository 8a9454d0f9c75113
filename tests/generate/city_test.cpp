#include "generate/laws.hpp"

namespace antumbra {
namespace {

using test::made;

TEST(City, has_about_300000_triangles_in_15000_objects) {
    RawScene scene = made("city");
    EXPECT_NEAR(double(scene.triangles.size()), 300'000, 1'000);
    EXPECT_NEAR(double(scene.objects.size()), 15'000, 500);
}

TEST(City, has_the_size_that_is_asked_for) {
    for (std::uint64_t size : {25'000, 33'333, 50'000, 1'000'000}) {
        double got = double(made("city", {size, 1}).triangles.size());
        EXPECT_NEAR(got, double(size), double(size) * 0.1);
    }
    EXPECT_EQ(generate("city", {100, 1}).status().code(), ErrorCode::usage);
    EXPECT_EQ(generate("city", {1'000'000'000'000, 1}).status().code(), ErrorCode::usage);
}

/// Buildings stand on their block's ground: nothing reaches beyond the streets, or above 60 m.
TEST(City, is_sound_for_any_seed_and_size) {
    for (auto [size, seed] :
         {std::pair<std::uint64_t, std::uint64_t>{25'000, 5}, {60'000, 2}, {300'000, 1}}) {
        RawScene scene = made("city", {size, seed});
        Box3d world;
        for (const RawObject& object : scene.objects)
            if (object.name.ends_with("/street"))
                world.extend(test::bounds_of(scene, object));
        world.max.y = 60;
        test::expect_sound(scene, world);
    }
}

/// Two buildings of a block touch at most: no walls reach into others.
TEST(City, buildings_do_not_overlap) {
    RawScene scene = made("city", {60'000, 3});
    std::vector<Box3d> walls;
    for (const RawObject& object : scene.objects)
        if (object.name.ends_with("/walls"))
            walls.push_back(test::bounds_of(scene, object));
    ASSERT_GT(walls.size(), 50u);
    for (std::size_t a = 0; a < walls.size(); ++a)
        for (std::size_t b = 0; b < a; ++b) {
            bool apart = false;
            for (int k = 0; k < 3; ++k)
                apart |= walls[a].min[k] >= walls[b].max[k] || walls[b].min[k] >= walls[a].max[k];
            EXPECT_TRUE(apart) << a << " and " << b;
        }
}

TEST(City, the_default_is_the_published_file) {
    EXPECT_EQ(test::sha256_of(made("city")), test::published("city"));
    EXPECT_NE(test::sha256_of(made("city", {0, 2})), test::sha256_of(made("city")));
}

} // namespace
} // namespace antumbra
