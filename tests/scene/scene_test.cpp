// Scene::create: the snapping law, what is refused, what the fingerprints notice.
#include <antumbra/scene.hpp>

#include "base/random.hpp"

#include <gtest/gtest.h>
#include <rapidcheck/gtest.h>

#include <cmath>
#include <functional>
#include <limits>
#include <set>

namespace antumbra {
namespace {

RawObject object(const std::string& name, std::uint32_t first, std::uint32_t count, std::uint32_t flags = kOccludes) {
    RawObject made;
    made.name = name;
    made.first_triangle = first;
    made.triangle_count = count;
    made.flags = flags;
    return made;
}

/// Two objects: a unit square of two triangles at z = 0, one triangle at z = 1.
RawScene small_scene() {
    RawScene raw;
    raw.source = "small";
    raw.positions = {{0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {0, 1, 0}, {0, 0, 1}, {1, 0, 1}, {0, 1, 1}};
    raw.triangles = {{0, 1, 2}, {0, 2, 3}, {4, 5, 6}};
    raw.objects = {object("square", 0, 2), object("triangle", 2, 1)};
    raw.objects[0].id = {3, 0, -1};
    raw.objects[1].id = {4, 1, 7};
    return raw;
}

Scene create(RawScene raw, const SceneOptions& options = {}) {
    Result<Scene> scene = Scene::create(std::move(raw), options);
    EXPECT_TRUE(scene.ok()) << scene.status().message();
    return std::move(*scene);
}

std::uint64_t found(const Scene& scene, const std::string& kind) {
    for (const Finding& finding : scene.findings())
        if (finding.kind == kind)
            return finding.count;
    return 0;
}

TEST(Scene, KeepsObjectsTrianglesAndPositions) {
    Scene scene = create(small_scene());
    ASSERT_EQ(scene.objects().size(), 2u);
    EXPECT_EQ(scene.triangles().size(), 3u);
    EXPECT_EQ(scene.positions().size(), 7u);
    EXPECT_EQ(scene.origin(), (Vec3d{0.5, 0.5, 0.5}));
    EXPECT_EQ(scene.step(), 0x1p-23);
    EXPECT_EQ(scene.vertex(1, 2), (Vec3d{-0.5, 0.5, -0.5}));
    EXPECT_EQ(scene.to_world(scene.vertex(2, 1)), (Vec3d{1, 0, 1}));
    EXPECT_EQ(scene.world_bounds(), (Box3d{{0, 0, 0}, {1, 1, 1}}));
    EXPECT_EQ(scene.objects()[1].id, (ObjectId{4, 1, 7}));
    EXPECT_EQ(scene.name(1), "triangle");
    EXPECT_EQ(scene.objects()[1].first_triangle, 2u);
    EXPECT_EQ(scene.triangle_objects()[1], 0u);
    EXPECT_EQ(scene.triangle_objects()[2], 1u);
    EXPECT_EQ(&scene.object_of(2), &scene.objects()[1]);
    EXPECT_TRUE(scene.findings().empty());
}

RC_GTEST_PROP(SceneLaw, EveryCoordinateIsAWholeNumberOfStepsAndNear, ()) {
    // Scales over 15 orders of magnitude, centres up to 2^38 sizes away.
    Random random(*rc::gen::arbitrary<std::uint64_t>());
    double size = std::ldexp(random.uniform(1, 2), int(random.below(48)) - 40);
    double away = std::ldexp(size * random.uniform(-1, 1), int(random.below(38)));
    RawScene raw;
    for (int i = 0; i < 12; ++i) {
        Vec3d p;
        for (int k = 0; k < 3; ++k)
            p[k] = away * (k + 1) + size * random.uniform(-1, 1);
        raw.positions.push_back(p);
    }
    raw.triangles = {{0, 1, 2}, {3, 4, 5}, {6, 7, 8}, {9, 10, 11}};
    raw.objects = {object("a", 0, 2), object("b", 2, 2)};
    Result<Scene> scene = Scene::create(raw);
    RC_ASSERT(scene.ok());
    double step = scene->step();
    int exponent = 0;
    RC_ASSERT(std::frexp(step, &exponent) == 0.5);
    for (const Vec3f& p : scene->positions())
        for (int k = 0; k < 3; ++k) {
            double steps = p[k] / step;
            RC_ASSERT(steps == std::floor(steps));
            RC_ASSERT(std::abs(steps) <= 0x1p23);
            // origin + local is exact: taking the origin away again gives the local.
            double world = scene->origin()[k] + double(p[k]);
            RC_ASSERT(world - scene->origin()[k] == double(p[k]));
        }
    if (scene->triangles().size() == 4)
        for (std::uint32_t t = 0; t < 4; ++t)
            for (int c = 0; c < 3; ++c)
                for (int k = 0; k < 3; ++k) {
                    double source = raw.positions[raw.triangles[t][std::size_t(c)]][k];
                    double made = scene->to_world(scene->vertex(t, c))[k];
                    RC_ASSERT(std::abs(source - made) <= step * 0.5 * (1 + 1e-9) + std::abs(source) * 0x1p-51);
                    Box3f bounds = scene->object_of(t).bounds;
                    RC_ASSERT(source - scene->origin()[k] >= bounds.min[k]);
                    RC_ASSERT(source - scene->origin()[k] <= bounds.max[k]);
                }
}

TEST(Scene, EqualPositionsStayEqualAndFarScenesKeepTheirDetail) {
    RawScene raw = small_scene();
    for (Vec3d& p : raw.positions)
        p = p + Vec3d{78613.525, 4.583, -457985.735};
    Scene scene = create(raw);
    EXPECT_EQ(scene.triangles().size(), 3u);
    // A metre at 4.6e5: 2^-23 locally, where a float of the world would know 1/32.
    EXPECT_LE(scene.step(), 0x1p-22);
    EXPECT_NEAR(scene.world_bounds().min.z, -457985.735, 1e-6);
}

TEST(Scene, DropsTrianglesWithoutAreaAndSaysSo) {
    RawScene raw = small_scene();
    raw.positions.push_back({1 + 1e-12, 1e-12, 1});
    raw.triangles.insert(raw.triangles.end(), {{0, 0, 1}, {4, 5, 7}, {4, 5, 6}});
    raw.objects[1].triangle_count = 4;
    Scene scene = create(raw);
    EXPECT_EQ(scene.objects()[1].triangle_count, 2u);
    EXPECT_EQ(scene.objects()[1].source_triangles, 4u);
    EXPECT_EQ(found(scene, "degenerate triangle"), 1u);
    EXPECT_EQ(found(scene, "triangle collapsed by snapping"), 1u);
    EXPECT_EQ(scene.findings()[0].example, "triangle 1 of 'triangle'");
}

TEST(Scene, WhatSnappingLosesIsNeverCulled) {
    RawScene raw = small_scene();
    raw.positions[4] = {0.25, 0.25, 0.25};
    raw.positions[5] = {0.25 + 1e-9, 0.25, 0.25};
    raw.positions[6] = {0.25, 0.25 + 1e-9, 0.25};
    Scene scene = create(raw);
    ASSERT_EQ(scene.objects().size(), 2u);
    EXPECT_EQ(scene.objects()[1].triangle_count, 0u);
    EXPECT_TRUE(scene.objects()[1].has(kAlwaysVisible));
    EXPECT_FALSE(scene.objects()[0].has(kAlwaysVisible));
    EXPECT_EQ(found(scene, "object without area"), 1u);
    EXPECT_TRUE(scene.objects()[1].bounds.contains({-0.25f, -0.25f, 0.125f}));
}

TEST(Scene, RefusesWhatIsNoScene) {
    struct Case {
        std::function<void(RawScene&)> edit;
        ErrorCode code;
        const char* part;
    };
    const double nan = std::numeric_limits<double>::quiet_NaN(), inf = std::numeric_limits<double>::infinity();
    const Case cases[] = {
        {[](RawScene& r) { r = {}; }, ErrorCode::corrupt, "has no triangles"},
        {[](RawScene& r) { r.triangles[1][2] = 7; }, ErrorCode::corrupt, "triangle 1: vertex index 7 is beyond the 7"},
        {[&](RawScene& r) { r.positions[2].y = nan; }, ErrorCode::corrupt, "object 'square': a vertex is not finite"},
        {[&](RawScene& r) { r.positions[6].y = -inf; }, ErrorCode::corrupt, "object 'triangle': a vertex"},
        {[](RawScene& r) { r.positions[6].y = 1.1e15; }, ErrorCode::corrupt, "beyond 1e15"},
        {[](RawScene& r) { r.objects[1].first_triangle = 1; }, ErrorCode::internal, "triangles out of order"},
        {[](RawScene& r) { r.objects[1].triangle_count = 0; }, ErrorCode::internal, "triangles without an object"},
        {[](RawScene& r) { r.objects[1].triangle_count = 0xFFFFFFFFu; }, ErrorCode::internal, "triangles"},
        {[](RawScene& r) { for (Vec3d& p : r.positions) p = {5, 5, 5}; }, ErrorCode::corrupt, "smaller than 1e-15"},
        {[](RawScene& r) { for (Vec3d& p : r.positions) p = {p.x, 0, 0}; }, ErrorCode::corrupt, "has an area"},
    };
    for (const Case& c : cases) {
        RawScene raw = small_scene();
        c.edit(raw);
        Result<Scene> scene = Scene::create(raw);
        ASSERT_FALSE(scene.ok()) << c.part;
        EXPECT_EQ(scene.status().code(), c.code);
        EXPECT_NE(scene.status().message().find(c.part), std::string::npos) << scene.status().message();
    }
}

TEST(Scene, PatternsChooseByName) {
    RawScene raw = small_scene();
    raw.objects[0].name = "Wall_01/primitive 0";
    SceneOptions options;
    options.never_occlude = {"Wall_?1*"};
    options.never_cull = {"tri*", "nothing"};
    Scene scene = create(raw, options);
    EXPECT_EQ(scene.objects()[0].flags, 0u);
    EXPECT_EQ(scene.objects()[1].flags, kOccludes | kAlwaysVisible);
    options.ignore = {"*primitive*"};
    Scene rest = create(raw, options);
    ASSERT_EQ(rest.objects().size(), 1u);
    EXPECT_EQ(rest.name(0), "triangle");
    EXPECT_EQ(rest.objects()[0].first_triangle, 0u);
    EXPECT_EQ(found(rest, "ignored object"), 1u);
    EXPECT_EQ(rest.positions().size(), 3u);
    options.ignore = {"*"};
    EXPECT_FALSE(Scene::create(raw, options).ok());
}

TEST(Scene, SidesAndMotion) {
    SceneOptions both;
    both.sides = SidesOption::both;
    EXPECT_EQ(create(small_scene(), both).objects()[0].flags, kOccludes | kDoubleSided);
    RawScene raw = small_scene();
    raw.objects[1].flags = kOccludes | kMoves;
    Scene scene = create(raw);
    EXPECT_EQ(scene.objects()[1].flags, kMoves | kAlwaysVisible);
    EXPECT_EQ(found(scene, "moving object"), 1u);
}

TEST(SceneFingerprint, NoticesEveryEdit) {
    const std::vector<std::function<void(RawScene&, SceneOptions&)>> edits = {
        [](RawScene&, SceneOptions&) {},
        [](RawScene& r, SceneOptions&) { r.positions[2].x += 1e-6; },
        [](RawScene& r, SceneOptions&) { std::swap(r.triangles[0], r.triangles[1]); },
        [](RawScene& r, SceneOptions&) { std::swap(r.triangles[0][0], r.triangles[0][1]); },
        [](RawScene& r, SceneOptions&) { r.objects[0].flags = 0; },
        [](RawScene& r, SceneOptions&) { r.objects[0].flags |= kDoubleSided; },
        [](RawScene& r, SceneOptions&) { r.objects[0].flags |= kAlwaysVisible; },
        [](RawScene& r, SceneOptions&) { r.objects[0].id.node = 9; },
        [](RawScene& r, SceneOptions&) { r.objects[0].id.primitive = 9; },
        [](RawScene& r, SceneOptions&) { r.objects[0].id.instance = 9; },
        [](RawScene& r, SceneOptions&) { r.objects[0].name = "other"; },
        [](RawScene& r, SceneOptions&) { r.objects[0].triangle_count = 1, r.objects[1] = object("triangle", 1, 2); },
        [](RawScene& r, SceneOptions&) { r.triangles.pop_back(), r.objects.pop_back(); },
        [](RawScene& r, SceneOptions&) { for (Vec3d& p : r.positions) p.x += 1; },
        [](RawScene& r, SceneOptions&) { for (Vec3d& p : r.positions) p = p * 2; },
        [](RawScene&, SceneOptions& o) { o.sides = SidesOption::both; },
        [](RawScene&, SceneOptions& o) { o.ignore = {"square"}; },
    };
    std::set<Fingerprint> seen;
    for (const auto& edit : edits) {
        RawScene raw = small_scene();
        SceneOptions options;
        edit(raw, options);
        seen.insert(create(raw, options).fingerprint());
    }
    EXPECT_EQ(seen.size(), edits.size());
    // What does not decide visibility does not count.
    RawScene renamed = small_scene();
    renamed.source = "elsewhere";
    renamed.positions.push_back({0.5, 0.5, 0.5}); // used by no triangle
    EXPECT_EQ(create(renamed).fingerprint(), create(small_scene()).fingerprint());
    EXPECT_EQ(to_hex(create(small_scene()).fingerprint()).size(), 32u);
}

RC_GTEST_PROP(SceneFingerprintLaw, AnyVertexThatMovesAStepChangesIt, ()) {
    RawScene raw = small_scene();
    std::size_t vertex = *rc::gen::inRange<std::size_t>(0, raw.positions.size());
    int axis = *rc::gen::inRange(0, 3);
    double amount = 0x1p-22 * *rc::gen::inRange(1, 1 << 20) * (*rc::gen::arbitrary<bool>() ? 1 : -1);
    Fingerprint before = create(raw).fingerprint();
    raw.positions[vertex][axis] += amount;
    RC_ASSERT(create(raw).fingerprint() != before);
}

TEST(SceneFingerprint, StructureIsFnvOfIdsAndCounts) {
    // One object (node 1, primitive 2, instance -1) of 3 triangles, hashed by hand over 16 little-endian bytes.
    std::uint64_t hash = 0xcbf29ce484222325u;
    for (int byte : {1, 0, 0, 0, 2, 0, 0, 0, 255, 255, 255, 255, 3, 0, 0, 0})
        hash = (hash ^ std::uint64_t(byte)) * 0x100000001b3u;
    RawScene raw = small_scene();
    raw.objects = {object("all", 0, 3)};
    raw.objects[0].id = {1, 2, -1};
    EXPECT_EQ(create(raw).structure_fingerprint(), hash);
    // Geometry does not enter, degenerate triangles do.
    raw.positions[0] = {0.25, 0.25, 0.125};
    raw.triangles[2] = {0, 0, 0};
    EXPECT_EQ(create(raw).structure_fingerprint(), hash);
}

} // namespace
} // namespace antumbra
