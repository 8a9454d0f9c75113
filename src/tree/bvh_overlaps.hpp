// The items of a tree whose nodes satisfy a condition on boxes, such as to overlap one.
#pragma once

#include "tree/bvh.hpp"

namespace antumbra {

/// Calls visit(item) for every item of every leaf on whose way from the root `enters(box)` holds for all nodes, in no order
/// that callers may rely on; ends at once when visit returns true, and then returns true. O(nodes entered).
template <class Enters, class Visit>
bool find_in_bvh(const Bvh& tree, Enters&& enters, Visit&& visit) {
    std::uint32_t todo[kMaxBvhDepth + 1];
    int count = 0;
    if (!tree.nodes.empty())
        todo[count++] = 0;
    while (count > 0) {
        const BvhNode& node = tree.nodes[todo[--count]];
        if (!enters(node.box))
            continue;
        if (!node.leaf()) {
            todo[count++] = node.first;
            todo[count++] = node.first + 1;
            continue;
        }
        for (std::uint32_t i = node.first; i < node.first + node.count; ++i)
            if (visit(tree.order[i]))
                return true;
    }
    return false;
}

} // namespace antumbra
