#include "evaluate/two_rooms.hpp"

#include <antumbra/evaluate.hpp>

namespace antumbra {
namespace {

using test::OpenFile;
using test::SceneMaker;
using test::two_cells;
using test::two_rooms;

VerifyOptions quick() {
    VerifyOptions options;
    options.samples = 24;
    options.face_size = 24;
    return options;
}

TEST(Verify, RightFileHasNothingFalseInvisible) {
    Scene scene = two_rooms().scene();
    auto result = verify(scene, *OpenFile(two_cells(scene)).pvs, quick());
    ASSERT_TRUE(result) << result.status().message();
    EXPECT_EQ(result->viewpoints, 24u);
    EXPECT_EQ(result->pixels, 24u * 6 * 24 * 24);
    EXPECT_EQ(result->false_invisible_objects, 0u);
    EXPECT_EQ(result->false_invisible_pixels, 0u);
    EXPECT_EQ(result->unconfirmed_pixels, 0u);
    EXPECT_EQ(result->reported_objects, 48u);
    EXPECT_TRUE(result->worst.empty());
}

TEST(Verify, FindsARemovedBit) {
    Scene scene = two_rooms().scene();
    PvsData data = two_cells(scene);
    data.rows[1] = 0b0010; // the right crate is lost
    auto result = verify(scene, *OpenFile(data).pvs, quick());
    ASSERT_TRUE(result) << result.status().message();
    EXPECT_GT(result->false_invisible_pixels, 0u);
    ASSERT_FALSE(result->worst.empty());
    for (const FalseInvisible& one : result->worst) {
        EXPECT_EQ(one.object, 3u);
        EXPECT_EQ(one.cell, 1);
        EXPECT_GT(one.eye.x, 0);
    }
    for (std::size_t k = 1; k < result->worst.size(); ++k)
        EXPECT_GE(result->worst[k - 1].pixels, result->worst[k].pixels);
}

TEST(Verify, CountsWhatIsReportedButNeverSeen) {
    Scene scene = two_rooms().scene();
    PvsData data = two_cells(scene);
    data.rows = {0b1111, 0b1111};
    auto result = verify(scene, *OpenFile(data).pvs, quick());
    ASSERT_TRUE(result) << result.status().message();
    EXPECT_EQ(result->reported_objects, 24u * 4);
    EXPECT_EQ(result->false_visible_objects, result->reported_objects - result->seen_objects);
    EXPECT_GE(result->false_visible_objects, 48u);
}

/// A leaf for the left room; for the right one a leaf that looks towards +z and one that looks towards -z.
PvsData leaves_by_direction(const Scene& scene) {
    PvsData data = two_cells(scene);
    data.tree.bounds = data.grid.bounds;
    data.grid = {};
    data.cell_row.clear();
    data.tree.nodes = {{0, kViewSteps / 2, 2},
                       {ViewNode::kLeaf, 0, 0},
                       {3, kViewSteps / 2, 4},
                       {ViewNode::kLeaf, 0, 1},
                       {ViewNode::kLeaf, 0, 2}};
    data.row_count = 3;
    data.rows = {0b0101, 0b1010, 0b1010};
    return data;
}

TEST(Verify, AViewTreeThatIsRightHasNothingFalseInvisible) {
    Scene scene = two_rooms().scene();
    auto result = verify(scene, *OpenFile(leaves_by_direction(scene)).pvs, quick());
    ASSERT_TRUE(result) << result.status().message();
    EXPECT_EQ(result->viewpoints, 24u);
    EXPECT_EQ(result->false_invisible_pixels, 0u);
}

TEST(Verify, FindsABitThatIsMissingInOneDirectionOnly) {
    Scene scene = two_rooms().scene();
    PvsData data = leaves_by_direction(scene);
    data.rows[2] = 0b0010; // who looks towards -z misses the right crate
    auto result = verify(scene, *OpenFile(data).pvs, quick());
    ASSERT_TRUE(result) << result.status().message();
    ASSERT_FALSE(result->worst.empty());
    for (const FalseInvisible& one : result->worst) {
        EXPECT_EQ(one.object, 3u);
        EXPECT_GT(one.eye.z, 1) << "the crate, from 1 to 2, is seen towards -z from behind it only";
    }
}

TEST(Verify, NoViewpointLiesInsideTheCrates) {
    Scene scene = SceneMaker().object("solid").box({0, 0, 0}, {1, 1, 1}).scene();
    PvsData data = two_cells(two_rooms().scene());
    data.scene_fingerprint = scene.fingerprint();
    data.structure_fingerprint = scene.structure_fingerprint();
    data.origin = scene.origin();
    data.objects.resize(1);
    data.objects[0].bounds = scene.objects()[0].bounds;
    data.grid.bounds = {{0.25, 0.25, 0.25}, {0.75, 0.75, 0.75}};
    data.rows = {1, 1};
    auto result = verify(scene, *OpenFile(data).pvs, quick());
    ASSERT_FALSE(result);
    EXPECT_EQ(result.status().code(), ErrorCode::usage);
}

TEST(Verify, ThreadsDoNotChangeTheResult) {
    Scene scene = two_rooms().scene();
    PvsData data = two_cells(scene);
    data.rows[0] = 0b0100;
    OpenFile file(data);
    std::optional<VerifyResult> first;
    for (unsigned threads : {1u, 3u}) {
        Job job;
        job.threads = threads;
        auto result = verify(scene, *file.pvs, quick(), job);
        ASSERT_TRUE(result);
        if (!first)
            first = *result;
        EXPECT_EQ(result->false_invisible_pixels, first->false_invisible_pixels);
        EXPECT_EQ(result->seen_objects, first->seen_objects);
        ASSERT_EQ(result->worst.size(), first->worst.size());
        for (std::size_t k = 0; k < first->worst.size(); ++k)
            EXPECT_EQ(result->worst[k].eye, first->worst[k].eye);
    }
}

TEST(CheckBelongs, AcceptsItsOwnScene) {
    Scene scene = two_rooms().scene();
    EXPECT_TRUE(check_belongs(scene, *OpenFile(two_cells(scene)).pvs));
}

TEST(CheckBelongs, NamesAnotherScene) {
    Scene scene = two_rooms().scene();
    Scene other = two_rooms().object("more").box({1, 0, 3}, {2, 1, 4}).scene();
    Status status = check_belongs(other, *OpenFile(two_cells(scene)).pvs);
    EXPECT_EQ(status.code(), ErrorCode::mismatch);
    EXPECT_NE(status.message().find("another scene"), std::string::npos);
    EXPECT_NE(status.message().find("again"), std::string::npos);
}

TEST(CheckBelongs, SaysWhenOnlyTheStructureMatches) {
    Scene scene = two_rooms().scene();
    RawScene raw = two_rooms().raw();
    raw.positions.back().y += 0.5;
    auto moved = Scene::create(raw);
    ASSERT_TRUE(moved);
    Status status = check_belongs(*moved, *OpenFile(two_cells(scene)).pvs);
    EXPECT_EQ(status.code(), ErrorCode::mismatch);
    EXPECT_NE(status.message().find("only the structure"), std::string::npos);
}

TEST(CheckBelongs, SaysWhenTheSidesDiffer) {
    Scene scene = two_rooms().scene();
    SceneOptions both;
    both.sides = SidesOption::both;
    Status status = check_belongs(two_rooms().scene(both), *OpenFile(two_cells(scene)).pvs);
    EXPECT_EQ(status.code(), ErrorCode::mismatch);
    EXPECT_NE(status.message().find("--sides material"), std::string::npos);
}

} // namespace
} // namespace antumbra
