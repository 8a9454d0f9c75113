// Inner boxes of single meshes and of several together, against brute force over voxels.
#include "base/random.hpp"
#include "occluder_finding/inner_boxes.hpp"
#include "occluder_finding/inside_tests.hpp"
#include "support/make_scene.hpp"

#include <antumbra/occluder_finding.hpp>

#include <gtest/gtest.h>

namespace antumbra {
namespace {

using grid::Point;

InnerBox box(Point min, Point max, std::uint32_t object) { return {min, max, min, max, object, 12, {}}; }

TEST(JoinBoxes, a_row_of_houses_is_one_box_up_to_its_lowest_roof) {
    std::vector<InnerBox> houses{box({0, 0, 0}, {10, 30, 12}, 0), box({10, 0, 0}, {22, 20, 12}, 1),
                                 box({22, 0, 0}, {31, 25, 12}, 2)};
    std::vector<InnerBox> joined = join_boxes(houses, 100);
    ASSERT_FALSE(joined.empty());
    EXPECT_EQ(joined[0].min, (Point{0, 0, 0}));
    EXPECT_EQ(joined[0].max, (Point{31, 20, 12}));
    EXPECT_EQ(joined[0].shell_max, (Point{31, 30, 12})) << "who stands on the lower roof is within";
    EXPECT_EQ(joined[0].triangles, 3u);
}

TEST(JoinBoxes, a_gap_of_one_step_or_a_step_back_keeps_them_apart) {
    EXPECT_TRUE(join_boxes({box({0, 0, 0}, {10, 30, 12}, 0), box({11, 0, 0}, {22, 30, 12}, 1)}, 100).empty());
    std::vector<InnerBox> back = join_boxes({box({0, 0, 0}, {10, 30, 12}, 0), box({10, 0, 6}, {20, 30, 18}, 1)}, 100);
    for (const InnerBox& b : back)
        EXPECT_FALSE(b.min[0] == 0 && b.max[0] == 20 && (b.min[2] < 6 || b.max[2] > 12));
}

TEST(JoinBoxes, two_boxes_of_one_object_are_left_to_that_object) {
    EXPECT_TRUE(join_boxes({box({0, 0, 0}, {10, 30, 12}, 7), box({10, 0, 0}, {22, 30, 12}, 7)}, 100).empty());
}

/// Whatever the boxes are: every voxel of a joined box lies in one of its boxes, and its shell holds theirs.
TEST(JoinBoxes, cover_nothing_that_the_boxes_do_not) {
    std::size_t found = 0;
    for (std::uint32_t trial = 0; trial < 400; ++trial) {
        Random random(77, trial);
        constexpr int kSize = 12;
        std::vector<InnerBox> boxes;
        std::vector<char> inside(kSize * kSize * kSize, 0);
        for (std::uint32_t b = 0, n = 2 + random.below(9); b < n; ++b) {
            InnerBox made;
            for (std::size_t k = 0; k < 3; ++k) {
                made.min[k] = 4 * random.below(3); // often side by side
                made.max[k] = made.min[k] + 4 + 4 * random.below(std::uint32_t((kSize - made.min[k]) / 4));
                if (random.below(6) == 0)
                    --made.max[k];
            }
            made.shell_min = made.min;
            made.shell_max = made.max;
            made.object = b;
            boxes.push_back(made);
            for (std::int64_t z = made.min[2]; z < made.max[2]; ++z)
                for (std::int64_t y = made.min[1]; y < made.max[1]; ++y)
                    for (std::int64_t x = made.min[0]; x < made.max[0]; ++x)
                        inside[std::size_t(x + kSize * (y + kSize * z))] = 1;
        }
        for (const InnerBox& joined : join_boxes(boxes, 1000)) {
            ++found;
            for (std::int64_t z = joined.min[2]; z < joined.max[2]; ++z)
                for (std::int64_t y = joined.min[1]; y < joined.max[1]; ++y)
                    for (std::int64_t x = joined.min[0]; x < joined.max[0]; ++x)
                        ASSERT_TRUE(inside[std::size_t(x + kSize * (y + kSize * z))]) << "trial " << trial;
            for (std::size_t k = 0; k < 3; ++k) {
                ASSERT_LE(joined.shell_min[k], joined.min[k]);
                ASSERT_GE(joined.shell_max[k], joined.max[k]);
            }
        }
    }
    EXPECT_GT(found, 200u);
}

std::vector<Box3f> synthetic_boxes(const OccluderSet& set) {
    std::vector<Box3f> boxes(set.solids.size());
    for (const OccluderPolygon& polygon : set.polygons)
        if (polygon.synthetic)
            for (std::uint32_t v : set.loop(polygon))
                boxes[polygon.solid].extend(set.vertices[v]);
    return boxes;
}

TEST(InnerBoxes, houses_that_share_a_wall_hide_as_one) {
    test::SceneMaker maker;
    maker.object("a").box({0, 0, 0}, {8, 16, 8}).object("b").box({8, 0, 0}, {20, 12, 8});
    maker.object("open").quad({0, 0, 20}, {1, 0, 20}, {1, 1, 20}, {0, 1, 20});
    Scene scene = maker.scene();
    OccluderStatistics statistics;
    OccluderSet set = find_occluders(scene, {}, &statistics);
    EXPECT_EQ(statistics.joined_boxes, 1u);
    EXPECT_EQ(statistics.closed_objects, 2u);
    ASSERT_EQ(set.solids.size(), 1u);
    Vec3d size = to_double(synthetic_boxes(set)[0]).size();
    EXPECT_EQ(size, (Vec3d{20, 12, 8}));
    EXPECT_EQ(to_double(set.solids[0].shell).size(), (Vec3d{20, 16, 8}));
}

TEST(InnerBoxes, an_open_house_joins_for_viewers_on_the_other_side) {
    test::SceneMaker maker;
    maker.object("a").box({0, 0, 0}, {8, 16, 8}).object("b").box({8, 0, 0}, {20, 12, 8});
    RawScene raw = maker.raw();
    raw.triangles.pop_back();
    --raw.objects[1].triangle_count;
    OccluderStatistics statistics;
    Scene scene = *Scene::create(raw);
    OccluderSet set = find_occluders(scene, {}, &statistics);
    ASSERT_EQ(statistics.joined_boxes, 1u);
    EXPECT_EQ(statistics.restricted_solids, 1u);
    EXPECT_EQ(set.solids[0].viewers.max.z, scene.local_bounds().max.z);
    raw.triangles.erase(raw.triangles.begin()); // and the first one another hole, to -x
    raw.objects[0].triangle_count -= 1;
    raw.objects[1].first_triangle -= 1;
    find_occluders(*Scene::create(raw), {}, &statistics);
    EXPECT_EQ(statistics.joined_boxes, 0u) << "nobody is on the other side of both";
}

TEST(InnerBoxes, glass_and_what_never_occludes_join_nothing) {
    test::SceneMaker maker;
    maker.object("a").box({0, 0, 0}, {8, 16, 8}).object("glass", 0).box({8, 0, 0}, {20, 12, 8});
    OccluderStatistics statistics;
    find_occluders(maker.scene(), {}, &statistics);
    EXPECT_EQ(statistics.joined_boxes, 0u);
}

// Two solids of one mesh that overlap: the surface of each runs through the other, yet both are matter.
TEST(InnerBoxes, solids_that_run_through_one_another_hide_as_one) {
    test::SceneMaker maker;
    maker.object("cross").box({0, 0, 0}, {20, 4, 4}).box({8, 0, -8}, {12, 4, 12});
    OccluderOptions options;
    options.inner_box_triangles = 1;
    OccluderSet set = find_occluders(maker.scene(), options);
    std::vector<Vec3d> sizes;
    for (const Box3f& b : synthetic_boxes(set))
        sizes.push_back(to_double(b).size());
    EXPECT_NE(std::find(sizes.begin(), sizes.end(), Vec3d{20, 4, 4}), sizes.end());
}

TEST(Enters, box_and_triangle_exactly) {
    Point min{0, 0, 0}, max{10, 10, 10};
    EXPECT_FALSE(enters(min, max, {Point{10, 0, 0}, Point{20, 0, 0}, Point{20, 5, 0}})) << "a corner on a face";
    EXPECT_FALSE(enters(min, max, {Point{0, 0, 0}, Point{10, 0, 0}, Point{10, 10, 0}})) << "in a face";
    EXPECT_FALSE(enters(min, max, {Point{20, 0, 5}, Point{0, 20, 5}, Point{30, 30, 5}})) << "touches an edge";
    EXPECT_TRUE(enters(min, max, {Point{19, 0, 5}, Point{0, 20, 5}, Point{30, 30, 5}}));
    EXPECT_TRUE(enters(min, max, {Point{2, 2, 2}, Point{3, 2, 2}, Point{2, 3, 2}})) << "inside";
    EXPECT_TRUE(enters(min, max, {Point{-90, 5, 5}, Point{90, 5, 5}, Point{0, 5, 500}})) << "through";
}

/// A voxel model of random boxes, drawn as the surface between matter and air: inner boxes must be matter.
TEST(InnerBoxes, of_random_closed_meshes_are_matter) {
    std::size_t found = 0;
    for (std::uint32_t trial = 0; trial < 60; ++trial) {
        Random random(78, trial);
        constexpr int kSize = 7;
        std::vector<char> inside(kSize * kSize * kSize, 0);
        auto at = [&](int x, int y, int z) {
            bool within = x >= 0 && y >= 0 && z >= 0 && x < kSize && y < kSize && z < kSize;
            return within && inside[std::size_t(x + kSize * (y + kSize * z))];
        };
        for (int b = 0; b < 4; ++b) {
            int low[3], high[3];
            for (int k = 0; k < 3; ++k) {
                low[k] = int(random.below(kSize - 1));
                high[k] = low[k] + 1 + int(random.below(std::uint32_t(kSize - low[k])));
            }
            for (int z = low[2]; z < high[2]; ++z)
                for (int y = low[1]; y < high[1]; ++y)
                    for (int x = low[0]; x < high[0]; ++x)
                        inside[std::size_t(x + kSize * (y + kSize * z))] = 1;
        }
        test::SceneMaker maker;
        maker.object("voxels");
        for (int z = 0; z < kSize; ++z)
            for (int y = 0; y < kSize; ++y)
                for (int x = 0; x < kSize; ++x)
                    for (int face = 0; face < 6 && at(x, y, z); ++face) {
                        int n[3] = {x, y, z};
                        n[face / 2] += face % 2 ? 1 : -1;
                        if (at(n[0], n[1], n[2]))
                            continue;
                        static constexpr int faces[6][4] = {{0, 4, 6, 2}, {1, 3, 7, 5}, {0, 1, 5, 4},
                                                            {2, 6, 7, 3}, {0, 2, 3, 1}, {4, 5, 7, 6}};
                        Box3d cell{{double(x), double(y), double(z)}, {x + 1.0, y + 1.0, z + 1.0}};
                        maker.quad(cell.corner(faces[face][0]), cell.corner(faces[face][1]),
                                   cell.corner(faces[face][2]), cell.corner(faces[face][3]));
                    }
        OccluderOptions options;
        options.inner_box_triangles = 1;
        options.inner_solids = false; // the bounds of a wedge are not matter
        Scene scene = maker.scene();
        OccluderSet set = find_occluders(scene, options);
        for (const Box3f& b : synthetic_boxes(set)) {
            ++found;
            Vec3d low = scene.to_world(to_double(b.min)), high = scene.to_world(to_double(b.max));
            for (int z = int(std::floor(low.z)); z < high.z; ++z)
                for (int y = int(std::floor(low.y)); y < high.y; ++y)
                    for (int x = int(std::floor(low.x)); x < high.x; ++x)
                        ASSERT_TRUE(at(x, y, z)) << "trial " << trial;
        }
    }
    EXPECT_GT(found, 100u);
}

} // namespace
} // namespace antumbra
