#include "support/make_scene.hpp"

#include <antumbra/evaluate.hpp>

namespace antumbra {
namespace {

using test::SceneMaker;

/// Two rooms side by side, [-4,0] and [0,4] along x, a closed wall between them, a crate in each.
SceneMaker two_rooms() {
    SceneMaker maker;
    maker.object("left room").box({-4, 0, 0}, {-0.25, 3, 4}, true);
    maker.object("right room").box({0.25, 0, 0}, {4, 3, 4}, true);
    maker.object("left crate").box({-3, 0, 1}, {-2, 1, 2});
    maker.object("right crate").box({2, 0, 1}, {3, 1, 2});
    return maker;
}

/// One cell per room. Row 0 lists the left objects, row 1 the right ones.
PvsData two_cells(const Scene& scene, Guarantee guarantee = Guarantee::conservative) {
    PvsData data;
    data.guarantee = guarantee;
    data.method = "by hand";
    data.tool_version = "test";
    data.options_json = "{}";
    data.scene_fingerprint = scene.fingerprint();
    data.structure_fingerprint = scene.structure_fingerprint();
    data.sides = std::uint8_t(scene.sides());
    data.origin = scene.origin();
    data.grid.bounds = {{-4, 0, 0}, {4, 3, 4}};
    data.grid.count = {2, 1, 1};
    data.cell_row = {0, 1};
    for (std::uint32_t o = 0; o < scene.objects().size(); ++o) {
        PvsObject object;
        object.node = std::int32_t(o);
        object.flags = scene.objects()[o].flags;
        object.triangle_count = scene.objects()[o].triangle_count;
        object.bounds = scene.objects()[o].bounds;
        object.name = std::string(scene.name(o));
        data.objects.push_back(object);
    }
    data.row_count = 2;
    data.rows = {0b0101, 0b1010};
    return data;
}

struct File {
    std::vector<std::byte> bytes;
    std::optional<Pvs> pvs;
};

File open(const PvsData& data) {
    File file;
    auto bytes = encode_pvs(data);
    EXPECT_TRUE(bytes) << bytes.status().message();
    file.bytes = std::move(*bytes);
    auto pvs = Pvs::open(file.bytes);
    EXPECT_TRUE(pvs) << pvs.status().message();
    file.pvs.emplace(std::move(*pvs));
    return file;
}

VerifyOptions quick() {
    VerifyOptions options;
    options.samples = 24;
    options.face_size = 24;
    return options;
}

TEST(Verify, RightFileHasNothingFalseInvisible) {
    Scene scene = two_rooms().scene();
    auto result = verify(scene, *open(two_cells(scene)).pvs, quick());
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
    auto result = verify(scene, *open(data).pvs, quick());
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
    auto result = verify(scene, *open(data).pvs, quick());
    ASSERT_TRUE(result) << result.status().message();
    EXPECT_EQ(result->reported_objects, 24u * 4);
    EXPECT_EQ(result->false_visible_objects, result->reported_objects - result->seen_objects);
    EXPECT_GE(result->false_visible_objects, 48u);
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
    auto result = verify(scene, *open(data).pvs, quick());
    ASSERT_FALSE(result);
    EXPECT_EQ(result.status().code(), ErrorCode::usage);
}

TEST(Verify, ThreadsDoNotChangeTheResult) {
    Scene scene = two_rooms().scene();
    PvsData data = two_cells(scene);
    data.rows[0] = 0b0100;
    File file = open(data);
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
    EXPECT_TRUE(check_belongs(scene, *open(two_cells(scene)).pvs));
}

TEST(CheckBelongs, NamesAnotherScene) {
    Scene scene = two_rooms().scene();
    Scene other = two_rooms().object("more").box({1, 0, 3}, {2, 1, 4}).scene();
    Status status = check_belongs(other, *open(two_cells(scene)).pvs);
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
    Status status = check_belongs(*moved, *open(two_cells(scene)).pvs);
    EXPECT_EQ(status.code(), ErrorCode::mismatch);
    EXPECT_NE(status.message().find("only the structure"), std::string::npos);
}

TEST(CheckBelongs, SaysWhenTheSidesDiffer) {
    Scene scene = two_rooms().scene();
    SceneOptions both;
    both.sides = SidesOption::both;
    Status status = check_belongs(two_rooms().scene(both), *open(two_cells(scene)).pvs);
    EXPECT_EQ(status.code(), ErrorCode::mismatch);
    EXPECT_NE(status.message().find("--sides material"), std::string::npos);
}

} // namespace
} // namespace antumbra
