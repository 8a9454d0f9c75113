#include "command.hpp"

#include "base/file.hpp"
#include "evaluate/census.hpp"
#include "pvs/chunks.hpp"

#include <antumbra/evaluate.hpp>
#include <antumbra/pvs.hpp>

#include <fmt/format.h>

namespace antumbra::app {
namespace {

struct InspectArguments {
    Common common;
    std::string file, report;
    std::size_t worst = 5;
};

double bits_per_pair(const Pvs& pvs, const Census& census) {
    double pairs = double(census.baked) * pvs.object_count();
    return pairs > 0 ? double(pvs.visibility_bytes()) * 8 / pairs : 0;
}

Json box_json(const Box3d& box) { return {{box.min.x, box.min.y, box.min.z}, {box.max.x, box.max.y, box.max.z}}; }

std::string hex(std::span<const std::uint8_t> bytes) {
    std::string text;
    for (std::uint8_t byte : bytes)
        text += fmt::format("{:02x}", byte);
    return text;
}

std::string format_version() { return fmt::format("{}.{}", kPvsFormatVersion >> 16, kPvsFormatVersion & 0xFFFF); }

void print_as_json(const Pvs& pvs, const std::vector<Section>& sections, const Census& census, std::size_t worst) {
    const CellGrid& grid = pvs.grid();
    Json document;
    document["format"] = format_version();
    document["tool_version"] = std::string(pvs.tool_version());
    document["method"] = std::string(pvs.method());
    document["guarantee"] = to_string(pvs.guarantee());
    document["crack_width"] = crack_width(pvs);
    document["coding"] = to_string(pvs.coding());
    document["volumes"] = pvs.volumes().cells();
    document["sides"] = pvs.sides() == 1 ? "both" : "material";
    document["scene_fingerprint"] = hex(pvs.scene_fingerprint());
    document["structure_fingerprint"] = fmt::format("{:016x}", pvs.structure_fingerprint());
    Json options = Json::parse(pvs.options_json(), nullptr, false);
    document["options"] = options.is_discarded() ? Json(std::string(pvs.options_json())) : options;
    document["objects"] = pvs.object_count();
    document["bytes"] = pvs.file_bytes();
    document["visibility_bytes"] = pvs.visibility_bytes();
    document["bits_per_pair"] = bits_per_pair(pvs, census);
    document["chunks"] = Json::array();
    for (const Section& section : sections) {
        std::string name = to_string(section.id);
        document["chunks"].push_back({{"name", name.substr(1, name.size() - 2)}, {"bytes", section.bytes.size()}});
    }
    if (pvs.tree().nodes.empty())
        document["grid"] = {{"count", {grid.count[0], grid.count[1], grid.count[2]}}, {"bounds", box_json(grid.bounds)}};
    else
        document["tree"] = {{"nodes", pvs.tree().nodes.size()}, {"bounds", box_json(pvs.tree().bounds)}};
    document["cells"] = census.cells.size();
    document["cells_baked"] = census.baked;
    document["cells_solid"] = census.solid;
    document["cells_not_baked"] = census.not_baked;
    document["rows"] = pvs.row_count();
    document["mean_visible"] = census.mean_visible;
    document["worst"] = Json::array();
    for (const CensusCell& cell : census.worst(worst))
        document["worst"].push_back({{"cell", cell.index}, {"visible", cell.visible}, {"box", box_json(cell.box)}});
    document["costliest"] = Json::array();
    for (const CensusObject& object : costliest_objects(pvs, census, worst))
        document["costliest"].push_back({{"id", object.object},
                                         {"name", std::string(pvs.object_name(object.object))},
                                         {"cells", object.cells},
                                         {"cost", object.cost}});
    print_json(document);
}

std::string box_text(const Box3d& box) {
    return fmt::format("({:g}, {:g}, {:g}) .. ({:g}, {:g}, {:g})", box.min.x, box.min.y, box.min.z, box.max.x,
                       box.max.y, box.max.z);
}

void print_as_text(const Pvs& pvs, const std::vector<Section>& sections, const Census& census, std::size_t worst) {
    const CellGrid& grid = pvs.grid();
    fmt::print("format       {}, written by Antumbra {}\n", format_version(), pvs.tool_version());
    fmt::print("method       {}\nguarantee    {}\nsides        {}\n", pvs.method(), describe_guarantee(pvs),
               pvs.sides() == 1 ? "both" : "material");
    fmt::print("scene        {}, structure {:016x}\n", hex(pvs.scene_fingerprint()), pvs.structure_fingerprint());
    fmt::print("options      {}\n", pvs.options_json());
    fmt::print("objects      {}\n", pvs.object_count());
    if (pvs.tree().nodes.empty())
        fmt::print("cells        {} x {} x {} in {}\n", grid.count[0], grid.count[1], grid.count[2],
                   box_text(grid.bounds));
    else
        fmt::print("cells        {} leaves of a view tree in {}\n", census.cells.size(), box_text(pvs.tree().bounds));
    fmt::print("             {} baked, {} solid, {} not baked, {} distinct rows\n", census.baked, census.solid,
               census.not_baked, pvs.row_count());
    fmt::print("coding       {}\n", to_string(pvs.coding()));
    if (pvs.volumes().cells() > 0)
        fmt::print("volumes      {} for moving things\n", pvs.volumes().cells());
    fmt::print("visible      {:.1f} objects from a baked cell on average\n", census.mean_visible);
    fmt::print("bytes        {}, of which visibility {} ({:.4f} bits per pair of cell and object)\n",
               pvs.file_bytes(), pvs.visibility_bytes(), bits_per_pair(pvs, census));
    for (const Section& section : sections)
        fmt::print("  chunk {}  {}\n", to_string(section.id), section.bytes.size());
    for (const CensusCell& cell : census.worst(worst))
        fmt::print("worst cell   {} sees {} from {}\n", cell.index, cell.visible, box_text(cell.box));
    for (const CensusObject& object : costliest_objects(pvs, census, worst))
        fmt::print("costliest    {} is seen from {} cells, {} triangles over all\n", pvs.object_name(object.object),
                   object.cells, object.cost);
}

int run_inspect(const InspectArguments& arguments) {
    Result<PvsFile> opened = open_pvs(arguments.file);
    if (!opened)
        return fail(opened.status());
    const Pvs& pvs = opened->pvs;
    std::vector<Section> sections = *read_chunks(opened->bytes());
    Census census = take_census(pvs);
    if (!arguments.report.empty()) {
        std::string page = census_page(pvs, census, arguments.file.substr(arguments.file.find_last_of('/') + 1));
        if (Status status = write_file_atomically(arguments.report, page); !status)
            return fail(status);
    }
    (arguments.common.json ? print_as_json : print_as_text)(pvs, sections, census, arguments.worst);
    return 0;
}

} // namespace

void add_inspect(CLI::App& app) {
    auto arguments = std::make_shared<InspectArguments>();
    CLI::App& command = *app.add_subcommand("inspect", "What a baked file holds and promises");
    command.add_option("FILE", arguments->file, "Baked file: .pvs")->required();
    command.add_option("--worst", arguments->worst, "How many of the cells that see most, and of the costliest objects, to list")
        ->capture_default_str();
    command.add_option("--report", arguments->report, "Write a page: the cells from above, coloured by what they see");
    add_common(command, arguments->common, "antumbra inspect house.pvs --report cells.html",
               [arguments] { return run_inspect(*arguments); });
}

} // namespace antumbra::app
