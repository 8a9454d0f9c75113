// Space cut into cells by planes along the axes: where occluder sets belong to.
#pragma once

#include "base/bytes.hpp"
#include "tree/kd_tree.hpp"

#include <antumbra/status.hpp>

#include <array>

namespace antumbra {

/// A binary tree of planes over a box. Plain data; reading is thread-safe.
struct SpaceCells {
    /// The child below the plane follows its parent.
    struct Node {
        std::uint32_t right = 0; ///< 0: a leaf
        std::uint32_t leaf = 0;  ///< of a leaf: its number
        float at = 0;            ///< the plane; who is on it belongs above
        std::uint8_t axis = 0;
    };
    static constexpr std::uint32_t kMostDepth = 255;

    Box3d bounds;
    std::vector<Node> nodes; ///< preorder; empty: no cells
    std::uint32_t leaves = 0;

    /// The leaf that holds `place`; outside of the bounds the nearest in the order of planes. NaN gives some leaf.
    std::uint32_t find(const Vec3d& place) const;
    /// Of each leaf, by its number.
    std::vector<Box3d> boxes() const;

    /// A grid, leaf (i, j, k) with the number i + nx (j + ny k).
    static SpaceCells of_grid(const Box3d& bounds, const std::array<std::uint32_t, 3>& count);
    /// The nodes of the tree down to `depth` edges from its root; leaves in preorder.
    static SpaceCells of_tree(const KdTree& tree, std::uint32_t depth);

    /// Nodes in preorder, a byte each: the axis, and then an f32 (the plane), or 3 for a leaf.
    void encode(ByteWriter& out) const;
    /// From `at`, which moves behind them; leaves in preorder. Empty for anything that encode cannot have written.
    static SpaceCells decode(std::span<const std::byte> bytes, std::size_t& at, const Box3d& bounds);
};

} // namespace antumbra
