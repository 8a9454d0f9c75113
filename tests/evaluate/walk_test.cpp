#include "evaluate/two_rooms.hpp"

#include <antumbra/evaluate.hpp>

namespace antumbra {
namespace {

using test::OpenFile;
using test::two_cells;
using test::two_rooms;

View view_in(const Scene& scene, Vec3d eye, Vec3d target) {
    View view;
    view.eye = scene.to_local(eye);
    view.target = scene.to_local(target);
    view.near_plane = 0;
    return view;
}

/// Three frames in the right room, all towards its crate and the wall behind it.
std::vector<View> path_in(const Scene& scene) {
    return {view_in(scene, {1, 1.5, 3.5}, {2.5, 0.5, 1.5}), view_in(scene, {1.5, 1.5, 3.5}, {2.5, 0.5, 1.5}),
            view_in(scene, {2, 1.5, 3.5}, {2.5, 0.5, 1.5})};
}

WalkOptions quick() {
    WalkOptions options;
    options.width = 64;
    options.height = 36;
    options.repeat = 2;
    options.draw = false;
    return options;
}

const WalkMethod& method(const WalkResult& result, const std::string& name) {
    for (const WalkMethod& one : result.methods)
        if (one.name == name)
            return one;
    ADD_FAILURE() << "no method " << name;
    return result.methods.front();
}

TEST(Walk, RightAnswersLoseNothingAndWasteNothing) {
    Scene scene = two_rooms().scene();
    OpenFile file(two_cells(scene));
    WalkOptions options = quick();
    options.methods = {"none", "frustum", "pvs"};
    options.pvs = &*file.pvs;
    auto result = walk(scene, path_in(scene), options);
    ASSERT_TRUE(result) << result.status().message();
    ASSERT_EQ(result->frames.size(), 3u);
    EXPECT_EQ(result->objects_true, 2);
    EXPECT_EQ(result->truth_pixels, 3u * 64 * 36);
    EXPECT_EQ(method(*result, "none").objects_reported, 4);
    EXPECT_EQ(method(*result, "none").false_visible_objects, 2);
    EXPECT_EQ(method(*result, "pvs").objects_reported, 2);
    EXPECT_EQ(method(*result, "pvs").triangles_drawn, 24);
    EXPECT_EQ(method(*result, "pvs").false_visible_objects, 0);
    EXPECT_EQ(method(*result, "pvs").false_invisible_pixels, 0u);
    EXPECT_EQ(find_broken_promise(*result), nullptr);
}

TEST(Walk, ALostCrateIsCountedInPixelsAndBreaksThePromise) {
    Scene scene = two_rooms().scene();
    PvsData data = two_cells(scene);
    data.rows[1] = 0b0010;
    OpenFile file(data);
    WalkOptions options = quick();
    options.methods = {"frustum", "pvs"};
    options.pvs = &*file.pvs;
    auto result = walk(scene, path_in(scene), options);
    ASSERT_TRUE(result) << result.status().message();
    EXPECT_EQ(method(*result, "pvs").false_invisible_objects, 3u);
    EXPECT_GT(method(*result, "pvs").false_invisible_pixels, 300u);
    ASSERT_NE(find_broken_promise(*result), nullptr);
    EXPECT_EQ(find_broken_promise(*result)->name, "pvs");
    EXPECT_EQ(method(*result, "frustum").false_invisible_pixels, 0u);
}

TEST(Walk, FourTimesTheTruthSeesFourTimesTheLostPixels) {
    Scene scene = two_rooms().scene();
    PvsData data = two_cells(scene);
    data.rows[1] = 0b0010;
    OpenFile file(data);
    WalkOptions options = quick();
    options.methods = {"pvs"};
    options.pvs = &*file.pvs;
    auto once = walk(scene, path_in(scene), options);
    options.truth_scale = 2;
    auto twice = walk(scene, path_in(scene), options);
    ASSERT_TRUE(once && twice);
    EXPECT_EQ(twice->truth_pixels, 4 * once->truth_pixels);
    double ratio =
        double(method(*twice, "pvs").false_invisible_pixels) / double(method(*once, "pvs").false_invisible_pixels);
    EXPECT_NEAR(ratio, 4, 0.4);
}

TEST(Walk, FrustumIsAlwaysThere) {
    Scene scene = two_rooms().scene();
    WalkOptions options = quick();
    options.methods = {"none"};
    auto result = walk(scene, path_in(scene), options);
    ASSERT_TRUE(result);
    ASSERT_EQ(result->methods.size(), 2u);
    EXPECT_EQ(result->methods[0].name, "frustum");
}

TEST(Walk, SnapshotsStayWithinTheirBound) {
    Scene scene = two_rooms().scene();
    WalkOptions options = quick();
    options.snapshot_bytes = 2 * 3 * 8; // of two frames: the truth and two methods, one word each
    auto result = walk(scene, path_in(scene), options);
    ASSERT_TRUE(result);
    ASSERT_EQ(result->snapshots.size(), 2u);
    EXPECT_EQ(result->snapshots[1].frame, 2u);
    EXPECT_EQ(result->snapshots[0].seen[0], 0b1010u);
}

TEST(Walk, InsideTheCrateABakedAnswerIsNotJudged) {
    Scene scene = two_rooms().scene();
    PvsData data = two_cells(scene);
    data.rows[1] = 0;
    OpenFile file(data);
    WalkOptions options = quick();
    options.methods = {"pvs"};
    options.pvs = &*file.pvs;
    std::vector<View> path = {view_in(scene, {2.5, 0.5, 1.5}, {2.5, 0.5, 3})};
    auto result = walk(scene, path, options);
    ASSERT_TRUE(result);
    EXPECT_EQ(result->frames_in_matter, 1u);
    EXPECT_GT(result->frames[0].methods[1].false_invisible_pixels, 0u);
    EXPECT_EQ(method(*result, "pvs").false_invisible_pixels, 0u);
    EXPECT_FALSE(result->notes.empty());
}

TEST(Walk, ThreadsChangeOnlyTheTimes) {
    Scene scene = two_rooms().scene();
    Job one, three;
    one.threads = 1;
    three.threads = 3;
    auto a = walk(scene, path_in(scene), quick(), one), b = walk(scene, path_in(scene), quick(), three);
    ASSERT_TRUE(a && b);
    for (std::size_t f = 0; f < 3; ++f) {
        EXPECT_EQ(a->snapshots[f].seen, b->snapshots[f].seen);
        EXPECT_EQ(a->snapshots[f].reported, b->snapshots[f].reported);
    }
}

TEST(Walk, RefusesWhatMakesNoSense) {
    Scene scene = two_rooms().scene();
    EXPECT_EQ(walk(scene, {}, quick()).status().code(), ErrorCode::usage);
    WalkOptions options = quick();
    options.methods = {"no such method"};
    EXPECT_EQ(walk(scene, path_in(scene), options).status().code(), ErrorCode::usage);
    options = quick();
    options.methods = {"pvs"};
    EXPECT_EQ(walk(scene, path_in(scene), options).status().code(), ErrorCode::usage);
    std::vector<View> flat = path_in(scene);
    flat[1].fov_y_deg = 180;
    Status status = walk(scene, flat, quick()).status();
    EXPECT_NE(status.message().find("frame 1"), std::string::npos) << status.message();
}

TEST(Walk, RefusesAFileOfAnotherScene) {
    Scene scene = two_rooms().scene(), other = two_rooms().object("more").box({1, 2, 3}, {2, 3, 4}).scene();
    OpenFile file(two_cells(other));
    WalkOptions options = quick();
    options.pvs = &*file.pvs;
    EXPECT_EQ(walk(scene, path_in(scene), options).status().code(), ErrorCode::mismatch);
}

} // namespace
} // namespace antumbra
