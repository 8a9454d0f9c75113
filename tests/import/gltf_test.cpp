// What every feature of glTF becomes, with literal answers.
#include <antumbra/import.hpp>

#include "import/gltf_builder.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <filesystem>
#include <fstream>

namespace antumbra {
namespace {

using test::bytes_of;
using test::GltfBuilder;
using test::Json;
namespace fs = std::filesystem;

RawScene read(const std::string& file, const ImportOptions& options = {}, const std::string& folder = "") {
    Result<RawScene> raw = import_gltf(bytes_of(file), "t.glb", folder, options);
    EXPECT_TRUE(raw.ok()) << raw.status().message();
    return raw.ok() ? *raw : RawScene();
}

/// Corner c of triangle t.
Vec3d corner(const RawScene& raw, std::size_t t, std::size_t c) { return raw.positions[raw.triangles[t][c]]; }

std::vector<Vec3d> corners(const RawScene& raw) {
    std::vector<Vec3d> all;
    for (const TriangleIndices& triangle : raw.triangles)
        for (std::uint32_t v : triangle)
            all.push_back(raw.positions[v]);
    return all;
}

std::uint64_t found(const RawScene& raw, const std::string& kind) {
    for (const Finding& finding : raw.findings)
        if (finding.kind == kind)
            return finding.count;
    return 0;
}

const std::vector<Vec3d> kTriangle = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}};

TEST(Gltf, OneTriangleAsGlbAndAsJson) {
    GltfBuilder b;
    b.add("nodes", {{"mesh", b.add_triangle_mesh()}, {"name", "tri"}});
    RawScene raw = read(b.glb());
    EXPECT_EQ(corners(raw), kTriangle);
    ASSERT_EQ(raw.objects.size(), 1u);
    EXPECT_EQ(raw.objects[0].id, (ObjectId{0, 0, -1}));
    EXPECT_EQ(raw.objects[0].name, "tri");
    EXPECT_EQ(raw.objects[0].flags, kOccludes);
    EXPECT_EQ(raw.source, "t.glb");

    // "AAAAAA.." of the 36 bytes of three points.
    b.json["buffers"] = Json::array({{{"byteLength", 36},
        {"uri", "data:application/octet-stream;base64,AAAAAAAAAAAAAAAAAACAPwAAAAAAAAAAAAAAAAAAgD8AAAAA"}}});
    EXPECT_EQ(corners(read(b.gltf())), kTriangle);
}

TEST(Gltf, NodesAreMultipliedFromTheRootDown) {
    GltfBuilder b;
    int mesh = b.add_triangle_mesh();
    double s = std::sqrt(0.5);
    b.add("nodes", {{"children", {1}}, {"translation", {100, 0, 0}}});
    b.add("nodes", {{"children", {2}}, {"rotation", {0, 0, s, s}}}); // a right angle about z: x -> y
    b.add("nodes", {{"mesh", mesh}, {"scale", {2, 3, 4}}, {"translation", {1, 0, 0}}});
    RawScene raw = read(b.glb());
    const Vec3d wanted[] = {{100, 1, 0}, {100, 3, 0}, {97, 1, 0}};
    for (std::size_t c = 0; c < 3; ++c)
        for (int k = 0; k < 3; ++k)
            EXPECT_NEAR(corner(raw, 0, c)[k], wanted[c][k], 1e-12);
    EXPECT_EQ(raw.objects[0].id.node, 2);
}

TEST(Gltf, MatricesAreColumnMajor) {
    GltfBuilder b;
    b.add("nodes", {{"mesh", b.add_triangle_mesh()}, {"matrix", {0, 1, 0, 0, -1, 0, 0, 0, 0, 0, 1, 0, 5, 6, 7, 1}}});
    EXPECT_EQ(corners(read(b.glb())), (std::vector<Vec3d>{{5, 6, 7}, {5, 7, 7}, {4, 6, 7}}));
}

TEST(Gltf, AccumulatesInDouble) {
    GltfBuilder b;
    int mesh = b.add_triangle_mesh();
    b.add("nodes", {{"children", {1}}, {"translation", {460000.125, 0, 0}}});
    b.add("nodes", {{"mesh", mesh}, {"translation", {0.0009765625, 0, 0}}});
    EXPECT_EQ(corner(read(b.glb()), 0, 0).x, 460000.1259765625);
}

