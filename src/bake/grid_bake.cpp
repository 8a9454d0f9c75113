// The bake of a regular grid: a unit is a cell or, where exact cells are handed what is hidden from the box around them, a
// block of cells.
#include "bake/assemble.hpp"
#include "bake/exact/exact_blocks.hpp"
#include "bake/parts.hpp"
#include "bake/resumable.hpp"
#include "bake/view_cells.hpp"

#include <algorithm>
#include <optional>

namespace antumbra {
namespace {

using Cells = std::vector<ExactCell>; ///< of sampled bakes without work

/// Empty: cancelled.
Cells compute(const SamplingScene& shared, const ExactCells* exact, const CellGrid& grid,
              std::span<const std::uint64_t> cells, const Job& job) {
    if (exact)
        return solve_block(*exact, grid, cells, shared.options().exact.block, job.cancel);
    return {ExactCell{sample_cell(shared, grid.cell(cells[0])), {}}};
}

Payload pack(const Cells& cells, bool exact) {
    PayloadWriter payload;
    for (const ExactCell& cell : cells)
        exact ? put(payload, cell) : payload.put(cell.sample);
    return payload.take();
}

/// False if the bytes do not hold so many cells.
bool unpack(std::span<const std::byte> bytes, std::size_t words, bool exact, std::size_t count, Cells& cells) {
    PayloadReader payload(bytes);
    for (std::size_t c = 0; c < count && payload.ok(); ++c)
        cells.push_back(exact ? get_exact_cell(payload, words) : ExactCell{payload.get_sample(words), {}});
    return payload.at_end();
}

} // namespace

Result<BakeResult> bake_grid(const SamplingScene& shared, const Job& job) {
    const Scene& scene = shared.scene();
    const BakeOptions& options = shared.options();
    Result<ViewCells> view = lay_view_cells(scene, options);
    if (!view)
        return view.status();
    std::optional<ExactCells> exact;
    if (options.method == "exact") {
        exact.emplace(shared);
        if (Status status = exact->check(view->grid.bounds); !status)
            return status;
    }
    CellBlocks blocks(view->grid, view->to_bake, exact ? options.exact.block : 1);
    std::size_t words = exact ? exact->words() : shared.words();
    Units units;
    units.stage = "bake";
    units.unit_name = exact && options.exact.block > 1 ? "blocks of cells" : "cells";
    units.ids = blocks.ids();
    std::uint64_t plan = plan_of(units.ids);
    keep_shard(units.ids, options.shard);
    units.compute = [&](std::size_t index) {
        return pack(compute(shared, exact ? &*exact : nullptr, view->grid, blocks.cells(units.ids[index]), job),
                    exact.has_value());
    };
    units.acceptable = [&](std::size_t index, std::span<const std::byte> payload) {
        Cells cells;
        return unpack(payload, words, exact.has_value(), blocks.cells(units.ids[index]).size(), cells);
    };
    Result<UnitResults> results = run_units(units, checkpoint_key(scene, options, view->grid), options, job);
    if (!results)
        return results.status();
    std::vector<std::pair<std::uint64_t, RegionSample>> baked; // by cell
    ExactStatistics work;
    std::uint64_t resumed = 0;
    for (std::size_t unit = 0; unit < units.ids.size(); ++unit) {
        const std::vector<std::uint64_t>& numbers = blocks.cells(units.ids[unit]);
        Cells cells;
        if (!unpack(results->payloads[unit], words, exact.has_value(), numbers.size(), cells))
            return Status(ErrorCode::internal, "cells cannot be read back; please report");
        for (std::size_t c = 0; c < numbers.size(); ++c) {
            baked.push_back({numbers[c], std::move(cells[c].sample)});
            add(work, cells[c].work);
        }
        resumed += results->was_resumed[unit] ? numbers.size() : 0;
        results->payloads[unit] = {};
    }
    std::sort(baked.begin(), baked.end(), [](const auto& a, const auto& b) { return a.first < b.first; });
    std::vector<RegionSample> samples;
    for (auto& [cell, sample] : baked)
        samples.push_back(std::move(sample));
    Assembled made = assemble(shared, exact ? &*exact : nullptr, work, samples, view->grid, plan);
    BakeResult& result = made.result;
    result.statistics.cells = view->grid.cells();
    result.statistics.cells_not_baked = view->grid.cells() - baked.size();
    result.statistics.cells_resumed = resumed;
    result.pvs.grid = view->grid;
    result.pvs.cell_row.assign(view->grid.cells(), kCellNotBaked);
    for (std::size_t i = 0; i < baked.size(); ++i)
        result.pvs.cell_row[baked[i].first] = made.row_of[i];
    return std::move(result);
}

} // namespace antumbra
