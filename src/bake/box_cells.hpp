// Boxes of viewpoints as the cells themselves: a k-d tree over space whose leaves are the boxes.
#pragma once

#include <antumbra/bake.hpp>

namespace antumbra {

struct BoxCells {
    ViewTree tree;                   ///< the link of a leaf is an index into `regions`, or kCellNotBaked
    std::vector<ViewRegion> regions; ///< the cells, in preorder
};

/// Boxes in world coordinates. Their faces are moved to the nearest of 65,536 places along each axis of the box around all of
/// them, each a whole number of the scene's steps (no move at all where that box is so small); none gets thinner than one.
/// A box that overlaps another, or that no plane separates from the rest, is cut, and its pieces are cells. What no box
/// holds is not baked. ErrorCode::usage for boxes that are empty or not finite, or none; limit beyond 2^16 boxes, or where
/// they need a deeper tree than the format allows. O(n log^2 n) for boxes that can be told apart.
Result<BoxCells> lay_box_cells(const Scene& scene, std::span<const Box3d> boxes);

/// FNV-1a over bounds and nodes.
std::uint64_t name_of(const ViewTree& tree);

} // namespace antumbra
