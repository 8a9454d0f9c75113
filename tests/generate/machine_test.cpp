#include "generate/laws.hpp"

namespace antumbra {
namespace {

using test::made;

TEST(Machine, has_the_parts_and_polygons_of_the_paper_for_any_seed) {
    for (std::uint64_t seed : {1, 2, 99}) {
        RawScene scene = made("machine", {0, seed});
        EXPECT_EQ(scene.objects.size(), 1726u);
        EXPECT_EQ(scene.triangles.size(), 455'806u);
    }
    EXPECT_EQ(generate("machine", {1000, 1}).status().code(), ErrorCode::usage);
}

/// Nothing but screw heads, the feet and the dial reaches beyond the housing.
TEST(Machine, is_sound) {
    RawScene scene = made("machine");
    test::expect_sound(scene, {{-0.01, -0.03, -0.04}, {1.21, 1.11, 0.71}}, 65536);
    Box3d housing{{0, 0, 0}, {1.2001, 1.1001, 0.7001}};
    for (const RawObject& object : scene.objects) {
        bool outside = object.name.starts_with("screws/") || object.name.starts_with("housing/");
        Box3d box = test::bounds_of(scene, object);
        EXPECT_TRUE(outside || (housing.contains(box.min) && housing.contains(box.max))) << object.name;
    }
}

TEST(Machine, the_default_is_the_published_file) {
    EXPECT_EQ(test::sha256_of(made("machine")), test::published("machine"));
    EXPECT_NE(test::sha256_of(made("machine", {0, 2})), test::sha256_of(made("machine")));
}

} // namespace
} // namespace antumbra
