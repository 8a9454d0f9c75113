#include <antumbra/cull.hpp>
#include <antumbra/scene.hpp>

#include "cull/random_views.hpp"
#include "cull/scene_data.hpp"
#include "geometry/camera.hpp"

#include <gtest/gtest.h>

#include <set>

namespace antumbra {
namespace {

using test::Volume;

CullResult run(const Culler& culler, const View& view) {
    ViewState state;
    CullResult result;
    culler.cull(view, state, result);
    return result;
}

std::unique_ptr<Culler> make(std::string_view name, const CullScene& scene, CullerOptions options = {}) {
    auto culler = make_culler(name, scene, options);
    EXPECT_TRUE(culler.ok()) << culler.status().message();
    return std::move(culler).value();
}

CullScene scene_of(const std::vector<Box3f>& boxes, const std::vector<std::uint32_t>& flags = {}) {
    CullSceneInput input;
    input.bounds = boxes;
    input.flags = flags;
    return CullScene::create(input);
}

/// Looks along -z from the origin, 90 degrees both ways: the sides are the planes |x| = -z and |y| = -z.
View square_view() {
    View view;
    view.fov_y_deg = 90;
    view.aspect = 1;
    view.near_plane = 1;
    view.far_plane = 100;
    return view;
}

TEST(Camera, half_angle_agrees_with_libm_to_the_last_digits) {
    for (double degrees = 0.001; degrees < 180; degrees += 0.37) {
        HalfAngle half = half_angle(degrees);
        long double radians = degrees * 3.14159265358979323846264338327950288L / 360;
        EXPECT_NEAR(half.sine, double(std::sin(radians)), 3e-16) << degrees;
        EXPECT_NEAR(half.cosine, double(std::cos(radians)), 3e-16) << degrees;
    }
}

TEST(Frustum, boxes_that_touch_a_plane_from_outside_are_inside) {
    std::vector<Box3f> boxes;
    for (float k : {1.0f, 2.0f, 3.0f, 7.0f, 50.0f, 99.0f})
        for (float s : {1.0f, -1.0f}) {
            float in = std::min(s * k, s * k + s), out = std::max(s * k, s * k + s);
            boxes.push_back({{in, 0, -k}, {out, 0, -k}}); // a segment whose one end lies on x = +-z
            boxes.push_back({{0, in, -k}, {0, out, -k}});
        }
    boxes.push_back({{0, 0, -1}, {0.5f, 0.5f, 5}});      // touches the near plane from behind
    boxes.push_back({{0, 0, -200}, {0.5f, 0.5f, -100}}); // touches the far plane from beyond
    CullScene scene = scene_of(boxes);
    for (const char* name : {"frustum-scalar", "frustum"})
        EXPECT_EQ(run(*make(name, scene), square_view()).visible_count, boxes.size()) << name;
}

TEST(Frustum, boxes_a_thousandth_outside_are_rejected) {
    std::vector<Box3f> boxes;
    for (float k : {1.0f, 2.0f, 3.0f, 7.0f, 50.0f})
        for (float s : {1.001f, -1.001f}) {
            boxes.push_back({{s * k, 0, -k}, {s * k, 0, -k}});
            boxes.push_back({{0, s * k, -k}, {0, s * k, -k}});
        }
    boxes.push_back({{0, 0, -0.999f}, {0, 0, 10}});
    boxes.push_back({{0, 0, -200}, {0, 0, -100.01f}});
    CullScene scene = scene_of(boxes);
    for (const char* name : {"frustum-scalar", "frustum"}) {
        CullResult result = run(*make(name, scene), square_view());
        EXPECT_EQ(result.visible_count, 0u) << name;
        EXPECT_FALSE(result.everything) << name;
    }
}

TEST(Frustum, never_drops_a_box_that_holds_a_point_of_the_view_volume) {
    for (std::uint32_t trial = 0; trial < 400; ++trial) {
        Random random(11, trial);
        double size = std::ldexp(1.0, int(random.below(30)) - 10);
        double distance = random.below(2) ? 0 : size * random.uniform(0, 1e6);
        Vec3d centre{distance, -distance * random.uniform(), distance * random.uniform()};
        View view = test::random_view(random, centre, size);
        ASSERT_EQ(problem_of(view), nullptr);
        Volume volume(view);
        std::vector<Box3f> boxes;
        double reach = std::min(view.far_plane, view.near_plane + 2 * size);
        for (int i = 0; i < 50; ++i) {
            // A point of the volume, often on its boundary; then the smallest float box around it, or one that
            // leaves it towards a random side.
            auto coordinate = [&] { return random.below(3) ? random.uniform(-1, 1) : random.below(2) ? 1.0 : -1.0; };
            long double point[3];
            volume.point(coordinate(), coordinate(), random.uniform(view.near_plane, reach), point);
            Box3f box;
            for (int k = 0; k < 3; ++k) {
                box.min[k] = test::nearest_below(double(point[k]));
                box.max[k] = test::nearest_above(double(point[k]));
                float grow = random.below(2) ? static_cast<float>(random.uniform() * size) : 0;
                if (random.below(2))
                    box.max[k] += grow;
                else
                    box.min[k] -= grow;
            }
            boxes.push_back(box);
        }
        std::vector<Box3f> others = test::random_boxes(random, 100, centre, size);
        boxes.insert(boxes.end(), others.begin(), others.end());
        CullScene scene = scene_of(boxes);
        for (const char* name : {"frustum-scalar", "frustum"}) {
            CullResult result = run(*make(name, scene), view);
            for (std::uint32_t o = 0; o < 50; ++o)
                EXPECT_TRUE(result.is_visible(o)) << name << " trial " << trial << " object " << o;
        }
    }
}

TEST(Frustum, rejects_what_is_clearly_outside) {
    std::uint64_t rejected = 0;
    for (std::uint32_t trial = 0; trial < 100; ++trial) {
        Random random(12, trial);
        View view = test::random_view(random, {0, 0, 0}, 100);
        std::vector<Box3f> boxes = test::random_boxes(random, 300, {0, 0, 0}, 100);
        Volume volume(view);
        CullScene scene = scene_of(boxes);
        CullResult result = run(*make("frustum", scene), view);
        for (std::uint32_t o = 0; o < boxes.size(); ++o)
            if (volume.outside(boxes[o]) > 0.001L) { // a hundred-thousandth of the scene
                EXPECT_FALSE(result.is_visible(o)) << trial;
                ++rejected;
            }
    }
    EXPECT_GT(rejected, 10000u);
}

TEST(Frustum, wide_tree_and_scalar_method_agree_on_every_object) {
    for (std::uint32_t trial = 0; trial < 200; ++trial) {
        Random random(13, trial);
        double size = std::ldexp(1.0, int(random.below(40)) - 20);
        Vec3d centre{size * random.uniform(-10, 10), 0, size * random.uniform(-1000, 1000)};
        std::vector<Box3f> boxes = test::random_boxes(random, 1 + random.below(700), centre, size);
        CullScene scene = scene_of(boxes);
        auto scalar = make("frustum-scalar", scene), wide = make("frustum", scene);
        for (int v = 0; v < 5; ++v) {
            View view = test::random_view(random, centre, size);
            EXPECT_EQ(run(*scalar, view).visible, run(*wide, view).visible) << trial;
        }
    }
}

TEST(Frustum, every_instruction_set_gives_the_same_bits) {
    for (std::uint32_t trial = 0; trial < 200; ++trial) {
        Random random(14, trial);
        std::vector<Box3f> boxes = test::random_boxes(random, 1 + random.below(500), {0, 0, 0}, 10);
        CullScene scene = scene_of(boxes);
        View view = test::random_view(random, {0, 0, 0}, 10);
        CullerOptions plain;
        plain.instruction_set = InstructionSet::scalar;
        CullResult expected = run(*make("frustum", scene, plain), view);
        for (InstructionSet set : {InstructionSet::avx2, InstructionSet::avx512}) {
            CullerOptions options;
            options.instruction_set = set;
            auto culler = make_culler("frustum", scene, options);
            if (!culler) {
                EXPECT_EQ(culler.status().code(), ErrorCode::unsupported);
                continue;
            }
            CullResult result = run(**culler, view);
            EXPECT_EQ(result.visible, expected.visible);
            EXPECT_EQ(result.counters.outside_frustum, expected.counters.outside_frustum);
        }
    }
}

struct BadView {
    const char* name;
    void (*spoil)(View&);
};

TEST(View, makes_no_sense_then_everything_is_visible_and_the_result_says_why) {
    const BadView views[] = {
        {"zero field of view", [](View& v) { v.fov_y_deg = 0; }},
        {"half turn", [](View& v) { v.fov_y_deg = 180; }},
        {"NaN field of view", [](View& v) { v.fov_y_deg = std::nan(""); }},
        {"NaN eye", [](View& v) { v.eye.y = std::nan(""); }},
        {"infinite target", [](View& v) { v.target.x = INFINITY; }},
        {"near beyond far", [](View& v) { v.near_plane = 101; }},
        {"near equals far", [](View& v) { v.near_plane = v.far_plane; }},
        {"NaN far", [](View& v) { v.far_plane = std::nan(""); }},
        {"negative near", [](View& v) { v.near_plane = -1; }},
        {"zero aspect", [](View& v) { v.aspect = 0; }},
        {"looks nowhere", [](View& v) { v.target = v.eye; }},
        {"up along the view", [](View& v) { v.up = v.target - v.eye; }},
        {"no up", [](View& v) { v.up = {0, 0, 0}; }},
        {"flat orthographic", [](View& v) { v.projection = Projection::orthographic; v.height = 0; }},
    };
    Random random(15);
    CullScene scene = scene_of(test::random_boxes(random, 70, {0, 0, 0}, 10));
    for (std::string_view name : culler_names()) {
        if (name == "pvs")
            continue; // needs a file; pvs_culler_test.cpp
        auto culler = make(name, scene);
        for (const BadView& bad : views) {
            View view = square_view();
            bad.spoil(view);
            ASSERT_NE(problem_of(view), nullptr) << bad.name;
            CullResult result = run(*culler, view);
            EXPECT_EQ(result.visible_count, 70u) << name << ": " << bad.name;
            EXPECT_TRUE(result.everything) << name << ": " << bad.name;
            EXPECT_STREQ(result.reason, problem_of(view)) << name << ": " << bad.name;
        }
    }
}

TEST(CullScene, always_visible_and_unusable_boxes_are_reported_from_anywhere) {
    static_assert(kAlwaysVisibleFlag == kAlwaysVisible);
    float nan = std::nanf("");
    std::vector<Box3f> boxes{{{0, 0, 10}, {1, 1, 11}},  // behind the eye: culled
                             {{0, 0, 10}, {1, 1, 11}},  // the same, flagged
                             {{0, nan, 10}, {1, 1, 11}},
                             {{2, 0, 10}, {1, 1, 11}},  // empty
                             {{0, 0, 10}, {1, 1, INFINITY}},
                             {{0, 0, 10}, {1, 1, 1e18f}}};
    CullScene scene = scene_of(boxes, {0, kAlwaysVisible, 0, 0, 0, 0});
    for (const char* name : {"frustum-scalar", "frustum"}) {
        CullResult result = run(*make(name, scene), square_view());
        EXPECT_EQ(result.visible, std::vector<std::uint64_t>{0b111110}) << name;
        EXPECT_EQ(result.visible_count, 5u) << name;
    }
}

TEST(CullScene, empty_and_single_object_scenes_work) {
    for (const char* name : {"none", "frustum-scalar", "frustum"}) {
        EXPECT_EQ(run(*make(name, scene_of({})), square_view()).visible_count, 0u) << name;
        EXPECT_EQ(run(*make(name, scene_of({{{-1, -1, -5}, {1, 1, -4}}})), square_view()).visible_count, 1u) << name;
    }
}

TEST(CullScene, trees_hold_every_object_once_and_nest) {
    Random random(16);
    for (std::size_t count : {1u, 2u, 7u, 8u, 9u, 65u, 1000u}) {
        std::vector<Box3f> boxes = test::random_boxes(random, count, {5, 5, 5}, 10);
        for (std::size_t i = 0; i < count / 2; ++i)
            boxes[i] = boxes[0]; // duplicates cannot be split by place
        const CullScene scene = scene_of(boxes);
        const CullScene::Data& data = scene.data();
        std::set<std::uint32_t> seen;
        for (const CullNode& node : data.wide)
            for (std::uint32_t slot = 0; slot < node.used; ++slot) {
                for (std::uint32_t i = node.first[slot]; i < node.first[slot] + node.count[slot]; ++i) {
                    const Box3f& box = data.bounds[data.order[i]];
                    Box3f around = node.box(int(slot));
                    EXPECT_TRUE(around.contains(box.min) && around.contains(box.max));
                }
                if (node.child[slot] & kObjectChild) {
                    EXPECT_TRUE(seen.insert(node.child[slot] & ~kObjectChild).second);
                }
            }
        EXPECT_EQ(seen.size(), count);
    }
}

TEST(CullScene, geometric_progressions_stay_within_the_depth_bound) {
    // Each box is half as far out as the one before: a greedy split peels off one at a time.
    std::vector<Box3f> boxes;
    for (int e = 50; e > -70; --e)
        for (float s : {1.0f, 1.01f, 1.02f})
            boxes.push_back({{std::ldexp(s, e), 0, 0}, {std::ldexp(s, e), 0, 0}});
    const CullScene scene = scene_of(boxes);
    const std::vector<BinaryNode>& nodes = scene.data().binary;
    std::vector<int> depth(nodes.size(), 0);
    int deepest = 0;
    for (std::size_t n = 0; n < nodes.size(); ++n) {
        deepest = std::max(deepest, depth[n]);
        if (nodes[n].right)
            depth[n + 1] = depth[nodes[n].right] = depth[n] + 1;
    }
    EXPECT_LE(deepest, kTreeDepth);
}

TEST(MakeCuller, unknown_name_lists_the_known_ones) {
    auto culler = make_culler("frustrum", scene_of({}));
    ASSERT_FALSE(culler.ok());
    EXPECT_EQ(culler.status().code(), ErrorCode::usage);
    for (std::string_view name : culler_names()) {
        EXPECT_NE(culler.status().message().find(name), std::string::npos) << name;
        EXPECT_NE(culler_summary(name), "") << name;
    }
}

TEST(MakeCuller, pvs_without_a_file_is_a_usage_error) {
    auto culler = make_culler("pvs", scene_of({}));
    ASSERT_FALSE(culler.ok());
    EXPECT_EQ(culler.status().code(), ErrorCode::usage);
}

TEST(ViewState, moves_between_cullers_and_does_not_allocate_in_steady_state) {
    Random random(17);
    CullScene scene = scene_of(test::random_boxes(random, 300, {0, 0, 0}, 10));
    auto first = make("frustum", scene), second = make("frustum-scalar", scene);
    ViewState state;
    CullResult result;
    View view = square_view();
    first->cull(view, state, result);
    std::vector<std::uint64_t> expected = result.visible;
    second->cull(view, state, result);
    EXPECT_EQ(result.visible, expected);
    first->cull(view, state, result);
    const std::uint64_t* words = result.visible.data();
    for (int i = 0; i < 10; ++i)
        first->cull(view, state, result);
    EXPECT_EQ(result.visible.data(), words);
    EXPECT_EQ(result.visible, expected);
}

} // namespace
} // namespace antumbra
