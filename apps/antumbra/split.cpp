#include "command.hpp"

#include "base/file.hpp"

#include <antumbra/export.hpp>
#include <antumbra/split.hpp>

#include <fmt/format.h>

namespace antumbra::app {
namespace {

struct SplitArguments {
    Common common;
    SceneArguments scene;
    SplitOptions options;
    std::string output;
};

int run_split(const SplitArguments& arguments) {
    Result<Scene> scene = arguments.scene.load();
    if (!scene)
        return fail(scene.status());
    SplitStatistics statistics;
    RawScene split = split_scene(*scene, arguments.options, &statistics);
    Result<std::vector<std::byte>> bytes = export_glb(split);
    if (!bytes)
        return fail(bytes.status().in(arguments.output));
    if (Status status = write_file_atomically(arguments.output, std::span<const std::byte>(*bytes)); !status)
        return fail(status);
    if (arguments.common.json)
        print_json({{"objects_before", scene->objects().size()},
                    {"objects", split.objects.size()},
                    {"objects_cut", statistics.objects_cut},
                    {"clusters", statistics.clusters},
                    {"triangles", split.triangles.size()},
                    {"bytes", bytes->size()}});
    else
        fmt::print("{}: {} of {} objects cut into {} clusters, {} objects now, {} triangles as before\n", arguments.output,
                   statistics.objects_cut, scene->objects().size(), statistics.clusters, split.objects.size(),
                   split.triangles.size());
    return 0;
}

} // namespace

void add_split(CLI::App& app) {
    auto arguments = std::make_shared<SplitArguments>();
    CLI::App& command = *app.add_subcommand("split", "Cut big objects into clusters that a renderer can hide");
    arguments->scene.add_to(command);
    command.add_option("-o,--output", arguments->output, "The .glb file to write (geometry alone, without textures)")
        ->required();
    command.add_option("--most-triangles", arguments->options.most_triangles, "In a cluster")
        ->check(CLI::Range(1, 1 << 30))
        ->capture_default_str();
    add_common(command, arguments->common, "antumbra split terrain.glb -o clusters.glb",
               [arguments] { return run_split(*arguments); });
}

} // namespace antumbra::app