TEST(Gltf, MirroringTurnsTheWinding) {
    GltfBuilder b;
    b.add("nodes", {{"mesh", b.add_triangle_mesh()}, {"scale", {-1, 1, 1}}});
    EXPECT_EQ(corners(read(b.glb())), (std::vector<Vec3d>{{0, 0, 0}, {0, 1, 0}, {-1, 0, 0}}));
}

TEST(Gltf, UpAxisZ) {
    GltfBuilder b;
    b.add("nodes", {{"mesh", b.add_triangle_mesh()}, {"translation", {1, 2, 3}}});
    ImportOptions options;
    options.up_axis = UpAxis::z;
    EXPECT_EQ(corners(read(b.glb(), options)), (std::vector<Vec3d>{{1, 3, -2}, {2, 3, -2}, {1, 3, -3}}));
}

TEST(Gltf, StripsFansAndLists) {
    auto triangles = [](int mode, int count) {
        GltfBuilder b;
        std::vector<float> points;
        for (int i = 0; i < count; ++i)
            points.insert(points.end(), {float(i), float(i * i), 0});
        b.add("nodes", {{"mesh", b.add_mesh(b.add_accessor("VEC3", points), -1, -1, mode)}});
        return read(b.glb()).triangles;
    };
    using T = std::vector<TriangleIndices>;
    EXPECT_EQ(triangles(4, 6), (T{{0, 1, 2}, {3, 4, 5}}));
    EXPECT_EQ(triangles(5, 5), (T{{0, 1, 2}, {1, 3, 2}, {2, 3, 4}}));
    EXPECT_EQ(triangles(6, 5), (T{{1, 2, 0}, {2, 3, 0}, {3, 4, 0}}));
}

TEST(Gltf, EveryIndexType) {
    auto first = [](auto type) {
        GltfBuilder b;
        int points = b.add_accessor<float>("VEC3", {0, 0, 0, 1, 0, 0, 0, 1, 0});
        int indices = b.add_accessor<decltype(type)>("SCALAR", {2, 1, 0});
        b.add("nodes", {{"mesh", b.add_mesh(points, indices)}});
        return read(b.glb()).triangles.at(0);
    };
    EXPECT_EQ(first(std::uint8_t()), (TriangleIndices{2, 1, 0}));
    EXPECT_EQ(first(std::uint16_t()), (TriangleIndices{2, 1, 0}));
    EXPECT_EQ(first(std::uint32_t()), (TriangleIndices{2, 1, 0}));
}

template <class T>
std::vector<Vec3d> quantised(std::vector<T> values, bool normalized) {
    GltfBuilder b;
    b.json["extensionsRequired"] = {"KHR_mesh_quantization"};
    b.add("nodes", {{"mesh", b.add_mesh(b.add_accessor<T>("VEC3", values, normalized))}});
    return corners(read(b.glb()));
}

TEST(Gltf, QuantisedPositions) {
    using P = std::vector<Vec3d>;
    EXPECT_EQ(quantised<std::int8_t>({0, 0, 0, 127, 0, 0, 0, -128, 0}, false), (P{{0, 0, 0}, {127, 0, 0}, {0, -128, 0}}));
    EXPECT_EQ(quantised<std::int8_t>({0, 0, 0, 127, 0, 0, 0, -128, 0}, true), (P{{0, 0, 0}, {1, 0, 0}, {0, -1, 0}}));
    EXPECT_EQ(quantised<std::uint8_t>({0, 0, 0, 255, 0, 0, 0, 51, 0}, true), (P{{0, 0, 0}, {1, 0, 0}, {0, 0.2, 0}}));
    EXPECT_EQ(quantised<std::uint8_t>({0, 0, 0, 255, 0, 0, 0, 51, 0}, false), (P{{0, 0, 0}, {255, 0, 0}, {0, 51, 0}}));
    EXPECT_EQ(quantised<std::int16_t>({0, 0, 0, 32767, 0, 0, 0, -32768, 0}, true), (P{{0, 0, 0}, {1, 0, 0}, {0, -1, 0}}));
    EXPECT_EQ(quantised<std::int16_t>({0, 0, 0, 300, 0, 0, 0, -300, 0}, false), (P{{0, 0, 0}, {300, 0, 0}, {0, -300, 0}}));
    EXPECT_EQ(quantised<std::uint16_t>({0, 0, 0, 65535, 0, 0, 0, 13107, 0}, true), (P{{0, 0, 0}, {1, 0, 0}, {0, 0.2, 0}}));
}

