#include "bake/viewpoint.hpp"
#include "evaluate/two_rooms.hpp"
#include "evaluate/walkable.hpp"

#include <antumbra/evaluate.hpp>

namespace antumbra {
namespace {

using test::SceneMaker;

/// A flat of two rooms, 8 x 2.5 x 5, with a door of 1 x 2 between them and a table in the left one.
Scene flat() {
    SceneMaker maker;
    maker.object("shell").box({-4, 0, 0}, {4, 2.5, 5}, true);
    maker.object("wall left of the door").box({-0.1, 0, 0}, {0.1, 2.5, 2});
    maker.object("wall right of the door").box({-0.1, 0, 3}, {0.1, 2.5, 5});
    maker.object("lintel").box({-0.1, 2, 2}, {0.1, 2.5, 3});
    maker.object("table").box({-3, 0.7, 2}, {-2, 0.8, 3});
    return maker.scene();
}

PathOptions frames(std::uint32_t count, std::uint64_t seed = 1) {
    PathOptions options;
    options.frames = count;
    options.seed = seed;
    return options;
}

TEST(FindPath, WalksThroughTheFlatWithoutTouchingAnything) {
    Scene scene = flat();
    Tracer tracer = Tracer::build(scene);
    auto path = find_path(scene, frames(60));
    ASSERT_TRUE(path) << path.status().message();
    ASSERT_EQ(path->views.size(), 60u);
    for (std::size_t f = 0; f < 60; ++f) {
        Vec3d eye = path->views[f].eye;
        EXPECT_TRUE(is_viewpoint(tracer, eye)) << f;
        EXPECT_EQ(problem_of(path->views[f]), nullptr) << f;
        Vec3d world = scene.to_world(eye);
        EXPECT_GT(world.y, 0.9) << f;
        EXPECT_LT(world.y, 2.0) << "through the door: " << f;
        EXPECT_TRUE(is_free(tracer, path->views[f > 0 ? f - 1 : 0].eye, eye)) << f;
    }
}

TEST(FindPath, SeesBothRooms) {
    Scene scene = flat();
    auto path = find_path(scene, frames(60));
    ASSERT_TRUE(path);
    bool left = false, right = false;
    for (const View& view : path->views)
        (scene.to_world(view.eye).x < 0 ? left : right) = true;
    EXPECT_TRUE(left && right);
}

TEST(FindPath, GoesOnInEvenSteps) {
    auto path = find_path(flat(), frames(60));
    ASSERT_TRUE(path);
    double sum = 0, longest = 0;
    for (std::size_t f = 1; f < 60; ++f) {
        double step = length(path->views[f].eye - path->views[f - 1].eye);
        sum += step;
        longest = std::max(longest, step);
    }
    EXPECT_GT(sum / 59, 0.8 * longest); // the chords of bends are shorter than the way
    EXPECT_GT(longest, 0.1);
}

TEST(FindPath, SameSeedSameWalkWhateverTheThreads) {
    Scene scene = flat();
    Job one, three;
    one.threads = 1;
    three.threads = 3;
    auto a = find_path(scene, frames(30), one), b = find_path(scene, frames(30), three);
    auto other = find_path(scene, frames(30, 2), one);
    ASSERT_TRUE(a && b && other);
    bool differs = false;
    for (std::size_t f = 0; f < 30; ++f) {
        EXPECT_EQ(a->views[f].eye, b->views[f].eye);
        EXPECT_EQ(a->views[f].target, b->views[f].target);
        differs |= a->views[f].eye != other->views[f].eye;
    }
    EXPECT_TRUE(differs);
}

TEST(FindPath, OrbitsWhereNobodyCanStand) {
    Scene scene = SceneMaker().object("ceiling").quad({-1, 0, -1}, {1, 0, -1}, {1, 0, 1}, {-1, 0, 1}).scene();
    auto path = find_path(scene, frames(8));
    ASSERT_TRUE(path);
    EXPECT_NE(path->description.find("orbits"), std::string::npos) << path->description;
    Vec3d centre = to_double(scene.local_bounds()).centre();
    for (const View& view : path->views) {
        EXPECT_NEAR(length(view.eye - centre), length(path->views[0].eye - centre), 1e-9);
        EXPECT_EQ(view.target, centre);
    }
    EXPECT_GT(length(path->views[4].eye - path->views[0].eye), 1);
}

TEST(FindPath, OrbitsOnRequest) {
    PathOptions options = frames(4);
    options.kind = PathKind::orbit;
    Scene scene = flat();
    auto path = find_path(scene, options);
    ASSERT_TRUE(path);
    Box3d bounds = to_double(scene.local_bounds());
    for (const View& view : path->views)
        EXPECT_FALSE(bounds.contains(view.eye));
    // A quarter turn from frame to frame.
    Vec3d centre = bounds.centre(), first = path->views[0].eye - centre, second = path->views[1].eye - centre;
    EXPECT_NEAR(first.x * second.x + first.z * second.z, 0, 1e-9);
}

TEST(FindPath, KeepsTheEyeHeightThatIsAsked) {
    PathOptions options = frames(20);
    options.eye_height = 1.25;
    auto path = find_path(flat(), options);
    ASSERT_TRUE(path);
    for (const View& view : path->views)
        EXPECT_NEAR(flat().to_world(view.eye).y, 1.25, 1e-5);
}

TEST(FindPath, RefusesWhatMakesNoSense) {
    EXPECT_EQ(find_path(flat(), frames(0)).status().code(), ErrorCode::usage);
}

} // namespace
} // namespace antumbra
