#include <antumbra/occluder_finding.hpp>

#include "base/random.hpp"
#include "cull/proof.hpp"
#include "occluder_finding/inner_boxes.hpp"
#include "occluder_finding/inside_tests.hpp"
#include "occluder_finding/merge.hpp"

#include <gtest/gtest.h>

namespace antumbra {
namespace {

using grid::Point;
using Loop = std::vector<std::uint32_t>;

Scene scene_of(RawScene raw) {
    Result<Scene> scene = Scene::create(std::move(raw));
    EXPECT_TRUE(scene.ok()) << scene.status().message();
    return std::move(scene).value();
}

/// A raw scene of one object.
RawScene mesh(std::vector<Vec3d> positions, std::vector<TriangleIndices> triangles, std::uint32_t flags = kOccludes) {
    RawScene raw;
    raw.source = "mesh";
    raw.positions = std::move(positions);
    raw.triangles = std::move(triangles);
    RawObject object;
    object.name = "mesh";
    object.flags = flags;
    object.triangle_count = std::uint32_t(raw.triangles.size());
    raw.objects.push_back(object);
    return raw;
}

/// An n x m sheet of quads in the plane y = 0.
RawScene sheet(std::uint32_t n, std::uint32_t m) {
    std::vector<Vec3d> positions;
    std::vector<TriangleIndices> triangles;
    for (std::uint32_t j = 0; j <= m; ++j)
        for (std::uint32_t i = 0; i <= n; ++i)
            positions.push_back({double(i), 0, double(j)});
    for (std::uint32_t j = 0; j < m; ++j)
        for (std::uint32_t i = 0; i < n; ++i) {
            std::uint32_t a = i + (n + 1) * j;
            triangles.push_back({a, a + n + 1, a + n + 2});
            triangles.push_back({a, a + n + 2, a + 1});
        }
    return mesh(positions, triangles);
}

/// A closed box with n x n quads per face.
RawScene fine_box(std::uint32_t n, double size) {
    std::vector<Vec3d> positions;
    std::vector<TriangleIndices> triangles;
    for (int face = 0; face < 6; ++face) {
        int axis = face / 2, u = (axis + 1) % 3, v = (axis + 2) % 3;
        auto base = std::uint32_t(positions.size());
        for (std::uint32_t j = 0; j <= n; ++j)
            for (std::uint32_t i = 0; i <= n; ++i) {
                Vec3d p;
                p[axis] = face % 2 ? size : 0;
                p[u] = size * i / n;
                p[v] = size * j / n;
                positions.push_back(p);
            }
        for (std::uint32_t j = 0; j < n; ++j)
            for (std::uint32_t i = 0; i < n; ++i) {
                std::uint32_t a = base + i + (n + 1) * j, b = a + 1, c = a + n + 2, d = a + n + 1;
                if (face % 2 == 0)
                    std::swap(b, d);
                triangles.push_back({a, b, c});
                triangles.push_back({a, c, d});
            }
    }
    return mesh(positions, triangles);
}

TEST(MergedLoop, two_triangles_of_a_square_become_the_square) {
    std::vector<Point> points{{0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {0, 1, 0}};
    EXPECT_EQ(merged_loop({0, 1, 2}, {0, 2, 3}, {0, 0, 1}, points), (Loop{0, 1, 2, 3}));
}

TEST(MergedLoop, refuses_what_would_not_be_convex) {
    std::vector<Point> points{{0, 0, 0}, {4, 0, 0}, {1, 1, 0}, {0, 4, 0}};
    EXPECT_EQ(merged_loop({0, 1, 2}, {0, 2, 3}, {0, 0, 1}, points), Loop{});
}

TEST(FindOccluders, a_flat_sheet_is_one_polygon_with_four_corners) {
    OccluderSet set = find_occluders(scene_of(sheet(7, 5)));
    ASSERT_EQ(set.polygons.size(), 1u);
    EXPECT_EQ(set.polygons[0].count, 4u);
    EXPECT_DOUBLE_EQ(set.polygons[0].area, 35);
    EXPECT_EQ(set.polygons[0].normal, (Vec3d{0, 1, 0}));
}

TEST(FindOccluders, a_bend_of_one_grid_step_is_not_flat) {
    RawScene raw = sheet(2, 1);
    Scene flat = scene_of(raw);
    raw.positions[2].y = raw.positions[5].y = flat.step();
    EXPECT_EQ(find_occluders(scene_of(raw)).polygons.size(), 2u);
}

TEST(FindOccluders, a_hole_stays_a_hole) {
    RawScene raw = sheet(3, 3);
    raw.triangles.erase(raw.triangles.begin() + 8, raw.triangles.begin() + 10); // the middle quad
    raw.objects[0].triangle_count -= 2;
    OccluderSet set = find_occluders(scene_of(raw));
    double area = 0;
    for (const OccluderPolygon& polygon : set.polygons)
        area += polygon.area;
    EXPECT_DOUBLE_EQ(area, 8);
}

TEST(FindOccluders, opposite_sides_and_other_sidedness_do_not_merge) {
    RawScene turned = sheet(2, 1);
    std::swap(turned.triangles[2][1], turned.triangles[2][2]);
    std::swap(turned.triangles[3][1], turned.triangles[3][2]);
    EXPECT_EQ(find_occluders(scene_of(turned)).polygons.size(), 2u);
    RawScene mixed = sheet(2, 1);
    mixed.objects[0].triangle_count = 2;
    mixed.objects.push_back(mixed.objects[0]);
    mixed.objects[1].first_triangle = 2;
    mixed.objects[1].flags |= kDoubleSided;
    EXPECT_EQ(find_occluders(scene_of(mixed)).polygons.size(), 2u);
}

TEST(FindOccluders, objects_that_let_light_through_give_nothing) {
    RawScene raw = sheet(2, 2);
    raw.objects[0].flags = 0;
    EXPECT_TRUE(find_occluders(scene_of(raw)).polygons.empty());
}

TEST(FindOccluders, faces_of_a_box_know_their_neighbours) {
    OccluderOptions options;
    options.inner_boxes = false;
    OccluderSet set = find_occluders(scene_of(fine_box(3, 1)), options);
    ASSERT_EQ(set.polygons.size(), 6u);
    for (std::uint32_t neighbour : set.neighbours) {
        EXPECT_NE(neighbour & ~kSameDirection, kNoPolygon);
        EXPECT_FALSE(neighbour & kSameDirection);
    }
    ASSERT_EQ(set.patches.size(), 1u);
    EXPECT_EQ(set.patches[0].core, 6u);
    EXPECT_TRUE(check_occluders(set).ok());
}

/// Whatever a polygon covers, a triangle of its plane covered: random points of every polygon of random soups.
TEST(FindOccluders, polygons_cover_nothing_that_triangles_did_not) {
    for (std::uint32_t trial = 0; trial < 20; ++trial) {
        Random random(31, trial);
        Scene scene = scene_of(test::random_soup(random, 12, 16));
        OccluderOptions options;
        options.inner_boxes = false;
        OccluderSet set = find_occluders(scene, options);
        double polygon_area = 0, triangle_area = 0;
        for (const OccluderPolygon& polygon : set.polygons)
            polygon_area += polygon.area;
        for (std::uint32_t t = 0; t < scene.triangles().size(); ++t)
            if (scene.object_of(t).has(kOccludes))
                triangle_area += length(cross(scene.vertex(t, 1) - scene.vertex(t, 0), scene.vertex(t, 2) - scene.vertex(t, 0))) / 2;
        EXPECT_NEAR(polygon_area, triangle_area, 1e-6 * triangle_area);
        Tracer tracer = Tracer::build(scene);
        for (const OccluderPolygon& polygon : set.polygons) {
            Vec3d corner = to_double(set.vertices[set.loop(polygon)[random.below(polygon.count)]]);
            Vec3d point = polygon.centre + (corner - polygon.centre) * random.uniform(0.01, 0.9);
            Hit hit = tracer.first_hit({point + polygon.normal * 1e-3, -polygon.normal});
            EXPECT_LE(hit.t, 1.1e-3) << trial; // the polygon's own triangles, or something even nearer
        }
    }
}

TEST(InnerBoxes, fill_a_finely_divided_box_to_its_faces) {
    OccluderOptions options;
    OccluderStatistics statistics;
    Scene scene = scene_of(fine_box(8, 10));
    OccluderSet set = find_occluders(scene, options, &statistics);
    EXPECT_EQ(statistics.closed_objects, 1u);
    ASSERT_EQ(statistics.inner_boxes, 1u);
    ASSERT_EQ(set.solids.size(), 1u);
    Box3f inner;
    for (const OccluderPolygon& polygon : set.polygons)
        if (polygon.synthetic)
            for (std::uint32_t v : set.loop(polygon))
                inner.extend(set.vertices[v]);
    Box3f bounds = scene.local_bounds();
    EXPECT_EQ(inner, bounds) << "up to the shell itself";
}

TEST(InnerBoxes, a_hole_in_a_side_restricts_viewers_to_the_other) {
    RawScene open = fine_box(8, 10);
    open.triangles.pop_back(); // in the face to +z
    --open.objects[0].triangle_count;
    OccluderStatistics statistics;
    Scene scene = scene_of(open);
    OccluderSet set = find_occluders(scene, {}, &statistics);
    EXPECT_EQ(statistics.inner_boxes, 1u);
    EXPECT_EQ(statistics.closed_objects, 0u);
    EXPECT_EQ(statistics.restricted_solids, 1u);
    ASSERT_EQ(set.solids.size(), 1u);
    EXPECT_EQ(set.solids[0].viewers.max.z, scene.local_bounds().max.z) << "the plane of the hole";
    EXPECT_EQ(set.solids[0].viewers.min, OccluderSolid().viewers.min);
    Vec3d beside = to_double(scene.local_bounds().max) + Vec3d{5, 0, 0};
    EXPECT_FALSE(set.solids[0].serves({beside, beside})) << "on the plane";
    beside.z -= 1;
    EXPECT_TRUE(set.solids[0].serves({beside, beside}));
    EXPECT_FALSE(set.solids[0].serves({beside, beside + Vec3d{0, 0, 3}})) << "the near rectangle beyond it";
}

TEST(InnerBoxes, holes_in_two_sides_or_inverted_shells_have_none) {
    RawScene open = fine_box(8, 10);
    open.triangles.pop_back();
    open.triangles.erase(open.triangles.begin());
    open.objects[0].triangle_count -= 2;
    OccluderStatistics statistics;
    find_occluders(scene_of(open), {}, &statistics);
    EXPECT_EQ(statistics.inner_boxes + statistics.inner_solids, 0u);
    RawScene inverted = fine_box(8, 10); // one sees its far walls from within, and from outside too
    for (TriangleIndices& triangle : inverted.triangles)
        std::swap(triangle[0], triangle[1]);
    find_occluders(scene_of(inverted), {}, &statistics);
    EXPECT_EQ(statistics.closed_objects, 1u);
    EXPECT_EQ(statistics.inner_boxes, 0u);
    inverted.objects[0].flags |= kDoubleSided;
    find_occluders(scene_of(inverted), {}, &statistics);
    EXPECT_EQ(statistics.inner_boxes, 1u);
}

TEST(Touches, box_and_triangle_exactly) {
    Point min{0, 0, 0}, max{10, 10, 10};
    EXPECT_TRUE(touches(min, max, {Point{10, 0, 0}, Point{20, 0, 0}, Point{20, 5, 0}}));   // a corner on a face
    EXPECT_FALSE(touches(min, max, {Point{11, 0, 0}, Point{20, 0, 0}, Point{20, 5, 0}}));
    EXPECT_TRUE(touches(min, max, {Point{2, 2, 2}, Point{3, 2, 2}, Point{2, 3, 2}}));      // inside
    EXPECT_TRUE(touches(min, max, {Point{-90, 5, 5}, Point{90, 5, 5}, Point{0, 5, 500}})); // through
    // Passes the edge from (10,10,0) to (10,10,10) at one step's distance, and touches it.
    EXPECT_FALSE(touches(min, max, {Point{21, 0, 5}, Point{0, 21, 5}, Point{30, 30, 5}}));
    EXPECT_TRUE(touches(min, max, {Point{20, 0, 5}, Point{0, 20, 5}, Point{30, 30, 5}}));
}

} // namespace
} // namespace antumbra
