#include <antumbra/export.hpp>
#include <antumbra/generate.hpp>
#include <antumbra/import.hpp>
#include <antumbra/split.hpp>

#include "support/make_scene.hpp"

#include <algorithm>

namespace antumbra {
namespace {

/// A wavy ground of 2 n^2 triangles, a box, and something that moves.
Scene terrain(int n) {
    test::SceneMaker maker;
    maker.object("ground");
    auto point = [&](int i, int k) { return Vec3d{i * 0.37, (i * 7 + k * 13) % 5 * 0.1, k * 0.41}; };
    for (int i = 0; i < n; ++i)
        for (int k = 0; k < n; ++k)
            maker.quad(point(i, k), point(i, k + 1), point(i + 1, k + 1), point(i + 1, k));
    maker.object("box", kOccludes | kDoubleSided).box({1, 1, 1}, {2, 2, 2});
    maker.object("bird", kMoves | kAlwaysVisible).box({3, 3, 3}, {4, 4, 4});
    return maker.scene();
}

/// All triangles, each from its lowest corner on, in world coordinates, sorted.
std::vector<std::array<double, 10>> triangles_of(const Scene& scene) {
    std::vector<std::array<double, 10>> list;
    for (std::uint32_t t = 0; t < scene.triangles().size(); ++t) {
        std::array<std::array<double, 3>, 3> corners;
        for (int c = 0; c < 3; ++c) {
            Vec3d p = scene.to_world(scene.vertex(t, c));
            corners[std::size_t(c)] = {p.x, p.y, p.z};
        }
        std::rotate(corners.begin(), std::min_element(corners.begin(), corners.end()), corners.end());
        std::array<double, 10> row{};
        for (std::size_t k = 0; k < 9; ++k)
            row[k] = corners[k / 3][k % 3];
        row[9] = scene.object_of(t).flags & (kOccludes | kDoubleSided);
        list.push_back(row);
    }
    std::sort(list.begin(), list.end());
    return list;
}

TEST(Split, CutsBigObjectsIntoCompactClusters) {
    Scene scene = terrain(32);
    SplitStatistics statistics;
    RawScene split = split_scene(scene, {64}, &statistics);
    EXPECT_EQ(statistics.objects_cut, 1u);
    EXPECT_EQ(statistics.clusters, 32u); // 2048 triangles, halved five times
    ASSERT_EQ(split.objects.size(), 34u);
    EXPECT_EQ(split.objects[0].name, "ground/cluster 1");
    EXPECT_EQ(split.objects[31].name, "ground/cluster 32");
    EXPECT_EQ(split.objects[32].name, "box");
    EXPECT_EQ(split.objects[33].name, "bird");
    Scene made = std::move(Scene::create(split)).value();
    double ground = 32 * 0.37, area = 0;
    for (std::uint32_t o = 0; o < 32; ++o) {
        EXPECT_LE(made.objects()[o].triangle_count, 64u);
        Vec3d size = to_double(made.objects()[o].bounds).size();
        EXPECT_LT(std::max(size.x, size.z), ground / 3);
        area += size.x * size.z;
    }
    EXPECT_LT(area, 2.0 * ground * 32 * 0.41); // hardly any overlap
    EXPECT_TRUE(made.objects()[33].has(kMoves));
}

TEST(Split, KeepsTheWorldTriangleForTriangleAlsoThroughAFile) {
    Scene scene = terrain(20);
    Scene made = std::move(Scene::create(split_scene(scene, {50}))).value();
    EXPECT_EQ(triangles_of(scene), triangles_of(made));
    EXPECT_EQ(scene.step(), made.step());
    Result<std::vector<std::byte>> glb = export_glb(split_scene(scene, {50}));
    ASSERT_TRUE(glb);
    Result<RawScene> read = import_gltf(*glb, "split.glb", "");
    ASSERT_TRUE(read) << read.status().message();
    Scene again = std::move(Scene::create(*read)).value();
    EXPECT_EQ(triangles_of(scene), triangles_of(again));
}

TEST(Split, OfAGeneratedTownKeepsItsTriangles) {
    Scene scene = std::move(Scene::create(*generate("town", {.triangles = 40000}))).value();
    RawScene split = split_scene(scene, {32});
    EXPECT_GT(split.objects.size(), scene.objects().size());
    EXPECT_EQ(triangles_of(scene), triangles_of(std::move(Scene::create(split)).value()));
}

TEST(Split, SmallObjectsStayWholeAndOneTriangleIsTheLeast) {
    Scene scene = terrain(4);
    EXPECT_EQ(split_scene(scene, {1000}).objects.size(), 3u);
    EXPECT_EQ(split_scene(scene, {1}).objects.size(), 32u + 12 + 1);
    EXPECT_EQ(split_scene(scene, {0}).objects.size(), 32u + 12 + 1);
}

} // namespace
} // namespace antumbra
