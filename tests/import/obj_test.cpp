#include <antumbra/import.hpp>

#include "import/gltf_builder.hpp"

#include <gtest/gtest.h>
#include <unistd.h>

#include <chrono>
#include <filesystem>
#include <fstream>

namespace antumbra {
namespace {

using test::bytes_of;
namespace fs = std::filesystem;

Result<RawScene> import(const std::string& text, const ImportOptions& options = {}, const std::string& folder = "") {
    return import_obj(bytes_of(text), "t.obj", folder, options);
}

RawScene read(const std::string& text, const std::string& folder = "") {
    Result<RawScene> raw = import(text, {}, folder);
    EXPECT_TRUE(raw.ok()) << raw.status().message();
    return raw.ok() ? *raw : RawScene();
}

std::uint64_t found(const RawScene& raw, const std::string& kind) {
    for (const Finding& finding : raw.findings)
        if (finding.kind == kind)
            return finding.count;
    return 0;
}

const std::string kPoints = "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 1 1 0\n";
using Triangles = std::vector<TriangleIndices>;

TEST(Obj, OneObjectWithoutGroups) {
    RawScene raw = read(kPoints + "f 1 2 3\nf 2 4 3\n");
    EXPECT_EQ(raw.triangles, (Triangles{{0, 1, 2}, {1, 3, 2}}));
    ASSERT_EQ(raw.objects.size(), 1u);
    EXPECT_EQ(raw.objects[0].name, "default");
    EXPECT_EQ(raw.objects[0].id, ObjectId());
    EXPECT_EQ(raw.objects[0].flags, kOccludes | kDoubleSided);
}

TEST(Obj, CoordinatesAreDoubles) {
    RawScene raw = read("v 78613.525 +4.583 -457985.735 1.0\nv 1e-3 2E2 .5\nv 0 0 0\nf 1 2 3");
    EXPECT_EQ(raw.positions[0], (Vec3d{78613.525, 4.583, -457985.735}));
    EXPECT_EQ(raw.positions[1], (Vec3d{0.001, 200, 0.5}));
}

TEST(Obj, EveryFormOfCorner) {
    EXPECT_EQ(read(kPoints + "vt 0 0\nvn 0 0 1\nf 1/1 2/1/1 3//1\n").triangles, (Triangles{{0, 1, 2}}));
    EXPECT_EQ(read(kPoints + "f -4 -3 -2\nv 9 9 9\nf -1 -2 -3\n").triangles, (Triangles{{0, 1, 2}, {4, 3, 2}}));
    EXPECT_EQ(read(kPoints + "f -4/1 -3/-1/2 -2//-7\n").triangles, (Triangles{{0, 1, 2}}));
    // Vertices that come later may be named.
    EXPECT_EQ(read("f 1 2 3\n" + kPoints).triangles, (Triangles{{0, 1, 2}}));
}

TEST(Obj, LineEndsBlanksCommentsAndContinuations) {
    EXPECT_EQ(read("# c\r\n\r\nv 0 0 0\r\n  v\t1 0 0 \r\nv 0 \\\r\n1 0\r\nf 1 2 \\\n 3").triangles,
              (Triangles{{0, 1, 2}}));
    EXPECT_EQ(read(kPoints + "f 1 2 3\\").triangles.size(), 1u) << "a last backslash joins nothing";
    EXPECT_EQ(read(" # C:\\dir\\\n" + kPoints + "f 1 2 3").positions.size(), 4u) << "comments do not go on";
}

TEST(Obj, GroupsAreObjectsAndGoOn) {
    RawScene raw = read(kPoints + "g a\nf 1 2 3\ng b\nusemtl x\nf 2 3 4\nusemtl y\nf 1 2 4\ng a\nf 1 3 4\n");
    ASSERT_EQ(raw.objects.size(), 2u);
    EXPECT_EQ(raw.objects[0].name, "a");
    EXPECT_EQ(raw.objects[0].triangle_count, 2u);
    EXPECT_EQ(raw.objects[1].first_triangle, 2u);
    EXPECT_EQ(raw.triangles, (Triangles{{0, 1, 2}, {0, 2, 3}, {1, 2, 3}, {0, 1, 3}}));
}

TEST(Obj, NamesOfObjectsAndGroups) {
    RawScene raw = read(kPoints + "f 1 2 3\no house\nf 1 2 3\ng wall east \nf 1 2 3\no shed\nf 1 2 3\ng\nf 2 3 4\n"
                                  "o empty\n");
    std::vector<std::string> names;
    for (const RawObject& object : raw.objects)
        names.push_back(object.name);
    EXPECT_EQ(names, (std::vector<std::string>{"default", "house", "house/wall east", "shed"}));
}

double area_z(const RawScene& raw) {
    double sum = 0;
    for (const TriangleIndices& t : raw.triangles) {
        Vec3d n = cross(raw.positions[t[1]] - raw.positions[t[0]], raw.positions[t[2]] - raw.positions[t[0]]);
        EXPECT_GE(n.z, 0) << "a triangle lies the wrong way round";
        sum += n.z / 2;
    }
    return sum;
}

TEST(Obj, ConvexPolygonsAreFans) {
    EXPECT_EQ(read(kPoints + "f 1 2 4 3\n").triangles, (Triangles{{0, 1, 3}, {0, 3, 2}}));
}

TEST(Obj, ConcavePolygonsKeepTheirShape) {
    // An L of area 3, and an arrow head whose fan from corner 1 would cover what lies outside.
    EXPECT_EQ(area_z(read("v 0 0 0\nv 2 0 0\nv 2 1 0\nv 1 1 0\nv 1 2 0\nv 0 2 0\nf 1 2 3 4 5 6\n")), 3);
    EXPECT_EQ(area_z(read("v 2 0 0\nv 0 1 0\nv -2 0 0\nv 0 3 0\nf 1 4 3 2\n")), 4);
    // The same far from the origin, and standing upright in other planes.
    EXPECT_EQ(area_z(read("v 4e5 0 0\nv 400002 0 0\nv 400002 1 0\nv 400001 1 0\nv 400001 2 0\nv 4e5 2 0\n"
                          "f 1 2 3 4 5 6\n")), 3);
}

TEST(Obj, CrossingAndCollapsedPolygonsStillGiveAllTriangles) {
    EXPECT_EQ(read("v 0 0 0\nv 1 1 0\nv 1 0 0\nv 0 1 0\nv 3 3 0\nf 1 2 3 4 5\n").triangles.size(), 3u);
    EXPECT_EQ(read("v 0 0 0\nf 1 1 1 1 1 1\n").triangles.size(), 4u);
    EXPECT_EQ(read("v 0 0 0\nv 1 0 0\nv 2 0 0\nv 3 0 0\nf 1 3 2 4\n").triangles.size(), 2u);
}

TEST(Obj, FacesOfTwoCornersAndLinesAreLeftOut) {
    RawScene raw = read(kPoints + "f 1 2\nf\nl 1 2\np 1\nf 1 2 3\n");
    EXPECT_EQ(raw.triangles.size(), 1u);
    EXPECT_EQ(found(raw, "face with fewer than three corners left out"), 2u);
    EXPECT_EQ(found(raw, "points or lines left out"), 2u);
}

TEST(Obj, UpAxisZ) {
    ImportOptions options;
    options.up_axis = UpAxis::z;
    EXPECT_EQ(import("v 1 2 3\nf 1 1 1", options)->positions[0], (Vec3d{1, 3, -2}));
}

TEST(Obj, BadInputIsNamed) {
    struct Case {
        std::string text;
        const char* message;
    };
    const Case cases[] = {
        {"", "t.obj: the file is empty"},
        {"v 1 2\n", "t.obj: line 1: 'v' wants three finite numbers, not ''; repair the line"},
        {"v 1 2 x\n", "t.obj: line 1: 'v' wants three finite numbers, not 'x'; repair the line"},
        {"v 1 2 nan\n", "t.obj: line 1: 'v' wants three finite numbers, not 'nan'; repair the line"},
        {"v 1 2 inf\n", "t.obj: line 1: 'v' wants three finite numbers, not 'inf'; repair the line"},
        {"v 1 2 1e999\n", "t.obj: line 1: 'v' wants three finite numbers, not '1e999'; repair the line"},
        {"v 1 2 3,\n", "t.obj: line 1: 'v' wants three finite numbers, not '3,'; repair the line"},
        {kPoints + "\nf 1 2 5\n", "t.obj: line 6: vertex '5' does not exist; the file has 4"},
        {kPoints + "f 1 2 0\n", "t.obj: line 5: vertex '0' does not exist; the file has 4"},
        {kPoints + "f 1 2 -5\n", "t.obj: line 5: vertex '-5' does not exist; the file has 4"},
        {kPoints + "f 1 2 99999999999999999999\n", "t.obj: line 5: '99999999999999999999' is no vertex of a face; repair the line"},
        {kPoints + "f 1 2 3x\n", "t.obj: line 5: '3x' is no vertex of a face; repair the line"},
        {"f f", "t.obj: line 1: 'f' is no vertex of a face; repair the line"},
    };
    for (const Case& c : cases) {
        Result<RawScene> raw = import(c.text);
        ASSERT_FALSE(raw.ok()) << c.text;
        EXPECT_EQ(raw.status().code(), ErrorCode::corrupt);
        EXPECT_EQ(raw.status().message(), c.message);
    }
}

TEST(Obj, Limits) {
    auto code = [](auto edit) {
        ImportOptions options;
        edit(options.limits);
        return import(kPoints + "g a\nf 1 2 3\ng b\nf 1 2 3 4\n", options).status().code();
    };
    EXPECT_EQ(code([](ImportLimits& l) { l.vertices = 3; }), ErrorCode::limit);
    EXPECT_EQ(code([](ImportLimits& l) { l.triangles = 2; }), ErrorCode::limit);
    EXPECT_EQ(code([](ImportLimits& l) { l.objects = 1; }), ErrorCode::limit);
    EXPECT_EQ(code([](ImportLimits& l) { l.bytes = 10; }), ErrorCode::limit);
    EXPECT_EQ(code([](ImportLimits& l) { l.memory = 100; }), ErrorCode::limit);
    EXPECT_EQ(code([](ImportLimits& l) { l = {1000, 4, 3, 2, 1000, 1}; }), ErrorCode::ok);
}

TEST(Obj, TimeGrowsLinearly) {
    auto seconds = [](const std::string& text) {
        auto start = std::chrono::steady_clock::now();
        (void)import(text);
        return std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
    };
    std::string polygon = kPoints + "f";
    for (int i = 0; i < 500'000; ++i)
        polygon += " 1 4 2 3";
    std::string polygons = kPoints;
    for (int i = 0; i < 100; ++i) {
        polygons += "f";
        for (int c = 0; c < 1020; ++c)
            polygons += std::string(" ") + "1423"[c % 4];
        polygons += "\n";
    }
    std::string joined;
    for (int i = 0; i < 500'000; ++i)
        joined += "\\\n";
    EXPECT_LT(seconds(polygon), 2);
    EXPECT_LT(seconds(polygons), 2);
    EXPECT_LT(seconds(joined), 2);
}

class ObjFolder : public ::testing::Test {
  protected:
    ObjFolder() {
        root_ = fs::temp_directory_path() / ("antumbra-obj-" + std::to_string(::getpid()));
        fs::create_directories(root_ / "scene");
        std::ofstream(root_ / "secret.mtl") << "newmtl wall\nd 0\n";
        std::ofstream(root_ / "scene" / "m.mtl")
            << "newmtl wall\nKd 1 1 1\nd 1.0\nTr 1.0\nnewmtl glass pane\r\nd 0.5\nnewmtl water\nTr 0.3\n"
               "newmtl leaf\nmap_d leaf.png\nnewmtl halo\nd -halo 0.5\nnewmtl odd\nd nan\n";
    }
    ~ObjFolder() override { fs::remove_all(root_); }

    std::uint32_t flags(const std::string& material, const std::string& library = "m.mtl") {
        RawScene raw = read("mtllib " + library + "\n" + kPoints + "usemtl " + material + "\nf 1 2 3\n",
                            (root_ / "scene").string());
        return raw.objects.at(0).flags;
    }
    fs::path root_;
};

TEST_F(ObjFolder, MaterialsDecideWhoOccludes) {
    EXPECT_EQ(flags("wall"), kOccludes | kDoubleSided) << "where there is a d, Tr does not count";
    EXPECT_EQ(flags("nobody"), kOccludes | kDoubleSided);
    for (const char* material : {"glass pane", "water", "leaf", "halo", "odd"})
        EXPECT_EQ(flags(material), kDoubleSided) << material;
}

TEST_F(ObjFolder, OneSeeThroughFaceIsEnough) {
    RawScene raw = read("mtllib m.mtl\n" + kPoints + "g a\nusemtl wall\nf 1 2 3\nusemtl water\nf 2 3 4\ng b\n"
                        "usemtl wall\nf 1 2 3\n", (root_ / "scene").string());
    EXPECT_EQ(raw.objects.at(0).flags, kDoubleSided);
    EXPECT_EQ(raw.objects.at(1).flags, kOccludes | kDoubleSided);
    EXPECT_EQ(found(raw, "see-through object"), 1u);
}

TEST_F(ObjFolder, LibrariesElsewhereAreNotReadButNoError) {
    for (const char* library : {"../secret.mtl", "none.mtl", "/etc/passwd", "http://x/y.mtl"})
        EXPECT_EQ(flags("wall", library), kOccludes | kDoubleSided) << library;
    RawScene raw = read("mtllib none.mtl\nmtllib none.mtl\n" + kPoints + "f 1 2 3\n", (root_ / "scene").string());
    EXPECT_EQ(found(raw, "material library not read"), 1u);
}

TEST(Obj, EveryTruncationEndsWell) {
    const std::string text = "mtllib m.mtl\r\no a\nv 0 0 0\nv 1 0 0\nv 0 1.5e0 \\\n 0\nv 1 1 -0\ng b c\nusemtl x\n"
                             "f 1/2/3 2//3 -1\nf 1 2 4 3\nl 1 2\n";
    for (std::size_t size = 0; size <= text.size(); ++size)
        (void)import(text.substr(0, size));
    for (std::size_t at = 0; at < text.size(); ++at)
        for (int mask : {0x01, 0x04, 0x10, 0x80}) {
            std::string flipped = text;
            flipped[at] = static_cast<char>(flipped[at] ^ mask);
            Result<RawScene> raw = import(flipped);
            if (raw.ok())
                (void)Scene::create(std::move(*raw));
        }
}

} // namespace
} // namespace antumbra
