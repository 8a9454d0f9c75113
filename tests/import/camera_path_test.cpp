#include <antumbra/camera.hpp>

#include "import/gltf_builder.hpp"

#include <gtest/gtest.h>

namespace antumbra {
namespace {

using test::bytes_of;
using test::GltfBuilder;
using test::Json;

Result<std::vector<CameraFrame>> parse(const std::string& text) { return parse_camera_path(bytes_of(text), "p.json"); }

TEST(CameraPath, ReadsFramesWithDefaults) {
    auto frames = parse(R"({"frames":[{"eye":[1,2,3],"target":[4,5,7]},
        {"eye":[0,0,0],"target":[0,1,0],"up":[0,0,1],"fov_y_deg":45.5}]})");
    ASSERT_TRUE(frames.ok()) << frames.status().message();
    ASSERT_EQ(frames->size(), 2u);
    EXPECT_EQ((*frames)[0].eye, (Vec3d{1, 2, 3}));
    EXPECT_EQ((*frames)[0].target, (Vec3d{4, 5, 7}));
    EXPECT_EQ((*frames)[0].up, (Vec3d{0, 1, 0}));
    EXPECT_EQ((*frames)[0].fov_y_deg, 60);
    EXPECT_EQ((*frames)[1].up, (Vec3d{0, 0, 1}));
    EXPECT_EQ((*frames)[1].fov_y_deg, 45.5);
}

TEST(CameraPath, NamesWhatIsWrong) {
    struct Case {
        const char* text;
        ErrorCode code;
        const char* part;
    };
    const Case cases[] = {
        {"", ErrorCode::corrupt, "p.json: is not valid JSON"},
        {"[1]", ErrorCode::corrupt, "must be an object"},
        {"{}", ErrorCode::corrupt, "frames: must hold at least one frame"},
        {R"({"frames":[]})", ErrorCode::corrupt, "frames: must hold at least one frame"},
        {R"({"frames":7})", ErrorCode::corrupt, "frames: must be an array"},
        {R"({"frames":[{"eye":[1,2],"target":[0,0,0]}]})", ErrorCode::corrupt, "frames[0].eye: must hold 3"},
        {R"({"frames":[{"eye":[1,2,3]}]})", ErrorCode::corrupt, "frames[0].target: is missing"},
        {R"({"frames":[{"eye":[1,2,3],"target":[1,2,3]}]})", ErrorCode::corrupt, "where the eye is"},
        {R"({"frames":[{"eye":[0,0,0],"target":[0,5,0]}]})", ErrorCode::corrupt, "frames[0].up"},
        {R"({"frames":[{"eye":[0,0,0],"target":[1,5,0],"fov_y_deg":180}]})", ErrorCode::corrupt, "fov_y_deg"},
    };
    for (const Case& c : cases) {
        auto frames = parse(c.text);
        ASSERT_FALSE(frames.ok()) << c.text;
        EXPECT_EQ(frames.status().code(), c.code) << c.text;
        EXPECT_NE(frames.status().message().find(c.part), std::string::npos) << frames.status().message();
    }
}

TEST(Boxes, ReadsAndRefuses) {
    auto boxes = parse_boxes(bytes_of(R"([{"min":[0,0,0],"max":[1,2,3]},{"min":[-1,0,0],"max":[-1,0,0]}])"), "b");
    ASSERT_TRUE(boxes.ok()) << boxes.status().message();
    ASSERT_EQ(boxes->size(), 2u);
    EXPECT_EQ((*boxes)[0], (Box3d{{0, 0, 0}, {1, 2, 3}}));
    auto reversed = parse_boxes(bytes_of(R"([{"min":[0,4,0],"max":[1,2,3]}])"), "b");
    ASSERT_FALSE(reversed.ok());
    EXPECT_EQ(reversed.status().message(), "b: boxes[0].max: must not be below min");
    EXPECT_FALSE(parse_boxes(bytes_of("[]"), "b").ok());
    EXPECT_FALSE(parse_boxes(bytes_of("{}"), "b").ok());
    EXPECT_EQ(read_boxes("/nowhere/boxes.json").status().code(), ErrorCode::io);
}

/// A camera on node 1, child of node 0. `channel` animates `node`'s `path`.
std::string camera_file(int node, const std::string& path, const std::string& interpolation, std::vector<float> times,
                        const std::string& type, std::vector<float> values) {
    GltfBuilder b;
    b.add("cameras", {{"type", "perspective"}, {"perspective", {{"yfov", 1.0}, {"znear", 0.1}}}});
    b.add("nodes", {{"children", {1}}, {"translation", {10, 0, 0}}});
    b.add("nodes", {{"camera", 0}});
    int input = b.add_accessor("SCALAR", times), output = b.add_accessor(type, values);
    Json sampler = {{"input", input}, {"output", output}, {"interpolation", interpolation}};
    Json channel = {{"sampler", 0}, {"target", {{"node", node}, {"path", path}}}};
    b.add("animations", {{"samplers", Json::array({sampler})}, {"channels", Json::array({channel})}});
    return b.glb();
}

