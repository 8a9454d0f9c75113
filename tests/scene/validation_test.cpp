#include <antumbra/scene.hpp>

#include <gtest/gtest.h>
#include <rapidcheck/gtest.h>

#include <map>

namespace antumbra {
namespace {

Scene scene_of(std::vector<Vec3d> positions, std::vector<TriangleIndices> triangles) {
    RawScene raw;
    raw.positions = std::move(positions);
    raw.triangles = std::move(triangles);
    RawObject object;
    object.name = "o";
    object.triangle_count = static_cast<std::uint32_t>(raw.triangles.size());
    raw.objects = {object};
    Result<Scene> scene = Scene::create(raw);
    EXPECT_TRUE(scene.ok()) << scene.status().message();
    return std::move(*scene);
}

std::map<std::string, std::uint64_t> counts(const Scene& scene) {
    std::map<std::string, std::uint64_t> result;
    for (const Finding& finding : validate(scene))
        result[finding.kind] = finding.count;
    return result;
}

using Counts = std::map<std::string, std::uint64_t>;
const std::vector<Vec3d> kCorners = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}};

TEST(Validate, AClosedTetrahedronHasNoFindings) {
    EXPECT_EQ(counts(scene_of(kCorners, {{0, 2, 1}, {0, 1, 3}, {1, 2, 3}, {2, 0, 3}})), Counts());
}

TEST(Validate, BoundaryEdges) {
    Scene scene = scene_of(kCorners, {{0, 2, 1}, {0, 1, 3}, {1, 2, 3}});
    EXPECT_EQ(counts(scene), (Counts{{"boundary edge", 3}}));
    EXPECT_EQ(validate(scene)[0].example, "triangle 0 of 'o'");
}

TEST(Validate, DuplicatesWhateverTheirWindingAndIndices) {
    std::vector<Vec3d> doubled = kCorners;
    doubled.insert(doubled.end(), kCorners.begin(), kCorners.end());
    Scene scene = scene_of(doubled, {{0, 2, 1}, {0, 1, 3}, {1, 2, 3}, {2, 0, 3}, {5, 4, 6}});
    EXPECT_EQ(counts(scene), (Counts{{"duplicate triangle", 1}, {"non-manifold edge", 3}}));
    EXPECT_EQ(validate(scene)[0].example, "triangle 4 of 'o'");
}

TEST(Validate, ThreeLeavesOfABook) {
    EXPECT_EQ(counts(scene_of({{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}, {0, -1, 0}}, {{0, 1, 2}, {0, 1, 3}, {0, 1, 4}})),
              (Counts{{"boundary edge", 6}, {"non-manifold edge", 1}}));
}

RC_GTEST_PROP(ValidateLaw, DoesNotDependOnIndexing, ()) {
    // Random triangles over few points; the same triangles with every corner a vertex of its own.
    std::vector<Vec3d> points;
    for (int i = 0; i < 8; ++i)
        points.push_back({double(i & 1), double(i >> 1 & 1), double(i >> 2)});
    std::vector<TriangleIndices> triangles = {{0, 1, 2}};
    int count = *rc::gen::inRange(1, 20);
    for (int t = 0; t < count; ++t)
        triangles.push_back({*rc::gen::inRange(0u, 8u), *rc::gen::inRange(0u, 8u), *rc::gen::inRange(0u, 8u)});
    std::vector<Vec3d> soup;
    std::vector<TriangleIndices> own;
    for (const TriangleIndices& t : triangles) {
        std::uint32_t base = static_cast<std::uint32_t>(soup.size());
        for (std::uint32_t v : t)
            soup.push_back(points[v]);
        own.push_back({base, base + 1, base + 2});
    }
    RC_ASSERT(counts(scene_of(points, triangles)) == counts(scene_of(soup, own)));
}

} // namespace
} // namespace antumbra
