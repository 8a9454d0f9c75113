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
        if (import("x", "off").status().message().find("this build lacks") != std::string::npos)
            GTEST_SKIP() << "built without assimp (ANTUMBRA_WITH_ASSIMP)";
    }
};

const std::string kOff = "OFF\n4 1 0\n0 0 0\n2 0 0\n2 2 0\n0 2 1\n4 0 1 2 3\n";

double area(const RawScene& raw) {
    double sum = 0;
    for (const TriangleIndices& t : raw.triangles)
        sum += length(cross(raw.positions[t[1]] - raw.positions[t[0]], raw.positions[t[2]] - raw.positions[t[0]])) / 2;
    return sum;
}

TEST_F(AssimpFormats, Off) {
    Result<RawScene> raw = import(kOff, "off");
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
    Result<RawScene> raw = import(kOff, "off", options);
    ASSERT_TRUE(raw.ok());
    EXPECT_EQ(raw->positions[3], (Vec3d{0, 1, -2}));
}

TEST_F(AssimpFormats, Collada) {
    // Units and axes are those of the file; assimp turns Z_UP itself.
    Result<RawScene> raw = import(
        "<?xml version=\"1.0\"?><COLLADA version=\"1.4.1\"><library_geometries><geometry id=\"g\"><mesh>"
        "<source id=\"p\"><float_array id=\"a\" count=\"9\">0 0 0 3 0 0 0 4 0</float_array><technique_common>"
        "<accessor source=\"#a\" count=\"3\" stride=\"3\"><param name=\"X\" type=\"float\"/>"
        "<param name=\"Y\" type=\"float\"/><param name=\"Z\" type=\"float\"/></accessor></technique_common></source>"
        "<vertices id=\"v\"><input semantic=\"POSITION\" source=\"#p\"/></vertices><triangles count=\"1\">"
        "<input semantic=\"VERTEX\" source=\"#v\" offset=\"0\"/><p>0 1 2</p></triangles></mesh></geometry>"
        "</library_geometries><library_visual_scenes><visual_scene id=\"s\"><node id=\"n\">"
        "<translate>10 0 0</translate><instance_geometry url=\"#g\"/></node></visual_scene></library_visual_scenes>"
        "<scene><instance_visual_scene url=\"#s\"/></scene></COLLADA>", "dae");
    ASSERT_TRUE(raw.ok()) << raw.status().message();
    ASSERT_EQ(raw->objects.size(), 1u);
    EXPECT_EQ(raw->objects[0].name, "n");
    EXPECT_EQ(area(*raw), 6);
    EXPECT_EQ(raw->positions[raw->triangles[0][0]].x, 10);
}

TEST_F(AssimpFormats, WhatIsNotRead) {
    struct Case {
        std::string text;
        const char* ending;
        ErrorCode code;
    };
    const Case cases[] = {
        {"", "off", ErrorCode::corrupt},
        {"nonsense", "off", ErrorCode::corrupt},
        {"nonsense", "fbx", ErrorCode::corrupt},
        {"nonsense", "dae", ErrorCode::corrupt},
        {kOff, "obj", ErrorCode::unsupported},
        {kOff, "blend", ErrorCode::unsupported},
        // The ending chooses the reader: no other may take the file.
        {kOff, "3ds", ErrorCode::corrupt},
    };
    for (const Case& c : cases) {
        Result<RawScene> raw = import(c.text, c.ending);
        ASSERT_FALSE(raw.ok()) << c.ending;
        EXPECT_EQ(raw.status().code(), c.code) << raw.status().message();
        EXPECT_EQ(raw.status().message().rfind(std::string("t.") + c.ending + ": ", 0), 0u) << raw.status().message();
    }
}

TEST_F(AssimpFormats, NumbersThatAreNotFinite) {
    std::string bad = kOff;
    bad.replace(bad.find("2 2 0"), 5, "2 nan 0");
    EXPECT_FALSE(import(bad, "off").ok());
}

TEST_F(AssimpFormats, Limits) {
    ImportOptions options;
    options.limits.triangles = 1;
    EXPECT_EQ(import(kOff, "off", options).status().code(), ErrorCode::limit);
    options = {};
    options.limits.bytes = 20;
    EXPECT_EQ(import(kOff, "off", options).status().code(), ErrorCode::limit);
    options = {};
    options.limits.memory = 50;
    EXPECT_EQ(import(kOff, "off", options).status().code(), ErrorCode::limit);
}

} // namespace
} // namespace antumbra
