#include "command.hpp"

#include "bake/exact/certificate_file.hpp"
#include "bake/sampled/sequential_test.hpp"
#include "base/file.hpp"

#include <antumbra/bake.hpp>
#include <antumbra/camera.hpp>

#include <fmt/format.h>

namespace antumbra::app {
namespace {

struct BakeArguments {
    Common common;
    SceneArguments scene;
    BakeOptions options;
    std::string output, cells, volumes, where, shard;
    double where_radius = 0, alpha = 0, beta = 0;
    bool dry_run = false, certificates = false;
    PvsCoding coding = PvsCoding::cheapest;
};

Result<std::array<std::uint32_t, 3>> parse_counts(const std::string& text, const char* option) {
    std::array<std::uint32_t, 3> cells{};
    int end = 0;
    if (std::sscanf(text.c_str(), "%ux%ux%u%n", &cells[0], &cells[1], &cells[2], &end) != 3 ||
        std::size_t(end) != text.size())
        return Status(ErrorCode::usage, std::string(option) + " wants three counts such as 16x4x16, not '" + text + "'");
    return cells;
}

/// "I/N", counted from 1.
Result<Shard> parse_shard(const std::string& text) {
    Shard shard;
    int end = 0;
    if (std::sscanf(text.c_str(), "%u/%u%n", &shard.index, &shard.count, &end) != 2 || std::size_t(end) != text.size() ||
        shard.index == 0 || shard.index > shard.count)
        return Status(ErrorCode::usage, "--shard wants I/N with I from 1 to N, such as 2/8, not '" + text + "'");
    --shard.index;
    return shard;
}

/// The boxes of --where: of a file of boxes, around the eyes of a camera path, or none for the whole scene.
Result<std::vector<Box3d>> read_where(const BakeArguments& arguments, const Scene& scene) {
    std::vector<Box3d> boxes;
    if (arguments.where.empty() || arguments.where == "auto")
        return boxes;
    if (!file_exists(arguments.where))
        return Status(ErrorCode::io, "--where " + arguments.where + ": no such file; give a file, or auto");
    Result<std::vector<Box3d>> listed = read_boxes(arguments.where);
    if (listed)
        return listed;
    CameraPathOptions path_options;
    path_options.z_up = arguments.scene.up_axis == "z";
    Result<std::vector<CameraFrame>> path = read_camera_path(arguments.where, path_options);
    if (!path)
        return Status(path.status().code(), "--where " + arguments.where + " is neither a list of boxes (" +
                                                listed.status().message() + ") nor a camera path (" +
                                                path.status().message() + ")");
    double radius = arguments.where_radius > 0 ? arguments.where_radius : length(scene.world_bounds().size()) / 100;
    Vec3d around{radius, radius, radius};
    for (const CameraFrame& frame : *path)
        boxes.push_back({frame.eye - around, frame.eye + around});
    return boxes;
}

int print_plan(const BakeArguments& arguments, const BakePlan& plan) {
    if (arguments.common.json) {
        Json document;
        document["method"] = arguments.options.method;
        document["dry_run"] = true;
        document["cells"] = plan.grid.cells() ? plan.grid.cells() : plan.cells_to_bake;
        document["cells_to_bake"] = plan.cells_to_bake;
        document["cells_estimated"] = plan.is_cells_estimate;
        document["grid"] = plan.grid.count;
        document["estimated_seconds"] = plan.estimated_seconds;
        document["estimated_bytes"] = plan.estimated_bytes;
        print_json(document);
        return 0;
    }
    if (plan.grid.cells())
        fmt::print("grid       {} x {} x {}, {} of {} cells to bake\n", plan.grid.count[0], plan.grid.count[1],
                   plan.grid.count[2], plan.cells_to_bake, plan.grid.cells());
    else
        fmt::print("cells      {}{}\n", plan.is_cells_estimate ? "about " : "", plan.cells_to_bake);
    fmt::print("estimate   {:.3g} s, {:.3g} MB\n", plan.estimated_seconds, double(plan.estimated_bytes) * 1e-6);
    return 0;
}

/// Places of different objects that snapping moved apart.
std::uint64_t opened_cracks(const Scene& scene) {
    for (const Finding& finding : scene.findings())
        if (finding.kind == kCrackOpened)
            return finding.count;
    return 0;
}

int print_result(const BakeArguments& arguments, const BakeResult& result, std::size_t bytes,
                 std::uint64_t visibility_bytes, std::uint64_t opened_cracks) {
    const BakeStatistics& statistics = result.statistics;
    std::size_t objects = result.pvs.objects.size();
    double pairs = double(statistics.cells_baked) * double(objects);
    double bits_per_pair = pairs > 0 ? double(visibility_bytes) * 8 / pairs : 0;
    if (arguments.common.json) {
        Json document;
        document["method"] = result.pvs.method;
        document["guarantee"] = to_string(result.pvs.guarantee);
        document["crack_width"] = arguments.scene.crack_width;
        document["cracks_opened_by_snapping"] = opened_cracks;
        static constexpr const char* granularities[] = {"object", "cluster", "triangle"};
        document["granularity"] = granularities[std::size_t(arguments.options.exact.granularity)];
        document["clusters"] = result.pvs.cluster_count();
        document["cells"] = statistics.cells;
        document["cells_baked"] = statistics.cells_baked;
        document["cells_solid"] = statistics.cells_solid;
        document["cells_not_baked"] = statistics.cells_not_baked;
        document["cells_resumed"] = statistics.cells_resumed;
        document["objects"] = objects;
        document["seconds"] = statistics.seconds;
        document["cpu_seconds"] = statistics.cpu_seconds;
        document["rays"] = statistics.rays;
        document["bytes"] = bytes;
        document["coding"] = to_string(arguments.coding);
        document["visibility_bytes"] = visibility_bytes;
        document["bits_per_pair"] = bits_per_pair;
        document["mean_visible"] = statistics.mean_visible;
        document["undecided"] = statistics.exact.undecided; // a sampled bake decides nothing but what it has seen
        if (arguments.options.method == "exact")
            document["exact"] = {{"box_queries", statistics.exact.box_queries},
                                 {"triangle_queries", statistics.exact.triangle_queries},
                                 {"pairs", statistics.exact.pairs},
                                 {"found_by_query", statistics.exact.found_by_query},
                                 {"effective_occluders", statistics.exact.effective_occluders},
                                 {"queries_with_occluders", statistics.exact.queries_with_occluders},
                                 {"most_effective", statistics.exact.most_effective}};
        document["rays_reused"] = statistics.rays_reused;
        document["aimed_rays"] = statistics.aimed_rays;
        document["confirmed_pairs"] = statistics.confirmed_pairs;
        document["unconfirmed_pairs"] = statistics.unconfirmed_pairs;
        document["holdout_rays"] = statistics.holdout_rays;
        document["holdout_misses"] = statistics.holdout_misses;
        document["miss_rate"] = statistics.miss_rate;
        document["miss_rate_upper95"] = statistics.miss_rate_upper95;
        document["s1"] = statistics.pair_s1;
        document["pair_miss_at_s1"] = statistics.pair_miss_at_s1;
        print_json(document);
        return 0;
    }
    bool exact = arguments.options.method == "exact";
    fmt::print("guarantee  {}{}: {}\n", to_string(result.pvs.guarantee),
               arguments.scene.crack_width > 0 ? fmt::format(" for cracks closed up to {:g}", arguments.scene.crack_width) : "",
               !exact ? "what is listed is visible; what is missing is measured below"
               : statistics.exact.undecided ? "nothing is missing; some budgets ran out, see below"
                                            : "what is listed is visible from its cell, and nothing else is");
    fmt::print("cells      {} baked, {} inside matter, {} not asked for{}\n", statistics.cells_baked,
               statistics.cells_solid, statistics.cells_not_baked,
               statistics.cells_resumed ? fmt::format(", {} taken from the checkpoint", statistics.cells_resumed) : "");
    fmt::print("visible    {:.1f} of {} objects per cell on average\n", statistics.mean_visible, objects);
    fmt::print("miss rate  {:.3g} of fresh random rays first hit an unlisted object (95%: below {:.3g}; {} of {})\n",
               statistics.miss_rate, statistics.miss_rate_upper95, statistics.holdout_misses, statistics.holdout_rays);
    if (exact)
        fmt::print("exact      {} boxes and {} triangles asked for, {} pairs found that the rays had missed, {} undecided\n",
                   statistics.exact.box_queries, statistics.exact.triangle_queries, statistics.exact.found_by_query,
                   statistics.exact.undecided);
    if (opened_cracks > 0)
        fmt::print("cracks     snapping moved {} places of different objects apart; --crack-width closes such cracks\n", opened_cracks);
    fmt::print("rays       {:.4g} million in {:.2f} s ({:.2f} CPU s)\n", double(statistics.rays) * 1e-6,
               statistics.seconds, statistics.cpu_seconds);
    fmt::print("file       {}, {} bytes; visibility alone {} bytes, {:.3f} bits per (cell, object) pair\n",
               arguments.output, bytes, visibility_bytes, bits_per_pair);
    return 0;
}

/// A proof for every pair of cell and object, beside the file.
Status write_certificates(const BakeArguments& arguments, const Scene& scene, const Pvs& pvs,
                          std::span<const std::byte> pvs_bytes, const Job& job) {
    CertificateFileResult made;
    Result<std::vector<std::byte>> proof = make_certificates(scene, pvs, pvs_bytes, made, job);
    if (!proof)
        return proof.status().in("--certificates");
    std::string path = arguments.output + ".proof";
    if (Status status = write_file_atomically(path, std::span<const std::byte>(*proof)); !status)
        return status;
    note(fmt::format("{}: {} witnesses, {} subdivisions of {} nodes in all, {} bytes; check them with verify --certificates",
                     path, made.visible, made.trees, made.nodes, made.bytes));
    return {};
}

int run_bake(BakeArguments& arguments) {
    if (arguments.output.empty() && !arguments.dry_run)
        return fail({ErrorCode::usage, "bake needs -o OUT.pvs (or --dry-run)"});
    if (arguments.certificates && (arguments.options.method != "exact" || !arguments.shard.empty()))
        return fail({ErrorCode::usage, "--certificates needs --method exact and no --shard"});
    if (!arguments.cells.empty()) {
        auto cells = parse_counts(arguments.cells, "--cells");
        if (!cells)
            return fail(cells.status());
        arguments.options.cells = *cells;
    }
    if (!arguments.volumes.empty()) {
        auto volumes = parse_counts(arguments.volumes, "--volumes");
        if (!volumes)
            return fail(volumes.status());
        arguments.options.volumes = *volumes;
    }
    if (!arguments.shard.empty()) {
        Result<Shard> shard = parse_shard(arguments.shard);
        if (!shard)
            return fail(shard.status());
        arguments.options.shard = *shard;
    }
    if (arguments.alpha > 0 || arguments.beta > 0) {
        SprtOptions& test = arguments.options.sequential;
        if (!(arguments.alpha > 0 && arguments.alpha < 1 && arguments.beta > 0 && arguments.beta < 1))
            return fail({ErrorCode::usage, "--alpha and --beta go together, each between 0 and 1"});
        WaldThresholds thresholds = wald_thresholds(arguments.alpha, arguments.beta);
        test.a = thresholds.a;
        test.b = thresholds.b;
    }
    arguments.scene.count_cracks = true;
    Result<Scene> scene = arguments.scene.load();
    if (!scene)
        return fail(scene.status());
    Result<std::vector<Box3d>> where = read_where(arguments, *scene);
    if (!where)
        return fail(where.status());
    arguments.options.where = std::move(*where);
    arguments.options.seed = arguments.common.seed;
    Job job = make_job(arguments.common);
    if (arguments.dry_run) {
        Result<BakePlan> plan = plan_bake(*scene, arguments.options, job);
        return plan ? print_plan(arguments, *plan) : fail(plan.status());
    }
    arguments.options.checkpoint = arguments.output + ".part";
    Result<BakeResult> result = bake(*scene, arguments.options, job);
    if (!result)
        return fail(result.status());
    Result<std::vector<std::byte>> bytes = encode_pvs(result->pvs, arguments.coding);
    if (!bytes)
        return fail(bytes.status());
    Result<Pvs> written = Pvs::open(*bytes);
    if (!written)
        return fail(written.status());
    if (Status status = write_file_atomically(arguments.output, *bytes); !status)
        return fail(status);
    if (arguments.certificates)
        if (Status status = write_certificates(arguments, *scene, *written, *bytes, job); !status)
            return fail(status);
    if (Status status = remove_file(arguments.options.checkpoint); !status)
        return fail(status);
    if (result->statistics.cells_baked == 0)
        note("every cell lies inside matter; if the scene is inside out, try --sides both");
    return print_result(arguments, *result, bytes->size(), written->visibility_bytes(), opened_cracks(*scene));
}

} // namespace

void add_bake(CLI::App& app) {
    auto arguments = std::make_shared<BakeArguments>();
    BakeOptions& options = arguments->options;
    CLI::App& command = *app.add_subcommand("bake", "What can be seen from every cell of viewpoints, into a .pvs file");
    arguments->scene.add_to(command);
    command.add_option("-o,--output", arguments->output, "The .pvs file to write; OUT.part keeps finished cells");
    command.add_option("--method", options.method, "How to bake")->check(CLI::IsMember({"sampled", "exact"}))->capture_default_str();
    ViewTreeOptions& tree = options.tree;
    command
        .add_option("--subdivision", tree.subdivision, "How view space is cut: grid, or a tree over space, over space "
                                                       "with eight headings a leaf, or over all five dimensions; or "
                                                       "boxes: those of --where are the cells")
        ->transform(CLI::CheckedTransformer(std::map<std::string, Subdivision>{{"grid", Subdivision::grid},
                                                                               {"spatial", Subdivision::spatial},
                                                                               {"angular", Subdivision::angular},
                                                                               {"five", Subdivision::five},
                                                                               {"boxes", Subdivision::boxes}}))
        ->default_str("grid");
    command
        .add_option("--split-estimate", tree.estimate, "Trees: count what both sides see against all (published), or "
                                                       "against chance (corrected)")
        ->transform(CLI::CheckedTransformer(std::map<std::string, SplitEstimate>{
            {"published", SplitEstimate::published}, {"corrected", SplitEstimate::corrected}}))
        ->default_str("corrected");
    command.add_option("--effectiveness", tree.effectiveness, "Trees: split only above this")->capture_default_str();
    command.add_option("--min-visible", tree.min_visible, "Trees: split only where so many triangles are visible")
        ->capture_default_str();
    command.add_option("--max-depth", tree.max_depth, "Trees: most splits below a tile")->capture_default_str();
    command.add_option("--min-extent", tree.min_extent, "Trees: least extent of a cell, as a share of view space")
        ->capture_default_str();
    command.add_option("--node-rays", tree.node_rays, "Trees: rays for the rough visibility of a node")
        ->capture_default_str();
    command.add_option("--view-space", tree.view_space, "Trees: view space as a multiple of the scene's box")
        ->capture_default_str();
    command.add_option("--tile-depth", tree.tile_depth, "Trees: 2^N tiles, baked independently")->capture_default_str();
    auto* cells = command.add_option("--cells", arguments->cells, "Cells along x, y, z [16x4x16]");
    command.add_option("--cell-size", options.cell_size, "Edge of a cell in scene units, instead of --cells")
        ->excludes(cells)
        ->check(CLI::PositiveNumber);
    command.add_option("--where", arguments->where,
                       "Where viewers can be: boxes.json, a camera path, or auto (the scene's bounds)");
    command.add_option("--where-radius", arguments->where_radius,
                       "How far around a camera path viewers can be [1/100 of the scene's diagonal]");
    command.add_flag("--dry-run", arguments->dry_run, "Estimate time and size from a few cells, write nothing");
    command.add_flag("--resume", options.resume, "Take up the finished cells of an interrupted bake");
    command.add_flag("--certificates", arguments->certificates,
                     "Exact bakes: store a proof for every pair of cell and object in OUT.pvs.proof");
    command.add_option("--shard", arguments->shard, "Bake part I of N only, for `antumbra merge`: I/N");
    std::map<std::string, PvsCoding> codings;
    for (PvsCoding coding : {PvsCoding::cheapest, PvsCoding::tree_leaves, PvsCoding::tree_parent,
                             PvsCoding::tree_sibling, PvsCoding::references, PvsCoding::archive})
        codings[to_string(coding)] = coding;
    command.add_option("--coding", arguments->coding, "How the file stores its rows; all are lossless")
        ->transform(CLI::CheckedTransformer(codings))
        ->default_str(to_string(arguments->coding));
    command
        .add_option("--granularity", options.exact.granularity, "What is listed besides objects (method exact)")
        ->transform(CLI::CheckedTransformer(std::map<std::string, Granularity>{{"object", Granularity::object},
                                                                               {"cluster", Granularity::cluster},
                                                                               {"triangle", Granularity::triangle}}))
        ->default_str("object");
    command.add_option("--cluster-order", options.exact.cluster_order,
                       "Clusters of triangles that lie together in space (sort index buffers by them), or runs of the file's order")
        ->transform(CLI::CheckedTransformer(
            std::map<std::string, ClusterOrder>{{"compact", ClusterOrder::compact}, {"file", ClusterOrder::file}}))
        ->default_str("compact");
    command.add_option("--cluster-triangles", options.exact.cluster_triangles, "Most triangles of a cluster")
        ->capture_default_str();
    command
        .add_option("--exact-form", options.exact.form, "The query of method exact: lazy, or as published in 2002")
        ->transform(CLI::CheckedTransformer(
            std::map<std::string, ExactForm>{{"fast", ExactForm::fast}, {"published", ExactForm::published}}))
        ->default_str("fast");
    command.add_option("--max-pieces", options.exact.max_pieces, "Budget of one exact query, in pieces of line space")
        ->capture_default_str();
    command.add_option("--cell-work", options.exact.cell_work,
                       "Budget of one exact cell, in pieces and pairs of faces; what it leaves open is listed (0: no end)")
        ->capture_default_str();
    command.add_option("--block", options.exact.block,
                       "Exact grids: solve cells in blocks of so many along each axis, from the outside in")
        ->check(CLI::IsMember({1, 2, 4, 8, 16, 32, 64}))
        ->capture_default_str();
    command.add_option("--rays-per-cell", options.rays_per_cell, "Rays in uniform directions")->capture_default_str();
    command
        .add_option("--sampling", options.sampling, "How those rays are spent")
        ->transform(CLI::CheckedTransformer(std::map<std::string, Sampling>{{"uniform", Sampling::uniform},
                                                                            {"guided", Sampling::guided}}))
        ->default_str("uniform");
    SprtOptions& test = options.sequential;
    command
        .add_option("--sprt", test.reading, "Reading of the sequential test of each object not seen by those")
        ->transform(CLI::CheckedTransformer(std::map<std::string, SprtReading>{
            {"wald", SprtReading::wald}, {"printed", SprtReading::printed}, {"normalised", SprtReading::normalised}}))
        ->default_str("wald");
    command.add_option("--st", test.s_t, "Share of hits below which an object need not be found")->capture_default_str();
    command.add_option("--s1", test.s_1, "Share of hits at which it should be")->capture_default_str();
    command.add_option("--sprt-a", test.a, "Visible above this likelihood ratio")->capture_default_str();
    command.add_option("--sprt-b", test.b, "Invisible below this likelihood ratio")->capture_default_str();
    auto* by_ratio = command.get_option("--sprt-a");
    command.add_option("--alpha", arguments->alpha, "Instead of the ratios: rate of calling an object of share --st visible")
        ->excludes(by_ratio);
    command.add_option("--beta", arguments->beta, "Instead of the ratios: rate of losing an object of share --s1")
        ->excludes(by_ratio);
    command.add_option("--volumes", arguments->volumes,
                       "Occludee volumes along x, y, z, so that moving boxes can be asked about");
    command.add_flag("--informed-prior", options.informed_prior,
                     "Weigh the test by how often objects of like size and distance were seen");
    command.add_option("--holdout-rays", options.holdout_rays, "Rays per cell that only measure the miss rate")
        ->capture_default_str();
    add_common(command, arguments->common, "antumbra bake house.glb -o house.pvs --cell-size 2",
               [arguments] { return run_bake(*arguments); });
}

} // namespace antumbra::app
