#include "command.hpp"

#include <antumbra/evaluate.hpp>

#include <fmt/format.h>

#include <bit>
#include <cmath>
#include <numbers>

namespace antumbra::app {
namespace {

struct QueryArguments {
    Common common;
    std::string file, eye, direction, up = "0,1,0";
    double fov_degrees = 60, aspect = 16.0 / 9, radius = 0;
};

/// Viewpoints around the eye and, if a direction was given, its frustum.
Result<ViewRange> range_of(const QueryArguments& arguments, const Vec3d& eye) {
    Vec3d radius{arguments.radius, arguments.radius, arguments.radius};
    ViewRange range{{eye - radius, eye + radius}, true, {}};
    if (arguments.direction.empty())
        return range;
    Result<Vec3d> direction = parse_vec3(arguments.direction, "--dir"), up = parse_vec3(arguments.up, "--up");
    if (!direction || !up)
        return direction ? up.status() : direction.status();
    return camera_range(range.eyes, *direction, *up, std::tan(arguments.fov_degrees * std::numbers::pi / 360),
                        arguments.aspect);
}

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

std::uint64_t count_volumes(const Pvs& pvs, const PvsCursor& cursor) {
    std::uint64_t count = 0;
    for (std::size_t v = 0; v < pvs.volumes().cells() && v / 64 < cursor.volumes.size(); ++v)
        count += cursor.volumes[v / 64] >> (v % 64) & 1; // bits of clusters follow
    return count;
}

/// Clusters that are seen, of objects that are.
std::vector<std::uint32_t> visible_clusters(const Pvs& pvs, const PvsCursor& cursor) {
    std::vector<std::uint32_t> clusters;
    for (std::uint32_t o = 0; o < pvs.object_count(); ++o)
        if (cursor.visible[o / 64] >> (o % 64) & 1)
            for (std::uint32_t c = pvs.first_cluster_of(o); c < pvs.first_cluster_of(o + 1); ++c)
                if (pvs.is_cluster_visible(c, cursor))
                    clusters.push_back(c);
    return clusters;
}

/// Why an answer is "everything"; nullptr if it is not.
const char* why_everything(const Pvs& pvs, const PvsCursor& cursor) {
    if (!cursor.everything)
        return nullptr;
    if (cursor.cell == -3)
        return "some viewpoints have no cell that was baked, so everything is visible";
    if (cursor.cell < 0 || !pvs.tree().nodes.empty())
        return "the eye is outside every cell, so everything is visible";
    return pvs.cell_row(std::uint64_t(cursor.cell)) == kCellSolid
               ? "the eye's cell is inside geometry, so everything is visible"
               : "the eye's cell was not baked, so everything is visible";
}

/// What the answer is, which may be less than what the file is. All objects at once is always conservative. A union over
/// cells that the viewpoints only touch, or bounds in the frustum in place of geometry, lists too much: what was exact
/// is conservative then, and what missed some visible objects (aggressive) is neither, so approximate.
Guarantee guarantee_of(const Pvs& pvs, const PvsCursor& cursor) {
    if (cursor.everything)
        return Guarantee::conservative;
    if (cursor.cell != -3)
        return pvs.guarantee();
    return may_lose_pixels(pvs.guarantee()) ? Guarantee::approximate : Guarantee::conservative;
}

std::string label(const Pvs& pvs, Guarantee guarantee) {
    return guarantee == pvs.guarantee() ? describe_guarantee(pvs) : to_string(guarantee);
}

void print_answer(const Pvs& pvs, const PvsCursor& cursor, Guarantee guarantee, bool json) {
    std::vector<std::uint32_t> ids = visible_ids(cursor);
    if (json) {
        Json document;
        document["cell"] = cursor.cell < 0 ? Json(nullptr) : Json(cursor.cell);
        document["guarantee"] = to_string(guarantee);
        document["volumes_visible"] = count_volumes(pvs, cursor);
        document["everything"] = cursor.everything;
        document["count"] = ids.size();
        document["clusters"] = visible_clusters(pvs, cursor);
        document["cluster_count"] = pvs.cluster_count();
        document["visible"] = Json::array();
        for (std::uint32_t id : ids)
            document["visible"].push_back(describe(pvs, id));
        print_json(document);
        return;
    }
    fmt::print("cell       {}\n", cursor.cell < 0 ? "none" : std::to_string(cursor.cell));
    fmt::print("guarantee  {}\nvisible    {} of {} objects\n", label(pvs, guarantee), ids.size(), pvs.object_count());
    if (pvs.cluster_count() > 0)
        fmt::print("clusters   {} of {}\n", visible_clusters(pvs, cursor).size(), pvs.cluster_count());
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
    Result<PvsFile> opened = open_pvs(arguments.file);
    if (!opened)
        return fail(opened.status());
    const Pvs& pvs = opened->pvs;
    Result<ViewRange> range = range_of(arguments, *eye);
    if (!range)
        return fail(range.status());
    PvsCursor cursor;
    if (range->all_directions && arguments.radius == 0)
        (void)pvs.query(*eye, cursor);
    else
        (void)pvs.query_range(*range, cursor);
    if (const char* reason = why_everything(pvs, cursor))
        note(reason);
    Guarantee guarantee = guarantee_of(pvs, cursor);
    if (cursor.cell == -3) // the cell of the eye itself, where cells are a grid
        cursor.cell = pvs.grid().find(*eye);
    print_answer(pvs, cursor, guarantee, arguments.common.json);
    return 0;
}

} // namespace

void add_query(CLI::App& app) {
    auto arguments = std::make_shared<QueryArguments>();
    CLI::App& command = *app.add_subcommand("query", "What can be seen from a point, by a baked file");
    command.add_option("FILE", arguments->file, "Baked file: .pvs")->required();
    command.add_option("--eye", arguments->eye, "Viewpoint X,Y,Z in the scene's coordinates")->required();
    command.add_option("--dir", arguments->direction, "Looking along X,Y,Z: only what is in the frustum");
    command.add_option("--up", arguments->up, "What is upward in the picture, with --dir")->capture_default_str();
    command.add_option("--fov", arguments->fov_degrees, "Vertical field of view in degrees, with --dir")
        ->check(CLI::Range(0.001, 179.0))
        ->capture_default_str();
    command.add_option("--aspect", arguments->aspect, "Width of the picture over its height, with --dir")
        ->check(CLI::Range(0.001, 1000.0))
        ->capture_default_str();
    command.add_option("--radius", arguments->radius, "From all viewpoints so near to the eye, in each axis")
        ->check(CLI::Range(0.0, 1e30))
        ->capture_default_str();
    add_common(command, arguments->common, "antumbra query house.pvs --eye 1.5,1.7,-4",
               [arguments] { return run_query(*arguments); });
}

} // namespace antumbra::app
