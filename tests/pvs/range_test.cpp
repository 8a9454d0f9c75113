// Queries over ranges: boxes of viewpoints, frusta, moving boxes.
#include "pvs/random_tree.hpp"

#include <gtest/gtest.h>
#include <rapidcheck.h>

#include <cmath>

namespace antumbra {
namespace {

using test::random_pvs;
using test::random_pvs_tree;
using Words = std::vector<std::uint64_t>;

bool has(const Words& words, std::size_t bit) { return words[bit / 64] >> (bit % 64) & 1; }

Box3d at(double x, double y, double z) { return {{x, y, z}, {x, y, z}}; }

/// A row of three cells along x; object o is a unit box at x = 2 o, y = 0, z = 10; cell c sees the objects of row c.
PvsData three_cells() {
    PvsData data;
    data.guarantee = Guarantee::conservative;
    data.grid = {{{0, 0, 0}, {3, 1, 1}}, {3, 1, 1}};
    data.objects.resize(4);
    for (int o = 0; o < 4; ++o) {
        float x = float(2 * o);
        data.objects[std::size_t(o)].bounds = {{x, 0, 10}, {x + 1, 1, 11}};
    }
    data.row_count = 3;
    data.rows = {1, 2, 12};
    data.cell_row = {0, 1, 2};
    return data;
}

TEST(PvsRange, UnitesTheCellsThatABoxTouches) {
    std::vector<std::byte> bytes = *encode_pvs(three_cells());
    Pvs pvs = *Pvs::open(bytes);
    PvsCursor cursor;
    EXPECT_TRUE(pvs.query_range({{{0.5, 0, 0}, {1.5, 1, 1}}}, cursor));
    EXPECT_EQ(cursor.visible, (Words{3}));
    EXPECT_EQ(cursor.visible_count, 2u);
    EXPECT_EQ(cursor.cell, -3);
    EXPECT_FALSE(pvs.query_range({{{0.6, 0, 0}, {1.4, 1, 1}}}, cursor)) << "the same answer";
    EXPECT_TRUE(pvs.query_range({{{0.5, 0, 0}, {2.5, 1, 1}}}, cursor));
    EXPECT_EQ(cursor.visible, (Words{15}));
    EXPECT_FALSE(cursor.everything);
    EXPECT_TRUE(pvs.query_range({{{0.5, 0, 0}, {3.5, 1, 1}}}, cursor)) << "the same objects, but now for want of knowledge";
    EXPECT_TRUE(cursor.everything);
}

TEST(PvsRange, AnEyeAfterARangeIsAnsweredAnew) {
    std::vector<std::byte> bytes = *encode_pvs(three_cells());
    Pvs pvs = *Pvs::open(bytes);
    PvsCursor cursor;
    ViewRange away = camera_range(at(0.5, 0.5, 0.5), {0, 0, -1}, {0, 1, 0}, 1, 1);
    (void)pvs.query({0.5, 0.5, 0.5}, cursor);
    EXPECT_TRUE(pvs.query_range(away, cursor));
    EXPECT_EQ(cursor.visible_count, 0u);
    EXPECT_TRUE(pvs.query({0.5, 0.5, 0.5}, cursor));
    EXPECT_EQ(cursor.visible, (Words{1}));
    EXPECT_EQ(cursor.cell, 0);
}

TEST(PvsRange, AFrustumDropsWhatLiesOutsideOfIt) {
    PvsData data = three_cells();
    data.rows = {15, 15, 15};
    data.objects[3].flags = 4; // always visible
    std::vector<std::byte> bytes = *encode_pvs(data);
    Pvs pvs = *Pvs::open(bytes);
    PvsCursor cursor;
    // Toward +z, 10 degrees or so: object 0 (x 0..1) is in, objects 1 and 2 are beyond the side plane x = 0.5 + z / 10.
    (void)pvs.query_range(camera_range(at(0.5, 0.5, 0), {0, 0, 1}, {0, 1, 0}, 0.1, 1), cursor);
    EXPECT_EQ(cursor.visible, (Words{9}));
    // The same from a wider box of eyes.
    (void)pvs.query_range(camera_range({{0.5, 0.5, 0}, {2.5, 0.5, 0}}, {0, 0, 1}, {0, 1, 0}, 0.1, 1), cursor);
    EXPECT_EQ(cursor.visible, (Words{11}));
    EXPECT_FALSE(cursor.everything);
    (void)pvs.query_range(camera_range(at(50, 0.5, 0), {0, 0, -1}, {0, 1, 0}, 0.1, 1), cursor);
    EXPECT_EQ(cursor.visible, (Words{8})) << "everything, but for the frustum";
    EXPECT_TRUE(cursor.everything);
}

/// Some cell of the data holds the view, and its row the object.
bool is_seen(const PvsData& data, const Vec3d& eye, const Vec3d& d, std::size_t object) {
    auto shown = [&](std::uint32_t row) { return row >= kCellSolid || has(test::expected_row(data, row), object); };
    if (data.tree.nodes.empty())
        return shown(data.cell_row[std::size_t(data.grid.find(eye))]);
    ViewDirection direction = to_view_direction(d);
    std::uint32_t n = 0;
    while (data.tree.nodes[n].axis != ViewNode::kLeaf) {
        const ViewNode& node = data.tree.nodes[n];
        double split = node.axis < 3 ? data.tree.position(node.axis, node.split) : double(node.split);
        double value = node.axis < 3 ? eye[node.axis] : node.axis == 3 ? direction.theta : direction.phi;
        n = value >= split ? node.link : n + 1;
    }
    return shown(data.tree.nodes[n].link);
}

TEST(PvsRange, HoldsWhatAnyViewOfTheRangeSees) {
    EXPECT_TRUE(rc::check("an object that a ray of the range meets and whose cell shows it is in the answer", [](std::uint64_t seed) {
        PvsData data = seed % 2 ? random_pvs(seed, 60) : random_pvs_tree(seed, 60);
        Random random(seed, 3);
        std::vector<std::byte> bytes = *encode_pvs(data);
        Pvs pvs = *Pvs::open(bytes);
        Box3d space = data.tree.nodes.empty() ? data.grid.bounds : data.tree.bounds, eyes;
        double inset = random.uniform();
        for (int corner = 0; corner < 2; ++corner) {
            Vec3d p = space.centre();
            for (int k = 0; k < 3; ++k)
                p[k] += (random.uniform(space.min[k], space.max[k]) - p[k]) * inset * 0.99;
            eyes.extend(p);
        }
        PvsCursor cursor;
        for (int view = 0; view < 20 && !data.objects.empty(); ++view) {
            std::uint32_t o = random.below(static_cast<std::uint32_t>(data.objects.size()));
            Box3d bounds = pvs.object_bounds(o);
            Vec3d target, eye, up{random.uniform(-1, 1), random.uniform(-1, 1), random.uniform(-1, 1)};
            for (int k = 0; k < 3; ++k) {
                target[k] = random.uniform(bounds.min[k], bounds.max[k]);
                eye[k] = random.uniform(eyes.min[k], eyes.max[k]);
            }
            double half = std::pow(10, random.uniform(-3, 0.5)), aspect = random.uniform(0.3, 3);
            // A camera that looks so that the target lies somewhere within its picture.
            Vec3d d = target - eye, right = normalized(cross(d, up)), top = normalized(cross(right, d));
            Vec3d forward = d + (right * aspect * random.uniform(-1, 1) + top * random.uniform(-1, 1)) * (half * 0.5 * length(d));
            ViewRange range = camera_range(eyes, forward, top, half, aspect);
            (void)pvs.query_range(range, cursor);
            RC_ASSERT(cursor.visible_count <= data.objects.size());
            if (is_seen(data, eye, d, o))
                RC_ASSERT(has(cursor.visible, o));
        }
    }));
}

TEST(PvsRange, ATreeIsAskedByEye) {
    EXPECT_TRUE(rc::check("all directions together", [](std::uint64_t seed) {
        PvsData data = random_pvs_tree(seed, 100);
        Random random(seed, 4);
        std::vector<std::byte> bytes = *encode_pvs(data);
        Pvs pvs = *Pvs::open(bytes);
        PvsCursor cursor;
        for (int round = 0; round < 10; ++round) {
            Vec3d eye;
            for (int k = 0; k < 3; ++k)
                eye[k] = random.uniform(data.tree.bounds.min[k], data.tree.bounds.max[k]);
            (void)pvs.query(eye, cursor);
            for (int ray = 0; ray < 20 && !data.objects.empty(); ++ray) {
                Vec3d d{random.uniform(-1, 1), random.uniform(-1, 1), random.uniform(-1, 1)};
                std::uint32_t o = random.below(static_cast<std::uint32_t>(data.objects.size()));
                if (is_seen(data, eye, d, o))
                    RC_ASSERT(has(cursor.visible, o));
            }
        }
        (void)pvs.query(data.tree.bounds.max + Vec3d{1, 0, 0}, cursor);
        RC_ASSERT(cursor.everything && cursor.cell == -1);
        RC_ASSERT(cursor.visible_count == data.objects.size());
    }));
}

/// The three cells with 4 x 1 x 1 volumes over [0,4]x[0,1]x[0,1]: cell 0 sees volume 0, cell 1 volumes 1 and 2.
PvsData with_volumes() {
    PvsData data = three_cells();
    data.volumes = {{{0, 0, 0}, {4, 1, 1}}, {4, 1, 1}};
    data.rows = {1 | 1 << 4, 2 | 6 << 4, 12};
    return data;
}

TEST(PvsVolumes, AMovingBoxIsVisibleIfAVolumeThatItTouchesIs) {
    std::vector<std::byte> bytes = *encode_pvs(with_volumes());
    Pvs pvs = *Pvs::open(bytes);
    PvsCursor cursor;
    EXPECT_TRUE(pvs.is_box_visible({{3.1, 0.2, 0.2}, {3.2, 0.3, 0.3}}, cursor)) << "nothing asked yet";
    (void)pvs.query({1.5, 0.5, 0.5}, cursor);
    EXPECT_EQ(cursor.visible, (Words{2})) << "volumes are no objects";
    EXPECT_EQ(cursor.visible_count, 1u);
    EXPECT_EQ(cursor.volumes, (Words{6}));
    EXPECT_TRUE(pvs.is_box_visible({{1.1, 0.2, 0.2}, {1.2, 0.3, 0.3}}, cursor));
    EXPECT_FALSE(pvs.is_box_visible({{0.1, 0.2, 0.2}, {0.2, 0.3, 0.3}}, cursor));
    EXPECT_TRUE(pvs.is_box_visible({{0.1, 0.2, 0.2}, {1.2, 0.3, 0.3}}, cursor));
    EXPECT_TRUE(pvs.is_box_visible({{0.1, 0.2, 0.2}, {1, 0.3, 0.3}}, cursor)) << "touches volume 1";
    EXPECT_TRUE(pvs.is_box_visible({{3, 0.2, 0.2}, {3.2, 0.3, 0.3}}, cursor)) << "touches volume 2 from above";
    EXPECT_FALSE(pvs.is_box_visible({{3.001, 0.2, 0.2}, {4, 1, 1}}, cursor));
    EXPECT_TRUE(pvs.is_box_visible({{3.5, 0.2, 0.2}, {4.5, 0.3, 0.3}}, cursor)) << "partly outside";
    EXPECT_TRUE(pvs.is_box_visible({{3.5, std::nan(""), 0.2}, {3.6, 0.3, 0.3}}, cursor));
    (void)pvs.query({2.5, 0.5, 0.5}, cursor);
    EXPECT_FALSE(pvs.is_box_visible({{1.1, 0.2, 0.2}, {1.2, 0.3, 0.3}}, cursor));
    (void)pvs.query({9, 9, 9}, cursor);
    EXPECT_TRUE(pvs.is_box_visible({{1.1, 0.2, 0.2}, {1.2, 0.3, 0.3}}, cursor)) << "everything is visible";
    std::vector<std::byte> without = *encode_pvs(three_cells());
    Pvs no_volumes = *Pvs::open(without);
    PvsCursor other;
    (void)no_volumes.query({0.5, 0.5, 0.5}, other);
    EXPECT_TRUE(no_volumes.is_box_visible({{1.1, 0.2, 0.2}, {1.2, 0.3, 0.3}}, other));
}

TEST(PvsVolumes, EveryVolumeBitIsKept) {
    EXPECT_TRUE(rc::check("for any number of objects and volumes", [](std::uint64_t seed) {
        Random random(seed);
        PvsData data = random_pvs(seed, 200);
        test::add_volumes(random, data);
        std::vector<std::byte> bytes = *encode_pvs(data);
        Pvs pvs = *Pvs::open(bytes);
        PvsCursor cursor;
        for (std::uint64_t c = 0; c < data.grid.cells(); ++c) {
            (void)pvs.query(data.grid.cell(c).centre(), cursor);
            for (std::size_t v = 0; v < data.volumes.cells(); ++v)
                RC_ASSERT(has(cursor.volumes, v) == (data.cell_row[c] >= kCellSolid ||
                                                     has(test::expected_row(data, data.cell_row[c]), data.objects.size() + v)));
            for (std::size_t o = data.objects.size(); o < cursor.visible.size() * 64; ++o)
                RC_ASSERT(!has(cursor.visible, o));
        }
    }));
}

} // namespace
} // namespace antumbra
