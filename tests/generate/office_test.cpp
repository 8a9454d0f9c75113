#include "generate/laws.hpp"

namespace antumbra {
namespace {

using test::made;

Box3d building(const RawScene& scene) {
    Box3d box;
    for (const RawObject& object : scene.objects)
        if (object.name.find("slab") != std::string::npos)
            box.extend(test::bounds_of(scene, object));
    return box;
}

TEST(Office, has_the_size_that_is_asked_for) {
    EXPECT_NEAR(double(made("office").triangles.size()), 120'000, 12'000);
    for (std::uint64_t size : {4'000, 5'000, 7'777, 10'000, 17'000, 33'000, 100'000, 500'000}) {
        double got = double(made("office", {size, 1}).triangles.size());
        EXPECT_NEAR(got, double(size), double(size) * 0.1);
    }
}

TEST(Office, impossible_sizes_are_wrong_usage) {
    EXPECT_EQ(generate("office", {100, 1}).status().code(), ErrorCode::usage);
    EXPECT_EQ(generate("office", {1'000'000'000'000, 1}).status().code(), ErrorCode::usage);
}

/// Nothing reaches beyond the slabs of the floors and the roof.
TEST(Office, is_sound_for_any_seed_and_size) {
    for (auto [size, seed] : {std::pair<std::uint64_t, std::uint64_t>{4'000, 3}, {20'000, 2}, {120'000, 1}}) {
        RawScene scene = made("office", {size, seed});
        test::expect_sound(scene, building(scene));
    }
}

TEST(Office, plants_have_644_polygons_and_are_the_only_things_seen_from_both_sides) {
    RawScene scene = made("office");
    int plants = 0;
    for (const RawObject& object : scene.objects) {
        EXPECT_EQ((object.flags & kDoubleSided) != 0, object.name.starts_with("plant ")) << object.name;
        if (object.name.starts_with("plant ")) {
            EXPECT_EQ(object.triangle_count, 644u);
            ++plants;
        }
    }
    EXPECT_GT(plants, 50);
}

/// A staircase of 16 steps of 3/16 by 1/4 m, 1.25 m wide: 16 steps plus the slant below them, less the foot.
TEST(Office, stairs_have_the_volume_of_their_outline) {
    RawScene scene = made("office");
    int stairs = 0;
    for (const RawObject& object : scene.objects)
        if (object.name.ends_with("/stairs")) {
            double step = 0.1875 * 0.25;
            // Every step is its own rectangle half hollowed by the slant, and stands on the next one's lower
            // half.
            double area = 16 * step / 2 + 15 * step + step / 2;
            EXPECT_NEAR(test::volume(scene, object) / 6, area * 1.25, 1e-9);
            ++stairs;
        }
    EXPECT_EQ(stairs, 2); // of three storeys
}

TEST(Office, the_default_is_the_published_file) {
    EXPECT_EQ(test::sha256_of(made("office")), test::published("office"));
    EXPECT_NE(test::sha256_of(made("office", {0, 2})), test::sha256_of(made("office")));
}

TEST(Office, takes_a_number_of_storeys_and_of_plants) {
    GenerateOptions options;
    options.storeys = 7;
    options.plants = 100;
    RawScene scene = made("office", options);
    std::uint32_t plants = 0, roofs = 0, floors = 0;
    for (const RawObject& object : scene.objects) {
        plants += object.name.starts_with("plant ");
        roofs += object.name == "roof/slab lobby";
        floors += object.name.ends_with("/slab lobby");
    }
    EXPECT_EQ(plants, 100u);
    EXPECT_EQ(floors - roofs, 7u);
    EXPECT_NEAR(double(scene.triangles.size()), 120'000, 12'000);
    test::expect_sound(scene, building(scene));
    options.plants = 1'000'000;
    EXPECT_EQ(generate("office", options).status().code(), ErrorCode::usage);
    options.plants = 1;
    EXPECT_EQ(generate("city", options).status().code(), ErrorCode::usage);
}

} // namespace
} // namespace antumbra
