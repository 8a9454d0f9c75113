#include <antumbra/quake3.hpp>

#include "import/gltf_builder.hpp"
#include "import/quake3_builder.hpp"

#include <gtest/gtest.h>

#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <functional>

namespace antumbra {
namespace {

using test::bytes_of;
using test::Quake3Builder;
namespace fs = std::filesystem;

Quake3Map read(const Quake3Builder& builder, const ImportOptions& options = {}) {
    Result<Quake3Map> map = import_quake3(bytes_of(builder.file()), "t.bsp", options);
    EXPECT_TRUE(map.ok()) << map.status().message();
    return map.ok() ? *map : Quake3Map();
}

std::uint64_t found(const RawScene& raw, const std::string& kind) {
    for (const Finding& finding : raw.findings)
        if (finding.kind == kind)
            return finding.count;
    return 0;
}

TEST(Quake3, SurfacesAreObjects) {
    Quake3Map map = read(Quake3Builder());
    const RawScene& raw = map.scene;
    ASSERT_EQ(raw.objects.size(), 4u);
    EXPECT_EQ(raw.objects[0].id, (ObjectId{0, 0, -1}));
    EXPECT_EQ(raw.objects[0].name, "surface 0 textures/stone");
    EXPECT_EQ(raw.objects[0].triangle_count, 2u);
    EXPECT_EQ(raw.objects[0].flags, kOccludes);
    EXPECT_EQ(raw.objects[1].triangle_count, 32u);
    EXPECT_EQ(raw.objects[2].name, "surface 4 textures/glass");
    EXPECT_EQ(raw.objects[2].flags, kDoubleSided);
    EXPECT_EQ(raw.objects[3].id, (ObjectId{5, 1, -1}));
    EXPECT_EQ(raw.objects[3].flags, kMoves | kAlwaysVisible);
    EXPECT_EQ(found(raw, "flare left out"), 1u);
    EXPECT_EQ(found(raw, "surface that is not drawn left out"), 1u);
    EXPECT_EQ(found(raw, "see-through object"), 1u);
    EXPECT_EQ(map.reference.surface_objects, (std::vector<std::int32_t>{0, 1, -1, -1, 2, 3}));
}

TEST(Quake3, MapCoordinatesBecomeYUpAndFrontsCounterClockwise) {
    RawScene raw = read(Quake3Builder()).scene;
    // The game's clockwise floor (0,0) (0,8) (8,8) is seen from above.
    EXPECT_EQ(raw.positions[raw.triangles[0][0]], (Vec3d{0, 0, 0}));
    EXPECT_EQ(raw.positions[raw.triangles[0][1]], (Vec3d{8, 0, -8}));
    EXPECT_EQ(raw.positions[raw.triangles[0][2]], (Vec3d{0, 0, -8}));
    // The lift stands where its entity says: (100, 200, 300) of the map.
    EXPECT_EQ(raw.positions[raw.triangles[raw.objects[3].first_triangle][0]], (Vec3d{100, 300, -200}));
}

TEST(Quake3, PatchesAreBezierSurfaces) {
    Quake3Builder builder;
    RawScene raw = read(builder).scene;
    // Parabola z = 2 t (1 - t) * 8 over x = 8 t: 4 at the top, 3 at a quarter.
    std::uint32_t first = raw.triangles[raw.objects[1].first_triangle][0];
    EXPECT_EQ(raw.positions[first + 1], (Vec3d{2, 3, 0}));
    EXPECT_EQ(raw.positions[first + 2], (Vec3d{4, 4, 0}));
    EXPECT_EQ(raw.positions[first + 5 * 4 + 2], (Vec3d{4, 4, -8}));
    ImportOptions options;
    options.patch_levels = 1;
    EXPECT_EQ(read(builder, options).scene.objects[1].triangle_count, 2u);
    options.patch_levels = 10;
    EXPECT_EQ(read(builder, options).scene.objects[1].triangle_count, 200u);
    options.patch_levels = 0;
    EXPECT_EQ(import_quake3(bytes_of(builder.file()), "t.bsp", options).status().code(), ErrorCode::usage);
}

TEST(Quake3, PinchedPatchesHaveNoCollapsedTriangles) {
    Quake3Builder builder;
    for (std::size_t p = 0; p < 3; ++p) // the first row to one point
        for (std::size_t k = 0; k < 3; ++k)
            builder.lumps[10][(4 + p) * 11 + k] = 0;
    EXPECT_EQ(read(builder).scene.objects[1].triangle_count, 28u);
}

TEST(Quake3, ReferenceAnswersAsTheGameDoes) {
    Quake3Reference reference = read(Quake3Builder()).reference;
    EXPECT_EQ(reference.leaf_of({5, 0, 0}), 0);
    EXPECT_EQ(reference.leaf_of({3, 0, 0}), 1);
    EXPECT_EQ(reference.leaves[1].bounds, (Box3d{{0, 0, -8}, {4, 8, 0}}));
    EXPECT_EQ(reference.clusters, 2u);
    EXPECT_TRUE(reference.cluster_sees(0, 0));
    EXPECT_FALSE(reference.cluster_sees(0, 1));
    EXPECT_TRUE(reference.cluster_sees(1, 0));
    EXPECT_TRUE(reference.cluster_sees(1, 1));
    EXPECT_FALSE(reference.cluster_sees(-1, 1));
    EXPECT_FALSE(reference.cluster_sees(1, 2));
    Quake3Builder blind;
    blind.lumps[16].clear();
    EXPECT_TRUE(read(blind).reference.cluster_sees(-1, 7));
}

TEST(Quake3, BadMapsAreNamed) {
    struct Case {
        std::function<void(Quake3Builder&)> edit;
        ErrorCode code;
        const char* part;
    };
    constexpr ErrorCode corrupt = ErrorCode::corrupt;
    const std::uint32_t nan = 0x7FC00000;
    const Case cases[] = {
        {[](Quake3Builder& b) { b.version = 47; }, ErrorCode::unsupported, "IBSP version 47"},
        {[](Quake3Builder& b) { b.lumps[13].push_back(0); }, corrupt, "surfaces: the lump is not a whole number"},
        {[](Quake3Builder& b) { b.lumps[13][0] = 3; }, corrupt, "surfaces[0]: names a shader"},
        {[](Quake3Builder& b) { b.lumps[13][0] = 0xFFFFFFFF; }, corrupt, "surfaces[0]: names a shader"},
        {[](Quake3Builder& b) { b.lumps[13][2] = 5; }, corrupt, "surfaces[0]: type 5 is unknown"},
        {[](Quake3Builder& b) { b.lumps[13][4] = 14; }, corrupt, "surfaces[0]: names vertices or indices"},
        {[](Quake3Builder& b) { b.lumps[13][5] = 0x7FFFFFFF; }, corrupt, "surfaces[0]: names vertices or indices"},
        {[](Quake3Builder& b) { b.lumps[13][4] = 3; }, corrupt, "surfaces[0]: indices[5]: is beyond the surface's 3"},
        {[](Quake3Builder& b) { b.lumps[11][2] = 0xFFFFFFFF; }, corrupt, "surfaces[0]: indices[2]: is beyond"},
        {[](Quake3Builder& b) { b.lumps[13][26 + 24] = 4; }, corrupt, "surfaces[1]: a patch of 4 x 3"},
        {[](Quake3Builder& b) { b.lumps[13][26 + 24] = 5; }, corrupt, "surfaces[1]: a patch of 5 x 3"},
        {[](Quake3Builder& b) { b.lumps[13][26 + 25] = 65535; }, corrupt, "surfaces[1]: a patch of 3 x 65535"},
        {[&](Quake3Builder& b) { b.lumps[10][1] = nan; }, corrupt, "surfaces[0]: vertices[0]: is not finite"},
        {[&](Quake3Builder& b) { b.lumps[2][3] = nan; }, corrupt, "planes[0]: is not finite"},
        {[](Quake3Builder& b) { b.lumps[3][0] = 1; }, corrupt, "nodes[0]: names a plane"},
        {[](Quake3Builder& b) { b.lumps[3][1] = 0; }, corrupt, "nodes[0]: names a child"},
        {[](Quake3Builder& b) { b.lumps[3][2] = 0x80000000; }, corrupt, "nodes[0]: names a child"},
        {[](Quake3Builder& b) { b.lumps[4][9] = 4; }, corrupt, "leaves[0]: names surfaces or brushes"},
        {[](Quake3Builder& b) { b.lumps[4][0] = 2; }, corrupt, "leaves[0]: names a cluster"},
        {[](Quake3Builder& b) { b.lumps[5][0] = 6; }, corrupt, "leaf surfaces[0]: does not exist"},
        {[](Quake3Builder& b) { b.lumps[6][0] = 1; }, corrupt, "leaf brushes[0]: does not exist"},
        {[](Quake3Builder& b) { b.lumps[7][7] = 7; }, corrupt, "models[0]: names surfaces or brushes"},
        {[](Quake3Builder& b) { b.lumps[8][1] = 2; }, corrupt, "brushes[0]: names sides or a shader"},
        {[](Quake3Builder& b) { b.lumps[9][0] = 1; }, corrupt, "brush sides[0]: names a plane or shader"},
        {[](Quake3Builder& b) { b.lumps[16][0] = 100; }, corrupt, "visibility: 100 rows of 1 bytes do not fit"},
        {[](Quake3Builder& b) { b.lumps[16] = {0xFFFFFFFF, 0xFFFFFFFF}; }, corrupt, "visibility: 4294967295 rows"},
    };
    for (const Case& c : cases) {
        Quake3Builder builder;
        c.edit(builder);
        Status status = import_quake3(bytes_of(builder.file()), "t.bsp").status();
        EXPECT_EQ(status.code(), c.code) << status.message();
        EXPECT_NE(status.message().find(std::string("t.bsp: ") + c.part), std::string::npos) << status.message();
    }
}

TEST(Quake3, Limits) {
    auto code = [](auto edit) {
        ImportOptions options;
        edit(options.limits);
        return import_quake3(bytes_of(Quake3Builder().file()), "t.bsp", options).status().code();
    };
    EXPECT_EQ(code([](ImportLimits& l) { l.vertices = 36; }), ErrorCode::limit);
    EXPECT_EQ(code([](ImportLimits& l) { l.triangles = 37; }), ErrorCode::limit);
    EXPECT_EQ(code([](ImportLimits& l) { l.objects = 3; }), ErrorCode::limit);
    EXPECT_EQ(code([](ImportLimits& l) { l.memory = 1000; }), ErrorCode::limit);
    EXPECT_EQ(code([](ImportLimits& l) { l.bytes = 1000; }), ErrorCode::limit);
    EXPECT_EQ(code([](ImportLimits& l) { l.vertices = 37, l.triangles = 38, l.objects = 4; }), ErrorCode::ok);
}

TEST(Quake3, EveryTruncationAndManyFlipsEndWell) {
    std::string good = Quake3Builder().file();
    for (std::size_t size = 0; size + 4 < good.size(); ++size)
        EXPECT_FALSE(import_quake3(bytes_of(good.substr(0, size)), "t.bsp").ok()) << size;
    for (std::size_t at = 0; at < good.size(); ++at)
        for (int mask : {0x01, 0x10, 0x80, 0xFF}) {
            std::string file = good;
            file[at] = static_cast<char>(file[at] ^ mask);
            Result<Quake3Map> map = import_quake3(bytes_of(file), "t.bsp");
            if (map.ok()) {
                (void)map->reference.leaf_of({1, 2, 3});
                (void)Scene::create(std::move(map->scene));
            }
        }
}

/// The same maps, converted to glTF by somebody else's program.
class Quake3Maps : public ::testing::TestWithParam<const char*> {};

TEST_P(Quake3Maps, AgreeWithTheirConversion) {
    const char* named = std::getenv("ANTUMBRA_SCENES");
    fs::path folder = (named ? fs::path(named) : fs::path(ANTUMBRA_SOURCE_DIR) / "../shared/scenes") / "gamemap";
    fs::path map_path = folder / (std::string(GetParam()) + ".bsp"), glb_path = folder / (std::string(GetParam()) + ".glb");
    if (!fs::exists(map_path) || !fs::exists(glb_path))
        GTEST_SKIP() << map_path << " is not on this machine";
    Result<RawScene> map = import_file(map_path.string()), glb = import_file(glb_path.string());
    ASSERT_TRUE(map.ok()) << map.status().message();
    ASSERT_TRUE(glb.ok());
    ASSERT_EQ(map->objects.size(), glb->objects.size());
    EXPECT_EQ(map->triangles.size(), glb->triangles.size());
    for (std::size_t o = 0; o < map->objects.size(); ++o) {
        ASSERT_EQ(map->objects[o].triangle_count, glb->objects[o].triangle_count) << map->objects[o].name;
        Box3d a, b;
        Vec3d area_a, area_b;
        for (std::uint32_t t = 0; t < map->objects[o].triangle_count; ++t)
            for (auto [raw, box, area] : {std::tuple{&*map, &a, &area_a}, {&*glb, &b, &area_b}}) {
                const TriangleIndices& triangle = raw->triangles[raw->objects[o].first_triangle + t];
                const Vec3d &p = raw->positions[triangle[0]], &q = raw->positions[triangle[1]],
                            &r = raw->positions[triangle[2]];
                for (const Vec3d* corner : {&p, &q, &r})
                    box->extend(*corner);
                *area += cross(q - p, r - p);
            }
        EXPECT_LT(length(a.min - b.min) + length(a.max - b.max), 1e-2) << map->objects[o].name;
        // Equal area vectors: the same surface, wound the same way.
        EXPECT_LT(length(area_a - area_b), 1e-3 * (1 + length(area_b))) << map->objects[o].name;
    }
}

INSTANTIATE_TEST_SUITE_P(All, Quake3Maps, ::testing::Values("oa_dm2", "czest3ctf"));

} // namespace
} // namespace antumbra