TEST(Gltf, StridedViews) {
    GltfBuilder b;
    // Position, then a normal that is not read; and an accessor that starts within the view.
    int mesh = b.add_mesh(b.add_accessor<float>("VEC3", {9, 9, 9, 8, 8, 8, 0, 0, 0, 8, 8, 8, 1, 0, 0, 8, 8, 8, 0, 1, 0}));
    b.json["bufferViews"][0]["byteStride"] = 24;
    b.json["accessors"][0]["byteOffset"] = 24;
    b.json["accessors"][0]["count"] = 3;
    b.add("nodes", {{"mesh", mesh}});
    EXPECT_EQ(corners(read(b.glb())), kTriangle);
}

TEST(Gltf, SparseAccessorsReplaceElements) {
    GltfBuilder b;
    int points = b.add_accessor<float>("VEC3", {0, 0, 0, 1, 0, 0, 0, 1, 0});
    int indices = b.add_view<std::uint8_t>({0, 2}), values = b.add_view<float>({5, 5, 5, 6, 6, 6});
    b.json["accessors"][0]["sparse"] = {{"count", 2},
                                        {"indices", {{"bufferView", indices}, {"componentType", 5121}}},
                                        {"values", {{"bufferView", values}}}};
    b.add("nodes", {{"mesh", b.add_mesh(points)}});
    EXPECT_EQ(corners(read(b.glb())), (std::vector<Vec3d>{{5, 5, 5}, {1, 0, 0}, {6, 6, 6}}));

    // Without a buffer view the rest is zero.
    b.json["accessors"][0].erase("bufferView");
    EXPECT_EQ(corners(read(b.glb())), (std::vector<Vec3d>{{5, 5, 5}, {0, 0, 0}, {6, 6, 6}}));
}

TEST(Gltf, SparseIndices) {
    GltfBuilder b;
    int points = b.add_accessor<float>("VEC3", {0, 0, 0, 1, 0, 0, 0, 1, 0});
    int list = b.add_accessor<std::uint16_t>("SCALAR", {0, 1, 0});
    int indices = b.add_view<std::uint8_t>({2}), values = b.add_view<std::uint16_t>({2});
    b.json["accessors"][1]["sparse"] = {{"count", 1},
                                        {"indices", {{"bufferView", indices}, {"componentType", 5121}}},
                                        {"values", {{"bufferView", values}}}};
    b.add("nodes", {{"mesh", b.add_mesh(points, list)}});
    EXPECT_EQ(corners(read(b.glb())), kTriangle);
}

TEST(Gltf, VerticesThatNoTriangleUsesAreNotTakenOver) {
    GltfBuilder b;
    std::vector<float> points(300);
    points[3 * 40] = 1;
    points[3 * 60 + 1] = 1;
    int mesh = b.add_mesh(b.add_accessor("VEC3", points), b.add_accessor<std::uint8_t>("SCALAR", {7, 40, 60}));
    b.add("nodes", {{"mesh", mesh}});
    RawScene raw = read(b.glb());
    EXPECT_EQ(raw.positions.size(), 3u);
    EXPECT_EQ(corners(raw), kTriangle);
}

TEST(Gltf, InstancesAreObjects) {
    GltfBuilder b;
    b.json["extensionsRequired"] = {"EXT_mesh_gpu_instancing"};
    int mesh = b.add_triangle_mesh();
    int t = b.add_accessor<float>("VEC3", {10, 0, 0, 20, 0, 0});
    // The second turned by half about z, as normalised bytes.
    int r = b.add_accessor<std::int8_t>("VEC4", {0, 0, 0, 127, 0, 0, 127, 0}, true);
    int s = b.add_accessor<float>("VEC3", {1, 1, 1, 2, 2, -2});
    b.add("nodes", {{"mesh", mesh}, {"name", "tree"}, {"translation", {0, 0, 5}},
                    {"extensions", {{"EXT_mesh_gpu_instancing",
                                     {{"attributes", {{"TRANSLATION", t}, {"ROTATION", r}, {"SCALE", s}}}}}}}});
    RawScene raw = read(b.glb());
    ASSERT_EQ(raw.objects.size(), 2u);
    EXPECT_EQ(raw.objects[1].id, (ObjectId{0, 0, 1}));
    EXPECT_EQ(raw.objects[1].name, "tree#1");
    // The second is mirrored by its scale, so its winding turns.
    EXPECT_EQ(corners(raw), (std::vector<Vec3d>{{10, 0, 5}, {11, 0, 5}, {10, 1, 5}, {20, 0, 5}, {20, -2, 5}, {18, 0, 5}}));
}

