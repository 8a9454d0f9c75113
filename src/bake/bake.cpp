#include <antumbra/bake.hpp>

#include "bake/binomial.hpp"
#include "bake/exact/exact_cells.hpp"
#include "bake/keys.hpp"
#include "bake/parts.hpp"
#include "bake/resumable.hpp"
#include "bake/sampled/sample_payload.hpp"
#include "bake/sampled/tree_bake.hpp"
#include "bake/view_cells.hpp"
#include "base/parallel.hpp"

#include <bit>
#include <chrono>
#include <cmath>
#include <ctime>
#include <map>
#include <nlohmann/json.hpp>
#include <optional>

namespace antumbra {
namespace {

using Clock = std::chrono::steady_clock;
using Json = nlohmann::ordered_json;

double seconds_since(Clock::time_point start) {
    return std::chrono::duration<double>(Clock::now() - start).count();
}

double process_cpu_seconds() {
    timespec now{};
    ::clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &now);
    return double(now.tv_sec) + double(now.tv_nsec) * 1e-9;
}

Status check(const BakeOptions& options) {
    if (options.method != "sampled" && options.method != "exact")
        return {ErrorCode::usage, "unknown bake method '" + options.method + "'; known: sampled, exact"};
    if (options.method != "exact" && options.exact.granularity != Granularity::object)
        return {ErrorCode::usage, "clusters and triangles are listed by the exact method only; use --method exact"};
    if (options.exact.cluster_triangles == 0 || options.exact.max_pieces == 0)
        return {ErrorCode::usage, "a cluster holds one triangle or more, and the budget is one piece or more"};
    if (options.method == "exact" && options.tree.subdivision != Subdivision::grid)
        return {ErrorCode::usage, "the exact method speaks of boxes in space; use --subdivision grid"};
    if (options.rays_per_cell == 0 || options.rays_per_cell > 1u << 30 || options.holdout_rays > 1u << 28)
        return {ErrorCode::usage, "rays per cell must be 1 to 2^30, hold-out rays up to 2^28"};
    const SprtOptions& test = options.sequential;
    if (!(0 < test.s_t && test.s_t < test.s_1 && test.s_1 < 1 && 0 < test.b && test.b < 1 && 1 < test.a) ||
        test.most_rays == 0 || test.most_rays > 1u << 20)
        return {ErrorCode::usage, "the sequential test needs 0 < s_t < s_1 < 1, 0 < b < 1 < a, at most 2^20 rays"};
    const ViewTreeOptions& tree = options.tree;
    if (!(tree.view_space > 0 && tree.view_space <= 1000 && tree.effectiveness >= 0 && tree.effectiveness <= 1 &&
          tree.min_extent > 0 && tree.min_extent <= 1) ||
        tree.max_depth > 64 || tree.tile_depth > 12 || tree.node_rays == 0 || tree.node_rays > 1u << 24)
        return {ErrorCode::usage, "the view tree needs a view space of 0 to 1000 times the scene, effectiveness 0 to 1, "
                                  "an extent of 0 to 1, depth up to 64 below tiles of depth up to 12"};
    if (options.shard.index >= options.shard.count || options.shard.count > 1u << 20)
        return {ErrorCode::usage, "a shard has a number from 1 to their count, of which there are at most 2^20"};
    double volumes = double(options.volumes[0]) * options.volumes[1] * options.volumes[2];
    if (volumes > 1 << 20)
        return {ErrorCode::limit, "at most 2^20 occludee volumes; ask for fewer along each axis"};
    if (volumes > 0 && options.method != "sampled")
        return {ErrorCode::usage, "occludee volumes need the sampled method"};
    return {};
}

/// Everything that the result depends on besides the scene, as text: goes into the file and names the checkpoint.
Json describe(const BakeOptions& options, const CellGrid& grid) {
    Json json;
    json["method"] = options.method;
    const ViewTreeOptions& tree = options.tree;
    static constexpr const char* subdivisions[] = {"grid", "spatial", "angular", "five"};
    json["subdivision"] = subdivisions[std::size_t(tree.subdivision)];
    if (tree.subdivision == Subdivision::grid)
        json["cells"] = grid.count;
    else
        json["tree"] = {{"view_space", tree.view_space},
                        {"estimate", tree.estimate == SplitEstimate::published ? "published" : "corrected"},
                        {"effectiveness", tree.effectiveness},
                        {"min_visible", tree.min_visible},
                        {"max_depth", tree.max_depth},
                        {"min_extent", tree.min_extent},
                        {"node_rays", tree.node_rays},
                        {"tile_depth", tree.tile_depth}};
    json["rays_per_cell"] = options.rays_per_cell;
    json["sampling"] = options.sampling == Sampling::guided ? "guided" : "uniform";
    static constexpr const char* readings[] = {"wald", "printed", "normalised"};
    const SprtOptions& test = options.sequential;
    json["sequential"] = {{"reading", readings[std::size_t(test.reading)]}, {"s_t", test.s_t}, {"s_1", test.s_1},
                          {"a", test.a}, {"b", test.b}, {"most_rays", test.most_rays},
                          {"informed_prior", options.informed_prior}};
    if (options.method == "exact") {
        static constexpr const char* granularities[] = {"object", "cluster", "triangle"};
        json["granularity"] = granularities[std::size_t(options.exact.granularity)];
        if (options.exact.granularity == Granularity::cluster)
            json["cluster_triangles"] = options.exact.cluster_triangles;
        json["form"] = options.exact.form == ExactForm::published ? "published" : "fast";
        json["max_pieces"] = options.exact.max_pieces;
    }
    json["holdout_rays_per_cell"] = options.holdout_rays;
    if (options.volumes[0])
        json["volumes"] = options.volumes;
    json["seed"] = options.seed;
    return json;
}

std::string checkpoint_key(const Scene& scene, const BakeOptions& options, const CellGrid& grid) {
    Json json = describe(options, grid);
    json["scene"] = to_hex(scene.fingerprint());
    for (int k = 0; k < 3; ++k) {
        json["min"].push_back(std::bit_cast<std::uint64_t>(grid.bounds.min[k]));
        json["max"].push_back(std::bit_cast<std::uint64_t>(grid.bounds.max[k]));
    }
    return json.dump();
}

RegionSample sample_cell(const SamplingScene& shared, const Box3d& cell) {
    const Scene& scene = shared.scene();
    SamplingRegion region = SamplingRegion::all_directions({scene.to_local(cell.min), scene.to_local(cell.max)});
    RegionSampler sampler(shared, region, cell_key(cell));
    sampler.run_all();
    return std::move(sampler).finish();
}

/// Header and objects of the result.
PvsData begin_pvs(const Scene& scene, const BakeOptions& options) {
    PvsData pvs = describe_scene(scene);
    pvs.guarantee = Guarantee::aggressive;
    pvs.method = options.method;
    return pvs;
}

/// Gives each sample its row, equal rows shared, in the order of the samples; kCellSolid where it has none.
std::vector<std::uint32_t> fill_rows(PvsData& pvs, std::vector<RegionSample>& samples) {
    std::map<std::vector<std::uint64_t>, std::uint32_t> rows;
    std::vector<std::uint32_t> row_of;
    for (RegionSample& sample : samples) {
        if (sample.solid) {
            row_of.push_back(kCellSolid);
            continue;
        }
        auto [row, fresh] = rows.try_emplace(std::move(sample.visible), pvs.row_count);
        if (fresh) {
            pvs.rows.insert(pvs.rows.end(), row->first.begin(), row->first.end());
            ++pvs.row_count;
        }
        row_of.push_back(row->second);
    }
    return row_of;
}

/// Objects in a sample's row, without the volumes behind them.
std::uint64_t count_objects(const RegionSample& sample, std::size_t objects) {
    std::uint64_t sum = 0;
    for (std::size_t w = 0; w < sample.visible.size() && w * 64 < objects; ++w) {
        std::size_t bits = std::min<std::size_t>(64, objects - w * 64);
        sum += std::uint64_t(std::popcount(sample.visible[w] << (64 - bits)));
    }
    return sum;
}

void count(BakeStatistics& statistics, const RegionSample& sample, const SprtOptions& test, std::size_t objects) {
    ++(sample.solid ? statistics.cells_solid : statistics.cells_baked);
    statistics.rays += sample.rays;
    statistics.aimed_rays += sample.aimed_rays;
    statistics.confirmed_pairs += sample.confirmed;
    statistics.unconfirmed_pairs += sample.unconfirmed;
    statistics.holdout_rays += sample.holdout_rays;
    statistics.holdout_misses += sample.holdout_misses;
    statistics.pair_s1 = test.s_1;
    if (sample.fewest_aimed != ~0u)
        statistics.pair_miss_at_s1 = std::max(statistics.pair_miss_at_s1,
                                              SequentialTest::miss_probability(test.s_1, sample.fewest_aimed));
    statistics.mean_visible += double(count_objects(sample, objects)); // a sum until finish()
}

void finish(BakeStatistics& statistics) {
    if (statistics.cells_baked)
        statistics.mean_visible /= double(statistics.cells_baked);
    if (statistics.holdout_rays)
        statistics.miss_rate = double(statistics.holdout_misses) / double(statistics.holdout_rays);
    statistics.miss_rate_upper95 = clopper_pearson_upper(statistics.holdout_misses, statistics.holdout_rays, 0.95);
}

void count_all(BakeStatistics& statistics, std::span<const RegionSample> samples, const BakeOptions& options,
               std::size_t objects) {
    for (const RegionSample& sample : samples)
        count(statistics, sample, options.sequential, objects);
    finish(statistics);
}

void count(ExactStatistics& total, const ExactStatistics& cell) {
    total.box_queries += cell.box_queries;
    total.triangle_queries += cell.triangle_queries;
    total.pairs += cell.pairs;
    total.undecided += cell.undecided;
    total.found_by_query += cell.found_by_query;
    total.effective_occluders += cell.effective_occluders;
    total.queries_with_occluders += cell.queries_with_occluders;
    total.most_effective = std::max(total.most_effective, cell.most_effective);
}

/// What the file says of how it was made: counts only, which are the same on every machine. In a part of a bake, options
/// and counts apart: merge_parts() adds the counts up.
std::string options_json(const BakeOptions& options, const CellGrid& grid, const BakeStatistics& statistics,
                         std::uint64_t plan) {
    Json counts;
    counts["rays"] = statistics.rays;
    counts["rays_reused"] = statistics.rays_reused;
    counts["aimed_rays"] = statistics.aimed_rays;
    counts["confirmed_pairs"] = statistics.confirmed_pairs;
    counts["unconfirmed_pairs"] = statistics.unconfirmed_pairs;
    counts["holdout_rays"] = statistics.holdout_rays;
    counts["holdout_misses"] = statistics.holdout_misses;
    if (options.method == "exact")
        counts["exact"] = {{"box_queries", statistics.exact.box_queries},
                           {"triangle_queries", statistics.exact.triangle_queries},
                           {"pairs", statistics.exact.pairs},
                           {"undecided", statistics.exact.undecided},
                           {"found_by_query", statistics.exact.found_by_query},
                         {"effective_occluders", statistics.exact.effective_occluders},
                         {"queries_with_occluders", statistics.exact.queries_with_occluders},
                         {"most_effective", statistics.exact.most_effective}};
    return describe_part({options.shard, plan, describe(options, grid), counts});
}

/// The regular grid: a unit is a cell.
Result<BakeResult> bake_grid(const SamplingScene& shared, const Job& job) {
    const Scene& scene = shared.scene();
    const BakeOptions& options = shared.options();
    Result<ViewCells> view = lay_view_cells(scene, options);
    if (!view)
        return view.status();
    std::uint64_t plan = plan_of(view->to_bake);
    keep_shard(view->to_bake, options.shard);
    std::optional<ExactCells> exact;
    if (options.method == "exact") {
        exact.emplace(shared);
        if (Status status = exact->check(view->grid.bounds); !status)
            return status;
    }
    std::size_t words = exact ? exact->words() : shared.words();
    auto read = [&](PayloadReader& reader) {
        return exact ? get_exact_cell(reader, words) : ExactCell{reader.get_sample(words), {}};
    };
    Units units;
    units.stage = "bake";
    units.unit_name = "cells";
    units.ids = view->to_bake;
    units.compute = [&](std::size_t index) {
        Box3d cell = view->grid.cell(view->to_bake[index]);
        PayloadWriter payload;
        if (exact) {
            ExactCell solved = exact->solve(cell, job.cancel);
            if (!solved.finished)
                return Payload();
            put(payload, solved);
        } else
            payload.put(sample_cell(shared, cell));
        return payload.take();
    };
    units.acceptable = [&](std::size_t, std::span<const std::byte> payload) {
        PayloadReader reader(payload);
        read(reader);
        return reader.at_end();
    };
    Result<UnitResults> results = run_units(units, checkpoint_key(scene, options, view->grid), options, job);
    if (!results)
        return results.status();
    BakeResult result;
    std::vector<RegionSample> samples;
    for (Payload& payload : results->payloads) {
        PayloadReader reader(payload);
        ExactCell cell = read(reader);
        samples.push_back(std::move(cell.sample));
        count(result.statistics.exact, cell.work);
        payload = {};
    }
    result.statistics.cells = view->grid.cells();
    result.statistics.cells_not_baked = view->grid.cells() - view->to_bake.size();
    result.statistics.cells_resumed = results->resumed;
    count_all(result.statistics, samples, options, scene.objects().size());
    result.pvs = begin_pvs(scene, options);
    if (exact)
        result.pvs.guarantee = result.statistics.exact.undecided ? Guarantee::conservative : Guarantee::exact;
    if (exact)
        result.pvs.cluster_first = exact->cluster_first();
    result.pvs.volumes = shared.volumes().grid();
    result.pvs.options_json = options_json(options, view->grid, result.statistics, plan);
    result.pvs.grid = view->grid;
    result.pvs.cell_row.assign(view->grid.cells(), kCellNotBaked);
    std::vector<std::uint32_t> rows = fill_rows(result.pvs, samples);
    for (std::size_t i = 0; i < rows.size(); ++i)
        result.pvs.cell_row[view->to_bake[i]] = rows[i];
    return result;
}

/// The k-d tree of view space: a unit is a tile.
Result<BakeResult> bake_tree(const SamplingScene& shared, const Job& job) {
    const Scene& scene = shared.scene();
    const BakeOptions& options = shared.options();
    if (!options.where.empty())
        return Status(ErrorCode::usage, "--where needs --subdivision grid; a view tree covers the whole view space");
    Result<TreeBake> baked = bake_view_tree(shared, checkpoint_key(scene, options, CellGrid()), job);
    if (!baked)
        return baked.status();
    BakeResult result;
    result.statistics.cells = baked->leaves.size();
    result.statistics.tiles_resumed = baked->tiles_resumed;
    result.statistics.rays_reused = baked->rays_reused;
    count_all(result.statistics, baked->leaves, options, scene.objects().size());
    result.pvs = begin_pvs(scene, options);
    result.pvs.volumes = shared.volumes().grid();
    result.pvs.options_json = options_json(options, CellGrid(), result.statistics, 0);
    result.pvs.tree = std::move(baked->tree);
    std::vector<std::uint32_t> rows = fill_rows(result.pvs, baked->leaves);
    for (ViewNode& node : result.pvs.tree.nodes)
        if (node.axis == ViewNode::kLeaf && node.link != kCellNotBaked)
            node.link = rows[node.link];
    return result;
}

} // namespace

