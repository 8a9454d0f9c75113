#include "pvs/direction.hpp"
#include "pvs/random_pvs.hpp"
#include "pvs/random_tree.hpp"

#include <gtest/gtest.h>
#include <rapidcheck.h>

#include <cmath>

namespace antumbra {
namespace {

using test::random_pvs_tree;
using test::random_view_tree;

constexpr double kQuarter = 16384;

TEST(ViewDirection, CountsQuarterTurnsFromXOverZ) {
    auto theta = [](Vec3d d) { return to_view_direction(d).theta; };
    auto phi = [](Vec3d d) { return to_view_direction(d).phi; };
    EXPECT_EQ(theta({1, 0, 0}), 0);
    EXPECT_EQ(theta({1, 0, 1}), kQuarter / 2);
    EXPECT_EQ(theta({0, 0, 1}), kQuarter);
    EXPECT_EQ(theta({-3, 0, 1}), 1.75 * kQuarter);
    EXPECT_EQ(theta({-1, 0, 0}), 2 * kQuarter);
    EXPECT_EQ(theta({0, 0, -1}), 3 * kQuarter);
    EXPECT_EQ(theta({1, 5, -1}), 3.5 * kQuarter);
    EXPECT_EQ(phi({0, -2, 0}), 0);
    EXPECT_EQ(phi({1, 0, 7}), 32768);
    EXPECT_EQ(phi({1, 2, 1}), 49152);
    EXPECT_EQ(phi({0, 9, 0}), 65536);
}

Vec3d random_direction(Random& random) {
    Vec3d d{random.uniform(-1, 1), random.uniform(-1, 1), random.uniform(-1, 1)};
    if (random.below(4) == 0)
        d[static_cast<int>(random.below(3))] = 0;
    return d == Vec3d{} ? Vec3d{0, 1, 0} : d;
}

TEST(ViewDirection, ThereAndBack) {
    EXPECT_TRUE(rc::check("from_view_direction(to_view_direction(d)) is parallel to d", [](std::uint64_t seed) {
        Random random(seed);
        Vec3d d = normalized(random_direction(random));
        Vec3d back = normalized(from_view_direction(to_view_direction(d)));
        RC_ASSERT(length(back - d) < 1e-9);
    }));
}

bool covers(const DirectionBoxes& boxes, const Vec3d& d) {
    ViewDirection at = to_view_direction(d);
    for (std::size_t i = 0; i < boxes.count; ++i) {
        const DirectionBox& box = boxes.boxes[i];
        if (at.theta >= box.theta_low && at.theta <= box.theta_high && at.phi >= box.phi_low && at.phi <= box.phi_high)
            return true;
    }
    return false;
}

TEST(DirectionBoxes, HoldEveryDirectionOfTheFrustum) {
    EXPECT_TRUE(rc::check("wide and narrow, over poles, over the end of the turn, rolled", [](std::uint64_t seed) {
        Random random(seed);
        Vec3d forward = random_direction(random);
        std::uint32_t kind = random.below(4);
        if (kind == 0) // a pole in view or at its rim
            forward = {random.uniform(-0.1, 0.1), random.below(2) ? 1.0 : -1.0, random.uniform(-0.1, 0.1)};
        if (kind == 1) // the end of the turn
            forward = {1, random.uniform(-0.1, 0.1), random.uniform(-1e-3, 1e-3)};
        double half = std::pow(10, random.uniform(-6, 1));
        ViewRange range = camera_range({}, forward, random_direction(random), half, random.uniform(0.2, 4));
        DirectionBoxes boxes = cover_directions(range);
        for (int round = 0; round < 50; ++round) {
            Vec3d d;
            for (const Vec3d& corner : range.corners)
                d += corner * (random.below(3) ? random.uniform() : 0);
            if (range.all_directions || d == Vec3d{})
                continue;
            RC_ASSERT(covers(boxes, d));
        }
    }));
}

TEST(DirectionBoxes, AreTight) {
    // Toward +x, 90 degrees both ways: corners (1, +-1, +-1).
    DirectionBoxes boxes = cover_directions(camera_range({}, {1, 0, 0}, {0, 1, 0}, 1, 1));
    ASSERT_EQ(boxes.count, 4u);
    for (std::size_t i = 0; i < 4; ++i) {
        const DirectionBox& box = boxes.boxes[i];
        bool first = box.theta_low == 0;
        EXPECT_EQ(box.theta_low, first ? 0u : 57343u);
        EXPECT_EQ(box.theta_high, first ? 8193u : 65536u);
        bool up = box.phi_low >= 32767;
        EXPECT_EQ(box.phi_low, up ? 32767u : 16383u);
        EXPECT_EQ(box.phi_high, up ? 49153u : 32769u);
    }
}

TEST(DirectionBoxes, NearAPoleEveryThetaIsSeen) {
    DirectionBoxes boxes = cover_directions(camera_range({}, {0, -1, 0}, {1, 0, 0}, 0.01, 1));
    EXPECT_EQ(boxes.count, 4u);
    for (int i = 0; i < 16; ++i) {
        ViewRegion slice;
        slice.low[3] = std::uint32_t(i) * 4096;
        slice.high[3] = slice.low[3] + 4096;
        slice.high[4] = 10;
        EXPECT_TRUE(boxes.touch(slice));
        slice.low[4] = 1000;
        slice.high[4] = 65536;
        EXPECT_FALSE(boxes.touch(slice));
    }
}

TEST(CameraRange, SenselessValuesMeanAllDirections) {
    double nan = std::nan("");
    EXPECT_TRUE(camera_range({}, {0, 0, 0}, {0, 1, 0}, 1, 1).all_directions);
    EXPECT_TRUE(camera_range({}, {0, 1, 0}, {0, -2, 0}, 1, 1).all_directions);
    EXPECT_TRUE(camera_range({}, {nan, 1, 0}, {0, 1, 0}, 1, 1).all_directions);
    EXPECT_TRUE(camera_range({}, {1, 0, 0}, {0, 1, 0}, nan, 1).all_directions);
    EXPECT_TRUE(camera_range({}, {1, 0, 0}, {0, 1, 0}, 1e300, 1).all_directions);
    EXPECT_TRUE(camera_range({}, {1, 0, 0}, {0, 1, 0}, 1, -1).all_directions);
    EXPECT_FALSE(camera_range({}, {1e200, 0, 0}, {0, 1e-200, 0}, 1, 1).all_directions);
}

/// x split in the middle; above it the turn is split at half.
ViewTree small_tree() {
    ViewTree tree;
    tree.bounds = {{0, 0, 0}, {2, 1, 1}};
    tree.nodes = {{0, 32768, 2}, {ViewNode::kLeaf, 0, 0}, {3, 32768, 4}, {ViewNode::kLeaf, 0, 1}, {ViewNode::kLeaf, 0, 2}};
    return tree;
}

std::vector<std::uint32_t> leaves_of(const ViewTree& tree, const ViewRange& range) {
    std::vector<std::uint32_t> leaves;
    EXPECT_TRUE(tree.find_leaves(range, leaves));
    return leaves;
}

TEST(ViewTree, FindsTheLeavesThatARangeTouches) {
    ViewTree tree = small_tree();
    ASSERT_TRUE(tree.check(3));
    Box3d left{{0.5, 0.5, 0.5}, {0.5, 0.5, 0.5}}, right{{1.5, 0.5, 0.5}, {1.5, 0.5, 0.5}}, both{{0.5, 0, 0}, {1.5, 1, 1}};
    using Leaves = std::vector<std::uint32_t>;
    EXPECT_EQ(leaves_of(tree, {left}), (Leaves{1}));
    EXPECT_EQ(leaves_of(tree, {right}), (Leaves{3, 4}));
    EXPECT_EQ(leaves_of(tree, {both}), (Leaves{1, 3, 4}));
    EXPECT_EQ(leaves_of(tree, camera_range(right, {0, 0, 1}, {0, 1, 0}, 0.5, 1)), (Leaves{3}));
    EXPECT_EQ(leaves_of(tree, camera_range(right, {0, 0, -1}, {0, 1, 0}, 0.5, 1)), (Leaves{4}));
    EXPECT_EQ(leaves_of(tree, camera_range(right, {1, 0, 0.1}, {0, 1, 0}, 0.5, 1)), (Leaves{3, 4})) << "over theta 0";
    EXPECT_EQ(leaves_of(tree, camera_range(right, {-1, 0, 0}, {0, 1, 0}, 0.5, 1)), (Leaves{3, 4})) << "over a split";
    Box3d on_split{{1, 0.5, 0.5}, {1, 0.5, 0.5}};
    EXPECT_EQ(leaves_of(tree, {on_split}), (Leaves{3, 4}));
}

TEST(ViewTree, KnowsNothingOutside) {
    ViewTree tree = small_tree();
    std::vector<std::uint32_t> leaves;
    EXPECT_FALSE(tree.find_leaves({{{-0.1, 0, 0}, {0.5, 1, 1}}}, leaves));
    EXPECT_FALSE(tree.find_leaves({{{0, 0, 0}, {0.5, 1, std::nan("")}}}, leaves));
    EXPECT_FALSE(tree.find_leaves({{{1, 0, 0}, {0.5, 1, 1}}}, leaves)) << "an empty box";
    EXPECT_FALSE(ViewTree{}.find_leaves({{{0, 0, 0}, {0, 0, 0}}}, leaves));
    EXPECT_TRUE(leaves.empty());
}

TEST(ViewTree, CheckRefusesWhatIsNoTree) {
    auto refused = [](auto change, const char* part) {
        ViewTree tree = small_tree();
        change(tree.nodes);
        Status status = tree.check(3);
        EXPECT_EQ(status.code(), ErrorCode::usage);
        EXPECT_NE(status.message().find(part), std::string::npos) << status.message();
    };
    using Nodes = std::vector<ViewNode>;
    refused([](Nodes& n) { n[4].link = 3; }, "node 4 of the view tree refers to a row");
    refused([](Nodes& n) { n[4].axis = 6; }, "node 4 of the view tree splits no axis");
    refused([](Nodes& n) { n[0].split = 0; }, "node 0 of the view tree splits outside");
    refused([](Nodes& n) { n[2] = {0, 32768, 4}; }, "node 2 of the view tree splits outside");
    refused([](Nodes& n) { n[0].link = 3; }, "is not where its parent says");
    refused([](Nodes& n) { n.pop_back(); }, "node 4 of the view tree is missing");
    refused([](Nodes& n) { n.push_back(n.back()); }, "node 5 of the view tree belongs to no parent");
    ViewTree tree = small_tree();
    tree.bounds.max.y = NAN;
    EXPECT_EQ(tree.check(3).code(), ErrorCode::usage);
    for (std::size_t depth : {ViewTree::kMostDepth, ViewTree::kMostDepth + 1}) {
        Nodes chain; // each child above is inner again
        for (std::uint32_t d = 0; d < depth; ++d) {
            chain.push_back({0, static_cast<std::uint16_t>(d + 1), 2 * d + 2});
            chain.push_back({ViewNode::kLeaf, 0, 0});
        }
        chain.push_back({ViewNode::kLeaf, 0, 0});
        tree = small_tree();
        tree.nodes = chain;
        EXPECT_EQ(tree.check(3).ok(), depth == ViewTree::kMostDepth);
    }
}

TEST(ViewTree, ARangeFindsEveryLeafThatHoldsOneOfItsViews) {
    EXPECT_TRUE(rc::check("any viewpoint of the box, any direction of the frustum", [](std::uint64_t seed) {
        Random random(seed);
        std::vector<ViewRegion> boxes;
        ViewTree tree = random_view_tree(random, 40, 7, &boxes);
        RC_ASSERT(tree.check(7).ok());
        Box3d eyes;
        for (int corner = 0; corner < 2; ++corner) {
            Vec3d p;
            for (int k = 0; k < 3; ++k)
                p[k] = random.uniform(tree.bounds.min[k], tree.bounds.max[k]);
            eyes.extend(p);
        }
        ViewRange range = camera_range(eyes, random_direction(random), random_direction(random),
                                       std::pow(10, random.uniform(-3, 0.5)), random.uniform(0.5, 2));
        std::vector<std::uint32_t> found;
        RC_ASSERT(tree.find_leaves(range, found));
        for (int round = 0; round < 30; ++round) {
            Vec3d eye, d = random_direction(random);
            for (int k = 0; k < 3; ++k)
                eye[k] = random.uniform(eyes.min[k], eyes.max[k]);
            if (!range.all_directions)
                for (const Vec3d& corner : range.corners)
                    d = corner * random.uniform() + (&corner == range.corners.data() ? Vec3d{} : d);
            ViewDirection at = to_view_direction(d);
            std::size_t holding = 0;
            for (std::uint32_t n = 0; n < tree.nodes.size(); ++n) {
                const ViewRegion& box = boxes[n];
                if (tree.nodes[n].axis != ViewNode::kLeaf || !tree.spatial_box(box).contains(eye) ||
                    at.theta < box.low[3] || at.theta > box.high[3] || at.phi < box.low[4] || at.phi > box.high[4])
                    continue;
                ++holding;
                RC_ASSERT(std::find(found.begin(), found.end(), n) != found.end());
            }
            RC_ASSERT(holding >= 1u);
        }
    }));
}

TEST(ViewTree, IsKeptByTheFile) {
    EXPECT_TRUE(rc::check("tree, rows of leaves, volumes", [](std::uint64_t seed) {
        PvsData data = random_pvs_tree(seed);
        Result<std::vector<std::byte>> bytes = encode_pvs(data);
        RC_ASSERT(bytes.ok());
        Result<Pvs> pvs = Pvs::open(*bytes);
        RC_ASSERT(pvs.ok());
        RC_ASSERT(pvs->tree().bounds == data.tree.bounds);
        RC_ASSERT(pvs->volumes().bounds == data.volumes.bounds);
        RC_ASSERT(pvs->volumes().count == data.volumes.count);
        RC_ASSERT(pvs->tree().nodes.size() == data.tree.nodes.size());
        std::vector<std::uint64_t> words(pvs->words_per_row());
        for (std::size_t n = 0; n < data.tree.nodes.size(); ++n) {
            const ViewNode &given = data.tree.nodes[n], &kept = pvs->tree().nodes[n];
            RC_ASSERT(given.axis == kept.axis && given.split == kept.split);
            if (given.axis != ViewNode::kLeaf || given.link >= kCellSolid) {
                RC_ASSERT(given.link == kept.link);
                continue;
            }
            pvs->decode_row(kept.link, words);
            RC_ASSERT(words == test::expected_row(data, given.link));
        }
    }));
}

} // namespace
} // namespace antumbra
