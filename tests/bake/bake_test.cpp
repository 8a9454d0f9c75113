#include <antumbra/bake.hpp>

#include "support/make_scene.hpp"

#include <gtest/gtest.h>

#include <filesystem>

namespace antumbra {
namespace {

using test::SceneMaker;

/// A wall across the middle of a closed room, something on either side of it, and a solid block.
SceneMaker divided_room() {
    SceneMaker maker;
    maker.object("room").box({0, 0, 0}, {8, 4, 4}, true);
    maker.object("wall").box({3.9, 0, 0}, {4.1, 4, 4});
    maker.object("left").box({1, 1, 1}, {1.5, 1.5, 1.5});
    maker.object("right").box({6, 1, 1}, {6.5, 1.5, 1.5});
    maker.object("pane", 0).quad({5, 1, 1}, {5, 1, 3}, {5, 3, 3}, {5, 3, 1});
    return maker;
}

enum : std::uint32_t { kRoom, kWall, kLeft, kRight, kPane };

BakeOptions small_bake() {
    BakeOptions options;
    options.cells = {2, 1, 1};
    options.rays_per_cell = 4096;
    options.holdout_rays = 256;
    return options;
}

bool listed(const PvsData& pvs, std::uint64_t cell, std::uint32_t object) {
    std::uint32_t row = pvs.cell_row[cell];
    EXPECT_LT(row, pvs.row_count);
    return pvs.rows[row * pvs.words_per_row() + object / 64] >> (object % 64) & 1;
}

Job threads_job(unsigned threads) {
    Job job;
    job.threads = threads;
    return job;
}

std::vector<std::byte> file_of(const Scene& scene, const BakeOptions& options, const Job& job = {}) {
    Result<BakeResult> result = bake(scene, options, job);
    EXPECT_TRUE(result) << result.status().message();
    return std::move(encode_pvs(result->pvs)).value();
}

TEST(Bake, AWallHidesWhatIsBehindIt) {
    Scene scene = divided_room().scene();
    Result<BakeResult> result = bake(scene, small_bake());
    ASSERT_TRUE(result) << result.status().message();
    const PvsData& pvs = result->pvs;
    EXPECT_EQ(pvs.guarantee, Guarantee::aggressive);
    EXPECT_TRUE(listed(pvs, 0, kRoom) && listed(pvs, 0, kWall) && listed(pvs, 0, kLeft));
    EXPECT_FALSE(listed(pvs, 0, kRight));
    EXPECT_TRUE(listed(pvs, 1, kRoom) && listed(pvs, 1, kWall) && listed(pvs, 1, kRight));
    EXPECT_FALSE(listed(pvs, 1, kLeft));
    EXPECT_EQ(result->statistics.cells_baked, 2u);
    EXPECT_EQ(result->statistics.holdout_misses, 0u);
    EXPECT_EQ(result->statistics.holdout_rays, 512u);
}

// The pane is seen only from its front (+x side of its normal) and hides nothing.
TEST(Bake, APaneIsSeenFromItsFrontAndHidesNothing) {
    SceneMaker maker;
    maker.object("room").box({0, 0, 0}, {8, 4, 4}, true);
    maker.object("pane", 0).quad({4, 0, 0}, {4, 4, 0}, {4, 4, 4}, {4, 0, 4});
    maker.object("left").box({1, 1, 1}, {1.5, 1.5, 1.5});
    Scene scene = maker.scene();
    Result<BakeResult> result = bake(scene, small_bake());
    ASSERT_TRUE(result);
    EXPECT_FALSE(listed(result->pvs, 0, 1)); // its back
    EXPECT_TRUE(listed(result->pvs, 1, 1));
    EXPECT_TRUE(listed(result->pvs, 1, 2)); // through it
}

TEST(Bake, CellsInsideMatterAreNoViewpoints) {
    SceneMaker maker;
    maker.object("room").box({0, 0, 0}, {8, 4, 4}, true);
    maker.object("block").box({4.5, 0.5, 0.5}, {7.5, 3.5, 3.5});
    BakeOptions options = small_bake();
    options.where = {Box3d{{1, 1, 1}, {3, 3, 3}}, Box3d{{5, 1, 1}, {7, 3, 3}}};
    options.cells = {3, 1, 1};
    Result<BakeResult> result = bake(maker.scene(), options);
    ASSERT_TRUE(result);
    EXPECT_EQ(result->statistics.cells_baked, 1u);
    EXPECT_EQ(result->statistics.cells_solid, 1u);
    EXPECT_EQ(result->statistics.cells_not_baked, 1u);
    EXPECT_EQ(result->pvs.cell_row, (std::vector<std::uint32_t>{0, kCellNotBaked, kCellSolid}));
}

TEST(Bake, MovingObjectsAreListedEverywhere) {
    SceneMaker maker = divided_room();
    maker.object("door", kOccludes | kMoves).box({7, 1, 1}, {7.2, 2, 2});
    Result<BakeResult> result = bake(maker.scene(), small_bake());
    ASSERT_TRUE(result);
    EXPECT_TRUE(listed(result->pvs, 0, 5));
}

TEST(Bake, SameBytesForAnyNumberOfThreads) {
    Scene scene = divided_room().scene();
    BakeOptions options = small_bake();
    options.cells = {6, 2, 3};
    options.rays_per_cell = 512;
    std::vector<std::byte> expected = file_of(scene, options, threads_job(1));
    for (unsigned threads : {2u, 3u, 4u, 7u, 8u, 16u, 32u})
        for (int run = 0; run < 3; ++run)
            ASSERT_EQ(file_of(scene, options, threads_job(threads)), expected) << threads << " threads";
}

TEST(Bake, OtherSeedsDrawOtherRays) {
    Scene scene = divided_room().scene();
    BakeOptions options = small_bake();
    std::vector<std::byte> first = file_of(scene, options);
    options.seed = 2;
    EXPECT_NE(file_of(scene, options), first);
}

// A cell's row depends on the cell alone: baking only part of the grid gives the same bits there.
TEST(Bake, PartOfTheGridGivesTheSameRows) {
    Scene scene = divided_room().scene();
    BakeOptions options = small_bake();
    options.cell_size = 1;
    options.rays_per_cell = 512;
    Result<BakeResult> whole = bake(scene, options);
    ASSERT_TRUE(whole);
    options.where = {Box3d{{2, 1, 1}, {4, 3, 3}}};
    Result<BakeResult> part = bake(scene, options);
    ASSERT_TRUE(part);
    ASSERT_EQ(part->pvs.grid.cells(), 8u);
    for (std::uint64_t cell = 0; cell < part->pvs.grid.cells(); ++cell) {
        Box3d box = part->pvs.grid.cell(cell);
        std::int64_t same = whole->pvs.grid.find(box.centre());
        ASSERT_GE(same, 0);
        ASSERT_EQ(whole->pvs.grid.cell(std::uint64_t(same)), box);
        for (std::uint32_t o = 0; o < 5; ++o)
            EXPECT_EQ(listed(part->pvs, cell, o), listed(whole->pvs, std::uint64_t(same), o));
    }
}

TEST(Bake, ResumedAfterAnyStopGivesTheSameBytes) {
    Scene scene = divided_room().scene();
    BakeOptions options = small_bake();
    options.cells = {5, 2, 2};
    options.rays_per_cell = 256;
    std::vector<std::byte> expected = file_of(scene, options);
    options.checkpoint = testing::TempDir() + "bake_resume_" + std::to_string(::getpid()) + ".part";
    for (std::uint64_t stop_after : {1u, 7u, 19u}) {
        std::filesystem::remove(options.checkpoint);
        std::atomic<bool> cancel{false};
        Job job = threads_job(1);
        job.progress = [&](const Progress& p) { cancel = p.done >= stop_after; };
        job.cancel = &cancel;
        options.resume = false;
        Result<BakeResult> stopped = bake(scene, options, job);
        ASSERT_FALSE(stopped);
        EXPECT_EQ(stopped.status().code(), ErrorCode::cancelled);
        options.resume = true;
        Result<BakeResult> resumed = bake(scene, options);
        ASSERT_TRUE(resumed) << resumed.status().message();
        EXPECT_EQ(resumed->statistics.cells_resumed, stop_after);
        EXPECT_EQ(encode_pvs(resumed->pvs).value(), expected);
    }
    std::filesystem::remove(options.checkpoint);
}

TEST(Bake, SenselessOptionsAreRefused) {
    Scene scene = divided_room().scene();
    auto code = [&](auto change) {
        BakeOptions options = small_bake();
        change(options);
        Result<BakeResult> result = bake(scene, options);
        return result ? ErrorCode::ok : result.status().code();
    };
    EXPECT_EQ(code([](BakeOptions& o) { o.method = "magic"; }), ErrorCode::usage);
    EXPECT_EQ(code([](BakeOptions& o) { o.cells = {0, 1, 1}; }), ErrorCode::usage);
    EXPECT_EQ(code([](BakeOptions& o) { o.cell_size = NAN; }), ErrorCode::usage);
    EXPECT_EQ(code([](BakeOptions& o) { o.cell_size = 1e-6; }), ErrorCode::limit);
    EXPECT_EQ(code([](BakeOptions& o) { o.where = {Box3d{{1, 1, 1}, {0, 2, 2}}}; }), ErrorCode::usage);
    EXPECT_EQ(code([](BakeOptions& o) { o.rays_per_cell = 0; }), ErrorCode::usage);
}

TEST(Bake, PlanTellsWhatBakeWouldDo) {
    Scene scene = divided_room().scene();
    BakeOptions options = small_bake();
    options.cell_size = 1;
    Result<BakePlan> plan = plan_bake(scene, options);
    ASSERT_TRUE(plan);
    EXPECT_EQ(plan->cells_to_bake, 8u * 4 * 4);
    EXPECT_EQ(plan->grid.count, (std::array<std::uint32_t, 3>{8, 4, 4}));
    EXPECT_GT(plan->estimated_seconds, 0);
    EXPECT_GT(plan->estimated_bytes, 0u);
}

} // namespace
} // namespace antumbra
