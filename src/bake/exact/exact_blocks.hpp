// The cells of a grid in blocks, each solved from the outside in: what no line from the block reaches is hidden from all
// of its cells, and need not be asked for again (Laine 2005: hidden from a parent cell, hidden from its children).
#pragma once

#include "bake/exact/exact_cells.hpp"

namespace antumbra {

/// Cells of a grid by blocks of edge x edge x edge.
class CellBlocks {
  public:
    /// `cells`: ascending. With an edge of 1 a block is a cell, and has its number.
    CellBlocks(const CellGrid& grid, std::span<const std::uint64_t> cells, std::uint32_t edge);

    const std::vector<std::uint64_t>& ids() const { return ids_; } ///< numbers of blocks that hold any, ascending
    /// Ascending.
    const std::vector<std::uint64_t>& cells(std::uint64_t id) const;

  private:
    std::vector<std::uint64_t> ids_;
    std::vector<std::vector<std::uint64_t>> cells_;
};

/// Solves the cells of one block, in their order: the box around them first, then the boxes around those in each half of it
/// along every axis, and so on. Work on boxes around is counted with the first cell. A pure function of scene, options,
/// grid and cells; rows are those of ExactCells::solve(), but for undecided pairs. Empty: cancelled.
std::vector<ExactCell> solve_block(const ExactCells& exact, const CellGrid& grid, std::span<const std::uint64_t> cells,
                                   std::uint32_t edge, const std::atomic<bool>* cancel = nullptr);

} // namespace antumbra
