// Draco and meshopt streams, made here by the encoders: what comes out, and what damage gives.
#include <antumbra/import.hpp>

#include "import/gltf_builder.hpp"

#include <draco/compression/encode.h>
#include <draco/mesh/mesh.h>
#include <gtest/gtest.h>
#include <meshoptimizer.h>

#include <functional>

namespace antumbra {
namespace {

using test::bytes_of;
using test::GltfBuilder;
using test::Json;

/// A bumpy grid of (n + 1)^2 vertices on whole numbers, n^2 * 2 triangles.
struct Grid {
    std::vector<float> positions;
    std::vector<std::uint32_t> indices;
    explicit Grid(std::uint32_t n) {
        for (std::uint32_t y = 0; y <= n; ++y)
            for (std::uint32_t x = 0; x <= n; ++x)
                for (std::uint32_t c : {x, (x * 7 + y * 3) % 5, y})
                    positions.push_back(float(c));
        for (std::uint32_t y = 0; y < n; ++y)
            for (std::uint32_t x = 0; x < n; ++x) {
                std::uint32_t a = y * (n + 1) + x;
                for (std::uint32_t i : {a, a + n + 1, a + 1, a + 1, a + n + 1, a + n + 2})
                    indices.push_back(i);
            }
    }
    std::size_t vertices() const { return positions.size() / 3; }
};

/// Corners of all triangles, each turned so that its least corner comes first, in sorted order: codecs reorder.
std::vector<std::array<std::array<double, 3>, 3>> triangles_of(const RawScene& raw) {
    std::vector<std::array<std::array<double, 3>, 3>> all;
    for (const TriangleIndices& t : raw.triangles) {
        std::array<std::array<double, 3>, 3> corners;
        for (std::size_t c = 0; c < 3; ++c) {
            const Vec3d& p = raw.positions[t[c]];
            corners[c] = {p.x, p.y, p.z};
        }
        std::rotate(corners.begin(), std::min_element(corners.begin(), corners.end()), corners.end());
        all.push_back(corners);
    }
    std::sort(all.begin(), all.end());
    return all;
}

Result<RawScene> import(const GltfBuilder& b) { return import_gltf(bytes_of(b.glb()), "t.glb", ""); }

GltfBuilder plain(const Grid& grid) {
    GltfBuilder b;
    int positions = b.add_accessor("VEC3", grid.positions), indices = b.add_accessor("SCALAR", grid.indices);
    b.add("nodes", {{"mesh", b.add_mesh(positions, indices)}});
    return b;
}

int add_packed(GltfBuilder& b, const std::vector<unsigned char>& packed, std::size_t count, std::size_t stride,
               const char* mode, const char* filter = "NONE") {
    int view = b.add_view(packed);
    Json& json = b.json["bufferViews"][std::size_t(view)];
    json["extensions"]["EXT_meshopt_compression"] = {{"buffer", 0}, {"byteOffset", json["byteOffset"]},
        {"byteLength", packed.size()}, {"byteStride", stride}, {"count", count}, {"mode", mode}, {"filter", filter}};
    json["byteLength"] = count * stride;
    json["byteOffset"] = 0;
    json["buffer"] = 1; // the fallback, which holds nothing
    return view;
}

GltfBuilder with_meshopt(const Grid& grid, bool sequence = false) {
    GltfBuilder b;
    std::vector<unsigned char> vertices(meshopt_encodeVertexBufferBound(grid.vertices(), 12));
    vertices.resize(meshopt_encodeVertexBuffer(vertices.data(), vertices.size(), grid.positions.data(),
                                               grid.vertices(), 12));
    std::size_t count = grid.indices.size();
    std::vector<unsigned char> indices(sequence ? meshopt_encodeIndexSequenceBound(count, grid.vertices())
                                                : meshopt_encodeIndexBufferBound(count, grid.vertices()));
    indices.resize(sequence
                       ? meshopt_encodeIndexSequence(indices.data(), indices.size(), grid.indices.data(), count)
                       : meshopt_encodeIndexBuffer(indices.data(), indices.size(), grid.indices.data(), count));
    b.json["extensionsRequired"] = {"EXT_meshopt_compression"};
    int v = add_packed(b, vertices, grid.vertices(), 12, "ATTRIBUTES");
    int i = add_packed(b, indices, count, 4, sequence ? "INDICES" : "TRIANGLES");
    b.add("accessors", {{"bufferView", v}, {"componentType", 5126}, {"type", "VEC3"}, {"count", grid.vertices()}});
    b.add("accessors", {{"bufferView", i}, {"componentType", 5125}, {"type", "SCALAR"}, {"count", count}});
    b.add("nodes", {{"mesh", b.add_mesh(0, 1)}});
    b.json["buffers"] = Json::array({{{"byteLength", b.binary.size()}},
        {{"byteLength", 1u << 20}, {"extensions", {{"EXT_meshopt_compression", {{"fallback", true}}}}}}});
    return b;
}

TEST(Meshopt, GivesTheSameTriangles) {
    Grid grid(20);
    auto wanted = triangles_of(*import(plain(grid)));
    ASSERT_EQ(wanted.size(), 800u);
    for (bool sequence : {false, true}) {
        Result<RawScene> raw = import(with_meshopt(grid, sequence));
        ASSERT_TRUE(raw.ok()) << raw.status().message();
        EXPECT_EQ(triangles_of(*raw), wanted);
        EXPECT_EQ(raw->positions.size(), 441u);
    }
}

TEST(Meshopt, ExponentialFilter) {
    // 2^E * M with 24 bits of M: 3 * 2^-1, -5 * 2^2, 0.
    GltfBuilder b;
    std::vector<std::uint32_t> words = {0xFF000003, 0x02FFFFFB, 0, 1, 0, 0, 0, 1, 0};
    std::vector<unsigned char> packed(meshopt_encodeVertexBufferBound(3, 12));
    packed.resize(meshopt_encodeVertexBuffer(packed.data(), packed.size(), words.data(), 3, 12));
    int view = add_packed(b, packed, 3, 12, "ATTRIBUTES", "EXPONENTIAL");
    b.add("accessors", {{"bufferView", view}, {"componentType", 5126}, {"type", "VEC3"}, {"count", 3}});
    b.add("nodes", {{"mesh", b.add_mesh(0)}});
    b.json["buffers"] = Json::array({{{"byteLength", b.binary.size()}}, {{"byteLength", 0}}});
    Result<RawScene> raw = import(b);
    ASSERT_TRUE(raw.ok()) << raw.status().message();
    EXPECT_EQ(raw->positions[0], (Vec3d{1.5, -20, 0}));
}

TEST(Meshopt, BadNumbersAreNamed) {
    const std::string at = "/bufferViews/0/extensions/EXT_meshopt_compression/";
    struct Case {
        const char* key;
        Json value;
        ErrorCode code;
        const char* part;
    };
    const Case cases[] = {
        {"count", 4'000'000'000, ErrorCode::limit, "bufferViews[0]: meshopt compression: 48000000000 bytes are more"},
        {"count", 440, ErrorCode::corrupt, ""},
        {"byteStride", 0, ErrorCode::corrupt, "byteStride 0 does not suit the mode"},
        {"byteStride", 10, ErrorCode::corrupt, "byteStride 10 does not suit the mode"},
        {"byteStride", 257, ErrorCode::corrupt, "byteStride: 257 is more than 256"},
        {"byteLength", 1 << 30, ErrorCode::corrupt, "reach beyond the buffer's"},
        {"byteOffset", 1 << 30, ErrorCode::corrupt, "reach beyond the buffer's"},
        {"byteLength", 10, ErrorCode::limit, "packed bytes can give"},
        {"byteLength", 1000, ErrorCode::corrupt, "the stream is damaged"},
        {"buffer", 2, ErrorCode::corrupt, "EXT_meshopt_compression.buffer: refers to 2"},
        {"buffer", 1, ErrorCode::corrupt, "has neither a uri nor a GLB chunk"},
        {"mode", "MAGIC", ErrorCode::unsupported, "mode: 'MAGIC' is not read"},
        {"mode", "TRIANGLES", ErrorCode::corrupt, "byteStride 12 does not suit the mode"},
        {"filter", "MAGIC", ErrorCode::unsupported, "filter: 'MAGIC' is not read"},
        {"filter", "QUATERNION", ErrorCode::corrupt, "byteStride 12 does not suit the filter"},
        {"filter", "OCTAHEDRAL", ErrorCode::corrupt, "byteStride 12 does not suit the filter"},
    };
    for (const Case& c : cases) {
        GltfBuilder b = with_meshopt(Grid(20));
        b.json[Json::json_pointer(at + c.key)] = c.value;
        Status status = import(b).status();
        EXPECT_EQ(status.code(), c.code) << c.key << c.value << status.message();
        EXPECT_NE(status.message().find(c.part), std::string::npos) << status.message();
    }
}

TEST(Meshopt, IndicesBeyondTheVerticesAreFoundAfterDecoding) {
    Grid grid(4);
    grid.indices[17] = 25;
    EXPECT_NE(import(with_meshopt(grid)).status().message().find("accessors[1]: element"), std::string::npos);
}

std::string draco_stream(const Grid& grid, int method, bool metadata = false) {
    draco::Mesh mesh;
    mesh.SetNumFaces(grid.indices.size() / 3);
    for (std::uint32_t f = 0; f < grid.indices.size() / 3; ++f)
        mesh.SetFace(draco::FaceIndex(f), {draco::PointIndex(grid.indices[3 * f]), draco::PointIndex(grid.indices[3 * f + 1]),
                                           draco::PointIndex(grid.indices[3 * f + 2])});
    mesh.set_num_points(std::uint32_t(grid.vertices()));
    draco::GeometryAttribute attribute;
    attribute.Init(draco::GeometryAttribute::POSITION, nullptr, 3, draco::DT_FLOAT32, false, 12, 0);
    int id = mesh.AddAttribute(attribute, true, std::uint32_t(grid.vertices()));
    for (std::uint32_t v = 0; v < grid.vertices(); ++v)
        mesh.attribute(id)->SetAttributeValue(draco::AttributeValueIndex(v), &grid.positions[3 * v]);
    if (metadata) {
        auto note = std::make_unique<draco::GeometryMetadata>();
        note->AddEntryString("who", "me");
        mesh.AddMetadata(std::move(note));
    }
    draco::Encoder encoder;
    encoder.SetEncodingMethod(method);
    draco::EncoderBuffer buffer;
    EXPECT_TRUE(encoder.EncodeMeshToBuffer(mesh, &buffer).ok());
    return std::string(buffer.data(), buffer.size());
}

GltfBuilder with_draco(const Grid& grid, const std::string& stream) {
    GltfBuilder b;
    b.json["extensionsRequired"] = {"KHR_draco_mesh_compression"};
    int view = b.add_view(std::vector<char>(stream.begin(), stream.end()));
    b.add("accessors", {{"componentType", 5126}, {"type", "VEC3"}, {"count", grid.vertices()}});
    b.add("accessors", {{"componentType", 5125}, {"type", "SCALAR"}, {"count", grid.indices.size()}});
    b.add("nodes", {{"mesh", b.add_mesh(0, 1)}});
    b.json["meshes"][0]["primitives"][0]["extensions"]["KHR_draco_mesh_compression"] = {
        {"bufferView", view}, {"attributes", {{"POSITION", 0}}}};
    return b;
}

TEST(Draco, GivesTheSameTriangles) {
    Grid grid(20);
    auto wanted = triangles_of(*import(plain(grid)));
    for (int method : {draco::MESH_SEQUENTIAL_ENCODING, draco::MESH_EDGEBREAKER_ENCODING}) {
        Result<RawScene> raw = import(with_draco(grid, draco_stream(grid, method)));
        ASSERT_TRUE(raw.ok()) << raw.status().message();
        EXPECT_EQ(triangles_of(*raw), wanted);
    }
}

TEST(Draco, PlainAccessorsArePreferred) {
    Grid grid(4);
    GltfBuilder b = plain(grid);
    b.json["meshes"][0]["primitives"][0]["extensions"]["KHR_draco_mesh_compression"] = {
        {"bufferView", 0}, {"attributes", {{"POSITION", 0}}}};
    EXPECT_EQ(import(b)->triangles.size(), 32u);
}

TEST(Draco, WhatTheFileSaysMustAgree) {
    Grid grid(20);
    const std::string stream = draco_stream(grid, draco::MESH_EDGEBREAKER_ENCODING);
    auto message = [&](std::function<void(GltfBuilder&)> edit, std::string bytes) {
        GltfBuilder b = with_draco(grid, bytes);
        edit(b);
        Result<RawScene> raw = import(b);
        return raw.ok() ? std::string("ok") : raw.status().message();
    };
    auto contains = [](const std::string& text, const char* part) { return text.find(part) != std::string::npos; };
    auto nothing = [](GltfBuilder&) {};
    EXPECT_EQ(message(nothing, stream), "ok");
    EXPECT_TRUE(contains(message([](GltfBuilder& b) { b.json["accessors"][1]["count"] = 2397; }, stream),
                         "primitives[0].KHR_draco_mesh_compression: the stream has 800 triangles, but the file says 799"));
    EXPECT_TRUE(contains(message([](GltfBuilder& b) { b.json["accessors"][0]["count"] = 100; }, stream),
                         "the stream has 441 vertices, but the file says 100"));
    EXPECT_TRUE(contains(message([](GltfBuilder& b) { b.json["accessors"][0]["componentType"] = 5122; }, stream),
                         "type is not that of the accessor"));
    EXPECT_TRUE(contains(message([](GltfBuilder& b) {
        b.json["meshes"][0]["primitives"][0]["extensions"]["KHR_draco_mesh_compression"]["attributes"]["POSITION"] = 7;
    }, stream), "no attribute has the id 7"));
    EXPECT_TRUE(contains(message([](GltfBuilder& b) { b.json["meshes"][0]["primitives"][0]["mode"] = 5; }, stream),
                         "triangle lists only"));
    EXPECT_TRUE(contains(message(nothing, "DRACX" + stream.substr(5)), "not a Draco stream"));
    EXPECT_TRUE(contains(message(nothing, "DRACO" + std::string("\1") + stream.substr(6)), "version 1.2 is not read"));
    EXPECT_TRUE(contains(message(nothing, draco_stream(grid, draco::MESH_SEQUENTIAL_ENCODING, true)), "metadata"));
    EXPECT_TRUE(contains(message(nothing, stream.substr(0, stream.size() / 2)), "libdraco"));
}

/// Every byte of a stream damaged in turn: an error or another scene, never more.
void damage(const GltfBuilder& good, std::size_t begin, std::size_t end) {
    for (std::size_t at = begin; at < end; ++at)
        for (int mask : {0x01, 0x40, 0xFF}) {
            GltfBuilder b = good;
            b.binary[at] = static_cast<char>(b.binary[at] ^ mask);
            Result<RawScene> raw = import(b);
            if (raw.ok())
                (void)Scene::create(std::move(*raw));
        }
}

TEST(Compression, DamagedStreamsEndWell) {
    Grid grid(6);
    GltfBuilder meshopt = with_meshopt(grid);
    damage(meshopt, 0, meshopt.binary.size());
    for (int method : {draco::MESH_SEQUENTIAL_ENCODING, draco::MESH_EDGEBREAKER_ENCODING}) {
        GltfBuilder draco = with_draco(grid, draco_stream(grid, method));
        damage(draco, 0, draco.binary.size());
    }
}

} // namespace
} // namespace antumbra
