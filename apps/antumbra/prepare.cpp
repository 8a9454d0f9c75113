#include "command.hpp"

#include "base/file.hpp"
#include "evaluate/cull_scene.hpp"

#include <antumbra/bake.hpp>
#include <antumbra/cull.hpp>
#include <antumbra/evaluate.hpp>
#include <antumbra/mos.hpp>
#include <antumbra/occluder_finding.hpp>

#include <fmt/format.h>

#include <cstdio>

namespace antumbra::app {
namespace {

struct PrepareArguments {
    Common common;
    SceneArguments scene;
    std::string pvs, output;
    OccluderOptions occluders;
    PrepareOptions prepare;
    bool no_merge = false, no_inner_boxes = false, no_inner_solids = false;
    bool minimum_sets = false;
    MosOptions mos;
    std::string grid = "8x1x8", region;
};

/// The file that the chunks go into: a copy of a bake, or one without cells.
Result<std::vector<std::byte>> file_for(const PrepareArguments& arguments, const Scene& scene) {
    if (arguments.pvs.empty())
        return encode_pvs(describe_scene(scene));
    Result<PvsFile> opened = open_pvs(arguments.pvs, scene);
    if (!opened)
        return opened.status();
    return std::vector<std::byte>(opened->bytes().begin(), opened->bytes().end());
}

/// Minimum occluder sets, kept point by point beside the output while they are made.
Result<OccluderDatabase> make_minimum_sets(const PrepareArguments& arguments, const Scene& scene,
                                           const OccluderSet& occluders) {
    MosOptions options = arguments.mos;
    int end = 0;
    if (std::sscanf(arguments.grid.c_str(), "%ux%ux%u%n", &options.grid[0], &options.grid[1], &options.grid[2], &end) != 3 ||
        std::size_t(end) != arguments.grid.size())
        return Status(ErrorCode::usage, "--mos-grid wants NXxNYxNZ such as 16x1x16, not '" + arguments.grid + "'");
    if (!arguments.region.empty()) {
        double v[6];
        end = 0;
        if (std::sscanf(arguments.region.c_str(), "%lf,%lf,%lf,%lf,%lf,%lf%n", &v[0], &v[1], &v[2], &v[3], &v[4], &v[5],
                        &end) != 6 ||
            std::size_t(end) != arguments.region.size())
            return Status(ErrorCode::usage, "--mos-region wants X0,Y0,Z0,X1,Y1,Z1, not '" + arguments.region + "'");
        options.region = {{v[0], v[1], v[2]}, {v[3], v[4], v[5]}};
        if (options.region.empty())
            return Status(ErrorCode::usage, "--mos-region: the second corner lies before the first");
    }
    options.checkpoint = arguments.output + ".mos-checkpoint";
    MosStatistics statistics;
    Result<OccluderDatabase> database =
        build_occluder_database(scene, occluders, options, make_job(arguments.common), &statistics);
    if (!database)
        return database;
    std::remove(options.checkpoint.c_str());
    if (!arguments.common.json)
        fmt::print("{} grid points ({} resumed): {} minimum sets for {} occludees, {:.1f} s\n", database->points(),
                   statistics.points_resumed, statistics.sets, statistics.occludees, statistics.seconds);
    return database;
}

/// Every chunk that `prepare` makes. Another one is added here.
Result<std::vector<PvsChunk>> make_chunks(const PrepareArguments& arguments, const Scene& scene, const Pvs& pvs,
                                          OccluderStatistics& statistics) {
    OccluderOptions options = arguments.occluders;
    options.merge = !arguments.no_merge;
    options.inner_boxes = !arguments.no_inner_boxes;
    options.inner_solids = !arguments.no_inner_solids;
    PrepareOptions prepare = arguments.prepare;
    prepare.pvs = &pvs;
    OccluderSet occluders = find_occluders(scene, options, &statistics);
    CullScene cull_scene = cull_scene_of(scene, occluders);
    Result<std::vector<PvsChunk>> chunks = prepare_chunks(cull_scene, prepare, make_job(arguments.common));
    if (!chunks || !arguments.minimum_sets)
        return chunks;
    Result<OccluderDatabase> database = make_minimum_sets(arguments, scene, occluders);
    if (!database)
        return database.status();
    chunks->push_back(occluder_database_chunk(*database));
    return chunks;
}

void print_result(const PrepareArguments& arguments, const std::vector<PvsChunk>& chunks,
                  const OccluderStatistics& statistics, std::size_t bytes) {
    if (arguments.common.json) {
        Json document;
        document["file"] = arguments.output;
        document["bytes"] = bytes;
        document["polygons"] = statistics.polygons;
        document["inner_boxes"] = statistics.inner_boxes;
        document["inner_solids"] = statistics.inner_solids;
        document["chunks"] = Json::array();
        for (const PvsChunk& chunk : chunks)
            document["chunks"].push_back({{"name", chunk.name}, {"bytes", chunk.bytes.size()}});
        return print_json(document);
    }
    fmt::print("{}: {} bytes, {} convex polygons, {} inner boxes\n", arguments.output, bytes, statistics.polygons,
               statistics.inner_boxes);
    for (const PvsChunk& chunk : chunks)
        fmt::print("  chunk {}  {} bytes\n", chunk.name, chunk.bytes.size());
}

int run_prepare(const PrepareArguments& arguments) {
    Result<Scene> scene = arguments.scene.load();
    if (!scene)
        return fail(scene.status());
    Result<std::vector<std::byte>> file = file_for(arguments, *scene);
    if (!file)
        return fail(file.status());
    Result<Pvs> pvs = Pvs::open(*file);
    if (!pvs)
        return fail(pvs.status());
    OccluderStatistics statistics;
    Result<std::vector<PvsChunk>> chunks = make_chunks(arguments, *scene, *pvs, statistics);
    if (!chunks)
        return fail(chunks.status());
    Result<std::vector<std::byte>> prepared = add_pvs_chunks(*file, *chunks);
    if (!prepared)
        return fail(prepared.status());
    if (Status status = write_file_atomically(arguments.output, std::span<const std::byte>(*prepared)); !status)
        return fail(status);
    print_result(arguments, *chunks, statistics, prepared->size());
    return 0;
}

} // namespace

void add_prepare(CLI::App& app) {
    auto arguments = std::make_shared<PrepareArguments>();
    CLI::App& command = *app.add_subcommand(
        "prepare", "Stores what run-time culling needs: occluders, trees and occluder sets, as chunks of a .pvs file");
    arguments->scene.add_to(command);
    command.add_option("-o,--output", arguments->output, "File to write: .pvs")->required();
    command.add_option("--pvs", arguments->pvs, "A bake of the same scene to copy; without one the file has no cells");
    command.add_option("--leaves", arguments->prepare.leaves, "Cells of space that have occluder sets of their own; with --pvs its cells, several together where they are more")
        ->check(CLI::Range(1, 1 << 20))
        ->capture_default_str();
    command.add_option("--first-hit-leaves", arguments->prepare.first_hit_leaves, "Cells that have sets by first hit")
        ->check(CLI::Range(1, 1 << 20))
        ->capture_default_str();
    command.add_option("--per-set", arguments->prepare.per_set, "Occluders for each leaf and direction; 0: no sets")
        ->check(CLI::Range(0, 4096))
        ->capture_default_str();
    command.add_flag("--no-merge", arguments->no_merge, "Leave coplanar triangles unmerged");
    command.add_flag("--inner-shells", arguments->occluders.inner_shells, "Look for simplified shells inside dense closed meshes");
    command.add_flag("--no-inner-boxes", arguments->no_inner_boxes, "Look for no boxes nor solids inside closed meshes");
    command.add_flag("--no-inner-solids", arguments->no_inner_solids, "Look for no oriented boxes nor convex solids inside closed meshes");
    command.add_flag("--mos", arguments->minimum_sets,
                     "Minimum occluder sets for a grid of viewpoints, for the method opacity");
    command.add_option("--mos-grid", arguments->grid, "Grid points along x, y and z")->capture_default_str();
    command.add_option("--mos-region", arguments->region,
                       "Where viewers are, X0,Y0,Z0,X1,Y1,Z1: the grid is spread over it [the whole scene]");
    command.add_option("--mos-limit", arguments->mos.limit, "Occluders in a list at most")
        ->check(CLI::Range(1, 65536))
        ->capture_default_str();
    command.add_flag("--resume", arguments->mos.resume, "Go on with grid points that an interrupted run has finished");
    add_common(command, arguments->common, "antumbra prepare city.glb --pvs city.pvs -o city-prepared.pvs",
               [arguments] { return run_prepare(*arguments); });
}

} // namespace antumbra::app
