// Bad glTF: one clear error that names the file and the place, never a crash.
#include <antumbra/import.hpp>

#include "import/gltf_builder.hpp"

#include <gtest/gtest.h>

#include <functional>
#include <limits>

namespace antumbra {
namespace {

using test::bytes_of;
using test::GltfBuilder;
using test::Json;

/// A file that uses most of what the reader knows: hierarchy, indices, sparse, instancing, animation, material.
GltfBuilder full_file() {
    GltfBuilder b;
    b.add("materials", {{"alphaMode", "MASK"}, {"doubleSided", true}});
    int points = b.add_accessor<float>("VEC3", {0, 0, 0, 1, 0, 0, 0, 1, 0, 1, 1, 0});
    int indices = b.add_accessor<std::uint16_t>("SCALAR", {0, 1, 2, 2, 1, 3});
    int at = b.add_view<std::uint8_t>({1}), values = b.add_view<float>({2, 0, 0});
    b.json["accessors"][0]["sparse"] = {{"count", 1},
                                        {"indices", {{"bufferView", at}, {"componentType", 5121}}},
                                        {"values", {{"bufferView", values}}}};
    int mesh = b.add_mesh(points, indices, 0);
    int offsets = b.add_accessor<float>("VEC3", {0, 0, 0, 9, 0, 0});
    int times = b.add_accessor<float>("SCALAR", {0});
    b.add("nodes", {{"children", {1, 2}}, {"rotation", {0, 0, 0, 1}}});
    b.add("nodes", {{"mesh", mesh}, {"name", "a"}});
    b.add("nodes", {{"mesh", mesh}, {"extensions", {{"EXT_mesh_gpu_instancing",
                                                      {{"attributes", {{"TRANSLATION", offsets}}}}}}}});
    b.json["scenes"] = Json::array({{{"nodes", {0}}}});
    b.json["animations"] = Json::array(
        {{{"samplers", Json::array({{{"input", times}, {"output", offsets}}})},
          {"channels", Json::array({{{"sampler", 0}, {"target", {{"node", 1}, {"path", "translation"}}}}})}}});
    return b;
}

Status import(const std::string& file) { return import_gltf(bytes_of(file), "bad.glb", "").status(); }

TEST(GltfErrors, TheFullFileItselfIsGood) {
    Result<RawScene> raw = import_gltf(bytes_of(full_file().glb()), "good.glb", "");
    ASSERT_TRUE(raw.ok()) << raw.status().message();
    EXPECT_EQ(raw->objects.size(), 3u);
    EXPECT_EQ(raw->triangles.size(), 6u);
}

struct Edit {
    const char* pointer; ///< JSON pointer
    const char* value;   ///< JSON, or "" to erase
    ErrorCode code;
    const char* part; ///< of the message
};

TEST(GltfErrors, EveryBadValueIsNamed) {
    constexpr ErrorCode corrupt = ErrorCode::corrupt, limit = ErrorCode::limit, unsupported = ErrorCode::unsupported;
    const Edit edits[] = {
        {"/asset", "", unsupported, "asset.version"},
        {"/asset", "7", corrupt, "asset: must be an object"},
        {"/asset/version", "\"1.0\"", unsupported, "asset.version: is '1.0'; only glTF 2.x is read"},
        {"/extensionsRequired", "[\"ACME_secret\"]", unsupported, "the file requires ACME_secret"},
        {"/extensionsRequired", "{}", corrupt, "extensionsRequired: must be an array"},
        {"/buffers", "[{\"byteLength\":1000000}]", corrupt, "buffers[0].byteLength: should have 1000000"},
        {"/buffers", "[{}]", corrupt, "buffers[0].byteLength: is missing"},
        {"/buffers", "[{\"byteLength\":-1}]", corrupt, "buffers[0].byteLength: must be a whole number"},
        {"/buffers", "[{\"byteLength\":1,\"uri\":\"data:,%\"}]", corrupt, "buffers[0].uri: data URI holds a broken"},
        {"/buffers", "[{\"byteLength\":9,\"uri\":\"data:;base64,????\"}]", corrupt, "not valid base64"},
        {"/buffers", "[{\"byteLength\":9,\"uri\":\"data:nothing\"}]", corrupt, "without a comma"},
        {"/buffers", "[{\"byteLength\":9,\"uri\":7}]", corrupt, "buffers[0].uri: must be a text"},
        {"/buffers", "[{\"byteLength\":9,\"uri\":\"a.bin\"}]", unsupported, "buffers[0].uri: 'a.bin'"},
        {"/bufferViews/0/buffer", "1", corrupt, "bufferViews[0].buffer: refers to 1"},
        {"/bufferViews/0/buffer", "-1", corrupt, "bufferViews[0].buffer: must be a whole number"},
        {"/bufferViews/0/buffer", "", corrupt, "bufferViews[0].buffer: is missing"},
        {"/bufferViews/0/byteOffset", "18446744073709551615", corrupt, "bufferViews[0]: bytes 18446744073709551615"},
        {"/bufferViews/0/byteLength", "18446744073709551615", corrupt, "bufferViews[0]: bytes 0 and the next"},
        {"/bufferViews/0/byteLength", "47", corrupt, "4 elements of 12 bytes do not fit into the 47 bytes"},
        {"/bufferViews/0/byteStride", "8", corrupt, "byteStride is shorter than an element"},
        {"/bufferViews/0/byteStride", "13", corrupt, "do not fit"},
        {"/bufferViews/0/byteStride", "99999999999", corrupt, "bufferViews[0].byteStride"},
        {"/accessors/0/bufferView", "77", corrupt, "accessors[0].bufferView: refers to 77"},
        {"/accessors/0/bufferView", "\"x\"", corrupt, "accessors[0].bufferView: must be a whole number"},
        {"/accessors/0/bufferView", "0.5", corrupt, "accessors[0].bufferView: must be a whole number"},
        {"/accessors/0/byteOffset", "18446744073709551608", corrupt, "accessors[0]: 4 elements"},
        {"/accessors/0/count", "", corrupt, "accessors[0].count: is missing"},
        {"/accessors/0/count", "5", corrupt, "accessors[0]: 5 elements of 12 bytes do not fit"},
        {"/accessors/0/count", "4000000000", corrupt, "do not fit"},
        // 12 * 1537228672809129302 = 2^64 + 8
        {"/accessors/0/count", "1537228672809129302", limit, "accessors[0].count: more than 2^32"},
        {"/accessors/0/componentType", "5124", corrupt, "accessors[0].componentType: 5124 is no component type"},
        {"/accessors/0/componentType", "5125", corrupt, "accessors[0]: positions must be VEC3"},
        {"/accessors/0/type", "\"VEC2\"", corrupt, "accessors[0]: positions must be VEC3"},
        {"/accessors/0/type", "\"VEC9\"", corrupt, "accessors[0].type: 'VEC9' is no accessor type"},
        {"/accessors/0/sparse", "7", corrupt, "accessors[0].sparse: must be an object"},
        {"/accessors/0/sparse/count", "5", corrupt, "accessors[0].sparse.count: 5 is more than 4"},
        {"/accessors/0/sparse/count", "2", corrupt, "accessors[0].sparse: indices: 2 elements"},
        {"/accessors/0/sparse/indices/componentType", "5126", corrupt, "indices must be unsigned"},
        {"/accessors/0/sparse/indices/bufferView", "", corrupt, "accessors[0].sparse.indices.bufferView: is missing"},
        {"/accessors/0/sparse/indices/byteOffset", "2", corrupt, "accessors[0].sparse: indices"},
        {"/accessors/0/sparse/values/byteOffset", "4", corrupt, "accessors[0].sparse: values"},
        {"/accessors/1/componentType", "5126", corrupt, "accessors[1]: indices must be SCALAR and unsigned"},
        {"/accessors/1/type", "\"VEC2\"", corrupt, "accessors[1]: indices must be SCALAR and unsigned"},
        {"/accessors/0/count", "3", corrupt, "accessors[1]: element 5 is 3, but there are only 3 vertices"},
        {"/accessors/1/bufferView", "", limit, "ok"},
        {"/meshes/0/primitives/0/attributes/POSITION", "9", corrupt,
         "meshes[0].primitives[0].attributes.POSITION: refers to 9"},
        {"/meshes/0/primitives/0/indices", "9", corrupt, "meshes[0].primitives[0].indices: refers to 9"},
        {"/meshes/0/primitives/0/material", "1", corrupt, "meshes[0].primitives[0].material: refers to 1"},
        {"/meshes/0/primitives/0/mode", "7", corrupt, "meshes[0].primitives[0].mode: 7 is more than 6"},
        {"/meshes/0/primitives", "{}", corrupt, "meshes[0].primitives: must be an array"},
        {"/meshes/0/primitives/0", "3", corrupt, "meshes[0].primitives[0]: must be an object"},
        {"/nodes/1/mesh", "1", corrupt, "nodes[1].mesh: refers to 1"},
        {"/nodes/1/name", "3", corrupt, "nodes[1].name: must be a text"},
        {"/nodes/0/rotation", "[0,0,1]", corrupt, "nodes[0].rotation: must hold 4 finite numbers"},
        {"/nodes/0/translation", "[0,0,\"1\"]", corrupt, "nodes[0].translation: must hold 3 finite numbers"},
        {"/nodes/0/matrix", "[1,0,0,0,0,1,0,0,0,0,1,5,0,0,0,1]", unsupported, "nodes[0].matrix: is a projection"},
        {"/nodes/0/children", "[1,2,0]", corrupt, "is no root"},
        {"/nodes/1/children", "[2]", corrupt, "nodes[1].children[0]: node 2 already hangs below node 0"},
        {"/nodes/0/children", "[1,1]", corrupt, "already hangs below"},
        {"/nodes/0/children", "[3]", corrupt, "nodes[0].children[0]: 3 is more than 2"},
        {"/nodes/0/children", "3", corrupt, "nodes[0].children: must be an array"},
        {"/nodes/2/extensions/EXT_mesh_gpu_instancing/attributes/SCALE", "0", corrupt, "attributes differ in length"},
        {"/nodes/2/extensions/EXT_mesh_gpu_instancing/attributes/ROTATION", "2", corrupt,
         "nodes[2]: meshes[0].primitives[0].EXT_mesh_gpu_instancing: accessors[2]: must have 4 components"},
        {"/scene", "1", corrupt, "scene: refers to 1, but there are only 1"},
        {"/scenes/0/nodes", "[0,0]", corrupt, "scenes[0].nodes[1]: node 0 is listed twice"},
        {"/scenes/0/nodes", "[1]", corrupt, "scenes[0].nodes[0]: node 1 is no root"},
        {"/scenes/0/nodes", "[5]", corrupt, "scenes[0].nodes[0]: 5 is more than 2"},
        {"/animations/0/channels/0/sampler", "1", corrupt, "animations[0].channels[0].sampler: refers to 1"},
        {"/animations/0/channels/0/target/node", "9", corrupt, "animations[0].channels[0].target.node"},
        {"/materials/0/doubleSided", "1", corrupt, "materials[0].doubleSided: must be true or false"},
    };
    for (const Edit& edit : edits) {
        GltfBuilder b = full_file();
        Json::json_pointer pointer(edit.pointer);
        if (*edit.value)
            b.json[pointer] = Json::parse(edit.value);
        else
            b.json[pointer.parent_pointer()].erase(pointer.back());
        Status status = import(b.glb());
        if (std::string(edit.part) == "ok") {
            EXPECT_TRUE(status.ok()) << edit.pointer << ": " << status.message();
            continue;
        }
        ASSERT_FALSE(status.ok()) << edit.pointer << " = " << edit.value;
        EXPECT_EQ(status.code(), edit.code) << status.message();
        EXPECT_EQ(status.message().rfind("bad.glb: ", 0), 0u) << status.message();
        EXPECT_NE(status.message().find(edit.part), std::string::npos)
            << edit.pointer << " = " << edit.value << "\n " << status.message();
    }
}

TEST(GltfErrors, NumbersThatAreNotFinite) {
    for (float bad : {std::numeric_limits<float>::quiet_NaN(), std::numeric_limits<float>::infinity()}) {
        GltfBuilder b;
        b.add("nodes", {{"mesh", b.add_mesh(b.add_accessor<float>("VEC3", {0, 0, 0, 1, 0, 0, 0, bad, 0}))}});
        EXPECT_EQ(import(b.glb()).message(), "bad.glb: nodes[0]: meshes[0].primitives[0]: accessors[0]: element 2 is "
                                             "not finite; repair the mesh");
    }
}

TEST(GltfErrors, TransformsThatOverflowAreFoundByTheScene) {
    GltfBuilder b;
    b.add("nodes", {{"mesh", b.add_triangle_mesh()}, {"scale", {1e308, 1e308, 1}}, {"translation", {1e308, 0, 0}}});
    Result<RawScene> raw = import_gltf(bytes_of(b.glb()), "bad.glb", "");
    ASSERT_TRUE(raw.ok());
    Result<Scene> scene = Scene::create(*raw);
    ASSERT_FALSE(scene.ok());
    EXPECT_NE(scene.status().message().find("bad.glb: object 'node 0'"), std::string::npos);
}

TEST(GltfErrors, ContainersThatAreNone) {
    std::string good = full_file().glb();
    struct Case {
        std::function<std::string()> file;
        ErrorCode code;
        const char* part;
    };
    auto with = [&](std::size_t at, const std::string& bytes) {
        return [=] {
            std::string file = good;
            return file.replace(at, bytes.size(), bytes);
        };
    };
    const Case cases[] = {
        {[] { return ""; }, ErrorCode::corrupt, "the file is empty"},
        {[] { return "glTF"; }, ErrorCode::corrupt, "GLB header is cut off"},
        {with(4, std::string("\1\0\0\0", 4)), ErrorCode::unsupported, "GLB version 1"},
        {with(8, "\xFF\xFF\xFF\xFF"), ErrorCode::corrupt, "GLB is cut off"},
        {with(8, std::string("\14\0\0\0", 4)), ErrorCode::corrupt, "GLB without a JSON chunk"},
        {with(8, std::string("\20\0\0\0", 4)), ErrorCode::corrupt, "chunk header at byte 12 is cut off"},
        {with(12, "\xFF\xFF\xFF\xFF"), ErrorCode::corrupt, "GLB chunk at byte 12 is longer than the file"},
        {with(16, "BIN"), ErrorCode::corrupt, "the first chunk of a GLB must be JSON"},
        {with(20, "x"), ErrorCode::corrupt, "is not valid JSON (byte 1)"},
        {[] { return "{\"asset\":{\"version\":\"2.0\"}"; }, ErrorCode::corrupt, "is not valid JSON"},
        {[] { return "{\"asset\":{\"version\":\"2.0\"},\"nodes\":[1e999]}"; }, ErrorCode::corrupt, "is not valid JSON"},
        {[] { return "[]"; }, ErrorCode::corrupt, "must be an object"},
        {[] { return "\xEF\xBB\xBF"; }, ErrorCode::corrupt, "is not valid JSON"},
    };
    for (const Case& c : cases) {
        Status status = import(c.file());
        EXPECT_EQ(status.code(), c.code) << status.message();
        EXPECT_NE(status.message().find(c.part), std::string::npos) << status.message();
    }
}

TEST(GltfErrors, EmptyScenesAreReadButNotMadeIntoScenes) {
    for (const char* text : {R"({"asset":{"version":"2.0"}})", R"({"asset":{"version":"2.0"},"scenes":[{}]})",
                             R"({"asset":{"version":"2.0"},"nodes":[{"mesh":0}],"meshes":[{"primitives":[]}]})"}) {
        Result<RawScene> raw = import_gltf(bytes_of(text), "empty.gltf", "");
        ASSERT_TRUE(raw.ok()) << raw.status().message();
        Result<Scene> scene = Scene::create(*raw);
        ASSERT_FALSE(scene.ok());
        EXPECT_EQ(scene.status().message(), "empty.gltf: the scene has no triangles; nothing can be seen in it");
    }
}

TEST(GltfErrors, CirclesAndDeepHierarchies) {
    GltfBuilder circle;
    circle.json["nodes"] = Json::parse(R"([{}, {"children":[2]}, {"children":[1]}])");
    EXPECT_EQ(import(circle.glb()).message(), "bad.glb: nodes[1]: is its own ancestor; repair the hierarchy");
    GltfBuilder self;
    self.json["nodes"] = Json::parse(R"([{"children":[0]}])");
    EXPECT_EQ(import(self.glb()).message(), "bad.glb: nodes[0]: is its own ancestor; repair the hierarchy");

    GltfBuilder chain;
    constexpr int kNodes = 100'000;
    for (int n = 0; n < kNodes; ++n)
        chain.add("nodes", n + 1 < kNodes ? Json{{"children", {n + 1}}} : Json{{"mesh", 0}});
    chain.add_triangle_mesh();
    EXPECT_EQ(import(chain.glb()).code(), ErrorCode::limit);
    EXPECT_EQ(import(chain.glb()).message(), "bad.glb: nodes[256]: hangs deeper than 256 levels");
}

TEST(GltfErrors, DeepJson) {
    std::string text = R"({"asset":{"version":"2.0"},"extras":)" + std::string(1'000'000, '[');
    EXPECT_EQ(import(text).message(), "bad.glb: JSON nests deeper than 128 levels");
    // Brackets within texts do not count.
    std::string quoted = R"({"asset":{"version":"2.0","x":")" + std::string(1000, '[') + R"(\"[["}})";
    EXPECT_TRUE(import(quoted).ok()) << import(quoted).message();
}

