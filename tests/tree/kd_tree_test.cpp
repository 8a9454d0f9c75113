#include "tree/kd_tree.hpp"

#include "base/random.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <numeric>
#include <set>

namespace antumbra {
namespace {

std::vector<Box3f> random_boxes(Random& random, std::uint32_t count) {
    std::vector<Box3f> boxes(count);
    for (Box3f& box : boxes)
        for (int k = 0; k < 3; ++k) {
            box.min[k] = float(random.below(64));
            box.max[k] = box.min[k] + (random.below(4) ? float(random.below(8)) : 0);
        }
    return boxes;
}

KdTree build(const std::vector<Box3f>& boxes, const KdTreeOptions& options) {
    std::vector<std::uint32_t> all(boxes.size());
    std::iota(all.begin(), all.end(), 0u);
    return build_kd_tree(boxes, all, options);
}

/// Children fill their parent's cell, and every item is in each leaf that it properly overlaps.
void check(const std::vector<Box3f>& boxes, const KdTree& tree, const KdTreeOptions& options) {
    ASSERT_FALSE(tree.nodes.empty());
    std::vector<std::set<std::uint32_t>> listed(tree.nodes.size());
    for (std::size_t n = 0; n < tree.nodes.size(); ++n) {
        const KdNode& node = tree.nodes[n];
        if (node.leaf()) {
            listed[n].insert(tree.items.begin() + node.first, tree.items.begin() + node.first + node.count);
            ASSERT_EQ(listed[n].size(), node.count);
            continue;
        }
        const Box3f &low = tree.nodes[n + 1].cell, &high = tree.nodes[node.right].cell;
        int cut = 0;
        for (int axis = 0; axis < 3; ++axis) {
            ASSERT_EQ(low.min[axis], node.cell.min[axis]);
            ASSERT_EQ(high.max[axis], node.cell.max[axis]);
            if (low.max[axis] == node.cell.max[axis] && high.min[axis] == node.cell.min[axis])
                continue;
            ASSERT_EQ(low.max[axis], high.min[axis]);
            ++cut;
        }
        ASSERT_EQ(cut, 1);
    }
    for (std::size_t n = 0; n < tree.nodes.size(); ++n) {
        if (!tree.nodes[n].leaf())
            continue;
        for (std::uint32_t item = 0; item < boxes.size(); ++item) {
            bool overlaps = true;
            for (int axis = 0; axis < 3; ++axis)
                overlaps &= boxes[item].min[axis] < tree.nodes[n].cell.max[axis] &&
                            boxes[item].max[axis] > tree.nodes[n].cell.min[axis];
            if (overlaps) {
                ASSERT_TRUE(listed[n].count(item));
            }
            if (listed[n].count(item)) {
                ASSERT_TRUE(boxes[item].overlaps(tree.nodes[n].cell));
            }
        }
    }
    // Flat items are properly in no cell, but must be somewhere.
    std::set<std::uint32_t> everything;
    for (const auto& list : listed)
        everything.insert(list.begin(), list.end());
    EXPECT_EQ(everything.size(), boxes.size());
    EXPECT_LE(double(tree.items.size()), options.most_copies * double(boxes.size()));
}

TEST(KdTree, holds_everything_where_it_is) {
    Random random(11);
    for (int trial = 0; trial < 60; ++trial) {
        std::vector<Box3f> boxes = random_boxes(random, 1 + random.below(200));
        KdTreeOptions options;
        options.rule = trial % 2 ? KdRule::balanced_counts : KdRule::fewest_splits;
        options.leaf_items = 1 + random.below(6);
        options.window = random.uniform(0, 0.5);
        check(boxes, build(boxes, options), options);
        if (HasFatalFailure())
            FAIL() << "trial " << trial;
    }
}

TEST(KdTree, the_fewest_splits_near_the_median) {
    // Boundaries at 40, 50 and 55 of 0..100: the plane at 50 cuts one, that at 40 none, that at 55 separates nothing.
    std::vector<Box3f> boxes{{{0, 0, 0}, {40, 1, 1}}, {{40, 0, 0}, {55, 1, 1}}, {{50, 0, 0}, {100, 1, 1}}};
    KdTreeOptions options;
    options.leaf_items = 1;
    options.window = 0.09;
    EXPECT_EQ(build(boxes, options).nodes[1].cell.max.x, 50) << "40 is outside of the window";
    options.window = 0.2;
    EXPECT_EQ(build(boxes, options).nodes[1].cell.max.x, 40);
}

TEST(KdTree, balanced_counts_in_turn) {
    std::vector<Box3f> boxes;
    for (int i = 0; i < 8; ++i)
        boxes.push_back({{float(i * i), 0, 0}, {float(i * i) + 0.5f, 100, 1}});
    KdTreeOptions options;
    options.rule = KdRule::balanced_counts;
    options.leaf_items = 4;
    KdTree tree = build(boxes, options);
    ASSERT_EQ(tree.nodes.size(), 3u);
    EXPECT_EQ(tree.nodes[1].count, 4u) << "x first, although y is longer";
    EXPECT_EQ(tree.nodes[2].count, 4u);
}

TEST(KdTree, what_cannot_be_separated_is_a_leaf) {
    std::vector<Box3f> boxes(10, Box3f{{1, 1, 1}, {2, 2, 2}});
    KdTree tree = build(boxes, {});
    ASSERT_EQ(tree.nodes.size(), 1u);
    EXPECT_EQ(tree.nodes[0].count, 10u);
    EXPECT_TRUE(build({}, {}).nodes.empty());
}

} // namespace
} // namespace antumbra
