// Bakes whose cells are the leaves of a k-d tree: one that grows as it is baked, or one over boxes that were given.
#include "bake/assemble.hpp"
#include "bake/box_cells.hpp"
#include "bake/parts.hpp"
#include "bake/resumable.hpp"
#include "bake/sampled/tree_bake.hpp"

#include <optional>

namespace antumbra {
namespace {

/// Rows in place of the indices of samples.
void link_rows(ViewTree& tree, const std::vector<std::uint32_t>& row_of) {
    for (ViewNode& node : tree.nodes)
        if (node.axis == ViewNode::kLeaf && node.link != kCellNotBaked)
            node.link = row_of[node.link];
}

std::uint64_t count_not_baked(const ViewTree& tree) {
    std::uint64_t count = 0;
    for (const ViewNode& node : tree.nodes)
        count += node.axis == ViewNode::kLeaf && node.link == kCellNotBaked;
    return count;
}

} // namespace

Result<BakeResult> bake_tree(const SamplingScene& shared, const Job& job) {
    const BakeOptions& options = shared.options();
    std::optional<ExactCells> exact;
    if (options.method == "exact")
        exact.emplace(shared);
    if (!exact && !options.where.empty())
        return Status(ErrorCode::usage, "--where needs --subdivision grid or boxes, or --method exact; a sampled view tree "
                                        "covers the whole view space");
    Result<TreeBake> baked = bake_view_tree(shared, exact ? &*exact : nullptr, job);
    if (!baked)
        return baked.status();
    Assembled made = assemble(shared, exact ? &*exact : nullptr, baked->work, baked->leaves, CellGrid(), baked->plan,
                              baked->rays_reused);
    made.result.statistics.cells = baked->leaves.size();
    made.result.statistics.tiles_resumed = baked->tiles_resumed;
    made.result.pvs.tree = std::move(baked->tree);
    if (exact)
        made.result.statistics.cells_not_baked = count_not_baked(made.result.pvs.tree);
    link_rows(made.result.pvs.tree, made.row_of);
    return std::move(made.result);
}

Result<BakeResult> bake_boxes(const SamplingScene& shared, const Job& job) {
    const Scene& scene = shared.scene();
    const BakeOptions& options = shared.options();
    Result<BoxCells> cells = lay_box_cells(scene, options.where);
    if (!cells)
        return cells.status();
    std::optional<ExactCells> exact;
    if (options.method == "exact") {
        exact.emplace(shared);
        for (const ViewRegion& region : cells->regions)
            if (Status status = exact->check(cells->tree.spatial_box(region)); !status)
                return status;
    }
    std::size_t words = exact ? exact->words() : shared.words();
    auto read = [&](PayloadReader& reader) {
        return exact ? get_exact_cell(reader, words) : ExactCell{reader.get_sample(words), {}};
    };
    Units units;
    units.stage = "bake";
    units.unit_name = "cells";
    for (std::uint64_t cell = 0; cell < cells->regions.size(); ++cell)
        units.ids.push_back(cell);
    std::uint64_t name = name_of(cells->tree);
    keep_shard(units.ids, options.shard);
    units.compute = [&](std::size_t index) {
        Box3d box = cells->tree.spatial_box(cells->regions[units.ids[index]]);
        PayloadWriter payload;
        if (exact) {
            ExactCell solved = exact->solve(box, job.cancel);
            if (!solved.finished)
                return Payload();
            put(payload, solved);
        } else
            payload.put(sample_cell(shared, box));
        return payload.take();
    };
    units.acceptable = [&](std::size_t, std::span<const std::byte> payload) {
        PayloadReader reader(payload);
        read(reader);
        return reader.at_end();
    };
    Result<UnitResults> results =
        run_units(units, checkpoint_key(scene, options, CellGrid(), std::to_string(name)), options, job);
    if (!results)
        return results.status();
    std::vector<RegionSample> samples;
    std::vector<std::uint32_t> sample_of(cells->regions.size(), kCellNotBaked);
    ExactStatistics work;
    for (std::size_t unit = 0; unit < units.ids.size(); ++unit) {
        PayloadReader reader(results->payloads[unit]);
        ExactCell cell = read(reader);
        sample_of[units.ids[unit]] = std::uint32_t(samples.size());
        samples.push_back(std::move(cell.sample));
        add(work, cell.work);
        results->payloads[unit] = {};
    }
    Assembled made = assemble(shared, exact ? &*exact : nullptr, work, samples, CellGrid(), name);
    made.result.statistics.cells = cells->regions.size();
    made.result.statistics.cells_not_baked = cells->regions.size() - units.ids.size();
    made.result.statistics.cells_resumed = results->resumed;
    made.result.pvs.tree = std::move(cells->tree);
    for (ViewNode& node : made.result.pvs.tree.nodes)
        if (node.axis == ViewNode::kLeaf && node.link != kCellNotBaked)
            node.link = sample_of[node.link];
    link_rows(made.result.pvs.tree, made.row_of);
    return std::move(made.result);
}

} // namespace antumbra
