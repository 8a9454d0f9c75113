#include "command.hpp"

#include "base/file.hpp"

#include <antumbra/bake.hpp>

#include <fmt/format.h>

namespace antumbra::app {
namespace {

struct MergeArguments {
    Common common;
    std::vector<std::string> parts;
    std::string output;
};

int run_merge(const MergeArguments& arguments) {
    std::vector<MappedFile> files;
    std::vector<Pvs> parts;
    for (const std::string& path : arguments.parts) {
        Result<PvsFile> opened = open_pvs(path);
        if (!opened)
            return fail(opened.status());
        if (!parts.empty() && opened->pvs.coding() != parts[0].coding())
            return fail({ErrorCode::mismatch, path + ": has another --coding than " + arguments.parts[0]});
        files.push_back(std::move(opened->file));
        parts.push_back(std::move(opened->pvs));
    }
    Result<PvsData> merged = merge_parts(parts, arguments.parts);
    if (!merged)
        return fail(merged.status());
    Result<std::vector<std::byte>> bytes = encode_pvs(*merged, parts[0].coding());
    if (!bytes)
        return fail(bytes.status());
    if (Status status = write_file_atomically(arguments.output, std::span<const std::byte>(*bytes)); !status)
        return fail(status);
    if (arguments.common.json)
        print_json({{"parts", parts.size()},
                    {"guarantee", to_string(merged->guarantee)},
                    {"cells", merged->grid.cells()},
                    {"rows", merged->row_count},
                    {"objects", merged->objects.size()},
                    {"bytes", bytes->size()}});
    else
        fmt::print("{}: {} parts, {}, {} bytes\n", arguments.output, parts.size(), to_string(merged->guarantee),
                   bytes->size());
    return 0;
}

} // namespace

void add_merge(CLI::App& app) {
    auto arguments = std::make_shared<MergeArguments>();
    CLI::App& command = *app.add_subcommand("merge", "Unite the parts of a bake that was done with --shard");
    command.add_option("PART", arguments->parts, "All parts, in any order")->required();
    command.add_option("-o,--output", arguments->output, "The .pvs file to write")->required();
    add_common(command, arguments->common, "antumbra merge part1.pvs part2.pvs -o house.pvs",
               [arguments] { return run_merge(*arguments); });
}

} // namespace antumbra::app
