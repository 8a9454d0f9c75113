// From the samples of cells to the data of a file: rows, counts, and what the file says of how it was made.
#pragma once

#include "bake/exact/exact_cells.hpp"

#include <antumbra/bake.hpp>

#include <string>

namespace antumbra {

/// The three ways to cut view space; each as bake() promises.
Result<BakeResult> bake_grid(const SamplingScene& shared, const Job& job);
Result<BakeResult> bake_tree(const SamplingScene& shared, const Job& job);
Result<BakeResult> bake_boxes(const SamplingScene& shared, const Job& job);

/// Names everything that the cells of a bake depend on: for the checkpoint. `cells` names those of them.
std::string checkpoint_key(const Scene& scene, const BakeOptions& options, const CellGrid& grid,
                           const std::string& cells = "");

/// One cell (world) of a sampled bake.
RegionSample sample_cell(const SamplingScene& shared, const Box3d& cell);

/// Objects in a sample's row, without volumes and clusters behind them.
std::uint64_t count_objects(const RegionSample& sample, std::size_t objects);

/// Result with statistics over all samples (of exact bakes with that of `work`), header, objects and options; rows in the
/// order of the samples, `row_of` each of them, equal rows shared, kCellSolid where a sample has none. Takes the
/// samples' rows. Left to the caller: cells, and the statistics that count them.
struct Assembled {
    BakeResult result;
    std::vector<std::uint32_t> row_of;
};
Assembled assemble(const SamplingScene& shared, const ExactCells* exact, const ExactStatistics& work,
                   std::vector<RegionSample>& samples, const CellGrid& grid, std::uint64_t plan,
                   std::uint64_t rays_reused = 0);

} // namespace antumbra
