// Builds the five-dimensional k-d tree of view space over one tile: splits where the two halves see different things,
// samples the leaves.
//
// Source: Gotsman, Sudarsky, Fayman 1999, section 4. Rays are cached for all candidate planes of a node, and handed on
// to its children (the paper's future work). Guarantee of the leaves: aggressive.
#pragma once

#include "bake/sampled/region_sampler.hpp"

#include <cstddef>

namespace antumbra {

/// A node of the tree under construction. Children follow their parent; children[0] is the side below the plane.
struct BuiltNode {
    int axis = -1;    ///< ViewAxis of the split, -1: leaf
    double split = 0; ///< local coordinate, or the angle number of view_region.hpp
    std::uint32_t children[2] = {0, 0};
    std::uint32_t leaf = 0; ///< into BuiltTree::leaves
};

struct BuiltTree {
    std::vector<BuiltNode> nodes; ///< root first
    std::vector<RegionSample> leaves;
    std::uint64_t rays_reused = 0; ///< cached rays that a child did not have to cast again
};

/// Effectiveness of splitting C into A and B (section 4): how well the plane separates what is seen, times how well it
/// balances the volumes. Counts of objects; volumes in five dimensions.
constexpr double split_effectiveness(double seen_by_both, double seen, double volume_a, double volume_b) {
    double apart = volume_a > volume_b ? volume_a - volume_b : volume_b - volume_a;
    return (1 - seen_by_both / seen) * (1 - apart / (volume_a + volume_b));
}

/// A pure function of (scene, options, tile). `tile` is local.
BuiltTree build_view_tree(const SamplingScene& shared, const ViewRegion& tile);

} // namespace antumbra
