// The tree that the cullers walk: every item is one leaf, boxes hold what is below, the wide form is the same tree.
#include "base/random.hpp"
#include "tree/object_tree.hpp"

#include <gtest/gtest.h>

#include <numeric>

namespace antumbra {
namespace {

std::vector<Box3f> random_boxes(Random& random, std::uint32_t count) {
    std::vector<Box3f> boxes(count);
    for (Box3f& box : boxes) {
        Vec3f at{float(random.uniform(-9, 9)), float(random.uniform(-9, 9)), float(random.uniform(-9, 9))};
        if (random.below(4) == 0) // many in one place
            at = {1, 1, 1};
        box.extend(at);
        box.extend(at + Vec3f{float(random.uniform()), 0.5f, 0.25f});
    }
    return boxes;
}

bool holds(const Box3f& outer, const Box3f& inner) {
    Box3f both = outer;
    both.extend(inner);
    return both == outer;
}

TEST(ObjectTree, holds_every_item_once_in_one_piece_below_each_node) {
    for (std::uint32_t trial = 0; trial < 60; ++trial) {
        Random random(61, trial);
        std::vector<Box3f> boxes = random_boxes(random, 1 + random.below(200));
        std::vector<std::uint32_t> order(boxes.size()), all(boxes.size());
        std::iota(all.begin(), all.end(), 0u);
        order = all;
        std::vector<BinaryNode> tree = build_binary_tree(boxes, order);
        ASSERT_EQ(tree.size(), 2 * boxes.size() - 1);
        std::vector<std::uint32_t> sorted = order;
        std::sort(sorted.begin(), sorted.end());
        ASSERT_EQ(sorted, all);
        for (std::size_t n = 0; n < tree.size(); ++n) {
            for (std::uint32_t i = tree[n].first; i < tree[n].first + tree[n].count; ++i)
                ASSERT_TRUE(holds(tree[n].box, boxes[order[i]]));
            if (tree[n].right == 0) {
                ASSERT_EQ(tree[n].count, 1u);
                continue;
            }
            const BinaryNode &left = tree[n + 1], &right = tree[tree[n].right];
            ASSERT_EQ(left.first, tree[n].first);
            ASSERT_EQ(left.first + left.count, right.first);
            ASSERT_EQ(left.count + right.count, tree[n].count);
        }
    }
}

TEST(ObjectTree, the_wide_form_reaches_every_item_once) {
    Random random(62);
    std::vector<Box3f> boxes = random_boxes(random, 777);
    std::vector<std::uint32_t> order(boxes.size());
    std::iota(order.begin(), order.end(), 0u);
    std::vector<CullNode> wide = collapse(build_binary_tree(boxes, order), order);
    std::vector<int> reached(boxes.size(), 0);
    for (const CullNode& node : wide)
        for (std::uint32_t slot = 0; slot < node.used; ++slot) {
            for (std::uint32_t i = node.first[slot]; i < node.first[slot] + node.count[slot]; ++i)
                ASSERT_TRUE(holds(node.box(int(slot)), boxes[order[i]]));
            if (node.child[slot] & kObjectChild)
                ++reached[node.child[slot] & ~kObjectChild];
        }
    for (int times : reached)
        EXPECT_EQ(times, 1);
}

// Whoever puts all boxes in one place does not make it deep.
TEST(ObjectTree, of_equal_boxes_is_no_deeper_than_allowed) {
    std::vector<Box3f> boxes(5000, Box3f{{0, 0, 0}, {1, 1, 1}});
    std::vector<std::uint32_t> order(boxes.size());
    std::iota(order.begin(), order.end(), 0u);
    std::vector<BinaryNode> tree = build_binary_tree(boxes, order);
    std::vector<int> depth(tree.size(), 0);
    for (std::size_t n = 0; n < tree.size(); ++n)
        if (tree[n].right != 0) {
            depth[n + 1] = depth[tree[n].right] = depth[n] + 1;
            ASSERT_LE(depth[n + 1], kTreeDepth);
        }
}

} // namespace
} // namespace antumbra