TEST(Gltf, MeshesMayBeSharedByNodes) {
    GltfBuilder b;
    int mesh = b.add_triangle_mesh();
    b.add("nodes", {{"mesh", mesh}});
    b.add("nodes", {{"mesh", mesh}, {"translation", {0, 0, 1}}});
    RawScene raw = read(b.glb());
    EXPECT_EQ(corners(raw), (std::vector<Vec3d>{{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}, {1, 0, 1}, {0, 1, 1}}));
    EXPECT_EQ(raw.objects[1].first_triangle, 1u);
    EXPECT_EQ(raw.objects[1].name, "node 1");
}

TEST(Gltf, NamesAndOrder) {
    GltfBuilder b;
    int mesh = b.add_triangle_mesh();
    b.json["meshes"][0]["name"] = "m";
    b.json["meshes"][0]["primitives"].push_back(b.json["meshes"][0]["primitives"][0]);
    // Roots listed backwards: objects still come by node index.
    b.add("nodes", {{"mesh", mesh}});
    b.add("nodes", {{"mesh", mesh}, {"name", "n"}});
    b.json["scenes"] = Json::array({{{"nodes", {1, 0}}}});
    std::vector<std::string> names;
    for (const RawObject& object : read(b.glb()).objects)
        names.push_back(object.name);
    EXPECT_EQ(names, (std::vector<std::string>{"m/primitive 0", "m/primitive 1", "n/primitive 0", "n/primitive 1"}));
}

TEST(Gltf, OnlyTheDefaultSceneIsRead) {
    GltfBuilder b;
    int mesh = b.add_triangle_mesh();
    for (int i = 0; i < 3; ++i)
        b.add("nodes", {{"mesh", mesh}});
    auto nodes = [&] {
        std::vector<int> ids;
        for (const RawObject& object : read(b.glb()).objects)
            ids.push_back(object.id.node);
        return ids;
    };
    EXPECT_EQ(nodes(), (std::vector<int>{0, 1, 2}));
    b.json["scenes"] = Json::parse(R"([{"nodes":[0]},{"nodes":[2,1]}])");
    EXPECT_EQ(nodes(), (std::vector<int>{0}));
    b.json["scene"] = 1;
    EXPECT_EQ(nodes(), (std::vector<int>{1, 2}));
}

TEST(Gltf, PointsLinesAndEmptyPrimitivesAreLeftOut) {
    GltfBuilder b;
    int mesh = b.add_triangle_mesh();
    Json& primitives = b.json["meshes"][0]["primitives"];
    for (int mode = 0; mode < 4; ++mode)
        primitives.push_back({{"attributes", {{"POSITION", 0}}}, {"mode", mode}});
    primitives.push_back({{"attributes", Json::object()}});
    b.add("nodes", {{"mesh", mesh}});
    RawScene raw = read(b.glb());
    EXPECT_EQ(raw.objects.size(), 1u);
    EXPECT_EQ(found(raw, "points or lines left out"), 4u);
    EXPECT_EQ(found(raw, "primitive without positions left out"), 1u);
}

/// Flags of the one object whose material is `material`.
std::uint32_t flags_with(Json material) {
    GltfBuilder b;
    b.add("materials", std::move(material));
    b.add("nodes", {{"mesh", b.add_triangle_mesh(0)}});
    RawScene raw = read(b.glb());
    return raw.objects.empty() ? ~0u : raw.objects[0].flags;
}

