#include <antumbra/import.hpp>

#include "import/gltf_builder.hpp"

#include <gtest/gtest.h>

#include <algorithm>

namespace antumbra {
namespace {

using test::bytes_of;

template <class T>
std::string raw_bytes(std::initializer_list<T> values, bool reversed = false) {
    std::string text;
    for (T value : values) {
        std::string one(reinterpret_cast<const char*>(&value), sizeof value);
        if (reversed)
            std::reverse(one.begin(), one.end());
        text += one;
    }
    return text;
}

Result<RawScene> ply(const std::string& text, const ImportOptions& options = {}) {
    return import_ply(bytes_of(text), "t.ply", options);
}
Result<RawScene> stl(const std::string& text, const ImportOptions& options = {}) {
    return import_stl(bytes_of(text), "t.stl", options);
}

std::string header(const std::string& format, const std::string& vertices, const std::string& faces) {
    return "ply\nformat " + format + " 1.0\ncomment made by hand\nelement vertex " + vertices +
           "\nproperty float x\nproperty double y\nproperty int z\nproperty list uchar uchar extra\nelement face " +
           faces + "\nproperty uchar red\nproperty list uchar int vertex_indices\nend_header\n";
}

const std::string kText = header("ascii", "4", "1") + "0 0 0 0\n2 0.5 0 1 9\r\n2 2 0 0\n-1e1 2 7 0\n255 4 0 1 2 3\n";
using Triangles = std::vector<TriangleIndices>;

TEST(Ply, Text) {
    Result<RawScene> raw = ply(kText);
    ASSERT_TRUE(raw.ok()) << raw.status().message();
    EXPECT_EQ(raw->positions, (std::vector<Vec3d>{{0, 0, 0}, {2, 0.5, 0}, {2, 2, 0}, {-10, 2, 7}}));
    EXPECT_EQ(raw->triangles, (Triangles{{0, 1, 2}, {0, 2, 3}}));
    ASSERT_EQ(raw->objects.size(), 1u);
    EXPECT_EQ(raw->objects[0].flags, kOccludes | kDoubleSided);
    EXPECT_EQ(raw->objects[0].triangle_count, 2u);
}

TEST(Ply, BinaryOfBothByteOrders) {
    for (bool big : {false, true}) {
        std::string file = header(big ? "binary_big_endian" : "binary_little_endian", "3", "1");
        for (int v = 0; v < 3; ++v)
            file += raw_bytes<float>({float(v)}, big) + raw_bytes<double>({v * v + 0.25}, big) +
                    raw_bytes<std::int32_t>({-v * 70000}, big) + std::string("\2ab");
        file += std::string("\377\3") + raw_bytes<std::int32_t>({2, 1, 0}, big);
        Result<RawScene> raw = ply(file);
        ASSERT_TRUE(raw.ok()) << raw.status().message();
        EXPECT_EQ(raw->positions[2], (Vec3d{2, 4.25, -140000}));
        EXPECT_EQ(raw->triangles, (Triangles{{2, 1, 0}}));
    }
}

TEST(Ply, UpAxisZ) {
    ImportOptions options;
    options.up_axis = UpAxis::z;
    EXPECT_EQ(ply(kText, options)->positions[3], (Vec3d{-10, 7, -2}));
}

TEST(Ply, BadInputIsNamed) {
    struct Case {
        std::string text;
        const char* message;
    };
    auto with = [](const char* from, const char* to) {
        std::string text = kText;
        return text.replace(text.find(from), std::string(from).size(), to);
    };
    const Case cases[] = {
        {"", "t.ply: the file is empty"},
        {"plx\n", "t.ply: is not a PLY file: it does not begin with 'ply'"},
        {"ply\nformat ascii 1.0\n", "t.ply: the header does not end; copy the file anew"},
        {"ply\nend_header\n", "t.ply: the header names no format"},
        {with("ascii", "zip"), "t.ply: line 2: format 'zip' is not read"},
        {with("vertex 4", "vertex -4"), "t.ply: line 4: 'element' wants a name and a number"},
        {with("vertex 4", "vertex 4000000000"), "t.ply: line 4: 4000000000 elements do not fit into the file"},
        {with("property float x", "property float w"), "t.ply: vertices without exactly one x, y and z"},
        {with("property float x", "property quad x"), "t.ply: line 5: this property makes no sense"},
        {with("2 2 0", "2 nan 0"), "t.ply: vertex[2]: is not finite; repair the mesh"},
        {with("2 2 0", "2 two 0"), "t.ply: vertex[2]: is cut off or no number"},
        {with("4 0 1 2 3", "4 0 1 2 4"), "t.ply: face[0]: names a vertex that does not exist (faces come after vertices)"},
        {with("4 0 1 2 3", "4 0 1 -2 3"), "t.ply: face[0]: names a vertex that does not exist (faces come after vertices)"},
        {with("4 0 1 2 3", "4 0 1 .5 3"), "t.ply: face[0]: names a vertex that does not exist (faces come after vertices)"},
        {with("4 0 1 2 3", "99 0 1 2 3"), "t.ply: face[0]: is cut off or no number"},
        {with("4 0 1 2 3", "4 0 1 2"), "t.ply: face[0]: is cut off or no number"},
    };
    for (const Case& c : cases) {
        Result<RawScene> raw = ply(c.text);
        ASSERT_FALSE(raw.ok()) << c.message;
        EXPECT_EQ(raw.status().message(), c.message);
    }
}

TEST(Ply, LimitsAndTruncations) {
    auto code = [](auto edit) {
        ImportOptions options;
        edit(options.limits);
        return ply(kText, options).status().code();
    };
    EXPECT_EQ(code([](ImportLimits& l) { l.vertices = 3; }), ErrorCode::limit);
    EXPECT_EQ(code([](ImportLimits& l) { l.triangles = 1; }), ErrorCode::limit);
    EXPECT_EQ(code([](ImportLimits& l) { l.memory = 100; }), ErrorCode::limit);
    EXPECT_EQ(code([](ImportLimits& l) { l.bytes = 100; }), ErrorCode::limit);
    EXPECT_EQ(code([](ImportLimits& l) { l.vertices = 4, l.triangles = 2; }), ErrorCode::ok);
    for (std::size_t size = 0; size + 2 < kText.size(); ++size)
        EXPECT_FALSE(ply(kText.substr(0, size)).ok()) << size;
    for (std::size_t at = 0; at < kText.size(); ++at)
        for (int mask : {0x01, 0x04, 0x10, 0x80}) {
            std::string flipped = kText;
            flipped[at] = static_cast<char>(flipped[at] ^ mask);
            Result<RawScene> raw = ply(flipped);
            if (raw.ok())
                (void)Scene::create(std::move(*raw));
        }
}

const std::string kFacet = "facet normal 0 0 1\n outer loop\n  vertex 0 0 0\n  vertex +3e0 0 0\n  vertex 0 4 0.5\n"
                           " endloop\nendfacet\n";

TEST(Stl, TextWithSeveralSolids) {
    Result<RawScene> raw = stl("solid first part\n" + kFacet + kFacet + "endsolid\nsolid\n" + kFacet + "endsolid\n");
    ASSERT_TRUE(raw.ok()) << raw.status().message();
    ASSERT_EQ(raw->objects.size(), 2u);
    EXPECT_EQ(raw->objects[0].name, "first part");
    EXPECT_EQ(raw->objects[0].triangle_count, 2u);
    EXPECT_EQ(raw->objects[1].name, "solid");
    EXPECT_EQ(raw->objects[1].first_triangle, 2u);
    EXPECT_EQ(raw->objects[1].flags, kOccludes | kDoubleSided);
    EXPECT_EQ(raw->triangles[2], (TriangleIndices{6, 7, 8}));
    EXPECT_EQ(raw->positions[8], (Vec3d{0, 4, 0.5}));
    EXPECT_TRUE(Scene::create(std::move(*raw)).ok());
}

std::string binary_stl(std::uint32_t count, const std::string& title = "") {
    std::string file = title;
    file.resize(80, ' ');
    file += raw_bytes<std::uint32_t>({count});
    for (std::uint32_t f = 0; f < count; ++f)
        file += raw_bytes<float>({0, 0, 1, 0, 0, float(f), 3, 0, float(f), 0, 4, float(f)}) + std::string("\0\0", 2);
    return file;
}

TEST(Stl, Binary) {
    // Some programs begin binary files with "solid".
    for (const char* title : {"", "solid lie"}) {
        Result<RawScene> raw = stl(binary_stl(3, title));
        ASSERT_TRUE(raw.ok()) << raw.status().message();
        EXPECT_EQ(raw->triangles.size(), 3u);
        EXPECT_EQ(raw->positions[8], (Vec3d{0, 4, 2}));
    }
}

TEST(Stl, BadInputIsNamed) {
    std::string not_finite = binary_stl(1);
    not_finite.replace(84 + 12, 4, std::string("\0\0\300\177", 4));
    struct Case {
        std::string text;
        const char* message;
    };
    const Case cases[] = {
        {"", "t.stl: the file is empty"},
        {"nonsense", "t.stl: is neither a text STL (solid ..) nor as long as a binary one of 0 facets must be"},
        {binary_stl(2).substr(0, 150), "t.stl: is neither a text STL (solid ..) nor as long as a binary one of 2 facets must be"},
        {not_finite, "t.stl: facet 0: is not finite; repair the mesh"},
        {"solid\nvertex 1 2\n", "t.stl: line 2: 'vertex' wants three finite numbers; repair the line"},
        {"solid\nvertex 1 2 inf\n", "t.stl: line 2: 'vertex' wants three finite numbers; repair the line"},
        {"solid\nfacet\nendfacet\n", "t.stl: line 3: a facet without three corners"},
        {"solid\nvertex 0 0 0\nvertex 0 0 0\nvertex 0 0 0\nvertex 0 0 0\n", "t.stl: line 5: a facet of more than three corners"},
        {"solid\nvertex 0 0 0\n", "t.stl: the file ends within a facet; copy it anew"},
    };
    for (const Case& c : cases) {
        Result<RawScene> raw = stl(c.text);
        ASSERT_FALSE(raw.ok()) << c.message;
        EXPECT_EQ(raw.status().message(), c.message);
    }
}

TEST(Stl, LimitsAndTruncations) {
    for (const std::string& file : {binary_stl(3), "solid\n" + kFacet + kFacet + kFacet}) {
        auto code = [&](auto edit) {
            ImportOptions options;
            edit(options.limits);
            return stl(file, options).status().code();
        };
        EXPECT_EQ(code([](ImportLimits& l) { l.vertices = 8; }), ErrorCode::limit);
        EXPECT_EQ(code([](ImportLimits& l) { l.triangles = 2; }), ErrorCode::limit);
        EXPECT_EQ(code([](ImportLimits& l) { l.memory = 200; }), ErrorCode::limit);
        EXPECT_EQ(code([](ImportLimits& l) { l.bytes = 100; }), ErrorCode::limit);
        EXPECT_EQ(code([](ImportLimits& l) { l.vertices = 9, l.triangles = 3; }), ErrorCode::ok);
        for (std::size_t at = 0; at < file.size(); ++at) {
            std::string flipped = file;
            flipped[at] = static_cast<char>(flipped[at] ^ 0x11);
            for (Result<RawScene>& raw : std::array{stl(flipped), stl(file.substr(0, at))})
                if (raw.ok())
                    (void)Scene::create(std::move(*raw));
        }
    }
}

} // namespace
} // namespace antumbra