TEST(GltfErrors, ZerosWithoutBytesAreBounded) {
    GltfBuilder b;
    b.json["accessors"] = Json::parse(R"([{"componentType":5126,"type":"VEC3","count":400000000}])");
    b.add("nodes", {{"mesh", b.add_mesh(0)}});
    EXPECT_EQ(import(b.glb()).code(), ErrorCode::limit);
    b.json["accessors"][0]["count"] = 4'000'000;
    EXPECT_NE(import(b.glb()).message().find("outnumber the bytes of the file"), std::string::npos);
}

TEST(GltfErrors, EveryTruncationEndsWell) {
    std::string good = full_file().glb();
    for (std::size_t size = 0; size < good.size(); ++size)
        EXPECT_FALSE(import(good.substr(0, size)).ok()) << size;
}

TEST(GltfErrors, FlippedBytesNeverBreakOut) {
    std::string good = full_file().glb();
    std::uint64_t accepted = 0, refused = 0;
    for (std::size_t at = 0; at < good.size(); ++at)
        for (int mask : {0x01, 0x02, 0x08, 0x10, 0x80, 0xFF}) {
            std::string file = good;
            file[at] = static_cast<char>(file[at] ^ mask);
            Result<RawScene> raw = import_gltf(bytes_of(file), "bad.glb", "");
            ++(raw.ok() ? accepted : refused);
            if (raw.ok()) {
                Result<Scene> scene = Scene::create(std::move(*raw));
                if (scene.ok())
                    validate(*scene);
            }
        }
    EXPECT_GT(accepted, 0u);
    EXPECT_GT(refused, accepted);
}

} // namespace
} // namespace antumbra
