#include "bake/sampled/volume_grid.hpp"

#include "base/random.hpp"
#include "support/make_scene.hpp"

#include <antumbra/bake.hpp>

#include <gtest/gtest.h>

#include <set>

namespace antumbra {
namespace {

Scene divided_room() {
    test::SceneMaker maker;
    maker.object("room").box({0, 0, 0}, {8, 4, 4}, true);
    maker.object("wall").box({3.9, 0, 0}, {4.1, 4, 4});
    return maker.scene();
}

// Every point of a ray lies in a volume that the walk names, but for points on faces; and it names no other.
TEST(VolumeGrid, WalkNamesTheVolumesOfThePoints) {
    Scene scene = divided_room();
    VolumeGrid volumes(scene, {7, 3, 5});
    Random random(4);
    for (int i = 0; i < 3000; ++i) {
        Ray ray;
        for (int k = 0; k < 3; ++k) {
            ray.origin[k] = random.uniform(-6, 6);
            ray.direction[k] = random.below(5) == 0 ? 0 : random.uniform(-1, 1);
        }
        if (dot(ray.direction, ray.direction) == 0)
            continue;
        double end = random.uniform(0, 12);
        std::set<std::uint64_t> walked, found;
        volumes.walk(ray, end, [&](std::uint64_t volume, const Vec3d& middle) {
            ASSERT_EQ(volumes.volume_of(middle), std::int64_t(volume));
            walked.insert(volume);
        });
        for (int s = 0; s < 200; ++s)
            if (std::int64_t volume = volumes.volume_of(ray.origin + ray.direction * (end * (s + 0.5) / 200)); volume >= 0)
                found.insert(std::uint64_t(volume));
        for (std::uint64_t volume : found)
            ASSERT_TRUE(walked.contains(volume)) << i;
    }
}

TEST(VolumeGrid, PointsLieInTheirVolume) {
    Scene scene = divided_room();
    VolumeGrid volumes(scene, {7, 3, 5});
    EXPECT_EQ(volumes.count(), 105u);
    for (std::uint64_t volume = 0; volume < volumes.count(); ++volume)
        EXPECT_EQ(volumes.volume_of(volumes.point_in(volume, 0.5, 0.25, 0.75)), std::int64_t(volume));
}

// A thing that moves behind the wall cannot be seen from the other side; one on this side can.
TEST(OccludeeVolumes, TellWhetherAMovingBoxCanBeSeen) {
    Scene scene = divided_room();
    for (Subdivision subdivision : {Subdivision::grid, Subdivision::spatial}) {
        BakeOptions options;
        options.cells = {2, 1, 1};
        options.tree.subdivision = subdivision;
        options.tree.tile_depth = 1;
        options.tree.max_depth = 1;
        options.rays_per_cell = 4096;
        options.volumes = {8, 2, 2};
        Result<BakeResult> result = bake(scene, options);
        ASSERT_TRUE(result) << result.status().message();
        EXPECT_LE(result->statistics.mean_visible, 2);
        std::vector<std::byte> bytes = encode_pvs(result->pvs).value();
        Pvs pvs = Pvs::open(bytes).value();
        PvsCursor cursor;
        pvs.query({1, 2, 2}, cursor);
        EXPECT_TRUE(pvs.is_box_visible({{2, 1, 1}, {2.5, 1.5, 1.5}}, cursor));
        EXPECT_FALSE(pvs.is_box_visible({{6, 1, 1}, {6.5, 1.5, 1.5}}, cursor));
        EXPECT_TRUE(pvs.is_box_visible({{3.5, 1, 1}, {6.5, 1.5, 1.5}}, cursor)); // reaches over the wall's both sides
        EXPECT_TRUE(pvs.is_box_visible({{20, 1, 1}, {21, 2, 2}}, cursor));      // outside of the volumes
        pvs.query({7, 2, 2}, cursor);
        EXPECT_FALSE(pvs.is_box_visible({{2, 1, 1}, {2.5, 1.5, 1.5}}, cursor));
        EXPECT_TRUE(pvs.is_box_visible({{6, 1, 1}, {6.5, 1.5, 1.5}}, cursor));
    }
}

TEST(OccludeeVolumes, TooManyAreRefused) {
    BakeOptions options;
    options.volumes = {2048, 2048, 2048};
    EXPECT_EQ(bake(divided_room(), options).status().code(), ErrorCode::limit);
    options.volumes = {2, 2, 2};
    options.method = "exact";
    EXPECT_EQ(bake(divided_room(), options).status().code(), ErrorCode::usage);
}

} // namespace
} // namespace antumbra
