#include "command.hpp"

#include <fmt/format.h>

namespace antumbra::app {
namespace {

struct InfoArguments {
    Common common;
    SceneArguments scene;
};

/// Objects by what they do to sight.
struct Census {
    std::size_t occluding = 0, double_sided = 0, always_visible = 0, moving = 0;
    std::uint64_t source_triangles = 0;

    explicit Census(const Scene& scene) {
        for (const Object& object : scene.objects()) {
            occluding += object.has(kOccludes);
            double_sided += object.has(kDoubleSided);
            always_visible += object.has(kAlwaysVisible);
            moving += object.has(kMoves);
            source_triangles += object.source_triangles;
        }
    }
};

std::vector<Finding> all_findings(const Scene& scene) {
    std::vector<Finding> findings(scene.findings().begin(), scene.findings().end());
    for (Finding& finding : validate(scene))
        findings.push_back(std::move(finding));
    return findings;
}

Json array_of(const Vec3d& v) { return {v.x, v.y, v.z}; }

Json as_json(const Scene& scene) {
    Census census(scene);
    Box3d bounds = scene.world_bounds();
    Json document;
    document["scene"] = scene.source();
    document["objects"] = scene.objects().size();
    document["triangles"] = scene.triangles().size();
    document["vertices"] = scene.positions().size();
    document["bounds"] = {array_of(bounds.min), array_of(bounds.max)};
    document["extent"] = array_of(bounds.size());
    document["file_triangles"] = census.source_triangles;
    document["occluding_objects"] = census.occluding;
    document["double_sided_objects"] = census.double_sided;
    document["always_visible_objects"] = census.always_visible;
    document["moving_objects"] = census.moving;
    document["sides"] = scene.sides() == SidesOption::both ? "both" : "material";
    document["grid_step"] = scene.step();
    document["fingerprint"] = to_hex(scene.fingerprint());
    document["structure_fingerprint"] = fmt::format("{:016x}", scene.structure_fingerprint());
    document["findings"] = Json::array();
    for (const Finding& finding : all_findings(scene))
        document["findings"].push_back(
            {{"kind", finding.kind}, {"count", finding.count}, {"example", finding.example}});
    return document;
}

/// Names come from files: control characters must not reach the terminal.
std::string printable(std::string text) {
    for (char& c : text)
        if (static_cast<unsigned char>(c) < 0x20 || c == 0x7F)
            c = '?';
    return text;
}

void print(const Scene& scene) {
    Census census(scene);
    Box3d bounds = scene.world_bounds();
    Vec3d size = bounds.size();
    std::size_t objects = scene.objects().size();
    fmt::print("scene      {}\n", printable(scene.source()));
    fmt::print("objects    {}: {} can hide others, {} cannot, {} moving\n", objects, census.occluding,
               objects - census.occluding, census.moving);
    fmt::print("           {} are seen from both sides, {} are never culled\n", census.double_sided,
               census.always_visible);
    fmt::print("triangles  {} of {} in the file\n", scene.triangles().size(), census.source_triangles);
    fmt::print("vertices   {}\n", scene.positions().size());
    fmt::print("bounds     ({:.9g}, {:.9g}, {:.9g}) .. ({:.9g}, {:.9g}, {:.9g})\n", bounds.min.x, bounds.min.y,
               bounds.min.z, bounds.max.x, bounds.max.y, bounds.max.z);
    fmt::print("extent     {:.6g} x {:.6g} x {:.6g}, snapped to steps of {:.3g}\n", size.x, size.y, size.z,
               scene.step());
    fmt::print("hash       {}\n", to_hex(scene.fingerprint()));
    std::vector<Finding> findings = all_findings(scene);
    fmt::print("{}\n", findings.empty() ? "nothing odd found" : "found:");
    for (const Finding& finding : findings)
        fmt::print("{:>10} {:<34} e.g. {}\n", finding.count, finding.kind, printable(finding.example));
}

int run_info(InfoArguments& arguments) {
    arguments.scene.count_cracks = true;
    Result<Scene> scene = arguments.scene.load();
    if (!scene)
        return fail(scene.status());
    if (arguments.common.json)
        print_json(as_json(*scene));
    else
        print(*scene);
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
