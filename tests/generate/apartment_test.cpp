#include "generate/laws.hpp"

namespace antumbra {
namespace {

using test::made;

TEST(Apartment, has_the_objects_of_the_paper_and_its_polygons_to_the_even_number_that_solids_allow) {
    RawScene scene = made("apartment");
    EXPECT_EQ(scene.objects.size(), 159u);
    EXPECT_EQ(scene.triangles.size(), 3060u);
}

TEST(Apartment, is_sound_for_any_seed) {
    for (std::uint64_t seed : {1, 2, 3, 1000}) {
        RawScene scene = made("apartment", {0, seed});
        EXPECT_EQ(scene.objects.size(), 159u);
        EXPECT_EQ(scene.triangles.size(), 3060u);
        test::expect_sound(scene, {{-0.25, -0.25, -0.25}, {8.875, 2.75, 4.65}});
    }
}

TEST(Apartment, only_the_panes_let_sight_pass) {
    RawScene scene = made("apartment");
    int panes = 0;
    for (const RawObject& object : scene.objects) {
        bool pane = object.name.ends_with("/pane");
        EXPECT_EQ(object.flags, pane ? 0u : std::uint32_t(kOccludes)) << object.name;
        panes += pane;
    }
    EXPECT_EQ(panes, 3);
}

/// What is in a cupboard or a drawer lies within its carcass: its box is inside the other's.
TEST(Apartment, contents_lie_inside_their_furniture) {
    for (std::uint64_t seed : {1, 7}) {
        RawScene scene = made("apartment", {0, seed});
        int inside = 0;
        for (const RawObject& outer : scene.objects)
            for (const RawObject& inner : scene.objects) {
                std::string rest =
                    inner.name.starts_with(outer.name + "/") ? inner.name.substr(outer.name.size()) : "";
                if (rest.empty() || rest.find("/door") == 0 || rest.find("/lamp") == 0)
                    continue;
                Box3d a = test::bounds_of(scene, outer), b = test::bounds_of(scene, inner);
                EXPECT_TRUE(a.contains(b.min) && a.contains(b.max)) << outer.name << " and " << inner.name;
                ++inside;
            }
        EXPECT_GT(inside, 60);
    }
}

/// Flat c is flat 0, moved; six storeys, then the next column.
TEST(Apartment, a_block_of_eighteen_has_eighteen_equal_flats) {
    RawScene flat = made("apartment"), block = made("apartment", {0, 1, 18});
    ASSERT_EQ(block.objects.size(), 18u * 159);
    ASSERT_EQ(block.triangles.size(), 18u * 3060);
    for (std::size_t c = 0; c < 18; ++c) {
        EXPECT_EQ(block.objects[c * 159 + 3].name,
                  "flat " + std::to_string(c + 1) + "/" + flat.objects[3].name);
        for (std::size_t v = 0; v < flat.positions.size(); ++v)
            ASSERT_EQ(block.positions[c * flat.positions.size() + v] - flat.positions[v],
                      (Vec3d{double(c / 6) * 11, double(c % 6) * 2.90625, 0}));
    }
    test::expect_sound(block, {{-0.25, -0.25, -0.25}, {31, 18, 4.65}});
}

TEST(Apartment, wrong_sizes_and_copies_are_wrong_usage) {
    EXPECT_EQ(generate("apartment", {5000, 1}).status().code(), ErrorCode::usage);
    EXPECT_EQ(generate("apartment", {0, 1, 0}).status().code(), ErrorCode::usage);
    EXPECT_EQ(generate("apartment", {0, 1, 10'001}).status().code(), ErrorCode::usage);
    EXPECT_EQ(generate("office", {0, 1, 2}).status().code(), ErrorCode::usage);
}

TEST(Apartment, the_default_is_the_published_file) {
    EXPECT_EQ(test::sha256_of(made("apartment")), test::published("apartment"));
    EXPECT_EQ(test::sha256_of(made("apartment")), test::sha256_of(made("apartment")));
    EXPECT_EQ(test::sha256_of(made("apartment", {0, 1, 18})), test::published("apartment --copies 18"));
    EXPECT_NE(test::sha256_of(made("apartment", {0, 2})), test::sha256_of(made("apartment")));
}

} // namespace
} // namespace antumbra
