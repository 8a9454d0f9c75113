#include <antumbra/import.hpp>

#include "import/gltf_builder.hpp"

#include <gtest/gtest.h>

#include <cstring>
#include <limits>

namespace antumbra {
namespace {

using test::bytes_of;

Result<RawScene> import(const std::string& text, const std::string& ending, const ImportOptions& options = {}) {
    return import_with_assimp(bytes_of(text), ending, "t." + ending, options);
}

/// Tests of what assimp reads are void where the library was built without it.
class AssimpFormats : public ::testing::Test {
  protected:
    void SetUp() override {
        if (import("x", "stl").status().message().find("this build lacks") != std::string::npos)
            GTEST_SKIP() << "built without assimp (ANTUMBRA_WITH_ASSIMP)";
    }
};

const std::string kPly = "ply\nformat ascii 1.0\nelement vertex 4\nproperty float x\nproperty float y\n"
                         "property float z\nelement face 1\nproperty list uchar int vertex_indices\nend_header\n"
                         "0 0 0\n2 0 0\n2 2 0\n0 2 1\n4 0 1 2 3\n";

double area(const RawScene& raw) {
    double sum = 0;
    for (const TriangleIndices& t : raw.triangles)
        sum += length(cross(raw.positions[t[1]] - raw.positions[t[0]], raw.positions[t[2]] - raw.positions[t[0]])) / 2;
    return sum;
}

TEST_F(AssimpFormats, Ply) {
    Result<RawScene> raw = import(kPly, "ply");
    ASSERT_TRUE(raw.ok()) << raw.status().message();
    ASSERT_EQ(raw->objects.size(), 1u);
    EXPECT_EQ(raw->objects[0].flags, kOccludes | kDoubleSided);
    EXPECT_EQ(raw->triangles.size(), 2u);
    EXPECT_EQ(raw->positions[raw->triangles[0][0]], (Vec3d{0, 0, 0}));
    EXPECT_TRUE(Scene::create(std::move(*raw)).ok());
}

TEST_F(AssimpFormats, UpAxisZ) {
    ImportOptions options;
    options.up_axis = UpAxis::z;
    Result<RawScene> raw = import(kPly, "ply", options);
    ASSERT_TRUE(raw.ok());
    EXPECT_EQ(raw->positions[3], (Vec3d{0, 1, -2}));
}

TEST_F(AssimpFormats, StlAsTextAndBinary) {
    Result<RawScene> text = import("solid s\nfacet normal 0 0 1\nouter loop\nvertex 0 0 0\nvertex 3 0 0\nvertex 0 4 0\n"
                                   "endloop\nendfacet\nendsolid s\n", "stl");
    ASSERT_TRUE(text.ok()) << text.status().message();
    EXPECT_EQ(text->triangles.size(), 1u);
    EXPECT_EQ(area(*text), 6);

    std::string binary(80, ' ');
    std::uint32_t count = 1;
    float facet[12] = {0, 0, 1, 0, 0, 0, 3, 0, 0, 0, 4, 0};
    binary.append(reinterpret_cast<const char*>(&count), 4);
    binary.append(reinterpret_cast<const char*>(facet), 48);
    binary.append(2, '\0');
    Result<RawScene> raw = import(binary, "stl");
    ASSERT_TRUE(raw.ok()) << raw.status().message();
    EXPECT_EQ(area(*raw), 6);
}

TEST_F(AssimpFormats, Off) {
    Result<RawScene> raw = import("OFF\n4 1 0\n0 0 0\n2 0 0\n2 2 0\n0 2 0\n4 0 1 2 3\n", "off");
    ASSERT_TRUE(raw.ok()) << raw.status().message();
    EXPECT_EQ(area(*raw), 4);
}

TEST_F(AssimpFormats, WhatIsNotRead) {
    struct Case {
        std::string text;
        const char* ending;
        ErrorCode code;
    };
    const Case cases[] = {
        {"", "ply", ErrorCode::corrupt},
        {"nonsense", "ply", ErrorCode::corrupt},
        {"nonsense", "fbx", ErrorCode::corrupt},
        {"nonsense", "dae", ErrorCode::corrupt},
        {kPly, "obj", ErrorCode::unsupported},
        {kPly, "blend", ErrorCode::unsupported},
        // The ending chooses the reader: no other may take the file.
        {kPly, "stl", ErrorCode::corrupt},
    };
    for (const Case& c : cases) {
        Result<RawScene> raw = import(c.text, c.ending);
        ASSERT_FALSE(raw.ok()) << c.ending;
        EXPECT_EQ(raw.status().code(), c.code) << raw.status().message();
        EXPECT_EQ(raw.status().message().rfind(std::string("t.") + c.ending + ": ", 0), 0u) << raw.status().message();
    }
}

TEST_F(AssimpFormats, NumbersThatAreNotFinite) {
    std::string bad = kPly;
    bad.replace(bad.find("2 2 0"), 5, "2 nan 0");
    EXPECT_FALSE(import(bad, "ply").ok());
}

TEST_F(AssimpFormats, Limits) {
    ImportOptions options;
    options.limits.triangles = 1;
    EXPECT_EQ(import(kPly, "ply", options).status().code(), ErrorCode::limit);
    options = {};
    options.limits.bytes = 20;
    EXPECT_EQ(import(kPly, "ply", options).status().code(), ErrorCode::limit);
    options = {};
    options.limits.memory = 50;
    EXPECT_EQ(import(kPly, "ply", options).status().code(), ErrorCode::limit);
}

} // namespace
} // namespace antumbra
