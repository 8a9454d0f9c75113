// The cells of a file as boxes of space alone, whether it has a grid or a view tree.
#pragma once

#include <antumbra/pvs.hpp>

#include <functional>

namespace antumbra {

/// Space that is answered by the same rows whichever way one looks.
struct SpatialCell {
    Box3d box;   ///< the piece of space (world)
    Box3d outer; ///< what is listed is visible from somewhere in here: all of its cells together
    Box3d inner; ///< what is visible from in here is listed, if the file is complete: what all of its cells share
    std::uint64_t cell = 0;          ///< number of the cell; of a tree: the node of the first leaf
    std::vector<std::uint32_t> rows; ///< ascending, each once; never empty
};

/// All of them that were baked, in a fixed order. Of a tree, whose splits are of all five dimensions, the pieces into
/// which the spatial splits cut it; pieces with a leaf that was not baked are left out.
std::vector<SpatialCell> spatial_cells(const Pvs& pvs);

/// The union of the rows of a cell, as words_per_row() words.
void unite_rows(const Pvs& pvs, const SpatialCell& cell, std::vector<std::uint64_t>& bits);

double volume(const Box3d& box);
Box3d intersection(const Box3d& a, const Box3d& b);

/// Calls visit(i, j, box) for all pairs of cells that share a volume, i ascending, then j ascending. O(n log n + pairs)
/// for grids, somewhat more for trees.
void for_each_common_piece(const std::vector<SpatialCell>& a, const std::vector<SpatialCell>& b,
                           const std::function<void(std::size_t, std::size_t, const Box3d&)>& visit);

} // namespace antumbra
