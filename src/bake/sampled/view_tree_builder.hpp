// Builds the five-dimensional k-d tree of view space over one tile: splits where the two halves see different things,
// samples the leaves.
//
// Source: Gotsman, Sudarsky, Fayman 1999, section 4. Rays are cached for all candidate planes of a node, and handed on
// to its children (the paper's future work). Guarantee of the leaves: aggressive.
#pragma once

#include "bake/sampled/region_sampler.hpp"

#include <antumbra/pvs.hpp>

#include <cstddef>

namespace antumbra {

struct BuiltTree {
    std::vector<ViewNode> nodes; ///< preorder, as in ViewTree; the link of a leaf is an index into `leaves`
    std::vector<RegionSample> leaves;
    ExactStatistics work; ///< of exact trees
    std::uint64_t rays_reused = 0; ///< cached rays that a child did not have to cast again
};

/// Effectiveness of splitting C into A and B (section 4): how well the plane separates what is seen, times how well it
/// balances the volumes. Counts of objects; volumes in five dimensions.
constexpr double split_effectiveness(double seen_by_both, double seen, double volume_a, double volume_b) {
    double apart = volume_a > volume_b ? volume_a - volume_b : volume_b - volume_a;
    return (1 - seen_by_both / seen) * (1 - apart / (volume_a + volume_b));
}

/// The part of view space in a box of steps of `space` (whose bounds alone count).
SamplingRegion region_of(const Scene& scene, const ViewTree& space, const ViewRegion& box);

/// A pure function of (scene, options, space, tile).
BuiltTree build_view_tree(const SamplingScene& shared, const ViewTree& space, const ViewRegion& tile);

} // namespace antumbra
