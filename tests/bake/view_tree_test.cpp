#include "bake/sampled/view_tree_builder.hpp"

#include "support/make_scene.hpp"

#include <antumbra/bake.hpp>

#include <gtest/gtest.h>

#include <filesystem>

namespace antumbra {
namespace {

using test::SceneMaker;

// E = (1 - |both| / |seen|) * (1 - |volA - volB| / vol).
TEST(SplitEffectiveness, KnownValues) {
    EXPECT_EQ(split_effectiveness(0, 10, 1, 1), 1);      // the ideal split
    EXPECT_EQ(split_effectiveness(10, 10, 1, 1), 0);     // separates nothing
    EXPECT_EQ(split_effectiveness(5, 10, 3, 1), 0.25);   // half separated, half balanced
    EXPECT_EQ(split_effectiveness(0, 10, 1, 0), 0);      // cuts nothing off
}

enum : std::uint32_t { kRoom, kWall, kLeft, kRight };

Scene divided_room() {
    SceneMaker maker;
    maker.object("room").box({0, 0, 0}, {8, 4, 4}, true);
    maker.object("wall").box({5.9, 0, 0}, {6.1, 4, 4});
    maker.object("left").box({1, 1, 1}, {1.5, 1.5, 1.5});
    maker.object("right").box({6.8, 1, 1}, {7.2, 1.5, 1.5});
    return maker.scene();
}

BakeOptions tree_bake(Subdivision subdivision) {
    BakeOptions options;
    options.tree.subdivision = subdivision;
    options.tree.tile_depth = 1;
    options.tree.max_depth = 4;
    options.tree.node_rays = 4096;
    options.rays_per_cell = 1024;
    options.holdout_rays = 64;
    return options;
}

std::vector<std::byte> file_of(const Scene& scene, const BakeOptions& options, unsigned threads = 0) {
    Job job;
    job.threads = threads;
    Result<BakeResult> result = bake(scene, options, job);
    EXPECT_TRUE(result) << result.status().message();
    Result<std::vector<std::byte>> bytes = encode_pvs(result->pvs);
    EXPECT_TRUE(bytes) << bytes.status().message();
    return std::move(bytes).value();
}

bool sees(const Pvs& pvs, const Vec3d& eye, std::uint32_t object) {
    PvsCursor cursor;
    pvs.query(eye, cursor);
    EXPECT_FALSE(cursor.everything);
    return cursor.visible[0] >> object & 1;
}

// The wall is not where the tile is halved: only an effective split can find it.
TEST(ViewTreeBake, SplitsAtTheWall) {
    Scene scene = divided_room();
    std::vector<std::byte> bytes = file_of(scene, tree_bake(Subdivision::spatial));
    Pvs pvs = Pvs::open(bytes).value();
    EXPECT_EQ(pvs.guarantee(), Guarantee::aggressive);
    EXPECT_TRUE(sees(pvs, {2, 2, 2}, kLeft));
    EXPECT_FALSE(sees(pvs, {2, 2, 2}, kRight));
    EXPECT_TRUE(sees(pvs, {6.5, 2, 2}, kRight));
    EXPECT_FALSE(sees(pvs, {6.5, 2, 2}, kLeft));
    EXPECT_TRUE(sees(pvs, {6.5, 2, 2}, kWall) && sees(pvs, {6.5, 2, 2}, kRoom));
}

TEST(ViewTreeBake, HeadingsSeparateWhatIsAheadFromWhatIsBehind) {
    Scene scene = divided_room();
    std::vector<std::byte> bytes = file_of(scene, tree_bake(Subdivision::angular));
    Pvs pvs = Pvs::open(bytes).value();
    Vec3d eye{5, 1.25, 1.25}; // in a leaf between the left box and the wall
    PvsCursor cursor;
    pvs.query_range(camera_range({eye, eye}, {1, 0, 0}, {0, 1, 0}, 0.1, 1), cursor);
    EXPECT_TRUE(cursor.visible[0] >> kWall & 1);
    EXPECT_FALSE(cursor.visible[0] >> kLeft & 1);
    pvs.query_range(camera_range({eye, eye}, {-1, 0, 0}, {0, 1, 0}, 0.1, 1), cursor);
    EXPECT_FALSE(cursor.visible[0] >> kWall & 1);
    EXPECT_TRUE(cursor.visible[0] >> kLeft & 1);
}

TEST(ViewTreeBake, AngularLeavesAreEightToASpatialOne) {
    Scene scene = divided_room();
    Result<BakeResult> spatial = bake(scene, tree_bake(Subdivision::spatial));
    Result<BakeResult> angular = bake(scene, tree_bake(Subdivision::angular));
    ASSERT_TRUE(spatial && angular);
    EXPECT_EQ(angular->statistics.cells, 8 * spatial->statistics.cells);
    EXPECT_LT(angular->statistics.mean_visible, spatial->statistics.mean_visible);
}

TEST(ViewTreeBake, SameBytesForAnyNumberOfThreads) {
    Scene scene = divided_room();
    BakeOptions options = tree_bake(Subdivision::five);
    options.tree.tile_depth = 3;
    std::vector<std::byte> expected = file_of(scene, options, 1);
    for (unsigned threads : {2u, 3u, 8u, 32u})
        EXPECT_EQ(file_of(scene, options, threads), expected) << threads;
}

TEST(ViewTreeBake, ResumedGivesTheSameBytes) {
    Scene scene = divided_room();
    BakeOptions options = tree_bake(Subdivision::five);
    options.tree.tile_depth = 2;
    std::vector<std::byte> expected = file_of(scene, options);
    options.checkpoint = testing::TempDir() + "tree_resume_" + std::to_string(::getpid()) + ".part";
    std::filesystem::remove(options.checkpoint);
    std::atomic<bool> cancel{false};
    Job job;
    job.threads = 1;
    job.cancel = &cancel;
    job.progress = [&](const Progress& progress) { cancel = progress.done >= 2; };
    EXPECT_EQ(bake(scene, options, job).status().code(), ErrorCode::cancelled);
    options.resume = true;
    Result<BakeResult> resumed = bake(scene, options);
    ASSERT_TRUE(resumed);
    EXPECT_EQ(resumed->statistics.tiles_resumed, 2u);
    EXPECT_EQ(encode_pvs(resumed->pvs).value(), expected);
    std::filesystem::remove(options.checkpoint);
}

// Handing rays to the children saves about the rays that they inherit.
TEST(ViewTreeBake, ChildrenReuseTheRaysOfTheirParent) {
    Scene scene = divided_room();
    Result<BakeResult> result = bake(scene, tree_bake(Subdivision::spatial));
    ASSERT_TRUE(result);
    EXPECT_GE(result->statistics.rays_reused, 4096u);
    EXPECT_LT(result->statistics.rays_reused, result->statistics.rays);
}

TEST(ViewTreeBake, OutsideViewSpaceEverythingIsVisible) {
    Scene scene = divided_room();
    BakeOptions options = tree_bake(Subdivision::spatial);
    std::vector<std::byte> bytes = file_of(scene, options);
    Pvs pvs = Pvs::open(bytes).value();
    PvsCursor cursor;
    pvs.query({20, 2, 2}, cursor);
    EXPECT_TRUE(cursor.everything);
    options.tree.view_space = 8;
    bytes = file_of(scene, options);
    Pvs wider = Pvs::open(bytes).value();
    wider.query({20, 2, 2}, cursor);
    EXPECT_EQ(wider.tree().bounds.max.x, 4 + 8 * 4.0);
}

} // namespace
} // namespace antumbra
