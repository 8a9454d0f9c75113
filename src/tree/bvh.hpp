// A bounding-volume hierarchy over boxes: one builder and two node shapes for all users (rays, cullers).
//
// Built top-down with the binned surface-area heuristic (Wald, "On fast construction of SAH-based bounding
// volume hierarchies", 2007): at each node the items' centres are counted into bins along every axis, and the
// cheapest plane between bins wins. The tree is a pure function of the boxes and options, whatever the number
// of threads.
#pragma once

#include <antumbra/job.hpp>
#include <antumbra/math.hpp>

#include <cstdint>
#include <span>
#include <vector>

namespace antumbra {

/// A leaf (count > 0) holds the items Bvh::order[first .. first + count); an inner node's children are the
/// nodes first and first + 1.
struct BvhNode {
    Box3f box;
    std::uint32_t first = 0;
    std::uint32_t count = 0;
    bool leaf() const { return count > 0; }
};

struct Bvh {
    std::vector<BvhNode> nodes; ///< the root is nodes[0]; empty without items. Parents come before children.
    std::vector<std::uint32_t> order; ///< a permutation of the items
};

struct BvhOptions {
    std::uint32_t leaf_size = 8;  ///< most items in a leaf, at least 1
    std::uint32_t block_size = 1; ///< items tested at the price of one: a leaf costs its number of blocks
    float node_cost = 1.0f;       ///< price of visiting a node, in block tests
};

/// No path from the root is longer, whatever the boxes: sizes the stacks of walks.
inline constexpr int kMaxBvhDepth = 72;

/// O(n log n); about 0.4 s per million items on one thread. Boxes must be finite and not empty.
Bvh build_bvh(std::span<const Box3f> boxes, const BvhOptions& options = {}, const Job& job = {});

/// N children side by side, so that one SIMD instruction tests all. Unused slots have an empty box (min =
/// +inf, max = -inf), which no walk enters.
template <int N>
struct alignas(64) WideNode {
    float bounds[6][N];     ///< rows: min x, max x, min y, max y, min z, max z
    std::uint32_t first[N]; ///< leaf: first item in `order`; inner: node index
    std::uint32_t count[N]; ///< items of a leaf; 0: inner node or unused
};

template <int N>
struct WideBvh {
    std::vector<WideNode<N>> nodes; ///< the root is nodes[0]; empty without items
    std::vector<std::uint32_t> order;
};

/// Gives every node up to N children, such that the expected cost of a ray is least; small subtrees may
/// become leaves of at most options.leaf_size. Pass the options of the build. No deeper than the binary tree.
template <int N>
WideBvh<N> widen(Bvh bvh, const BvhOptions& options = {});

extern template WideBvh<4> widen<4>(Bvh bvh, const BvhOptions& options);
extern template WideBvh<8> widen<8>(Bvh bvh, const BvhOptions& options);
extern template WideBvh<16> widen<16>(Bvh bvh, const BvhOptions& options);

} // namespace antumbra