TEST(Gltf, MaterialsDecideWhoOccludes) {
    EXPECT_EQ(flags_with(Json::object()), kOccludes);
    EXPECT_EQ(flags_with({{"alphaMode", "OPAQUE"}}), kOccludes);
    EXPECT_EQ(flags_with({{"alphaMode", "MASK"}}), 0u);
    EXPECT_EQ(flags_with({{"alphaMode", "BLEND"}}), 0u);
    EXPECT_EQ(flags_with({{"alphaMode", "SOMETHING NEW"}}), 0u);
    EXPECT_EQ(flags_with({{"doubleSided", true}}), kOccludes | kDoubleSided);
    auto with = [](const char* extension, Json body) {
        return flags_with({{"extensions", {{extension, std::move(body)}}}});
    };
    EXPECT_EQ(with("KHR_materials_transmission", {{"transmissionFactor", 0.5}}), 0u);
    EXPECT_EQ(with("KHR_materials_transmission", {{"transmissionFactor", 0}}), kOccludes);
    EXPECT_EQ(with("KHR_materials_transmission", Json::object()), kOccludes);
    EXPECT_EQ(with("KHR_materials_volume", Json::object()), 0u);
    EXPECT_EQ(with("KHR_materials_diffuse_transmission", Json::object()), 0u);
    EXPECT_EQ(with("KHR_materials_clearcoat", Json::object()), kOccludes);
}

TEST(Gltf, VariantsMustAllOcclude) {
    GltfBuilder b;
    b.json["materials"] = Json::parse(R"([{}, {"alphaMode":"BLEND"}, {"doubleSided":true}])");
    int mesh = b.add_triangle_mesh(0);
    b.add("nodes", {{"mesh", mesh}});
    auto flags = [&](int variant) {
        b.json["meshes"][0]["primitives"][0]["extensions"]["KHR_materials_variants"]["mappings"] =
            Json::array({{{"material", variant}, {"variants", {0}}}});
        return read(b.glb()).objects.at(0).flags;
    };
    EXPECT_EQ(flags(0), kOccludes);
    EXPECT_EQ(flags(1), 0u);
    EXPECT_EQ(flags(2), kDoubleSided);
}

TEST(Gltf, WhatMovesNeverOccludes) {
    constexpr std::uint32_t kMoving = kMoves | kAlwaysVisible;
    auto flags = [](const char* path, bool of_parent, Json node_extra = Json::object(), bool morph = false) {
        GltfBuilder b;
        int mesh = b.add_triangle_mesh();
        if (morph)
            b.json["meshes"][0]["primitives"][0]["targets"] = Json::array({{{"POSITION", 0}}});
        b.add("nodes", {{"children", {1}}});
        Json node = {{"mesh", mesh}};
        node.update(node_extra);
        b.add("nodes", node);
        int key = b.add_accessor<float>("SCALAR", {0});
        if (path)
            b.json["animations"] = Json::array(
                {{{"samplers", Json::array({{{"input", key}, {"output", key}}})},
                  {"channels", Json::array({{{"sampler", 0}, {"target", {{"node", of_parent ? 0 : 1}, {"path", path}}}}})}}});
        return read(b.glb()).objects.at(0).flags;
    };
    EXPECT_EQ(flags(nullptr, false), kOccludes);
    EXPECT_EQ(flags("translation", false), kMoving);
    EXPECT_EQ(flags("rotation", true), kMoving);
    EXPECT_EQ(flags("scale", true), kMoving);
    EXPECT_EQ(flags("weights", false), kMoving);
    EXPECT_EQ(flags("weights", true), kOccludes);
    EXPECT_EQ(flags(nullptr, false, {{"skin", 0}}), kMoving);
    EXPECT_EQ(flags(nullptr, false, Json::object(), true), kMoving);
}

