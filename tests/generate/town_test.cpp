#include "generate/laws.hpp"

#include "generate/town_house.hpp"

namespace antumbra {
namespace {

using test::made;

TEST(Town, has_the_size_that_is_asked_for) {
    EXPECT_NEAR(double(made("town").triangles.size()), 1'330'000, 1'000);
    for (std::uint64_t size : {40'000, 77'000, 200'000, 2'000'000}) {
        double got = double(made("town", {size, 1}).triangles.size());
        EXPECT_NEAR(got, double(size), double(size) * 0.1);
    }
    EXPECT_EQ(generate("town", {1'000, 1}).status().code(), ErrorCode::usage);
    EXPECT_EQ(generate("town", {1'000'000'000'000, 1}).status().code(), ErrorCode::usage);
}

TEST(Town, is_sound_for_any_seed_and_size) {
    for (auto [size, seed] : {std::pair<std::uint64_t, std::uint64_t>{77'000, 5}, {300'000, 2}, {0, 1}}) {
        RawScene scene = made("town", {size, seed});
        Box3d world;
        for (const RawObject& object : scene.objects)
            if (object.name.starts_with("ground "))
                world.extend(test::bounds_of(scene, object));
        world.max.y = 33;
        test::expect_sound(scene, world);
    }
}

/// Except for what the front of a house shows to the street, all of it stays within its own plot.
TEST(Town, a_house_keeps_to_its_plot_and_its_size) {
    for (double width : {6.0, 6.75, 7.5})
        for (std::uint64_t seed = 0; seed < 5; ++seed) {
            generation::Modeller modeller("test");
            generation::town_house(modeller, {}, "house", width, Random(seed));
            EXPECT_LE(modeller.triangle_count(), generation::kTownHouseTriangles);
            EXPECT_GT(modeller.triangle_count(), 5'000u);
            RawScene scene = modeller.finish();
            Box3d plot{{-width / 2 - 0.1, 0, -generation::kTownHouseDepth - 0.4}, {width / 2 + 0.1, 11, 1.2}};
            test::expect_sound(scene, plot);
        }
}

/// The centres of house floors keep the width of a house (6 m) from each other.
TEST(Town, houses_do_not_stand_in_each_other) {
    RawScene scene = made("town");
    std::vector<Vec3d> centres;
    for (const RawObject& object : scene.objects)
        if (object.name.starts_with("house ") && object.name.ends_with("/floor"))
            centres.push_back(test::bounds_of(scene, object).centre());
    ASSERT_GT(centres.size(), 200u);
    for (std::size_t a = 0; a < centres.size(); ++a)
        for (std::size_t b = 0; b < a; ++b)
            EXPECT_GT(length(centres[a] - centres[b]), 6.0) << a << " and " << b;
}

TEST(Town, the_default_is_the_published_file) {
    EXPECT_EQ(test::sha256_of(made("town")), test::published("town"));
    EXPECT_NE(test::sha256_of(made("town", {77'000, 2})), test::sha256_of(made("town", {77'000, 1})));
}

} // namespace
} // namespace antumbra
