// The sampled bake over the k-d tree of view space: tiles as units, merged into one tree.
#pragma once

#include "bake/resumable.hpp"
#include "bake/sampled/view_tree_builder.hpp"

namespace antumbra {

struct TreeBake {
    ViewRegion view_space; ///< local
    BuiltTree tree;     ///< nodes in depth-first order, the side below the plane first
    std::uint64_t tiles_resumed = 0;
    std::uint64_t tiles = 0;
};

/// The spatial part of view space (local, on the scene's grid): the scene's box times options.tree.view_space about
/// its centre.
ViewRegion view_space_of(const Scene& scene, const BakeOptions& options);

/// A pure function of (scene, options). Statuses as run_units; `key` names scene and options.
Result<TreeBake> bake_view_tree(const SamplingScene& shared, const std::string& key, const Job& job);

} // namespace antumbra
