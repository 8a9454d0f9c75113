// The bake over a k-d tree of view space, sampled or (over space alone) exact: tiles as units, merged into one tree.
#pragma once

#include "bake/exact/exact_cells.hpp"
#include "bake/resumable.hpp"
#include "bake/sampled/view_tree_builder.hpp"

namespace antumbra {

struct TreeBake {
    ViewTree tree;                    ///< the link of a leaf is an index into `leaves`, or kCellNotBaked: another shard's
    std::vector<RegionSample> leaves; ///< in preorder
    std::uint64_t rays_reused = 0;
    ExactStatistics work;   ///< of exact bakes
    std::uint64_t plan = 0; ///< PartDescription::plan
    std::uint64_t tiles = 0, tiles_resumed = 0;
};

/// A pure function of (scene, options). View space is the scene's box times options.tree.view_space about its centre; of
/// exact bakes, if options.where is not empty, the box around that. Statuses as run_units.
Result<TreeBake> bake_view_tree(const SamplingScene& shared, const ExactCells* exact, const Job& job);

} // namespace antumbra
