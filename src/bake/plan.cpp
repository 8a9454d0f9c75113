// What a bake would take, from a few of its cells.
#include "bake/assemble.hpp"
#include "bake/box_cells.hpp"
#include "bake/check_options.hpp"
#include "bake/view_cells.hpp"
#include "base/collect.hpp"

#include <chrono>
#include <cmath>
#include <optional>

namespace antumbra {
namespace {

using Clock = std::chrono::steady_clock;

constexpr std::size_t kProbedCells = 8;
constexpr std::uint32_t kProbedTiles = 2; ///< of a tree
constexpr std::uint32_t kFinerTiles = 3;  ///< halvings below the tiles of the bake, so that a few are a small share

double seconds_since(Clock::time_point start) { return std::chrono::duration<double>(Clock::now() - start).count(); }

/// A row costs at most two bytes for each visible object and a bit for each object; the header, about 64 an object.
std::uint64_t bytes_of(double objects, double visible_per_row, double rows, double cells) {
    double row_bytes = std::min(objects / 8, 2 * visible_per_row);
    return std::uint64_t(64 * objects + cells * 4 + row_bytes * rows);
}

/// Of cells that are known beforehand: some of them baked, evenly chosen among all.
template <class CellAt>
Result<BakePlan> plan_cells(const Scene& scene, const BakeOptions& options, std::size_t count, const CellAt& cell_at,
                            const Job& job) {
    BakePlan plan;
    plan.cells_to_bake = count;
    Clock::time_point start = Clock::now();
    Tracer tracer = Tracer::build(scene, job);
    SamplingScene shared(tracer, options);
    std::optional<ExactCells> exact;
    if (options.method == "exact")
        exact.emplace(shared);
    double set_up_seconds = seconds_since(start);
    std::size_t probed = std::min(kProbedCells, count);
    std::uint64_t set_bits = 0, rows = 0;
    start = Clock::now();
    auto bake_one = [&](std::size_t index, unsigned) {
        Box3d box = cell_at((2 * index + 1) * count / (2 * probed));
        return exact ? exact->solve(box, job.cancel).sample : sample_cell(shared, box);
    };
    auto take = [&](std::size_t, const RegionSample& sample) {
        rows += !sample.solid;
        set_bits += count_objects(sample, scene.objects().size());
    };
    if (Status status = collect(probed, job, "estimate", "cells", bake_one, take); !status)
        return status;
    double scale = double(count) / double(std::max<std::size_t>(probed, 1));
    plan.estimated_seconds = set_up_seconds + seconds_since(start) * scale;
    plan.estimated_bytes = bytes_of(double(scene.objects().size()), double(set_bits) / double(std::max<std::uint64_t>(rows, 1)),
                                    double(rows) * scale, double(count));
    return plan;
}

/// Of a tree that grows: a few of many small tiles are baked.
Result<BakePlan> plan_tree(const Scene& scene, const BakeOptions& options, const Job& job) {
    BakeOptions part = options;
    auto halvings = std::uint32_t(std::max(0.0, 3 * std::floor(std::log2(1 / part.tree.min_extent)))); // until cells are least
    std::uint32_t room = std::min(12u, halvings) - std::min({12u, halvings, part.tree.tile_depth});
    std::uint32_t finer = std::min({kFinerTiles, part.tree.max_depth, room});
    part.tree.tile_depth += finer;
    part.tree.max_depth -= finer; // it counts from the tiles
    std::uint32_t tiles = 1u << part.tree.tile_depth, probed = std::min(kProbedTiles, tiles);
    part.shard.count = tiles / probed;
    part.shard.index = part.shard.count / 2;
    part.checkpoint.clear();
    part.resume = false;
    Clock::time_point start = Clock::now();
    Result<BakeResult> baked = bake(scene, part, job);
    if (!baked)
        return baked.status();
    const BakeStatistics& statistics = baked->statistics;
    double scale = part.shard.count;
    BakePlan plan;
    plan.is_cells_estimate = true;
    plan.cells_to_bake = std::uint64_t(scale * double(statistics.cells_baked + statistics.cells_solid));
    plan.estimated_seconds = scale * seconds_since(start);
    plan.estimated_bytes = bytes_of(double(scene.objects().size()), statistics.mean_visible,
                                    scale * double(statistics.cells_baked), double(plan.cells_to_bake));
    return plan;
}

} // namespace

Result<BakePlan> plan_bake(const Scene& scene, const BakeOptions& options, const Job& job) {
    if (Status status = check_options(options); !status)
        return status;
    if (options.tree.subdivision == Subdivision::boxes) {
        Result<BoxCells> cells = lay_box_cells(scene, options.where);
        if (!cells)
            return cells.status();
        return plan_cells(scene, options, cells->regions.size(),
                          [&](std::size_t cell) { return cells->tree.spatial_box(cells->regions[cell]); }, job);
    }
    if (options.tree.subdivision != Subdivision::grid)
        return plan_tree(scene, options, job);
    Result<ViewCells> view = lay_view_cells(scene, options);
    if (!view)
        return view.status();
    Result<BakePlan> plan = plan_cells(scene, options, view->to_bake.size(),
                                       [&](std::size_t cell) { return view->grid.cell(view->to_bake[cell]); }, job);
    if (plan) {
        plan->grid = view->grid;
        plan->estimated_bytes += 4 * (view->grid.cells() - plan->cells_to_bake);
    }
    return plan;
}

} // namespace antumbra
