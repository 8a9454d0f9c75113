#include "evaluate/proving.hpp"
#include "evaluate/two_rooms.hpp"

#include <antumbra/generate.hpp>
#include <antumbra/import.hpp>

#include <cstdlib>
#include <filesystem>

namespace antumbra {
namespace {

Scene generated(const char* kind, std::uint64_t triangles = 0) {
    GenerateOptions options;
    options.triangles = triangles;
    auto raw = generate(kind, options);
    EXPECT_TRUE(raw) << raw.status().message();
    auto scene = Scene::create(std::move(*raw));
    EXPECT_TRUE(scene);
    return std::move(*scene);
}

ProofOptions small() {
    ProofOptions options;
    options.frames = 64;
    options.width = 40;
    options.height = 24;
    options.truth_scale = 4;
    options.aimed = 400;
    return options;
}

void expect_proved(const Scene& scene, const ProofOptions& options, const char* what) {
    ProofResult result;
    Status status = prove(scene, options, result);
    ASSERT_TRUE(status) << status.message();
    ASSERT_GE(result.methods.size(), 4u);
    for (const ProofMethod& method : result.methods) {
        EXPECT_EQ(method.frames, options.frames) << method.name;
        if (!may_lose_pixels(method.guarantee)) {
            EXPECT_EQ(method.lost_pixels, 0u) << what << ": " << method.name;
        }
    }
    for (const ProofLoss& loss : result.losses)
        ADD_FAILURE() << loss.method << " frame " << loss.frame << " object " << loss.object;
}

TEST(Prove, NoMethodLosesAPixelOfAGeneratedScene) {
    expect_proved(generated("city", 30000), small(), "city");
    expect_proved(generated("office"), small(), "office");
    expect_proved(generated("machine"), small(), "machine");
    expect_proved(generated("apartment"), small(), "apartment");
    expect_proved(generated("town", 40000), small(), "town");
    expect_proved(generated("forest", 40000), small(), "forest");
}

TEST(Prove, NoMethodLosesAPixelOfAScannedOrDrawnScene) {
    const char* folder = std::getenv("ANTUMBRA_SCENES");
    std::string scenes = folder ? folder : std::string(ANTUMBRA_SOURCE_DIR) + "/../shared/scenes";
    if (!std::filesystem::exists(scenes))
        GTEST_SKIP() << "no development scenes";
    for (const char* name : {"city/denhaag.glb", "gamemap/oa_dm2.glb", "gamemap/ctf_compromise.brushes.glb",
                             "ugly/tesseract_alphacorp.obj", "cad/as1-tu-203.glb"}) {
        auto scene = load_scene(scenes + "/" + name);
        ASSERT_TRUE(scene) << scene.status().message();
        expect_proved(*scene, small(), name);
    }
}

/// What the judge is for: an answer that lacks one seen object.
TEST(Prove, OneMissingObjectIsALoss) {
    Scene scene = test::two_rooms().scene();
    Tracer tracer = Tracer::build(scene);
    ProofOptions options = small();
    std::uint64_t with_something = 0;
    for (std::uint64_t f = 0; f < 40; ++f) {
        View view = proof_view(tracer, 1, f, 1.6);
        ProofFrame frame(tracer, view, f, options, {});
        std::vector<std::uint64_t> all{(std::uint64_t(1) << scene.objects().size()) - 1};
        ProofMethod good, bad;
        std::vector<ProofLoss> losses;
        frame.judge(all, all, good, losses);
        EXPECT_TRUE(losses.empty());
        for (std::uint32_t o = 0; o < scene.objects().size(); ++o) {
            std::vector<std::uint64_t> reported{all[0] & ~(std::uint64_t(1) << o)};
            std::uint64_t before = bad.lost_objects;
            frame.judge(all, reported, bad, losses);
            if (has_bit(frame.seen(), o)) {
                ++with_something;
                EXPECT_GE(bad.lost_objects + bad.grazing_pixels, before + 1) << "frame " << f << " object " << o;
            }
        }
    }
    EXPECT_GT(with_something, 20u);
}

/// A sliver between the pixels: aimed lines see it.
TEST(Prove, AimedLinesFindWhatPixelsMiss) {
    Scene scene = test::SceneMaker()
                      .object("thread")
                      .quad({-1e-4, -1, -5}, {1e-4, -1, -5}, {1e-4, 1, -5}, {-1e-4, 1, -5})
                      .object("floor")
                      .quad({-9, -2, 9}, {9, -2, 9}, {9, -2, -9}, {-9, -2, -9})
                      .scene();
    Tracer tracer = Tracer::build(scene);
    ProofOptions options = small();
    View view;
    view.eye = scene.to_local({0.01, 0, 0});
    view.target = scene.to_local({0.02, 0, -1});
    view.near_plane = 0.1;
    ProofFrame frame(tracer, view, 0, options, {});
    ASSERT_FALSE(has_bit(frame.seen(), 0));
    ProofMethod method;
    std::vector<ProofLoss> losses;
    frame.judge({3}, {2}, method, losses);
    EXPECT_EQ(method.lost_objects, 1u);
    EXPECT_GT(method.lost_pixels, 300u);
}

TEST(Prove, WhatLiesBeforeTheNearPlaneDoesNotHide) {
    Scene scene = test::SceneMaker()
                      .object("pane")
                      .quad({-9, -9, -1}, {9, -9, -1}, {9, 9, -1}, {-9, 9, -1})
                      .object("wall")
                      .quad({-9, -9, -3}, {9, -9, -3}, {9, 9, -3}, {-9, 9, -3})
                      .scene();
    Tracer tracer = Tracer::build(scene);
    ProofOptions options = small();
    View view;
    view.eye = scene.to_local({0, 0, 0});
    view.target = scene.to_local({0, 0, -1});
    view.near_plane = 0.5;
    EXPECT_EQ(ProofFrame(tracer, view, 0, options, {}).seen()[0], 1u);
    view.near_plane = 1.5;
    EXPECT_EQ(ProofFrame(tracer, view, 0, options, {}).seen()[0], 2u);
    view.projection = Projection::orthographic;
    EXPECT_EQ(ProofFrame(tracer, view, 0, options, {}).seen()[0], 2u);
    view.near_plane = -0.5;
    EXPECT_EQ(ProofFrame(tracer, view, 0, options, {}).seen()[0], 1u);
}

TEST(Prove, GoesOnWhereItStopped) {
    Scene scene = generated("apartment");
    ProofOptions options = small();
    options.methods = {"masked", "planes"};
    options.aimed = 50;
    options.frames = 128;
    ProofResult whole, parts;
    ASSERT_TRUE(prove(scene, options, whole));
    options.frames = 64;
    ASSERT_TRUE(prove(scene, options, parts));
    EXPECT_EQ(parts.methods[0].frames, 64u);
    options.frames = 100; // a block at a time
    ASSERT_TRUE(prove(scene, options, parts));
    for (std::size_t m = 0; m < 2; ++m) {
        EXPECT_EQ(parts.methods[m].frames, 128u);
        EXPECT_EQ(parts.methods[m].hidden, whole.methods[m].hidden);
        EXPECT_EQ(parts.methods[m].aimed, whole.methods[m].aimed);
    }
    EXPECT_GT(whole.methods[1].hidden, 0u);
}

TEST(Prove, FramesAreOfEveryKindAndMakeSense) {
    Scene scene = generated("office");
    Tracer tracer = Tracer::build(scene);
    int orthographic = 0, near = 0, moved = 0;
    View last;
    for (std::uint64_t f = 0; f < 400; ++f) {
        View view = proof_view(tracer, 3, f, 1.5);
        EXPECT_EQ(problem_of(view), nullptr);
        orthographic += view.projection == Projection::orthographic;
        near += view.near_plane > 0;
        moved += f % kProofBurst != 0 && (view.eye.x != last.eye.x || view.target.x != last.target.x);
        last = view;
    }
    EXPECT_GT(orthographic, 15);
    EXPECT_GT(near, 100);
    EXPECT_GT(moved, 150);
}

} // namespace
} // namespace antumbra
