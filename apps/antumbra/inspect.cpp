#include "command.hpp"

#include "base/file.hpp"
#include "pvs/chunks.hpp"

#include <antumbra/pvs.hpp>

#include <fmt/format.h>

#include <algorithm>
#include <bit>

namespace antumbra::app {
namespace {

struct InspectArguments {
    Common common;
    std::string file;
    std::size_t worst = 5;
};

struct CellCount {
    std::uint64_t cell;
    std::uint32_t visible;
};

/// What the cells see, counted.
struct Census {
    std::uint64_t baked = 0, not_baked = 0, solid = 0;
    double mean_visible = 0;
    std::vector<CellCount> worst; ///< most visible first
};

std::vector<std::uint32_t> count_rows(const Pvs& pvs) {
    std::vector<std::uint32_t> counts(pvs.row_count());
    std::vector<std::uint64_t> words(pvs.words_per_row());
    for (std::uint32_t row = 0; row < pvs.row_count(); ++row) {
        pvs.decode_row(row, words);
        for (std::uint64_t word : words)
            counts[row] += static_cast<std::uint32_t>(std::popcount(word));
    }
    return counts;
}

Census take_census(const Pvs& pvs, std::size_t worst) {
    Census census;
    std::vector<std::uint32_t> counts = count_rows(pvs);
    std::vector<CellCount> cells;
    std::uint64_t sum = 0;
    for (std::uint64_t cell = 0; cell < pvs.grid().cells(); ++cell) {
        std::uint32_t row = pvs.cell_row(cell);
        census.not_baked += row == kCellNotBaked;
        census.solid += row == kCellSolid;
        if (row >= kCellSolid)
            continue;
        cells.push_back({cell, counts[row]});
        sum += counts[row];
    }
    census.baked = cells.size();
    census.mean_visible = cells.empty() ? 0 : double(sum) / double(cells.size());
    std::size_t shown = std::min(worst, cells.size());
    std::partial_sort(cells.begin(), cells.begin() + std::ptrdiff_t(shown), cells.end(),
                      [](const CellCount& a, const CellCount& b) {
                          return a.visible != b.visible ? a.visible > b.visible : a.cell < b.cell;
                      });
    cells.resize(shown);
    census.worst = std::move(cells);
    return census;
}

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

void print_as_json(const Pvs& pvs, const std::vector<Section>& sections, const Census& census) {
    const CellGrid& grid = pvs.grid();
    Json document;
    document["format"] = format_version();
    document["tool_version"] = std::string(pvs.tool_version());
    document["method"] = std::string(pvs.method());
    document["guarantee"] = to_string(pvs.guarantee());
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
    document["grid"] = {{"count", {grid.count[0], grid.count[1], grid.count[2]}}, {"bounds", box_json(grid.bounds)}};
    document["cells"] = grid.cells();
    document["cells_baked"] = census.baked;
    document["cells_solid"] = census.solid;
    document["cells_not_baked"] = census.not_baked;
    document["rows"] = pvs.row_count();
    document["mean_visible"] = census.mean_visible;
    document["worst"] = Json::array();
    for (const CellCount& cell : census.worst)
        document["worst"].push_back(
            {{"cell", cell.cell}, {"visible", cell.visible}, {"box", box_json(grid.cell(cell.cell))}});
    print_json(document);
}

std::string box_text(const Box3d& box) {
    return fmt::format("({:g}, {:g}, {:g}) .. ({:g}, {:g}, {:g})", box.min.x, box.min.y, box.min.z, box.max.x,
                       box.max.y, box.max.z);
}

void print_as_text(const Pvs& pvs, const std::vector<Section>& sections, const Census& census) {
    const CellGrid& grid = pvs.grid();
    fmt::print("format       {}, written by Antumbra {}\n", format_version(), pvs.tool_version());
    fmt::print("method       {}\nguarantee    {}\nsides        {}\n", pvs.method(), to_string(pvs.guarantee()),
               pvs.sides() == 1 ? "both" : "material");
    fmt::print("scene        {}, structure {:016x}\n", hex(pvs.scene_fingerprint()), pvs.structure_fingerprint());
    fmt::print("options      {}\n", pvs.options_json());
    fmt::print("objects      {}\n", pvs.object_count());
    fmt::print("cells        {} x {} x {} in {}\n", grid.count[0], grid.count[1], grid.count[2],
               box_text(grid.bounds));
    fmt::print("             {} baked, {} solid, {} not baked, {} distinct rows\n", census.baked, census.solid,
               census.not_baked, pvs.row_count());
    fmt::print("visible      {:.1f} objects from a baked cell on average\n", census.mean_visible);
    fmt::print("bytes        {}, of which visibility {} ({:.4f} bits per pair of cell and object)\n",
               pvs.file_bytes(), pvs.visibility_bytes(), bits_per_pair(pvs, census));
    for (const Section& section : sections)
        fmt::print("  chunk {}  {}\n", to_string(section.id), section.bytes.size());
    for (const CellCount& cell : census.worst)
        fmt::print("worst cell   {} sees {} from {}\n", cell.cell, cell.visible, box_text(grid.cell(cell.cell)));
}

int run_inspect(const InspectArguments& arguments) {
    Result<MappedFile> file = MappedFile::open(arguments.file);
    if (!file)
        return fail(file.status());
    Result<Pvs> pvs = Pvs::open(file->bytes());
    if (!pvs)
        return fail(pvs.status().in(arguments.file));
    std::vector<Section> sections = *read_chunks(file->bytes());
    Census census = take_census(*pvs, arguments.worst);
    (arguments.common.json ? print_as_json : print_as_text)(*pvs, sections, census);
    return 0;
}

} // namespace

void add_inspect(CLI::App& app) {
    auto arguments = std::make_shared<InspectArguments>();
    CLI::App& command = *app.add_subcommand("inspect", "What a baked file holds and promises");
    command.add_option("FILE", arguments->file, "Baked file: .pvs")->required();
    command.add_option("--worst", arguments->worst, "How many of the cells that see most to list")
        ->capture_default_str();
    add_common(command, arguments->common, "antumbra inspect house.pvs",
               [arguments] { return run_inspect(*arguments); });
}

} // namespace antumbra::app
