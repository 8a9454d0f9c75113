#include "command.hpp"

#include <antumbra/occluder_finding.hpp>

#include <fmt/format.h>

namespace antumbra::app {
namespace {

struct OccludersArguments {
    Common common;
    SceneArguments scene;
    OccluderOptions options;
    bool no_merge = false, no_inner_boxes = false;
};

int run_occluders(const OccludersArguments& arguments) {
    Result<Scene> scene = arguments.scene.load();
    if (!scene)
        return fail(scene.status());
    OccluderOptions options = arguments.options;
    options.merge = !arguments.no_merge;
    options.inner_boxes = !arguments.no_inner_boxes;
    OccluderStatistics statistics;
    OccluderSet set = find_occluders(*scene, options, &statistics);
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
    command.add_flag("--no-merge", arguments->no_merge, "Leave coplanar triangles unmerged");
    command.add_flag("--no-inner-boxes", arguments->no_inner_boxes, "Look for no boxes inside closed meshes");
    add_common(command, arguments->common, "antumbra occluders city.glb", [arguments] { return run_occluders(*arguments); });
}

} // namespace antumbra::app
