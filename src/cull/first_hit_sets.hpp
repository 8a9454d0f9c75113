// The choice of occluders by first hit, made in preprocessing: what covers most of sample pictures.
#pragma once

#include "cull/scene_data.hpp"

#include <antumbra/job.hpp>

namespace antumbra {

/// For each leaf and direction the groups of occluders that most rays of sample views from the leaf hit first, most
/// first, at most `per_set`; `is_seen` as in OccluderSetsOptions. Views have all 14 directions, a right angle wide; viewpoints from which most rays first hit
/// the back of something are in matter and do not count. Only an order: nothing relies on its being right. O(leaves *
/// groups near them * rays). A pure function of (scene, cells, per_set, is_seen), whatever the threads.
OccluderSets find_first_hit_sets(const CullScene::Data& scene, const SpaceCells& cells, std::uint32_t per_set,
                                 const std::function<bool(std::uint32_t, std::uint32_t)>& is_seen, const Job& job);

} // namespace antumbra
