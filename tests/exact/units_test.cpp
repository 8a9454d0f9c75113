// What a bake lists: clusters that are compact whatever the order of the file.
#include "bake/exact/baked_cells.hpp"

#include <antumbra/bake.hpp>

#include <gtest/gtest.h>

#include <algorithm>
#include <numeric>
#include <random>

namespace antumbra {
namespace {

using exact::Units;

constexpr int kSide = 24;

/// A floor of 24 x 24 squares, its triangles in the order of rows or in any; one without area among them; and a thing.
RawScene floor_of_squares(std::uint32_t shuffle) {
    RawScene raw;
    raw.source = "floor";
    for (int z = 0; z <= kSide; ++z)
        for (int x = 0; x <= kSide; ++x)
            raw.positions.push_back({double(x), 0, double(z)});
    for (int z = 0; z < kSide; ++z)
        for (int x = 0; x < kSide; ++x) {
            auto v = std::uint32_t(z * (kSide + 1) + x);
            raw.triangles.push_back({v, v + kSide + 1, v + 1});
            raw.triangles.push_back({v + 1, v + kSide + 1, v + kSide + 2});
        }
    raw.triangles.insert(raw.triangles.begin() + 7, {0, 1, 2}); // on a line
    if (shuffle)
        std::shuffle(raw.triangles.begin(), raw.triangles.end(), std::mt19937(shuffle));
    raw.objects.push_back({{0, 0, -1}, "floor", kOccludes | kDoubleSided, 0, std::uint32_t(raw.triangles.size())});
    auto first = std::uint32_t(raw.positions.size());
    raw.positions.insert(raw.positions.end(), {{5, 1, 5}, {6, 1, 5}, {5, 2, 5}});
    raw.triangles.push_back({first, first + 1, first + 2});
    raw.objects.push_back({{1, 0, -1}, "thing", kOccludes | kDoubleSided, std::uint32_t(raw.triangles.size()) - 1, 1});
    return raw;
}

Scene scene_of(RawScene raw) { return std::move(Scene::create(std::move(raw))).value(); }

/// Sum over units of the areas of their boxes in the plane.
double spread(const Scene& scene, const Units& units) {
    double sum = 0;
    for (std::uint32_t u = 0; u < units.count(); ++u) {
        Box3d box;
        for (std::uint32_t t : units.triangles_of(u))
            for (int c = 0; c < 3; ++c)
                box.extend(scene.vertex(t, c));
        sum += box.size().x * box.size().z;
    }
    return sum;
}

TEST(Units, ClustersHoldEachTriangleOnceAndNoMoreThanAsked) {
    Scene scene = scene_of(floor_of_squares(3));
    for (ClusterOrder order : {ClusterOrder::compact, ClusterOrder::file}) {
        Units units = Units::clusters(scene, 32, order);
        std::vector<int> met(scene.triangles().size(), 0);
        for (std::uint32_t u = 0; u < units.count(); ++u) {
            std::span<const std::uint32_t> triangles = units.triangles_of(u);
            ASSERT_FALSE(triangles.empty());
            ASSERT_LE(triangles.size(), 32u);
            ASSERT_TRUE(std::is_sorted(triangles.begin(), triangles.end()));
            for (std::uint32_t t : triangles) {
                ++met[t];
                ASSERT_EQ(units.of[t], u);
                ASSERT_EQ(scene.triangle_objects()[t], scene.triangle_objects()[triangles[0]]);
            }
        }
        EXPECT_EQ(std::count(met.begin(), met.end(), 1), std::ptrdiff_t(met.size()));
        auto [first, last] = units.range_of(scene.objects()[0]);
        EXPECT_EQ(first, 0u);
        EXPECT_EQ(last + 1, units.count() - 1); // the thing is the last
    }
}

TEST(Units, CompactClustersDoNotCareForTheOrderOfTheFile) {
    Scene rows = scene_of(floor_of_squares(0)), mixed = scene_of(floor_of_squares(5));
    double area = double(kSide) * kSide;
    double a = spread(rows, Units::clusters(rows, 32, ClusterOrder::compact)),
           b = spread(mixed, Units::clusters(mixed, 32, ClusterOrder::compact));
    EXPECT_LT(a, 1.7 * area); // hardly more than the floor itself
    EXPECT_LT(b, 1.7 * area);
    EXPECT_GT(spread(mixed, Units::clusters(mixed, 32, ClusterOrder::file)), 20 * area);
}

TEST(Units, AFileTellsThemByTheTrianglesOfTheSceneFile) {
    Scene scene = scene_of(floor_of_squares(5));
    BakeOptions options;
    options.method = "exact";
    options.cells = {1, 1, 1};
    options.where = {{{2, 0.5, 2}, {3, 1, 3}}};
    options.rays_per_cell = 100;
    options.holdout_rays = 100;
    options.exact.granularity = Granularity::cluster;
    options.exact.cluster_triangles = 32;
    Result<BakeResult> baked = bake(scene, options);
    ASSERT_TRUE(baked) << baked.status().message();
    std::vector<std::byte> bytes = *encode_pvs(baked->pvs);
    Pvs pvs = *Pvs::open(bytes);
    PvsTriangles floor = pvs.triangles_of(0, 100000);
    ASSERT_EQ(floor.in_file, 2u * kSide * kSide + 1);
    EXPECT_EQ(std::count(floor.cluster.begin(), floor.cluster.end(), PvsTriangles::kNone), 1);
    Units made = Units::clusters(scene, 32, ClusterOrder::compact);
    for (std::uint32_t t = 0; t < scene.triangles().size(); ++t)
        if (scene.triangle_objects()[t] == 0) {
            EXPECT_EQ(floor.cluster[scene.triangle_sources()[t]], made.of[t]);
        }
    Result<Units> read = exact::units_of(scene, pvs);
    ASSERT_TRUE(read) << read.status().message();
    EXPECT_EQ(read->of, made.of);
    EXPECT_EQ(read->order, made.order);
    EXPECT_EQ(read->first, made.first);
    // Of a scene with other triangles it is no partition.
    RawScene other = floor_of_squares(5);
    other.triangles.pop_back();
    other.objects.pop_back();
    EXPECT_EQ(exact::units_of(scene_of(std::move(other)), pvs).status().code(), ErrorCode::mismatch);
}

} // namespace
} // namespace antumbra
