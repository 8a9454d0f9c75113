#include "generate/laws.hpp"

namespace antumbra {
namespace {

using test::made;

TEST(Downtown, is_thirty_copies_of_ten_thousand_triangles) {
    RawScene scene = made("downtown");
    EXPECT_NEAR(double(scene.triangles.size()), 300'540, 3'000);
    std::size_t grounds = 0, towers = 0;
    for (const RawObject& object : scene.objects) {
        grounds += object.name.ends_with("/ground");
        towers += object.name.find("/tower ") != std::string::npos;
        if (object.name.find("/tower ") != std::string::npos) {
            EXPECT_GT(object.triangle_count, 20u) << "what minimum occluder sets are sought for";
            EXPECT_LE(object.triangle_count, 256u);
        }
    }
    EXPECT_NEAR(double(grounds), 30, 2);
    EXPECT_EQ(grounds + towers, scene.objects.size());
}

TEST(Downtown, has_the_size_that_is_asked_for) {
    for (std::uint64_t size : {5'000, 33'333, 1'000'000}) {
        double got = double(made("downtown", {size, 1}).triangles.size());
        EXPECT_NEAR(got, double(size), double(size) * 0.1);
    }
    EXPECT_EQ(generate("downtown", {100, 1}).status().code(), ErrorCode::usage);
}

TEST(Downtown, every_copy_is_the_same) {
    RawScene scene = made("downtown", {40'000, 3});
    const RawObject *first = nullptr, *second = nullptr;
    for (const RawObject& object : scene.objects) {
        if (object.name == "district 1,1/tower 4,3")
            first = &object;
        if (object.name == "district 2,1/tower 4,3")
            second = &object;
    }
    ASSERT_TRUE(first && second);
    ASSERT_EQ(first->triangle_count, second->triangle_count);
    for (std::uint32_t t = 0; t < first->triangle_count; ++t)
        for (std::size_t corner = 0; corner < 3; ++corner) {
            Vec3d a = scene.positions[scene.triangles[first->first_triangle + t][corner]];
            Vec3d b = scene.positions[scene.triangles[second->first_triangle + t][corner]];
            ASSERT_EQ(b - a, (Vec3d{400, 0, 0}));
        }
}

TEST(Downtown, is_sound_for_any_seed_and_size) {
    for (auto [size, seed] : {std::pair<std::uint64_t, std::uint64_t>{10'000, 5}, {60'000, 2}}) {
        RawScene scene = made("downtown", {size, seed});
        Box3d world;
        for (const RawObject& object : scene.objects)
            if (object.name.ends_with("/ground"))
                world.extend(test::bounds_of(scene, object));
        world.max.y = 600;
        test::expect_sound(scene, world);
    }
}

TEST(Downtown, the_default_is_the_published_file) {
    EXPECT_EQ(test::sha256_of(made("downtown")), test::published("downtown"));
}

} // namespace
} // namespace antumbra
