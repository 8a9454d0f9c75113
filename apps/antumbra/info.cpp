#include "command.hpp"

#include <fmt/format.h>

namespace antumbra::app {
namespace {

struct InfoArguments {
    Common common;
    SceneArguments scene;
};

int run_info(const InfoArguments& arguments) {
    Result<Scene> scene = arguments.scene.load();
    if (!scene)
        return fail(scene.status());
    std::vector<Finding> findings(scene->findings().begin(), scene->findings().end());
    for (Finding& finding : validate(*scene))
        findings.push_back(std::move(finding));
    Box3d bounds = scene->world_bounds();
    if (arguments.common.json) {
        Json document;
        document["objects"] = scene->objects().size();
        document["triangles"] = scene->triangles().size();
        document["vertices"] = scene->positions().size();
        document["bounds"] = {{bounds.min.x, bounds.min.y, bounds.min.z}, {bounds.max.x, bounds.max.y, bounds.max.z}};
        document["grid_step"] = scene->step();
        document["fingerprint"] = to_hex(scene->fingerprint());
        document["findings"] = Json::array();
        for (const Finding& finding : findings)
            document["findings"].push_back(
                {{"kind", finding.kind}, {"count", finding.count}, {"example", finding.example}});
        print_json(document);
        return 0;
    }
    Vec3d size = bounds.size();
    fmt::print("objects    {}\ntriangles  {}\nvertices   {}\n", scene->objects().size(), scene->triangles().size(),
               scene->positions().size());
    fmt::print("bounds     ({:g}, {:g}, {:g}) .. ({:g}, {:g}, {:g})\n", bounds.min.x, bounds.min.y, bounds.min.z,
               bounds.max.x, bounds.max.y, bounds.max.z);
    fmt::print("extent     {:g} x {:g} x {:g}, grid step {:g}\n", size.x, size.y, size.z, scene->step());
    fmt::print("scene      {}\n", to_hex(scene->fingerprint()));
    for (const Finding& finding : findings)
        fmt::print("found      {} x {}, e.g. {}\n", finding.count, finding.kind, finding.example);
    return 0;
}

} // namespace

void add_info(CLI::App& app) {
    auto arguments = std::make_shared<InfoArguments>();
    CLI::App& command = *app.add_subcommand("info", "Objects, triangles, bounds and oddities of a scene");
    arguments->scene.add_to(command);
    add_common(command, arguments->common, "antumbra info house.glb", [arguments] { return run_info(*arguments); });
}

} // namespace antumbra::app
