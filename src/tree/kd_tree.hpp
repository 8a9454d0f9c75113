// A kd-tree over boxes whose cells fill space: what the papers on culling from a point walk. Items that lie on both
// sides of a plane are in both children, so that whatever is known of a cell holds for the part of its items inside.
#pragma once

#include <antumbra/math.hpp>

#include <cstdint>
#include <span>
#include <vector>

namespace antumbra {

/// Where cells are cut. Both rules cut at boundaries of the items' boxes.
enum class KdRule : std::uint8_t {
    /// Coorg, Teller 1997: the axes take turns; the plane that leaves the most equal numbers on its sides.
    balanced_counts,
    /// Bittner, Havran, Slavik 1998, section 2.2: across the largest extent; among the boundaries near the spatial
    /// median the one that cuts the fewest items.
    fewest_splits,
};

struct KdTreeOptions {
    KdRule rule = KdRule::fewest_splits;
    std::uint32_t leaf_items = 4;  ///< cells with so many are not cut, at least 1
    std::uint32_t most_depth = 40; ///< at most kMaxKdDepth
    /// fewest_splits: how far from the median boundaries are looked at, as a share of the extent. Where there are none
    /// all count, the nearest to the median first.
    double window = 0.125;
    double most_copies = 4; ///< the leaves list at most about so many times the items
};

inline constexpr std::uint32_t kMaxKdDepth = 64;

/// A leaf (right == 0) lists items[first .. first + count), each once, ascending. The left child follows its parent.
struct KdNode {
    Box3f cell;
    std::uint32_t right = 0;
    std::uint32_t first = 0, count = 0;
    bool leaf() const { return right == 0; }
};

struct KdTree {
    std::vector<KdNode> nodes; ///< the root is nodes[0], its cell is around all items; empty without items
    std::vector<std::uint32_t> items;
};

/// `items` of `boxes` (finite, not empty). A pure function of its arguments. O(n log^2 n), about a second per million.
KdTree build_kd_tree(std::span<const Box3f> boxes, std::span<const std::uint32_t> items,
                     const KdTreeOptions& options = {});

} // namespace antumbra