TEST(Gltf, AnimationPointers) {
    auto flags = [](const char* pointer) {
        GltfBuilder b;
        b.add("materials", Json::object());
        b.add("nodes", {{"mesh", b.add_triangle_mesh(0)}});
        int key = b.add_accessor<float>("SCALAR", {0});
        Json target = {{"path", "pointer"}, {"extensions", {{"KHR_animation_pointer", {{"pointer", pointer}}}}}};
        b.json["animations"] = Json::array({{{"samplers", Json::array({{{"input", key}, {"output", key}}})},
                                             {"channels", Json::array({{{"sampler", 0}, {"target", target}}})}}});
        return read(b.glb()).objects.at(0).flags;
    };
    EXPECT_EQ(flags("/nodes/0/translation"), kMoves | kAlwaysVisible);
    EXPECT_EQ(flags("/meshes/0/weights"), kMoves | kAlwaysVisible);
    EXPECT_EQ(flags("/materials/0/pbrMetallicRoughness/baseColorFactor"), 0u);
    EXPECT_EQ(flags("/nodes/7/translation"), kOccludes);
    EXPECT_EQ(flags("/cameras/0/perspective/yfov"), kOccludes);
}

TEST(Gltf, HiddenNodesHideNothing) {
    GltfBuilder b;
    int mesh = b.add_triangle_mesh();
    b.add("nodes", {{"children", {1}}, {"extensions", {{"KHR_node_visibility", {{"visible", false}}}}}});
    b.add("nodes", {{"mesh", mesh}});
    RawScene raw = read(b.glb());
    EXPECT_EQ(raw.objects.at(0).flags, 0u);
    EXPECT_EQ(found(raw, "hidden object"), 1u);
}

TEST(Gltf, AuthorFlagsOnNodesMeshesAndMaterials) {
    auto flags = [](const char* where, Json extras) -> std::int64_t {
        GltfBuilder b;
        b.add("materials", Json::object());
        int mesh = b.add_triangle_mesh(0);
        b.add("nodes", {{"children", {1}}});
        b.add("nodes", {{"mesh", mesh}});
        b.json[Json::json_pointer(where)]["extras"] = std::move(extras);
        RawScene raw = read(b.glb());
        return raw.objects.empty() ? std::int64_t(-1) : raw.objects[0].flags;
    };
    for (const char* where : {"/nodes/0", "/nodes/1", "/meshes/0", "/materials/0"}) {
        EXPECT_EQ(flags(where, {{"antumbra", {{"never_cull", true}}}}), kOccludes | kAlwaysVisible);
        EXPECT_EQ(flags(where, {{"antumbra", {{"never_occlude", true}}}}), 0);
        EXPECT_EQ(flags(where, {{"antumbra", {{"ignore", true}}}}), -1);
        EXPECT_EQ(flags(where, {{"antumbra_never_cull", 1}}), kOccludes | kAlwaysVisible);
        EXPECT_EQ(flags(where, {{"antumbra_ignore", false}}), kOccludes);
        EXPECT_EQ(flags(where, "antumbra_ignore"), kOccludes);
    }
}

/// A folder of its own, removed at the end.
class GltfFolder : public ::testing::Test {
  protected:
    GltfFolder() {
        root_ = fs::temp_directory_path() / ("antumbra-gltf-" + std::to_string(::getpid()));
        fs::create_directories(root_ / "scene" / "sub folder");
        GltfBuilder b;
        b.add("nodes", {{"mesh", b.add_triangle_mesh()}});
        builder_ = b;
        for (const char* name : {"scene/a.bin", "scene/sub folder/a.bin", "outside.bin"})
            std::ofstream(root_ / name, std::ios::binary) << b.binary;
        fs::create_symlink(root_ / "outside.bin", root_ / "scene" / "link.bin");
        fs::create_symlink("a.bin", root_ / "scene" / "inner.bin");
    }
    ~GltfFolder() override { fs::remove_all(root_); }

    Result<RawScene> with_uri(const std::string& uri) {
        builder_.json["buffers"] = Json::array({{{"byteLength", 36}, {"uri", uri}}});
        return import_gltf(bytes_of(builder_.gltf()), "t.gltf", (root_ / "scene").string());
    }

    fs::path root_;
    GltfBuilder builder_;
};

TEST_F(GltfFolder, BuffersBelowTheFolderAreRead) {
    for (const char* uri : {"a.bin", "./a.bin", "sub folder/a.bin", "sub%20folder/a.bin", "inner.bin"}) {
        Result<RawScene> raw = with_uri(uri);
        ASSERT_TRUE(raw.ok()) << uri << ": " << raw.status().message();
        EXPECT_EQ(corners(*raw), kTriangle);
    }
}

