#include "command.hpp"

#include "base/file.hpp"

#include <antumbra/pvs.hpp>

#include <fmt/format.h>

#include <bit>

namespace antumbra::app {
namespace {

struct QueryArguments {
    Common common;
    std::string file, eye;
};

Json describe(const Pvs& pvs, std::uint32_t id) {
    PvsObject object = pvs.object(id);
    return {{"id", id},
            {"node", object.node},
            {"primitive", object.primitive},
            {"instance", object.instance},
            {"name", object.name}};
}

std::vector<std::uint32_t> visible_ids(const PvsCursor& cursor) {
    std::vector<std::uint32_t> ids;
    for (std::size_t w = 0; w < cursor.visible.size(); ++w)
        for (std::uint64_t rest = cursor.visible[w]; rest != 0; rest &= rest - 1)
            ids.push_back(static_cast<std::uint32_t>(w * 64 + static_cast<unsigned>(std::countr_zero(rest))));
    return ids;
}

/// Why an answer is "everything"; nullptr if it is not.
const char* why_everything(const Pvs& pvs, const PvsCursor& cursor) {
    if (!cursor.everything)
        return nullptr;
    if (cursor.cell < 0)
        return "the eye is outside every cell, so everything is visible";
    return pvs.cell_row(std::uint64_t(cursor.cell)) == kCellSolid
               ? "the eye's cell is inside geometry, so everything is visible"
               : "the eye's cell was not baked, so everything is visible";
}

void print_answer(const Pvs& pvs, const PvsCursor& cursor, Guarantee guarantee, bool json) {
    std::vector<std::uint32_t> ids = visible_ids(cursor);
    if (json) {
        Json document;
        document["cell"] = cursor.cell < 0 ? Json(nullptr) : Json(cursor.cell);
        document["guarantee"] = to_string(guarantee);
        document["everything"] = cursor.everything;
        document["count"] = ids.size();
        document["visible"] = Json::array();
        for (std::uint32_t id : ids)
            document["visible"].push_back(describe(pvs, id));
        print_json(document);
        return;
    }
    fmt::print("cell       {}\n", cursor.cell < 0 ? "none" : std::to_string(cursor.cell));
    fmt::print("guarantee  {}\nvisible    {} of {} objects\n", to_string(guarantee), ids.size(), pvs.object_count());
    for (std::uint32_t id : ids) {
        PvsObject object = pvs.object(id);
        fmt::print("{:>8}  node {} primitive {} instance {}  {}\n", id, object.node, object.primitive, object.instance,
                   object.name);
    }
}

int run_query(const QueryArguments& arguments) {
    Result<Vec3d> eye = parse_vec3(arguments.eye, "--eye");
    if (!eye)
        return fail(eye.status());
    Result<MappedFile> file = MappedFile::open(arguments.file);
    if (!file)
        return fail(file.status());
    Result<Pvs> pvs = Pvs::open(file->bytes());
    if (!pvs)
        return fail(pvs.status().in(arguments.file));
    PvsCursor cursor;
    (void)pvs->query(*eye, cursor);
    if (const char* reason = why_everything(*pvs, cursor))
        note(reason);
    print_answer(*pvs, cursor, cursor.everything ? Guarantee::conservative : pvs->guarantee(), arguments.common.json);
    return 0;
}

} // namespace

void add_query(CLI::App& app) {
    auto arguments = std::make_shared<QueryArguments>();
    CLI::App& command = *app.add_subcommand("query", "What can be seen from a point, by a baked file");
    command.add_option("FILE", arguments->file, "Baked file: .pvs")->required();
    command.add_option("--eye", arguments->eye, "Viewpoint X,Y,Z in the scene's coordinates")->required();
    add_common(command, arguments->common, "antumbra query house.pvs --eye 1.5,1.7,-4",
               [arguments] { return run_query(*arguments); });
}

} // namespace antumbra::app
