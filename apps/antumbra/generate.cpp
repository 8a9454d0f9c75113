#include "command.hpp"

#include "base/file.hpp"

#include <antumbra/export.hpp>
#include <antumbra/generate.hpp>

#include <fmt/format.h>
#include <fmt/ranges.h>

namespace antumbra::app {
namespace {

struct GenerateArguments {
    Common common;
    std::string kind, output;
    GenerateOptions options;
};

int run_generate(GenerateArguments& arguments) {
    arguments.options.seed = arguments.common.seed;
    Result<RawScene> scene = generate(arguments.kind, arguments.options);
    if (!scene)
        return fail(scene.status());
    Result<std::vector<std::byte>> bytes = export_glb(*scene);
    if (!bytes)
        return fail(bytes.status());
    if (Status written = write_file_atomically(arguments.output, *bytes); !written)
        return fail(written);
    if (arguments.common.json) {
        Json document;
        document["kind"] = arguments.kind;
        document["file"] = arguments.output;
        document["objects"] = scene->objects.size();
        document["triangles"] = scene->triangles.size();
        document["bytes"] = bytes->size();
        print_json(document);
    } else {
        fmt::print("{}: {} objects, {} triangles, {} bytes\n", arguments.output, scene->objects.size(),
                   scene->triangles.size(), bytes->size());
    }
    return 0;
}

} // namespace

void add_generate(CLI::App& app) {
    auto arguments = std::make_shared<GenerateArguments>();
    CLI::App& command = *app.add_subcommand("generate", "A procedural scene in the manner of the papers");
    command
        .add_option("KIND", arguments->kind, fmt::format("One of: {}", fmt::join(generator_names(), ", ")))
        ->required();
    command.add_option("-o,--output", arguments->output, "The scene to write (.glb)")->required();
    command
        .add_option("--triangles", arguments->options.triangles,
                    "Wanted size, where the kind can scale (within a tenth); 0: that of the paper's scene")
        ->capture_default_str();
    command
        .add_option("--copies", arguments->options.copies, "apartment only: a block of so many equal flats")
        ->capture_default_str();
    command.add_option("--storeys", arguments->options.storeys, "office only: so many; 0: in proportion")
        ->capture_default_str();
    command
        .add_option("--plants", arguments->options.plants, "office only: exactly so many, spread at random; 0: in proportion")
        ->capture_default_str();
    add_common(command, arguments->common, "antumbra generate apartment -o apartment.glb",
               [arguments] { return run_generate(*arguments); });
}

} // namespace antumbra::app
