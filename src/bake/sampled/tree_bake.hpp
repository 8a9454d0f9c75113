// The sampled bake over the k-d tree of view space: tiles as units, merged into one tree.
#pragma once

#include "bake/resumable.hpp"
#include "bake/sampled/view_tree_builder.hpp"

namespace antumbra {

struct TreeBake {
    ViewTree tree;                    ///< the link of a leaf is an index into `leaves`, or kCellNotBaked: another shard's
    std::vector<RegionSample> leaves; ///< in preorder
    std::uint64_t rays_reused = 0;
    std::uint64_t tiles = 0, tiles_resumed = 0;
};

/// A pure function of (scene, options). View space is the scene's box times options.tree.view_space about its centre.
/// Statuses as run_units; `key` names scene and options.
Result<TreeBake> bake_view_tree(const SamplingScene& shared, const std::string& key, const Job& job);

} // namespace antumbra
