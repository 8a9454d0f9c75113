#include "command.hpp"

#include <antumbra/export.hpp>
#include <antumbra/occluder_finding.hpp>

#include "base/file.hpp"

#include <fmt/format.h>

#include <array>

namespace antumbra::app {
namespace {

struct OccludersArguments {
    Common common;
    SceneArguments scene;
    OccluderOptions options;
    std::string output;
    bool no_merge = false, no_inner_boxes = false, no_inner_solids = false;
};

/// What a polygon stands for, and its colour.
struct Kind {
    const char* name;
    std::array<float, 4> colour;
};
constexpr Kind kKinds[] = {
    {"merged triangles", {0.55f, 0.55f, 0.6f, 1}}, {"double-sided", {0.2f, 0.6f, 0.35f, 1}},
    {"inner boxes", {0.9f, 0.45f, 0.1f, 0.6f}},    {"boxes inside of several objects", {0.85f, 0.1f, 0.15f, 0.6f}},
    {"inner shells", {0.15f, 0.35f, 0.9f, 0.8f}},  {"oriented boxes and convex solids", {0.75f, 0.6f, 0.05f, 0.6f}},
};

/// Solids come in the order joined boxes, other boxes, convex solids, shells.
std::size_t kind_of(const OccluderPolygon& polygon, const OccluderStatistics& counts) {
    if (!polygon.synthetic)
        return polygon.double_sided ? 1 : 0;
    return polygon.solid < counts.joined_boxes                         ? 3
           : polygon.solid < counts.inner_boxes                       ? 2
           : polygon.solid < counts.inner_boxes + counts.inner_solids ? 5
                                                                      : 4;
}

/// A part for each kind, and the edges of the synthetic ones.
std::vector<DrawingPart> to_drawing(const Scene& scene, const OccluderSet& set, const OccluderStatistics& counts) {
    std::vector<DrawingPart> parts(std::size(kKinds) + 1);
    for (std::size_t k = 0; k < std::size(kKinds); ++k) {
        parts[k].name = kKinds[k].name;
        parts[k].colour = kKinds[k].colour;
    }
    DrawingPart& edges = parts.back();
    edges = {"edges of inner solids", {0.1f, 0.05f, 0.05f, 1}, true, {}, {}};
    for (const OccluderPolygon& polygon : set.polygons) {
        DrawingPart& part = parts[kind_of(polygon, counts)];
        auto base = static_cast<std::uint32_t>(part.positions.size());
        auto edge_base = static_cast<std::uint32_t>(edges.positions.size());
        for (std::uint32_t v : set.loop(polygon)) {
            part.positions.push_back(scene.to_world(to_double(set.vertices[v])));
            if (polygon.synthetic)
                edges.positions.push_back(part.positions.back());
        }
        for (std::uint32_t i = 2; i < polygon.count; ++i)
            part.indices.insert(part.indices.end(), {base, base + i - 1, base + i});
        for (std::uint32_t i = 0; polygon.synthetic && i < polygon.count; ++i)
            edges.indices.insert(edges.indices.end(), {edge_base + i, edge_base + (i + 1) % polygon.count});
    }
    return parts;
}

int run_occluders(const OccludersArguments& arguments) {
    Result<Scene> scene = arguments.scene.load();
    if (!scene)
        return fail(scene.status());
    OccluderOptions options = arguments.options;
    options.merge = !arguments.no_merge;
    options.inner_boxes = !arguments.no_inner_boxes;
    options.inner_solids = !arguments.no_inner_solids;
    OccluderStatistics statistics;
    OccluderSet set = find_occluders(*scene, options, &statistics);
    if (!arguments.output.empty()) {
        Result<std::vector<std::byte>> bytes = export_drawing(to_drawing(*scene, set, statistics));
        if (!bytes)
            return fail(bytes.status());
        if (Status status = write_file_atomically(arguments.output, std::span<const std::byte>(*bytes)); !status)
            return fail(status);
    }
    if (arguments.common.json) {
        Json document;
        document["triangles"] = statistics.triangles;
        document["polygons"] = statistics.polygons;
        document["patches"] = statistics.patches;
        document["closed_objects"] = statistics.closed_objects;
        document["inner_boxes"] = statistics.inner_boxes;
        document["joined_boxes"] = statistics.joined_boxes;
        document["enclosures"] = statistics.enclosures;
        document["inner_solids"] = statistics.inner_solids;
        document["oriented_boxes"] = statistics.oriented_boxes;
        document["restricted_solids"] = statistics.restricted_solids;
        document["inner_shells"] = statistics.inner_shells;
        document["inner_shell_triangles"] = statistics.inner_shell_triangles;
        document["inner_shell_dropped"] = statistics.inner_shell_dropped;
        document["largest_area"] = statistics.largest_area;
        print_json(document);
        return 0;
    }
    fmt::print("triangles that occlude  {}\nconvex polygons         {}\npatches                 {}\n",
               statistics.triangles, statistics.polygons, statistics.patches);
    fmt::print("closed objects          {}, and {} groups closed together or but for one side\n", statistics.closed_objects,
               statistics.enclosures - statistics.closed_objects);
    fmt::print("inner boxes             {}, {} of them inside of several objects\n", statistics.inner_boxes,
               statistics.joined_boxes);
    fmt::print("inner convex solids     {}, {} of them boxes at an angle to the axes\n", statistics.inner_solids,
               statistics.oriented_boxes);
    if (options.inner_shells)
        fmt::print("inner shells            {} of {} triangles; {} could not be certified\n", statistics.inner_shells,
                   statistics.inner_shell_triangles, statistics.inner_shell_dropped);
    fmt::print("largest polygon         {:g} square units\n", statistics.largest_area);
    return 0;
}

} // namespace

void add_occluders(CLI::App& app) {
    auto arguments = std::make_shared<OccludersArguments>();
    CLI::App& command = *app.add_subcommand("occluders", "The convex occluders found in a scene");
    arguments->scene.add_to(command);
    command.add_option("-o,--output", arguments->output, "Write them as GLB: merged triangles grey, double-sided ones green, inner boxes orange, those of several objects red, oriented boxes and convex solids yellow, inner shells blue");
    command.add_flag("--no-merge", arguments->no_merge, "Leave coplanar triangles unmerged");
    command.add_flag("--inner-shells", arguments->options.inner_shells, "Look for simplified shells inside dense closed meshes");
    command.add_flag("--no-inner-boxes", arguments->no_inner_boxes, "Look for no boxes nor solids inside closed meshes");
    command.add_flag("--no-inner-solids", arguments->no_inner_solids, "Look for no oriented boxes nor convex solids inside closed meshes");
    add_common(command, arguments->common, "antumbra occluders city.glb -o occluders.glb", [arguments] { return run_occluders(*arguments); });
}

} // namespace antumbra::app
