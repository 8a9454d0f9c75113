// The grid of view cells that a bake works on.
#pragma once

#include <antumbra/bake.hpp>

namespace antumbra {

struct ViewCells {
    CellGrid grid;
    std::vector<std::uint64_t> to_bake; ///< ascending indices of the cells that `where` touches
};

/// Lays the grid over `where` (or the scene's bounds). All cell corners are whole multiples of the scene's step
/// from its origin, so that every method speaks of exactly the same boxes. Cells that only share a face with
/// `where` do not touch it. ErrorCode::usage for boxes or counts that make no sense, limit for more than 2^28 cells.
Result<ViewCells> lay_view_cells(const Scene& scene, const BakeOptions& options);

} // namespace antumbra
