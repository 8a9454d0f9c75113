#include "command.hpp"

#include "base/file.hpp"

#include <antumbra/evaluate.hpp>
#include <antumbra/explain.hpp>

#include <fmt/format.h>

namespace antumbra::app {
namespace {

struct ExplainArguments {
    Common common;
    SceneArguments scene;
    std::string pvs, eye, object, glb, line_space;
    ExplainOptions options;
    bool no_proof = false;
};

/// Without an object: the whole cell as a drawing.
int draw_cell(const ExplainArguments& arguments, const Scene& scene, const Pvs& pvs, const Vec3d& eye) {
    if (arguments.glb.empty())
        return fail({ErrorCode::usage, "explain needs --object, or --glb to draw the whole cell"});
    Result<std::vector<std::byte>> bytes = cell_as_glb(scene, pvs, eye);
    if (!bytes)
        return fail(bytes.status());
    if (Status status = write_file_atomically(arguments.glb, std::span<const std::byte>(*bytes)); !status)
        return fail(status);
    PvsCursor cursor;
    pvs.query(eye, cursor);
    if (arguments.common.json)
        print_json({{"cell", cursor.cell},
                    {"guarantee", to_string(pvs.guarantee())},
                    {"listed", cursor.visible_count},
                    {"objects", scene.objects().size()}});
    else
        fmt::print("{}: cell {} in yellow, {} objects that it lists in green, the other {} in red\n", arguments.glb,
                   cursor.cell, cursor.visible_count, scene.objects().size() - cursor.visible_count);
    return 0;
}

/// All unobstructed lines from the cell (where there is none, from the eye's own grid step) to the object.
Status write_line_space(const ExplainArguments& arguments, const Scene& scene, const Explanation& explanation, const Job& job) {
    LineSpaceOptions options;
    options.seed = arguments.common.seed;
    const SightAnswer& from = explanation.from_cell ? *explanation.from_cell : explanation.from_eye;
    Result<std::string> document = line_space_in_json(scene, from.from, explanation.object, options, job);
    if (!document)
        return document.status().in(arguments.line_space);
    return write_file_atomically(arguments.line_space, *document);
}

int run_explain(ExplainArguments& arguments) {
    Result<Vec3d> eye = parse_vec3(arguments.eye, "--eye");
    if (!eye)
        return fail(eye.status());
    Result<Scene> scene = arguments.scene.load();
    if (!scene)
        return fail(scene.status());
    Result<PvsFile> opened = open_pvs(arguments.pvs);
    if (!opened)
        return fail(opened.status());
    const Pvs& pvs = opened->pvs;
    if (arguments.object.empty())
        return draw_cell(arguments, *scene, pvs, *eye);
    Result<std::uint32_t> object = find_object(*scene, arguments.object);
    if (!object)
        return fail(object.status());
    Job job = make_job(arguments.common);
    Result<Explainer> explainer = Explainer::create(*scene, pvs, job);
    if (!explainer)
        return fail(explainer.status().in(arguments.pvs));
    arguments.options.seed = arguments.common.seed;
    arguments.options.prove = !arguments.no_proof;
    Result<Explanation> explanation = explainer->explain(*eye, *object, arguments.options, job);
    if (!explanation)
        return fail(explanation.status());
    if (job.cancelled())
        return fail({ErrorCode::cancelled, "stopped"});
    if (!arguments.glb.empty()) {
        Result<std::vector<std::byte>> bytes = explain_as_glb(*scene, *explanation);
        if (!bytes)
            return fail(bytes.status().in(arguments.glb));
        if (Status status = write_file_atomically(arguments.glb, std::span<const std::byte>(*bytes)); !status)
            return fail(status);
    }
    if (!arguments.line_space.empty())
        if (Status status = write_line_space(arguments, *scene, *explanation, job); !status)
            return fail(status);
    if (crack_width(pvs) > 0 && !arguments.common.json)
        fmt::print("The file is {}; so is this answer.\n", describe_guarantee(pvs));
    fmt::print("{}\n", arguments.common.json ? explain_in_json(*scene, *explanation)
                                             : explain_in_words(*scene, *explanation));
    return 0;
}

} // namespace

void add_explain(CLI::App& app) {
    auto arguments = std::make_shared<ExplainArguments>();
    CLI::App& command = *app.add_subcommand("explain", "Why an object is visible or hidden: a witness line, or what hides it");
    arguments->scene.add_to(command);
    command.add_option("PVS", arguments->pvs, "The .pvs file")->required();
    command.add_option("--eye", arguments->eye, "Viewpoint X,Y,Z in the scene's coordinates")->required();
    command.add_option("--object", arguments->object, "The object, by name or number; without it --glb draws what the "
                                                          "whole cell sees (green) and does not (red)");
    command.add_option("--glb", arguments->glb, "Write the explanation as a drawing, to be looked at with the scene");
    command.add_option("--line-space", arguments->line_space,
                       "Write all unobstructed lines from the cell to the object, as pieces of line space (JSON)");
    command.add_option("--sight-lines", arguments->options.sight_lines, "Aimed at the object, from eye and cell each")
        ->check(CLI::Range(0, 1 << 24))
        ->capture_default_str();
    command.add_flag("--no-proof", arguments->no_proof, "Sight lines only; what they do not see stays undecided");
    command.add_option("--most-queries", arguments->options.most_queries, "Budget of a proof, in pairs of polygons")
        ->capture_default_str();
    add_common(command, arguments->common, "antumbra explain house.glb house.pvs --eye 1.5,1.7,-4 --object stove",
               [arguments] { return run_explain(*arguments); });
}

} // namespace antumbra::app
