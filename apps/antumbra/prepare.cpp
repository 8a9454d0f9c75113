#include "command.hpp"

#include "base/file.hpp"
#include "evaluate/cull_scene.hpp"

#include <antumbra/bake.hpp>
#include <antumbra/cull.hpp>
#include <antumbra/evaluate.hpp>
#include <antumbra/occluder_finding.hpp>

#include <fmt/format.h>

namespace antumbra::app {
namespace {

struct PrepareArguments {
    Common common;
    SceneArguments scene;
    std::string pvs, output;
    OccluderOptions occluders;
    PrepareOptions prepare;
    bool no_merge = false, no_inner_boxes = false;
};

/// The file that the chunks go into: a copy of a bake, or one without cells.
Result<std::vector<std::byte>> file_for(const PrepareArguments& arguments, const Scene& scene) {
    if (arguments.pvs.empty())
        return encode_pvs(describe_scene(scene));
    Result<MappedFile> file = MappedFile::open(arguments.pvs);
    if (!file)
        return file.status();
    Result<Pvs> pvs = Pvs::open(file->bytes());
    if (!pvs)
        return pvs.status().in(arguments.pvs);
    if (Status status = check_belongs(scene, *pvs); !status)
        return status.in(arguments.pvs);
    return std::vector<std::byte>(file->bytes().begin(), file->bytes().end());
}

/// Every chunk that `prepare` makes. Another one is added here.
Result<std::vector<PvsChunk>> make_chunks(const PrepareArguments& arguments, const Scene& scene,
                                          OccluderStatistics& statistics) {
    OccluderOptions options = arguments.occluders;
    options.merge = !arguments.no_merge;
    options.inner_boxes = !arguments.no_inner_boxes;
    CullScene cull_scene = cull_scene_of(scene, find_occluders(scene, options, &statistics));
    return prepare_chunks(cull_scene, arguments.prepare);
}

void print_result(const PrepareArguments& arguments, const std::vector<PvsChunk>& chunks,
                  const OccluderStatistics& statistics, std::size_t bytes) {
    if (arguments.common.json) {
        Json document;
        document["file"] = arguments.output;
        document["bytes"] = bytes;
        document["polygons"] = statistics.polygons;
        document["inner_boxes"] = statistics.inner_boxes;
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
    OccluderStatistics statistics;
    Result<std::vector<PvsChunk>> chunks = make_chunks(arguments, *scene, statistics);
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
    command.add_option("--leaves", arguments->prepare.leaves, "Leaves of space that have occluder sets of their own")
        ->check(CLI::Range(1, 1 << 20))
        ->capture_default_str();
    command.add_option("--per-set", arguments->prepare.per_set, "Occluders for each leaf and direction; 0: no sets")
        ->check(CLI::Range(0, 4096))
        ->capture_default_str();
    command.add_flag("--no-merge", arguments->no_merge, "Leave coplanar triangles unmerged");
    command.add_flag("--inner-shells", arguments->occluders.inner_shells, "Look for simplified shells inside dense closed meshes");
    command.add_flag("--no-inner-boxes", arguments->no_inner_boxes, "Look for no boxes inside closed meshes");
    add_common(command, arguments->common, "antumbra prepare city.glb --pvs city.pvs -o city-prepared.pvs",
               [arguments] { return run_prepare(*arguments); });
}

} // namespace antumbra::app
