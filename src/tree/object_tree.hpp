// The tree over objects that the cullers walk: binary, one object to a leaf, and the same with up to eight children to a
// node.
//
// A variant beside bvh.hpp, and meant to stay one. That tree is made for rays: its leaves hold several items, its splits
// weigh blocks of them, and its wide form is chosen for the cost of a ray. Cullers want every object to be a child of
// its own, items below any node in one piece, bounded depth, and a shape that can be stored (chunk CTRE). `frustum-scalar`, the
// denominator of all ratios, walks the binary form: other splits would change what every figure is compared with.
#pragma once

#include <antumbra/math.hpp>

#include <cstdint>
#include <span>
#include <vector>

namespace antumbra {

/// Node of the binary tree, depth first: the left child follows its parent. Objects below any node are contiguous
/// in CullScene::Data::order.
struct BinaryNode {
    Box3f box;
    std::uint32_t right = 0; ///< index of the right child; 0: a leaf
    std::uint32_t first = 0, count = 0;
};

inline constexpr std::uint32_t kObjectChild = 0x80000000u;
inline constexpr int kWidth = 8;

/// Eight children, structure of arrays. A child is an inner node (index) or one object (index | kObjectChild).
/// Slots from `used` on repeat slot 0, so that arithmetic on them is harmless.
struct alignas(64) CullNode {
    float min[3][kWidth];
    float max[3][kWidth];
    std::uint32_t child[kWidth];
    std::uint32_t first[kWidth]; ///< objects below a child: order[first .. first + count)
    std::uint32_t count[kWidth];
    std::uint32_t used = 0;

    std::uint32_t mask() const { return (1u << used) - 1; }
    Box3f box(int slot) const {
        return {{min[0][slot], min[1][slot], min[2][slot]}, {max[0][slot], max[1][slot], max[2][slot]}};
    }
};

/// Binned surface-area heuristic (16 bins), one object per leaf. `order` lists the objects to take and is
/// permuted. No path is longer than kTreeDepth.
inline constexpr int kTreeDepth = 96;
std::vector<BinaryNode> build_binary_tree(std::span<const Box3f> bounds, std::vector<std::uint32_t>& order);

/// Opens the largest children of the binary tree until every node has up to eight.
std::vector<CullNode> collapse(const std::vector<BinaryNode>& binary, const std::vector<std::uint32_t>& order);

} // namespace antumbra
