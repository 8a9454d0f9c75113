// View trees for tests, drawn from a seed.
#pragma once

#include "pvs/random_pvs.hpp"

#include <vector>

namespace antumbra::test {

/// Appends the subtree of `box` in preorder, about `leaves` leaves, rows below row_count or special; `boxes` (may be
/// null) receives the box of each node.
inline void add_random_nodes(Random& random, const ViewRegion& box, std::uint32_t leaves, std::uint32_t row_count,
                             std::vector<ViewNode>& nodes, std::vector<ViewRegion>* boxes) {
    if (boxes)
        boxes->push_back(box);
    std::uint8_t axis = static_cast<std::uint8_t>(random.below(5));
    std::uint32_t width = box.high[axis] - box.low[axis];
    if (leaves <= 1 || width < 2) {
        std::uint32_t kind = random.below(12);
        std::uint32_t row = kind == 0 || row_count == 0 ? kCellNotBaked : kind == 1 ? kCellSolid : random.below(row_count);
        nodes.push_back({ViewNode::kLeaf, 0, row});
        return;
    }
    std::size_t self = nodes.size();
    std::uint32_t split = box.low[axis] + 1 + random.below(width - 1), first = 1 + random.below(leaves - 1);
    if (random.below(2))
        split = box.low[axis] + width / 2;
    nodes.push_back({axis, static_cast<std::uint16_t>(split), 0});
    ViewRegion below = box, above = box;
    below.high[axis] = above.low[axis] = split;
    add_random_nodes(random, below, first, row_count, nodes, boxes);
    nodes[self].link = static_cast<std::uint32_t>(nodes.size());
    add_random_nodes(random, above, leaves - first, row_count, nodes, boxes);
}

inline ViewTree random_view_tree(Random& random, std::uint32_t leaves, std::uint32_t row_count,
                                 std::vector<ViewRegion>* boxes = nullptr) {
    ViewTree tree;
    for (int k = 0; k < 3; ++k) {
        tree.bounds.min[k] = random.uniform(-100, 100);
        tree.bounds.max[k] = tree.bounds.min[k] + random.uniform(0.1, 100);
    }
    add_random_nodes(random, {}, leaves, row_count, tree.nodes, boxes);
    return tree;
}

/// random_pvs with a view tree in place of the grid and, in half of the cases, occludee volumes.
inline PvsData random_pvs_tree(std::uint64_t seed, std::uint32_t most_objects = 200) {
    PvsData data = random_pvs(seed, most_objects);
    Random random(seed, 99);
    data.cell_row.clear();
    data.grid = {};
    data.tree = random_view_tree(random, 1 + random.below(60), data.row_count);
    if (random.below(2))
        add_volumes(random, data);
    return data;
}

} // namespace antumbra::test