std::vector<CameraFrame> sampled(const std::string& file, double fps) {
    CameraPathOptions options;
    options.frames_per_second = fps;
    auto frames = sample_gltf_camera(bytes_of(file), "c.glb", "", options);
    EXPECT_TRUE(frames.ok()) << frames.status().message();
    return frames.ok() ? *frames : std::vector<CameraFrame>();
}

TEST(GltfCamera, InterpolatesLinearly) {
    auto frames = sampled(camera_file(1, "translation", "LINEAR", {0, 1, 2}, "VEC3", {0, 0, 0, 0, 4, 0, 8, 4, 0}), 2);
    ASSERT_EQ(frames.size(), 5u);
    EXPECT_EQ(frames[1].eye, (Vec3d{10, 2, 0}));
    EXPECT_EQ(frames[3].eye, (Vec3d{14, 4, 0}));
    EXPECT_EQ(frames[3].target, (Vec3d{14, 4, -1}));
    EXPECT_EQ(frames[3].up, (Vec3d{0, 1, 0}));
    EXPECT_NEAR(frames[0].fov_y_deg, 57.29577951308232, 1e-12);
}

TEST(GltfCamera, StepHoldsTheLastKey) {
    auto frames = sampled(camera_file(1, "translation", "STEP", {0, 1}, "VEC3", {0, 0, 0, 0, 4, 0}), 2);
    ASSERT_EQ(frames.size(), 3u);
    EXPECT_EQ(frames[1].eye, (Vec3d{10, 0, 0}));
    EXPECT_EQ(frames[2].eye, (Vec3d{10, 4, 0}));
}

TEST(GltfCamera, CubicSplineUsesTangents) {
    // From 0 to 0 leaving with slope 8 and arriving with 0: h10(1/2) * 8 = 1.
    auto frames = sampled(camera_file(1, "translation", "CUBICSPLINE", {0, 1}, "VEC3",
                                      {0, 0, 0, 0, 0, 0, 0, 8, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0}), 2);
    ASSERT_EQ(frames.size(), 3u);
    EXPECT_EQ(frames[1].eye, (Vec3d{10, 1, 0}));
}

TEST(GltfCamera, RotationFollowsTheGreatArcOfAnAncestor) {
    // Half of a right-angle turn about y, by the parent of the camera.
    float s = std::sqrt(0.5f);
    auto frames = sampled(camera_file(0, "rotation", "LINEAR", {0, 1}, "VEC4", {0, 0, 0, 1, 0, s, 0, s}), 2);
    ASSERT_EQ(frames.size(), 3u);
    Vec3d forward = frames[1].target - frames[1].eye;
    EXPECT_NEAR(forward.x, -std::sqrt(0.5), 1e-12);
    EXPECT_NEAR(forward.z, -std::sqrt(0.5), 1e-12);
    EXPECT_NEAR((frames[2].target - frames[2].eye).x, -1, 1e-7);
}

TEST(GltfCamera, RefusesWhatMakesNoPath) {
    auto message = [](const std::string& file) {
        auto frames = sample_gltf_camera(bytes_of(file), "c.glb", "");
        return frames.ok() ? std::string("ok") : frames.status().message();
    };
    EXPECT_EQ(message(camera_file(1, "weights", "LINEAR", {0, 1}, "SCALAR", {0, 1})),
              "c.glb: no animation moves a camera; give a JSON camera path instead");
    EXPECT_EQ(message(camera_file(1, "translation", "LINEAR", {1, 0}, "VEC3", {0, 0, 0, 0, 4, 0})),
              "c.glb: accessors[0]: times must increase");
    EXPECT_EQ(message(camera_file(1, "translation", "LINEAR", {0, 1}, "VEC3", {0, 0, 0})),
              "c.glb: accessors[1]: does not match its times");
    EXPECT_NE(message(camera_file(1, "translation", "LINEAR", {0, 1e9f}, "VEC3", {0, 0, 0, 0, 4, 0})).find("frames"),
              std::string::npos);
    EXPECT_NE(message(camera_file(0, "scale", "LINEAR", {0, 1}, "VEC3", {0, 0, 0, 0, 0, 0})).find("line of sight"),
              std::string::npos);
}

} // namespace
} // namespace antumbra