Result<BakeResult> bake(const Scene& scene, const BakeOptions& options, const Job& job) {
    Clock::time_point start = Clock::now();
    double cpu_start = process_cpu_seconds();
    if (Status status = check(options); !status)
        return status;
    Tracer tracer = Tracer::build(scene, job);
    SamplingScene shared(tracer, options);
    Result<BakeResult> result =
        options.tree.subdivision == Subdivision::grid ? bake_grid(shared, job) : bake_tree(shared, job);
    if (result) {
        result->statistics.seconds = seconds_since(start);
        result->statistics.cpu_seconds = process_cpu_seconds() - cpu_start;
    }
    return result;
}

Result<BakePlan> plan_bake(const Scene& scene, const BakeOptions& options, const Job& job) {
    constexpr std::size_t kProbedCells = 8;
    if (Status status = check(options); !status)
        return status;
    Result<ViewCells> view = lay_view_cells(scene, options);
    if (!view)
        return view.status();
    BakePlan plan;
    plan.grid = view->grid;
    plan.cells_to_bake = view->to_bake.size();
    Clock::time_point start = Clock::now();
    Tracer tracer = Tracer::build(scene, job);
    SamplingScene shared(tracer, options);
    std::optional<ExactCells> exact;
    if (options.method == "exact")
        exact.emplace(shared);
    double set_up_seconds = seconds_since(start);
    std::size_t probed = std::min(kProbedCells, view->to_bake.size());
    std::atomic<std::uint64_t> set_bits{0}, rows{0};
    start = Clock::now();
    parallel_for(probed, job, [&](std::size_t index, unsigned) {
        std::uint64_t cell = view->to_bake[(2 * index + 1) * view->to_bake.size() / (2 * probed)];
        Box3d box = view->grid.cell(cell);
        RegionSample sample = exact ? exact->solve(box).sample : sample_cell(shared, box);
        rows += !sample.solid;
        set_bits += count_objects(sample, scene.objects().size());
    });
    if (job.cancelled())
        return Status(ErrorCode::cancelled, "stopped");
    double cells = double(plan.cells_to_bake);
    plan.estimated_seconds = set_up_seconds + seconds_since(start) * cells / double(std::max<std::size_t>(probed, 1));
    // A row costs at most two bytes for each visible object and a bit for each object; the header, about 64 an object.
    double objects = double(scene.objects().size());
    double row_bytes = std::min(objects / 8, 2 * double(set_bits) / double(std::max<std::uint64_t>(rows, 1)));
    plan.estimated_bytes = std::uint64_t(64 * objects + double(plan.grid.cells()) * 4 + row_bytes * cells *
                                         double(rows) / double(std::max<std::size_t>(probed, 1)));
    return plan;
}

} // namespace antumbra
