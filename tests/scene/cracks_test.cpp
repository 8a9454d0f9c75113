// Cracks: what snapping opens is counted, what a user asks for is closed, and nothing else moves.
#include "base/random.hpp"
#include "scene/cracks.hpp"

#include <antumbra/scene.hpp>

#include <gtest/gtest.h>

#include <map>

namespace antumbra {
namespace {

void add(RawScene& raw, const std::string& name, std::vector<std::array<Vec3d, 3>> triangles, std::uint32_t flags = kOccludes) {
    RawObject object;
    object.name = name;
    object.flags = flags;
    object.first_triangle = std::uint32_t(raw.triangles.size());
    object.triangle_count = std::uint32_t(triangles.size());
    for (const auto& t : triangles) {
        auto first = std::uint32_t(raw.positions.size());
        for (const Vec3d& p : t)
            raw.positions.push_back(p);
        raw.triangles.push_back({first, first + 1, first + 2});
    }
    raw.objects.push_back(object);
}

/// Two rectangles side by side, `gap` apart; the right one is cut in two at half its height.
RawScene two_walls(double gap) {
    RawScene raw;
    raw.source = "walls";
    add(raw, "left", {{Vec3d{0, 0, 0}, Vec3d{4, 0, 0}, Vec3d{4, 4, 0}}, {Vec3d{0, 0, 0}, Vec3d{4, 4, 0}, Vec3d{0, 4, 0}}});
    double x = 4 + gap;
    for (double y : {0.0, 2.0})
        add(raw, "right " + std::to_string(y),
            {{Vec3d{x, y, 0}, Vec3d{8, y, 0}, Vec3d{8, y + 2, 0}}, {Vec3d{x, y, 0}, Vec3d{8, y + 2, 0}, Vec3d{x, y + 2, 0}}});
    return raw;
}

std::uint64_t found(const Scene& scene, const std::string& kind) {
    for (const Finding& finding : scene.findings())
        if (finding.kind == kind)
            return finding.count;
    return 0;
}

/// Signed sum of all directed edges between the places of a scene; a closed seam leaves nothing along x between low and high.
std::map<std::pair<std::array<float, 3>, std::array<float, 3>>, int> rim(const Scene& scene) {
    std::map<std::pair<std::array<float, 3>, std::array<float, 3>>, int> edges;
    auto key = [&](std::uint32_t v) {
        Vec3f p = scene.positions()[v];
        return std::array<float, 3>{p.x, p.y, p.z};
    };
    for (const TriangleIndices& t : scene.triangles())
        for (std::size_t k = 0; k < 3; ++k) {
            auto a = key(t[k]), b = key(t[(k + 1) % 3]);
            edges[std::pair(std::min(a, b), std::max(a, b))] += a < b ? 1 : -1;
        }
    std::erase_if(edges, [](const auto& e) { return e.second == 0; });
    return edges;
}

Scene create(RawScene raw, double width) {
    SceneOptions options;
    options.crack_width = width;
    Result<Scene> scene = Scene::create(std::move(raw), options);
    EXPECT_TRUE(scene.ok()) << scene.status().message();
    return std::move(*scene);
}

TEST(Cracks, AreClosedUpToTheWidthAndLeftBeyondIt) {
    // The rim of the whole rectangle: left 1 + 2 top + 2 bottom + 2 right edges = 7, none along the seam.
    Scene closed = create(two_walls(0.01), 0.02);
    EXPECT_EQ(rim(closed).size(), 7u);
    EXPECT_EQ(found(closed, "corner moved to close a crack"), 2u);   // top and bottom of the seam
    EXPECT_EQ(found(closed, "triangle added to close a crack"), 1u); // the middle: a T-junction
    EXPECT_EQ(closed.crack_width(), 0.02);
    Scene left = create(two_walls(0.03), 0.02);
    EXPECT_EQ(found(left, "corner moved to close a crack") + found(left, "triangle added to close a crack"), 0u);
    EXPECT_EQ(left.triangles().size(), 6u);
}

TEST(Cracks, AWidthOfZeroIsTheSceneAsItIs) {
    Scene a = create(two_walls(0.01), 0);
    Result<Scene> b = Scene::create(two_walls(0.01));
    EXPECT_EQ(a.fingerprint(), b->fingerprint());
    EXPECT_NE(a.fingerprint(), create(two_walls(0.01), 0.02).fingerprint());
    EXPECT_EQ(a.structure_fingerprint(), create(two_walls(0.01), 0.02).structure_fingerprint()); // what a viewer draws
}

TEST(Cracks, WhatHidesNothingIsNotJoined) {
    RawScene raw = two_walls(0.01);
    raw.objects[0].flags = 0;
    EXPECT_EQ(create(std::move(raw), 0.02).triangles().size(), 6u);
}

TEST(Cracks, ObjectsKeepTheirOrderAndTheirTriangles) {
    Scene scene = create(two_walls(0.01), 0.02);
    ASSERT_EQ(scene.objects().size(), 3u);
    std::uint32_t next = 0;
    for (std::uint32_t o = 0; o < 3; ++o) {
        const Object& object = scene.objects()[o];
        EXPECT_EQ(object.first_triangle, next);
        next += object.triangle_count;
        EXPECT_EQ(object.source_triangles, 2u);
        for (std::uint32_t t = object.first_triangle; t < next; ++t) {
            EXPECT_EQ(scene.triangle_objects()[t], o);
            for (int c = 0; c < 3; ++c)
                EXPECT_TRUE(to_double(object.bounds).contains(scene.vertex(t, c)));
        }
    }
    EXPECT_EQ(next, scene.triangles().size());
}

/// Small triangles, wide cracks: none may vanish or turn over.
TEST(Cracks, WhatIsAddedIsCountedBehindTheTrianglesOfTheFile) {
    RawScene raw = two_walls(0.01);
    auto corner = raw.triangles[0][0];
    raw.triangles.insert(raw.triangles.begin() + 1, {corner, corner, corner}); // without area, in the first object
    for (RawObject& object : raw.objects)
        object.first_triangle += &object != raw.objects.data();
    ++raw.objects[0].triangle_count;
    for (double width : {0.0, 0.02}) {
        Scene scene = create(raw, width);
        std::uint32_t added = 0;
        for (const Object& object : scene.objects()) {
            std::uint32_t last = 0;
            for (std::uint32_t k = 0; k < object.triangle_count; ++k) {
                std::uint32_t source = scene.triangle_sources()[object.first_triangle + k];
                EXPECT_TRUE(k == 0 || source > last);
                if (source >= object.source_triangles) {
                    EXPECT_EQ(source, std::max(last + 1, object.source_triangles));
                    ++added;
                }
                last = source;
            }
        }
        EXPECT_EQ(scene.triangle_sources().size(), scene.triangles().size());
        EXPECT_EQ(added, width > 0 ? 1u : 0u);
        EXPECT_EQ(scene.triangle_sources()[0], 0u);
        EXPECT_EQ(scene.triangle_sources()[1], 2u);
    }
}

TEST(Cracks, NoTriangleCollapsesOrTurnsOver) {
    for (std::uint64_t seed = 1; seed <= 20; ++seed) {
        Random random(seed);
        GridMesh mesh;
        for (std::uint32_t t = 0; t < 60; ++t) {
            Vec3d at{double(random.below(200)), double(random.below(200)), double(random.below(40))};
            for (int c = 0; c < 3; ++c)
                mesh.positions.push_back(at + Vec3d{double(random.below(12)), double(random.below(12)), double(random.below(12))});
            Vec3d n = cross(mesh.positions[3 * t + 1] - mesh.positions[3 * t], mesh.positions[3 * t + 2] - mesh.positions[3 * t]);
            if (n == Vec3d{0, 0, 0})
                mesh.positions[3 * t + 2] = mesh.positions[3 * t] + Vec3d{0, 0, 5}, mesh.positions[3 * t + 1] = mesh.positions[3 * t] + Vec3d{5, 0, 0};
            mesh.triangles.push_back({3 * t, 3 * t + 1, 3 * t + 2});
            mesh.object_of.push_back(t / 5);
        }
        GridMesh was = mesh;
        Result<CrackClosing> done = close_cracks(mesh, std::vector<bool>(12, true), 9);
        if (!done)
            continue; // too many seals: said so
        ASSERT_GE(mesh.triangles.size(), 60u);
        std::map<std::uint32_t, std::uint32_t> next;
        for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
            auto normal = [&](const GridMesh& m, const TriangleIndices& i) {
                return cross(m.positions[i[1]] - m.positions[i[0]], m.positions[i[2]] - m.positions[i[0]]);
            };
            Vec3d n = normal(mesh, mesh.triangles[t]);
            EXPECT_GT(dot(n, n), 0) << seed;
            std::uint32_t o = mesh.object_of[t], k = next[o]++;
            if (k < 5) { // one of the mesh
                EXPECT_GT(dot(n, normal(was, was.triangles[o * 5 + k])), 0) << seed << " " << t;
            }
        }
    }
}

TEST(Cracks, AWidthThatIsNoCracksIsRefused) {
    RawScene raw;
    raw.source = "many";
    Random random(3);
    for (int t = 0; t < 300; ++t) {
        Vec3d at{random.uniform(0, 10), random.uniform(0, 10), random.uniform(0, 10)};
        add(raw, std::to_string(t), {{at, at + Vec3d{3, 0.1, 0}, at + Vec3d{0.2, 3, 1}}});
    }
    SceneOptions options;
    options.crack_width = 5;
    Result<Scene> scene = Scene::create(raw, options);
    ASSERT_FALSE(scene.ok());
    EXPECT_NE(scene.status().message().find("--crack-width"), std::string::npos);
    options.crack_width = -1;
    EXPECT_FALSE(Scene::create(raw, options).ok());
    options.crack_width = NAN;
    EXPECT_FALSE(Scene::create(raw, options).ok());
}

TEST(OpenedCracks, AreCountedBetweenObjectsOnly) {
    // In steps: 0.49 goes to 0, 0.51 to 1.
    std::vector<SnappedPoint> points = {{{0.49, 3, 3}, {0, 3, 3}, 0}, {{0.51, 3, 3}, {1, 3, 3}, 1}};
    EXPECT_EQ(count_opened_cracks(points).count, 1u);
    points[1].object = 0;
    EXPECT_EQ(count_opened_cracks(points).count, 0u);
    points[1] = {{0.49, 3, 3}, {0, 3, 3}, 1}; // the same place before and after
    EXPECT_EQ(count_opened_cracks(points).count, 0u);
    points = {{{0.1, 3, 3}, {0, 3, 3}, 0}, {{0.9, 3, 3}, {1, 3, 3}, 1}}; // apart before
    EXPECT_EQ(count_opened_cracks(points).count, 0u);
    points = {{{0.49, -0.49, 3}, {0, 0, 3}, 0}, {{0.51, -0.51, 3}, {1, -1, 3}, 1}, {{0.51, -0.51, 3}, {1, -1, 3}, 1}};
    EXPECT_EQ(count_opened_cracks(points).count, 1u); // a diagonal neighbour, once
}

TEST(OpenedCracks, AreAFindingWhereAskedFor) {
    RawScene raw = two_walls(0);
    double step = create(two_walls(0), 0).step();
    for (std::size_t v = 6; v < raw.positions.size(); ++v) // what another node's matrix may do to the seam
        if (raw.positions[v].x == 4)
            raw.positions[v].x += 0.3 * step;
    raw.positions[0].x -= 0.4 * step; // shifts nothing but the bounds' centre at the most
    for (std::size_t v = 0; v < 6; ++v)
        if (raw.positions[v].x == 4)
            raw.positions[v].x += 0.49 * step;
    for (std::size_t v = 6; v < raw.positions.size(); ++v)
        if (raw.positions[v].x > 4 && raw.positions[v].x < 5)
            raw.positions[v].x = 4 + 0.51 * step;
    SceneOptions options;
    EXPECT_EQ(found(*Scene::create(raw, options), kCrackOpened), 0u); // costs a search
    options.count_cracks = true;
    EXPECT_EQ(found(*Scene::create(raw, options), kCrackOpened), 2u);
    Scene closed = [&] {
        options.crack_width = 2 * step;
        return std::move(*Scene::create(raw, options));
    }();
    EXPECT_EQ(found(closed, "corner moved to close a crack"), 2u);
}

} // namespace
} // namespace antumbra