TEST_F(GltfFolder, EverythingElseIsRefused) {
    const std::string refused[] = {"", "/etc/passwd", (root_ / "scene/a.bin").string(), "../outside.bin",
                                   "sub folder/../../outside.bin", "sub folder/../a.bin", "%2e%2e/outside.bin",
                                   "..%2Foutside.bin", "link.bin", "file:a.bin", "file:///etc/passwd",
                                   "http://localhost/a.bin", "C:/a.bin", "..\\outside.bin", "\\\\host\\share",
                                   "~/a.bin", "a.bin%00.png", "a.bin%0a", "%2Fetc%2Fpasswd", "$(reboot)/../../x"};
    for (const std::string& uri : refused) {
        Result<RawScene> raw = with_uri(uri);
        ASSERT_FALSE(raw.ok()) << uri;
        EXPECT_EQ(raw.status().code(), ErrorCode::unsupported) << uri << ": " << raw.status().message();
        EXPECT_NE(raw.status().message().find("t.gltf: "), std::string::npos);
        EXPECT_NE(raw.status().message().find("buffers[0].uri"), std::string::npos);
    }
    EXPECT_EQ(with_uri("nothing.bin").status().code(), ErrorCode::io);
    EXPECT_EQ(with_uri("sub folder").status().code(), ErrorCode::io);
    EXPECT_EQ(with_uri("$(reboot)").status().code(), ErrorCode::io);
    EXPECT_EQ(with_uri("a%2.bin").status().code(), ErrorCode::corrupt);
}

TEST_F(GltfFolder, ImportFileFindsBuffersBesideIt) {
    builder_.json["buffers"] = Json::array({{{"byteLength", 36}, {"uri", "a.bin"}}});
    fs::path path = root_ / "scene" / "Scene.GLTF";
    std::ofstream(path) << builder_.gltf();
    Result<RawScene> raw = import_file(path.string());
    ASSERT_TRUE(raw.ok()) << raw.status().message();
    EXPECT_EQ(raw->triangles.size(), 1u);
    EXPECT_EQ(import_file((root_ / "scene" / "a.bin").string()).status().code(), ErrorCode::unsupported);
    EXPECT_EQ(import_file((root_ / "none.glb").string()).status().code(), ErrorCode::io);
}

TEST(Gltf, MissingBuffersThatGeometryDoesNotNeedAreNoError) {
    GltfBuilder b;
    b.add("nodes", {{"mesh", b.add_triangle_mesh()}});
    b.json["buffers"] = Json::parse(R"([{"byteLength":36},{"byteLength":8,"uri":"textures.bin"}])");
    EXPECT_EQ(corners(read(b.glb())), kTriangle);
}

TEST(Gltf, LimitsAreKeptBeforeAnythingIsMade) {
    GltfBuilder b;
    int mesh = b.add_triangle_mesh();
    b.add("nodes", {{"mesh", mesh}});
    b.add("nodes", {{"mesh", mesh}});
    auto message = [&](auto edit) {
        ImportOptions options;
        edit(options.limits);
        Result<RawScene> raw = import_gltf(bytes_of(b.glb()), "t.glb", "", options);
        EXPECT_EQ(raw.status().code(), ErrorCode::limit);
        return raw.status().message();
    };
    const std::string place = "t.glb: nodes[1]: meshes[0].primitives[0]: the scene needs more ";
    EXPECT_EQ(message([](ImportLimits& l) { l.vertices = 5; }),
              place + "vertices than the limit of 5; split it or raise the limit");
    EXPECT_EQ(message([](ImportLimits& l) { l.triangles = 1; }),
              place + "triangles than the limit of 1; split it or raise the limit");
    EXPECT_EQ(message([](ImportLimits& l) { l.objects = 1; }),
              place + "objects than the limit of 1; split it or raise the limit");
    EXPECT_NE(message([](ImportLimits& l) { l.bytes = 100; }).find("more than the limit of 100"), std::string::npos);
    EXPECT_NE(message([](ImportLimits& l) { l.memory = 1000; }).find("memory"), std::string::npos);
    ImportOptions enough;
    enough.limits = {b.glb().size(), 6, 2, 2, 1u << 16, 1};
    EXPECT_EQ(read(b.glb(), enough).triangles.size(), 2u);
}

} // namespace
} // namespace antumbra
