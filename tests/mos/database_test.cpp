// The database of occluder lists: the same bytes however it is computed, and good for its culler.
#include <antumbra/mos.hpp>

#include "cull/proof.hpp"

#include <filesystem>

namespace antumbra {
namespace {

using test::Stage;

Stage soup() {
    Random random(97);
    Result<Scene> scene = Scene::create(test::random_soup(random, 80, 8));
    return Stage(std::move(*scene));
}

MosOptions small() {
    MosOptions options;
    options.grid = {3, 1, 2};
    options.resolution = 48;
    options.least_primitives = 1;
    options.most_primitives = 16;
    options.limit = 20;
    return options;
}

bool same(const OccluderDatabase& a, const OccluderDatabase& b) {
    return a.first == b.first && a.polygons == b.polygons && a.count == b.count && a.origin == b.origin;
}

TEST(OccluderDatabase, is_the_same_for_any_number_of_threads) {
    Stage stage = soup();
    Job one, four;
    one.threads = 1;
    four.threads = 4;
    auto a = build_occluder_database(*stage.scene, stage.occluders, small(), one);
    auto b = build_occluder_database(*stage.scene, stage.occluders, small(), four);
    ASSERT_TRUE(a.ok() && b.ok());
    EXPECT_TRUE(same(*a, *b));
    EXPECT_GT(a->polygons.size(), 20u);
    EXPECT_TRUE(check_occluder_database(*a, stage.occluders.polygons.size()).ok());
}

TEST(OccluderDatabase, is_the_same_when_interrupted_and_resumed) {
    Stage stage = soup();
    MosOptions options = small();
    options.checkpoint = ::testing::TempDir() + "mos_test.checkpoint";
    std::filesystem::remove(options.checkpoint);
    auto whole = build_occluder_database(*stage.scene, stage.occluders, small());
    Job job;
    job.threads = 1;
    std::uint64_t done = 0;
    std::atomic<bool> stop{false};
    job.cancel = &stop;
    job.progress = [&](const Progress& progress) {
        done = progress.done;
        stop = done >= 2;
    };
    auto cut = build_occluder_database(*stage.scene, stage.occluders, options, job);
    ASSERT_FALSE(cut.ok());
    EXPECT_EQ(cut.status().code(), ErrorCode::cancelled);
    options.resume = true;
    MosStatistics statistics;
    auto resumed = build_occluder_database(*stage.scene, stage.occluders, options, {}, &statistics);
    ASSERT_TRUE(resumed.ok()) << resumed.status().message();
    EXPECT_EQ(statistics.points_resumed, done);
    EXPECT_TRUE(same(*whole, *resumed));
    std::filesystem::remove(options.checkpoint);
}

TEST(OccluderDatabase, nonsense_is_refused) {
    Stage stage = soup();
    auto code = [&](auto&& change) {
        MosOptions options = small();
        change(options);
        return build_occluder_database(*stage.scene, stage.occluders, options).status().code();
    };
    EXPECT_EQ(code([](MosOptions& o) { o.grid[1] = 0; }), ErrorCode::usage);
    EXPECT_EQ(code([](MosOptions& o) { o.grid = {1u << 20, 1u << 20, 1}; }), ErrorCode::usage);
    EXPECT_EQ(code([](MosOptions& o) { o.resolution = 4; }), ErrorCode::usage);
    EXPECT_EQ(code([](MosOptions& o) { o.limit = 0; }), ErrorCode::usage);
    EXPECT_EQ(code([](MosOptions& o) { o.polygon_weight = 0; }), ErrorCode::usage);
    EXPECT_EQ(code([](MosOptions& o) { o.size_weight = NAN; }), ErrorCode::usage);
}

/// Whatever the lists hold, the culler that draws them loses no line of sight.
TEST(OccluderDatabase, its_culler_loses_nothing) {
    test::ProofCounts counts;
    for (std::uint32_t trial = 0; trial < 8; ++trial) {
        Random random(98, trial);
        Result<Scene> scene = Scene::create(test::random_soup(random, 80, 8));
        Stage stage(std::move(*scene));
        MosOptions options = small();
        options.region = {{-8, -8, -8}, {8, 8, 8}};
        options.grid = {2, 2, 2};
        auto database = build_occluder_database(*stage.scene, stage.occluders, options);
        ASSERT_TRUE(database.ok());
        CullerOptions with;
        with.opacity.database = &*database;
        with.opacity.adaptive = false;
        auto culler = make_culler("opacity", stage.cull_scene, with);
        ASSERT_TRUE(culler.ok());
        ViewState state;
        for (int frame = 0; frame < 20; ++frame) {
            View view = test::random_view(random, {0, 0, 0}, 8);
            if (problem_of(view) == nullptr)
                test::prove(stage, **culler, view, state, 24, 24, random, counts);
        }
    }
    EXPECT_GT(counts.hidden, 100u);
}

} // namespace
} // namespace antumbra
