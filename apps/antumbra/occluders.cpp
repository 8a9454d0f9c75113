#include "command.hpp"

#include <antumbra/export.hpp>
#include <antumbra/occluder_finding.hpp>

#include "base/file.hpp"

#include <fmt/format.h>

namespace antumbra::app {
namespace {

struct OccludersArguments {
    Common common;
    SceneArguments scene;
    OccluderOptions options;
    std::string output;
    bool no_merge = false, no_inner_boxes = false;
};

/// One object per polygon, named after the object that it came from; inner boxes are named so.
RawScene to_raw(const Scene& scene, const OccluderSet& set) {
    RawScene raw;
    raw.source = "occluders of " + scene.source();
    for (const Vec3f& vertex : set.vertices)
        raw.positions.push_back(scene.to_world(to_double(vertex)));
    for (std::size_t p = 0; p < set.polygons.size(); ++p) {
        const OccluderPolygon& polygon = set.polygons[p];
        RawObject object;
        object.name = std::string(scene.name(polygon.object)) + (polygon.synthetic ? " inner box " : " occluder ") +
                      std::to_string(p);
        object.flags = kOccludes | (polygon.double_sided ? std::uint32_t(kDoubleSided) : 0u);
        object.first_triangle = std::uint32_t(raw.triangles.size());
        std::span<const std::uint32_t> loop = set.loop(polygon);
        for (std::size_t i = 2; i < loop.size(); ++i)
            raw.triangles.push_back({loop[0], loop[i - 1], loop[i]});
        object.triangle_count = std::uint32_t(raw.triangles.size()) - object.first_triangle;
        raw.objects.push_back(object);
    }
    return raw;
}

int run_occluders(const OccludersArguments& arguments) {
    Result<Scene> scene = arguments.scene.load();
    if (!scene)
        return fail(scene.status());
    OccluderOptions options = arguments.options;
    options.merge = !arguments.no_merge;
    options.inner_boxes = !arguments.no_inner_boxes;
    OccluderStatistics statistics;
    OccluderSet set = find_occluders(*scene, options, &statistics);
    if (!arguments.output.empty()) {
        Result<std::vector<std::byte>> bytes = export_glb(to_raw(*scene, set));
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
        document["largest_area"] = statistics.largest_area;
        print_json(document);
        return 0;
    }
    fmt::print("triangles that occlude  {}\nconvex polygons         {}\npatches                 {}\n",
               statistics.triangles, statistics.polygons, statistics.patches);
    fmt::print("closed objects          {}\ninner boxes             {}\nlargest polygon         {:g} square units\n",
               statistics.closed_objects, statistics.inner_boxes, statistics.largest_area);
    return 0;
}

} // namespace

void add_occluders(CLI::App& app) {
    auto arguments = std::make_shared<OccludersArguments>();
    CLI::App& command = *app.add_subcommand("occluders", "The convex occluders found in a scene");
    arguments->scene.add_to(command);
    command.add_option("-o,--output", arguments->output, "Write them as GLB, one object per polygon");
    command.add_flag("--no-merge", arguments->no_merge, "Leave coplanar triangles unmerged");
    command.add_flag("--no-inner-boxes", arguments->no_inner_boxes, "Look for no boxes inside closed meshes");
    add_common(command, arguments->common, "antumbra occluders city.glb -o occluders.glb", [arguments] { return run_occluders(*arguments); });
}

} // namespace antumbra::app
