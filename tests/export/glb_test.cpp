#include <antumbra/export.hpp>
#include <antumbra/generate.hpp>
#include <antumbra/import.hpp>

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>
#include <rapidcheck.h>

#include <cstring>

namespace antumbra {
namespace {

RawScene imported(const std::vector<std::byte>& bytes) {
    Result<RawScene> raw = import_gltf(bytes, "test.glb", "");
    EXPECT_TRUE(raw.ok()) << raw.status().message();
    return raw.ok() ? std::move(*raw) : RawScene{};
}

Scene created(RawScene raw) {
    Result<Scene> scene = Scene::create(std::move(raw));
    EXPECT_TRUE(scene.ok()) << scene.status().message();
    return std::move(*scene);
}

nlohmann::json document_of(const std::vector<std::byte>& bytes) {
    std::uint32_t length = 0;
    std::memcpy(&length, bytes.data() + 12, 4);
    const char* text = reinterpret_cast<const char*>(bytes.data()) + 20;
    return nlohmann::json::parse(text, text + length);
}

/// One object per entry of `offsets`: the same tetrahedron there.
RawScene tetrahedra(const std::vector<Vec3d>& offsets) {
    RawScene raw;
    raw.source = "tetrahedra";
    for (const Vec3d& offset : offsets) {
        RawObject object;
        object.id = {static_cast<std::int32_t>(raw.objects.size()), 0, -1};
        object.name = "t" + std::to_string(raw.objects.size());
        object.first_triangle = static_cast<std::uint32_t>(raw.triangles.size());
        object.triangle_count = 4;
        raw.objects.push_back(object);
        auto base = static_cast<std::uint32_t>(raw.positions.size());
        for (Vec3d p : {Vec3d{0, 0, 0}, Vec3d{1, 0, 0}, Vec3d{0, 1, 0}, Vec3d{0, 0, 1}})
            raw.positions.push_back(p + offset);
        for (TriangleIndices t : {TriangleIndices{0, 2, 1}, {0, 1, 3}, {0, 3, 2}, {1, 2, 3}})
            raw.triangles.push_back({base + t[0], base + t[1], base + t[2]});
    }
    return raw;
}

TEST(ExportGlb, generated_scenes_come_back_with_the_same_fingerprint) {
    for (std::string_view kind : generator_names()) {
        GenerateOptions options;
        options.triangles = kind == "apartment" || kind == "machine" ? 0 : 50'000; // kinds of one size
        Result<RawScene> raw = generate(kind, options);
        ASSERT_TRUE(raw.ok()) << kind << ": " << raw.status().message();
        Result<std::vector<std::byte>> bytes = export_glb(*raw);
        ASSERT_TRUE(bytes.ok()) << bytes.status().message();
        Scene before = created(std::move(*raw)), after = created(imported(*bytes));
        EXPECT_EQ(to_hex(before.fingerprint()), to_hex(after.fingerprint())) << kind;
        EXPECT_EQ(before.structure_fingerprint(), after.structure_fingerprint()) << kind;
    }
}

/// Compared by place: a scene created anew from snapped positions may choose another origin.
TEST(ExportGlb, a_snapped_scene_comes_back_exactly) {
    rc::check([] {
        std::vector<Vec3d> offsets;
        double far = *rc::gen::element(0.0, 1e3, 4.6e5, 1e7);
        for (int i = *rc::gen::inRange(1, 6); i > 0; --i)
            offsets.push_back({far + *rc::gen::inRange(-1000, 1000) * 0.37,
                               -far + *rc::gen::inRange(-1000, 1000) * 0.01,
                               *rc::gen::inRange(-1000, 1000) / 3.0});
        RawScene raw = tetrahedra(offsets);
        for (RawObject& object : raw.objects)
            object.flags =
                *rc::gen::element<std::uint32_t>(0, kOccludes, kDoubleSided, kOccludes | kDoubleSided);
        Scene scene = created(std::move(raw));
        Result<std::vector<std::byte>> bytes = export_glb(scene);
        RC_ASSERT(bytes.ok());
        RawScene again = imported(*bytes);
        RC_ASSERT(again.triangles.size() == scene.triangles().size());
        for (std::size_t t = 0; t < again.triangles.size(); ++t)
            for (std::size_t k = 0; k < 3; ++k)
                RC_ASSERT(again.positions[again.triangles[t][k]] ==
                          scene.to_world(to_double(scene.positions()[scene.triangles()[t][k]])));
        for (std::size_t o = 0; o < again.objects.size(); ++o)
            RC_ASSERT(again.objects[o].flags == scene.objects()[o].flags);
    });
}

TEST(ExportGlb, far_away_coordinates_keep_their_detail) {
    RawScene raw = tetrahedra({{1e7 + 0.125, 0, -4e6}, {1e7 + 3, 0.0625, -4e6 + 2}});
    RawScene back = imported(*export_glb(raw));
    ASSERT_EQ(back.triangles.size(), raw.triangles.size());
    for (std::size_t t = 0; t < raw.triangles.size(); ++t)
        for (std::size_t k = 0; k < 3; ++k)
            EXPECT_EQ(back.positions[back.triangles[t][k]], raw.positions[raw.triangles[t][k]]);
}

TEST(ExportGlb, copies_share_one_mesh_and_a_different_material_does_not) {
    RawScene raw = tetrahedra({{0, 0, 0}, {5, 0, 0}, {0, 7, 2}, {9, 9, 9}});
    raw.objects[3].flags = kOccludes | kDoubleSided;
    nlohmann::json document = document_of(*export_glb(raw));
    EXPECT_EQ(document["nodes"].size(), 4u);
    EXPECT_EQ(document["meshes"].size(), 2u);
    EXPECT_EQ(document["nodes"][2]["mesh"], 0);
    EXPECT_EQ(document["nodes"][3]["mesh"], 1);
}

TEST(ExportGlb, flags_become_materials) {
    RawScene raw = tetrahedra({{0, 0, 0}, {5, 0, 0}});
    raw.objects[0].flags = kOccludes | kDoubleSided;
    raw.objects[1].flags = 0;
    nlohmann::json materials = document_of(*export_glb(raw))["materials"];
    EXPECT_EQ(materials[0]["doubleSided"], true);
    EXPECT_FALSE(materials[0].contains("alphaMode"));
    EXPECT_EQ(materials[1]["alphaMode"], "BLEND");
    EXPECT_FALSE(materials[1].contains("doubleSided"));
}

/// A strip of triangles with more vertices than 16 bits can name.
TEST(ExportGlb, big_meshes_use_wide_indices) {
    for (std::uint32_t vertices : {65534u, 65535u, 65536u, 70000u}) {
        RawScene raw;
        raw.source = "strip";
        for (std::uint32_t i = 0; i < vertices; ++i)
            raw.positions.push_back({double(i / 2), double(i % 2), 0});
        for (std::uint32_t i = 0; i + 2 < vertices; ++i)
            raw.triangles.push_back(i % 2 ? TriangleIndices{i + 1, i, i + 2}
                                          : TriangleIndices{i, i + 1, i + 2});
        RawObject object;
        object.id = {0, 0, -1};
        object.triangle_count = vertices - 2;
        raw.objects.push_back(object);
        std::vector<std::byte> bytes = *export_glb(raw);
        EXPECT_EQ(document_of(bytes)["accessors"][1]["componentType"], vertices < 65535 ? 5123 : 5125);
        RawScene back = imported(bytes);
        EXPECT_EQ(back.triangles, raw.triangles);
        EXPECT_EQ(back.positions, raw.positions);
    }
}

TEST(ExportGlb, names_that_are_not_utf8_are_mended) {
    RawScene raw = tetrahedra({{0, 0, 0}});
    raw.objects[0].name = "caf\xe9 \"x\"\n";
    EXPECT_EQ(document_of(*export_glb(raw))["nodes"][0]["name"], "caf\xef\xbf\xbd \"x\"\n");
}

TEST(ExportGlb, an_object_without_triangles_keeps_its_place) {
    RawScene raw = tetrahedra({{0, 0, 0}, {5, 0, 0}});
    raw.objects[0].triangle_count = 0;
    raw.objects[1].first_triangle = 0;
    raw.objects[1].triangle_count = 8;
    nlohmann::json nodes = document_of(*export_glb(raw))["nodes"];
    EXPECT_FALSE(nodes[0].contains("mesh"));
    EXPECT_EQ(nodes[1]["mesh"], 0);
}

TEST(ExportGlb, broken_scenes_are_refused_by_name) {
    RawScene infinite = tetrahedra({{0, 0, 0}});
    infinite.positions[2].y = std::numeric_limits<double>::infinity();
    EXPECT_EQ(export_glb(infinite).status().code(), ErrorCode::corrupt);
    EXPECT_EQ(export_glb(infinite).status().message(),
              "tetrahedra: object 't0': vertex 2 is not finite; repair or leave it out");
    RawScene beyond = tetrahedra({{0, 0, 0}});
    beyond.triangles[1][2] = 4;
    EXPECT_EQ(export_glb(beyond).status().message(), "tetrahedra: object 't0': vertex index 4 out of range");
    RawScene long_object = tetrahedra({{0, 0, 0}});
    long_object.objects[0].triangle_count = 5;
    EXPECT_EQ(export_glb(long_object).status().message(), "tetrahedra: object 't0': triangles out of range");
}

} // namespace
} // namespace antumbra
