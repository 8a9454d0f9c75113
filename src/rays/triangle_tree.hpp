// Triangles in blocks for SIMD tests, and the tree above them.
#pragma once

#include "tree/bvh.hpp"

#include <antumbra/scene.hpp>

#include <vector>

namespace antumbra::rays {

inline constexpr int kLanes = 8;  ///< triangles in a block
inline constexpr int kWidth = 16; ///< children of a node
using Node = WideNode<kWidth>;    ///< `first` and `count` of a leaf are in blocks

/// Triangles side by side. Corners are sorted by position, so that t does not depend on the order in a file.
struct alignas(32) Block {
    float corner[3][3]
                [kLanes]; ///< [corner][axis]; unused lanes hold one point three times, which is never hit
    std::uint32_t triangle[kLanes]; ///< kNoTriangle in unused lanes
    std::uint8_t flipped = 0;       ///< bit per lane: sorting turned the winding around
    std::uint8_t double_sided = 0;  ///< bit per lane
};

struct TreeView {
    const Node* nodes = nullptr; ///< null: nothing to hit
    const Block* blocks = nullptr;
};

struct TriangleTree {
    std::vector<Node> nodes; ///< the root is nodes[0]
    std::vector<Block> blocks;
    TreeView view() const { return {nodes.empty() ? nullptr : nodes.data(), blocks.data()}; }
    std::size_t bytes() const { return nodes.size() * sizeof(Node) + blocks.size() * sizeof(Block); }
};

/// A tree over some of the scene's triangles. The options are those of the builder but for the block size.
TriangleTree build_triangle_tree(const Scene& scene, std::span<const std::uint32_t> triangles,
                                 BvhOptions options = {}, const Job& job = {});

} // namespace antumbra::rays
