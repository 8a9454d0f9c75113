#include "command.hpp"

#include "evaluate/cull_scene.hpp"

#include <antumbra/cull.hpp>
#include <antumbra/occluder_finding.hpp>

#include <fmt/format.h>

namespace antumbra::app {
namespace {

struct CullArguments {
    Common common;
    SceneArguments scene;
    std::string choice = "area-angle";
    std::string method = "frustum", pvs, eye, direction = "0,0,-1", up = "0,1,0";
    View view;
    bool orthographic = false, centre = false;
    CullerOptions options;
};

Status place_view(const CullArguments& arguments, const Scene& scene, View& view) {
    Result<Vec3d> eye = parse_vec3(arguments.eye, "--eye");
    Result<Vec3d> direction = parse_vec3(arguments.direction, "--dir");
    Result<Vec3d> up = parse_vec3(arguments.up, "--up");
    for (const Status* status : {&eye.status(), &direction.status(), &up.status()})
        if (!*status)
            return *status;
    view = arguments.view;
    view.projection = arguments.orthographic ? Projection::orthographic : Projection::perspective;
    view.eye = scene.to_local(*eye);
    view.target = view.eye + *direction;
    view.up = *up;
    return {};
}

void print_result(const CullArguments& arguments, const Scene& scene, const Culler& culler, const CullResult& result) {
    const std::pair<const char*, std::uint64_t> counters[] = {
        {"nodes_visited", result.counters.nodes_visited},
        {"boxes_tested", result.counters.boxes_tested},
        {"outside_frustum", result.counters.outside_frustum},
        {"hidden_by_pvs", result.counters.hidden_by_pvs},
        {"occluders_used", result.counters.occluders_used},
        {"shadow_tests", result.counters.shadow_tests},
        {"relations_cached", result.counters.relations_cached},
        {"relations_made", result.counters.relations_made},
        {"hidden_by_last", result.counters.hidden_by_last},
        {"hidden_by_planes", result.counters.hidden_by_planes},
        {"hidden_by_raster", result.counters.hidden_by_raster},
        {"tree_nodes", result.counters.tree_nodes},
        {"tree_fragments", result.counters.tree_fragments},
        {"tree_tests", result.counters.tree_tests},
        {"tree_planes_tested", result.counters.tree_planes_tested},
        {"tests_saved", result.counters.tests_saved},
        {"hidden_by_tree", result.counters.hidden_by_tree},
        {"patches_drawn", result.counters.patches_drawn},
        {"polygons_drawn", result.counters.polygons_drawn},
        {"overlap_tests", result.counters.overlap_tests},
        {"stopped_early", result.counters.stopped_early},
        {"switched_off", result.counters.switched_off},
        {"budget_spent", result.counters.budget_spent},
    };
    if (arguments.common.json) {
        Json document;
        document["method"] = culler.name();
        document["guarantee"] = to_string(culler.guarantee());
        document["objects"] = scene.objects().size();
        document["count"] = result.visible_count;
        document["everything"] = result.everything;
        document["reason"] = result.reason;
        for (auto [name, value] : counters)
            document["counters"][name] = value;
        document["visible"] = Json::array();
        for (std::uint32_t o = 0; o < scene.objects().size(); ++o)
            if (result.is_visible(o)) {
                const ObjectId& id = scene.objects()[o].id;
                document["visible"].push_back({{"id", o}, {"node", id.node}, {"primitive", id.primitive},
                                               {"instance", id.instance}, {"name", scene.name(o)}});
            }
        return print_json(document);
    }
    fmt::print("{} ({}): {} of {} objects\n", culler.name(), to_string(culler.guarantee()), result.visible_count,
               scene.objects().size());
    if (*result.reason)
        fmt::print("why        {}\n", result.reason);
    for (auto [name, value] : counters)
        fmt::print("{:<26} {}\n", name, value);
}

int run_cull(const CullArguments& arguments) {
    Result<Scene> scene = arguments.scene.load();
    if (!scene)
        return fail(scene.status());
    CullerOptions options = arguments.options;
    options.opacity.coverage = arguments.centre ? OpacityCoverage::centre : OpacityCoverage::inner;
    options.opacity.adaptive = false; // nothing to adapt to in one frame
    options.occluder_choice = parse_occluder_choice(arguments.choice);
    std::optional<PvsFile> baked;
    if (!arguments.pvs.empty()) {
        Result<PvsFile> opened = open_pvs(arguments.pvs, *scene);
        if (!opened)
            return fail(opened.status());
        options.pvs = &baked.emplace(std::move(*opened)).pvs;
    }
    Result<CullScene> cull_scene = cull_scene_for(*scene, options.pvs);
    if (!cull_scene)
        return fail(cull_scene.status());
    Result<std::unique_ptr<Culler>> culler = make_culler(arguments.method, *cull_scene, options);
    if (!culler)
        return fail(culler.status());
    View view;
    if (Status status = place_view(arguments, *scene, view); !status)
        return fail(status);
    ViewState state;
    CullResult result;
    (*culler)->cull(view, state, result);
    print_result(arguments, *scene, **culler, result);
    return 0;
}

} // namespace

void add_cull(CLI::App& app) {
    auto arguments = std::make_shared<CullArguments>();
    CLI::App& command = *app.add_subcommand("cull", "One run-time culling of one view, with what each stage did");
    arguments->scene.add_to(command);
    std::vector<std::string> names;
    for (std::string_view name : culler_names())
        names.emplace_back(name);
    command.add_option("--method", arguments->method, "How to cull")->check(CLI::IsMember(names))->capture_default_str();
    command.add_option("--pvs", arguments->pvs, "A bake of the same scene; what it was prepared with is not looked for again");
    command.add_option("--eye", arguments->eye, "Where the viewer is: X,Y,Z")->required();
    command.add_option("--dir", arguments->direction, "Where the viewer looks: X,Y,Z")->capture_default_str();
    command.add_option("--up", arguments->up, "What is up: X,Y,Z")->capture_default_str();
    command.add_option("--fov", arguments->view.fov_y_deg, "Vertical field of view, degrees")->capture_default_str();
    command.add_option("--aspect", arguments->view.aspect, "Width / height")->capture_default_str();
    command.add_option("--near", arguments->view.near_plane, "Near plane")->capture_default_str();
    command.add_option("--far", arguments->view.far_plane, "Far plane");
    command.add_flag("--orthographic", arguments->orthographic, "Parallel projection");
    command.add_option("--height", arguments->view.height, "Height of an orthographic view")->capture_default_str();
    add_occluder_choice(command, arguments->choice);
    command.add_option("--occluders", arguments->options.occluders, "planes, tree-: occluders at most")->capture_default_str();
    command.add_option("--minimum-cost", arguments->options.tree.minimum_cost, "tree-: nodes with fewer triangles are not tested")->capture_default_str();
    command.add_flag("--inner-tests", arguments->options.tree.inner_tests, "tree-fme, tree-fmc: tests at inner nodes of the occlusion tree, too");
    command.add_flag("--extra-nodes", arguments->options.tree.extra_nodes, "tree-fme, tree-fmc: extra nodes where shadow planes meet sharply");
    command.add_flag_callback("--area-angle-of-view", [arguments] { arguments->options.tree.area_angle = AreaAngle::viewing_direction; },
                              "tree-: area-angle with the viewing direction, as printed, not with the line of sight");
    command.add_flag_callback("--from-deepest-node", [arguments] { arguments->options.tree.start = TreeStart::deepest_node; },
                              "tree: start boxes at the deepest node, not at the leaves that the box around them reached");
    command.add_flag("--centre", arguments->centre, "opacity: pixels count when their centre is covered, as published (approximate)");
    command.add_option("--tolerance", arguments->options.opacity.tolerance, "opacity: share of a box that may be open (approximate)")
        ->capture_default_str();
    command.add_option("--map", arguments->options.opacity.width, "opacity: pixels across [256; published 128]");
    command.add_option("--polygons-drawn", arguments->options.opacity.occluders, "opacity: occluder polygons at most")
        ->capture_default_str();
    command.add_option("--raster-width", arguments->options.raster_width, "hzb, masked: pixels across")->capture_default_str();
    command.add_option("--polygons", arguments->options.polygon_budget, "hzb, masked: polygons drawn at most")->capture_default_str();
    add_common(command, arguments->common, "antumbra cull city.glb --method frustum --eye 0,1.7,0 --dir 1,0,0",
               [arguments] { return run_cull(*arguments); });
}

} // namespace antumbra::app
