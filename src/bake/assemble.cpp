#include "bake/assemble.hpp"

#include "bake/binomial.hpp"
#include "bake/keys.hpp"
#include "bake/parts.hpp"

#include <bit>
#include <map>

namespace antumbra {
namespace {

using Json = nlohmann::ordered_json;

/// Everything that the result depends on besides the scene, as text: goes into the file and names the checkpoint.
Json describe(const Scene& scene, const BakeOptions& options, const CellGrid& grid) {
    Json json;
    json["method"] = options.method;
    const ViewTreeOptions& tree = options.tree;
    static constexpr const char* subdivisions[] = {"grid", "spatial", "angular", "five", "boxes"};
    json["subdivision"] = subdivisions[std::size_t(tree.subdivision)];
    if (tree.subdivision == Subdivision::grid)
        json["cells"] = grid.count;
    else if (tree.subdivision != Subdivision::boxes)
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
        if (options.exact.granularity == Granularity::cluster) {
            json["cluster_triangles"] = options.exact.cluster_triangles;
            json["cluster_order"] = options.exact.cluster_order == ClusterOrder::file ? "file" : "compact";
        }
        json["form"] = options.exact.form == ExactForm::published ? "published" : "fast";
        json["max_pieces"] = options.exact.max_pieces;
        json["cell_work"] = options.exact.cell_work;
        if (tree.subdivision == Subdivision::grid)
            json["block"] = options.exact.block;
    }
    if (scene.crack_width() > 0)
        json["crack_width"] = scene.crack_width();
    for (const Finding& finding : scene.findings())
        if (finding.kind == kCrackOpened)
            json["cracks_opened_by_snapping"] = finding.count;
    json["holdout_rays_per_cell"] = options.holdout_rays;
    if (options.volumes[0])
        json["volumes"] = options.volumes;
    json["seed"] = options.seed;
    return json;
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

/// What the file says of how it was made: counts only, which are the same on every machine. In a part of a bake, options
/// and counts apart: merge_parts() adds the counts up.
std::string options_json(const Scene& scene, const BakeOptions& options, const CellGrid& grid, const BakeStatistics& statistics,
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
    return describe_part({options.shard, plan, describe(scene, options, grid), counts});
}

} // namespace

std::string checkpoint_key(const Scene& scene, const BakeOptions& options, const CellGrid& grid, const std::string& cells) {
    Json json = describe(scene, options, grid);
    json["scene"] = to_hex(scene.fingerprint());
    for (int k = 0; k < 3; ++k) {
        json["min"].push_back(std::bit_cast<std::uint64_t>(grid.bounds.min[k]));
        json["max"].push_back(std::bit_cast<std::uint64_t>(grid.bounds.max[k]));
    }
    json["cells_of"] = cells;
    return json.dump();
}

RegionSample sample_cell(const SamplingScene& shared, const Box3d& cell) {
    const Scene& scene = shared.scene();
    SamplingRegion region = SamplingRegion::all_directions({scene.to_local(cell.min), scene.to_local(cell.max)});
    RegionSampler sampler(shared, region, cell_key(cell));
    sampler.run_all();
    return std::move(sampler).finish();
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

Assembled assemble(const SamplingScene& shared, const ExactCells* exact, const ExactStatistics& work,
                   std::vector<RegionSample>& samples, const CellGrid& grid, std::uint64_t plan, std::uint64_t rays_reused) {
    const Scene& scene = shared.scene();
    const BakeOptions& options = shared.options();
    Assembled made;
    BakeStatistics& statistics = made.result.statistics;
    statistics.exact = work;
    statistics.rays_reused = rays_reused;
    count_all(statistics, samples, options, scene.objects().size());
    PvsData& pvs = made.result.pvs = begin_pvs(scene, options);
    if (exact) {
        pvs.guarantee = work.undecided ? Guarantee::conservative : Guarantee::exact;
        pvs.cluster_first = exact->cluster_first();
        pvs.triangles = exact->triangles();
    }
    pvs.volumes = shared.volumes().grid();
    pvs.options_json = options_json(scene, options, grid, statistics, plan);
    made.row_of = fill_rows(pvs, samples);
    return made;
}

} // namespace antumbra
