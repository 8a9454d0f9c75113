// The cells of space that occluder sets belong to.
#pragma once

#include "cull/scene_data.hpp"

#include <functional>

namespace antumbra {

/// Cells, and what is seen from them where that is known (OccluderSetsOptions::is_seen), else nothing.
struct SetCells {
    SpaceCells cells;
    std::function<bool(std::uint32_t leaf, std::uint32_t object)> is_seen;
};

/// The leaves of the kd-tree that `planes-published` walks (balanced counts), or, where it has more than `leaves`, its upper nodes:
/// leaves share the sets of the one that they lie in.
SpaceCells cells_of_objects(const CullScene::Data& scene, std::uint32_t leaves);

/// Where the PVS has cells: these (of a view tree its cuts of space), several together if they are more than `leaves`; and
/// what they see. Else cells_of_objects(). The function keeps what it needs, but `pvs` not: it unites rows now. O(rows).
SetCells choose_set_cells(const CullScene::Data& scene, const Pvs* pvs, std::uint32_t leaves);

} // namespace antumbra
