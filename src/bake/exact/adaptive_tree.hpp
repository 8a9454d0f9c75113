// Exact cells as fine as they pay: a k-d tree over space, each node solved, each solved within what its parent does not see.
#pragma once

#include "bake/exact/exact_cells.hpp"
#include "bake/sampled/view_tree_builder.hpp"

namespace antumbra {

/// Can a plane at this step of an axis carry faces of exact cells? True where it lies on the scene's grid.
bool is_on_grid(const Scene& scene, const ViewTree& space, int axis, std::uint32_t step);

/// The part of the tree over one tile. A node is halved across its longest axis, down to options.tree.min_extent, as long as the
/// halves see different things: 1 - (seen by both) / (seen) above options.tree.effectiveness (the published measure of
/// Gotsman, Sudarsky, Fayman 1999, section 4, without chance, since both sets are complete). What options.where does not
/// touch is not baked. `work`: of all nodes, those that were given up too. A pure function of scene, options, space and
/// tile. False: cancelled.
bool build_exact_tree(const ExactCells& exact, const ViewTree& space, const ViewRegion& tile, BuiltTree& tree,
                      const std::atomic<bool>* cancel = nullptr);

} // namespace antumbra
