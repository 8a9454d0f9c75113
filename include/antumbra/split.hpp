// Big objects cut into clusters that a renderer can hide one by one.
#pragma once

#include <antumbra/scene.hpp>

namespace antumbra {

struct SplitOptions {
    std::uint32_t most_triangles = 256; ///< in a cluster; objects of more are cut
};

struct SplitStatistics {
    std::uint32_t objects_cut = 0; ///< of the scene
    std::uint32_t clusters = 0;    ///< that they were cut into
};

/// The scene with every object of more than most_triangles triangles cut into compact clusters "NAME/cluster K", K from 1,
/// in place of it; a cluster is a node of its own. Cut again and again in two halves across the longest axis of the
/// triangles' centres. The triangles are those of the (snapped) scene, each once, in the order of the scene within a
/// cluster, in world coordinates; flags are kept. Objects that move or are always visible are not cut. Made a scene
/// again with the same options it has the same bounds, hence the same grid, hence the same triangles to the last bit.
/// O(n log n). Deterministic.
RawScene split_scene(const Scene& scene, const SplitOptions& options = {}, SplitStatistics* statistics = nullptr);

} // namespace antumbra
