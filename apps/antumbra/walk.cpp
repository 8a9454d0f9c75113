#include "command.hpp"

#include "base/file.hpp"
#include "evaluate/walk_json.hpp"

#include <antumbra/camera.hpp>
#include <antumbra/evaluate.hpp>

#include <fmt/format.h>

#include <cmath>

namespace antumbra::app {
namespace {

struct WalkArguments {
    Common common;
    SceneArguments scene;
    std::string pvs, path = "auto", save_path, size = "640x360", report, study_pictures;
    std::string cull, studies, choice = "area-angle";
    std::uint32_t frames = 0;
    bool no_draw = false;
    PathOptions path_options;
    WalkOptions options;
};

std::vector<std::string> split(const std::string& text) {
    std::vector<std::string> parts;
    std::size_t at = 0;
    while (at <= text.size()) {
        std::size_t comma = std::min(text.find(',', at), text.size());
        parts.push_back(text.substr(at, comma - at));
        at = comma + 1;
    }
    return parts;
}

/// Every known method that needs nothing the caller did not give.
std::vector<std::string> choose_methods(const WalkArguments& arguments) {
    if (!arguments.cull.empty() && arguments.cull != "all")
        return split(arguments.cull);
    std::vector<std::string> methods;
    for (std::string_view name : culler_names()) {
        bool plain = name == "none" || name == "frustum" || name == "pvs";
        if ((plain || arguments.cull == "all") && (name != "pvs" || !arguments.pvs.empty()))
            methods.emplace_back(name);
    }
    return methods;
}

Json triple(const Vec3d& v) {
    return {v.x, v.y, v.z};
}

Status save_path(const Scene& scene, std::span<const View> path, const std::string& file) {
    Json frames = Json::array();
    for (const View& view : path)
        frames.push_back({{"eye", triple(scene.to_world(view.eye))},
                          {"target", triple(scene.to_world(view.target))},
                          {"up", triple(view.up)},
                          {"fov_y_deg", view.fov_y_deg}});
    return write_file_atomically(file, Json{{"frames", frames}}.dump(1) + "\n");
}

Result<FoundPath> read_path(const WalkArguments& arguments, const Scene& scene) {
    CameraPathOptions options;
    options.z_up = arguments.scene.up_axis == "z";
    Result<std::vector<CameraFrame>> frames = read_camera_path(arguments.path, options);
    if (!frames)
        return frames.status();
    FoundPath path;
    std::size_t count = frames->size();
    if (arguments.frames > 0)
        count = std::min<std::size_t>(count, arguments.frames);
    for (std::size_t k = 0; k < count; ++k) {
        // Evenly spread over the file, its last frame included.
        std::size_t from = count > 1 ? k * (frames->size() - 1) / (count - 1) : 0;
        const CameraFrame& frame = (*frames)[from];
        View view;
        view.eye = scene.to_local(frame.eye);
        view.target = scene.to_local(frame.target);
        view.up = frame.up;
        view.fov_y_deg = frame.fov_y_deg;
        view.near_plane = 0;
        path.views.push_back(view);
    }
    path.description = fmt::format("follows {} of the {} frames of {}", count, frames->size(), arguments.path);
    return path;
}

Json to_json(const Scene& scene, const FoundPath& path, const WalkResult& result, std::span<const Study> studies) {
    Json document;
    document["scene"] = scene.source();
    document["fingerprint"] = to_hex(scene.fingerprint());
    document["path"] = path.description;
    document["frames"] = result.frames.size();
    document["width"] = result.width;
    document["height"] = result.height;
    document["repeat"] = result.repeat;
    document["truth_scale"] = result.truth_scale;
    document["truth_pixels"] = result.truth_pixels;
    document["renderer"] = result.renderer;
    document["occluder_seconds"] = result.occluder_seconds;
    document["frames_in_matter"] = result.frames_in_matter;
    document["objects"] = scene.objects().size();
    document["triangles"] = scene.triangles().size();
    document["triangles_true"] = result.triangles_true;
    document["empty_ms"] = {{"median", figure_json(result.empty_ms_median)}};
    document["ceiling_ms"] = {{"median", figure_json(result.ceiling_ms_median)}};
    document["ceiling_speedup"] = figure_json(result.ceiling_speedup);
    document["methods"] = Json::array();
    for (const WalkMethod& method : result.methods)
        document["methods"].push_back(method_json(method, result));
    document["notes"] = result.notes;
    document["studies"] = Json::array();
    for (const Study& study : studies)
        document["studies"].push_back(Json::parse(study_json(study, false)));
    return document;
}

std::string cell(double value, int digits) {
    return value < 0 ? "-" : fmt::format("{:.{}f}", value, digits);
}

void print_text(const Scene& scene, const FoundPath& path, const WalkResult& result) {
    fmt::print("scene      {}: {} objects, {} triangles\n", scene.source(), scene.objects().size(),
               scene.triangles().size());
    fmt::print("path       {} frames, {}\n", result.frames.size(), path.description);
    fmt::print("truth      {:.1f} objects seen per frame, by {} rays\n", result.objects_true, result.truth_pixels);
    if (!result.renderer.empty())
        fmt::print(
            "drawing    {} x {}, {}\n           empty frame {} ms, only what is seen {} ms: {} times frustum at most\n",
            result.width, result.height, result.renderer, cell(result.empty_ms_median, 2),
            cell(result.ceiling_ms_median, 2), cell(result.ceiling_speedup, 2));
    fmt::print("\n{:<16}{:>10}{:>10}{:>10}{:>10}{:>11}{:>11}{:>9}{:>9}{:>10}{:>9}\n", "method", "cull ms", "p99 ms",
               "draw ms", "frame ms", "reported", "triangles", "culled", "f.vis.", "lost px", "speed-up");
    for (const WalkMethod& method : result.methods)
        fmt::print("{:<16}{:>10}{:>10}{:>10}{:>10}{:>11.1f}{:>11.0f}{:>8.1f}%{:>9.1f}{:>10}{:>9}\n", method.name,
                   cell(method.cull_ms_median, 4), cell(method.cull_ms_p99, 4), cell(method.draw_ms_median, 2),
                   cell(method.frame_ms_median, 2), method.objects_reported, method.triangles_drawn,
                   method.culled_of_frustum * 100, method.false_visible_objects, method.false_invisible_pixels,
                   cell(method.speedup_over_frustum, 2));
}

std::string study_cell(const StudyCell& cell, int digits) {
    if (!cell.words.empty())
        return cell.words;
    return std::isfinite(cell.number) ? fmt::format("{:.{}f}", cell.number, digits) : "-";
}

void print_study(const Study& study) {
    fmt::print("\nstudy      {} ({})\n", study.title, study.source);
    for (const StudyTable& table : study.tables) {
        std::vector<std::vector<std::string>> lines(1);
        for (const StudyColumn& column : table.columns)
            lines[0].push_back(column.title + (column.unit.empty() ? "" : ", " + column.unit));
        for (const StudyRow& row : table.rows) {
            lines.emplace_back();
            for (std::size_t c = 0; c < row.cells.size(); ++c)
                lines.back().push_back(study_cell(row.cells[c], table.columns[c].digits));
            if (row.origin == StudyOrigin::published)
                lines.back().back() += "  (published)";
        }
        fmt::print("\n{}\n", table.title);
        for (const auto& line : lines) {
            for (std::size_t c = 0; c < line.size(); ++c) {
                std::size_t width = 0;
                for (const auto& other : lines)
                    width = std::max(width, other[c].size());
                fmt::print("  {:<{}}", line[c], width);
            }
            fmt::print("\n");
        }
    }
    for (const std::string& text : study.notes)
        note(text);
}

Status run_studies(const WalkArguments& arguments, const Scene& scene, const FoundPath& path, const Job& job,
                   std::vector<Study>& studies) {
    StudyOptions options;
    options.path = path.views;
    options.path_description = path.description;
    options.pvs = arguments.options.pvs;
    options.width = arguments.options.width;
    options.height = arguments.options.height;
    options.occluders = arguments.options.occluders;
    options.repeat = arguments.options.repeat;
    options.draw = arguments.options.draw;
    options.seed = arguments.common.seed;
    for (const std::string& name : arguments.studies.empty() ? std::vector<std::string>{} : split(arguments.studies)) {
        Result<Study> study = run_study(name, scene, options, job);
        if (!study)
            return study.status();
        studies.push_back(std::move(*study));
    }
    return {};
}

/// Before the walk, which takes time.
Status check_studies(const WalkArguments& arguments) {
    for (const std::string& name : arguments.studies.empty() ? std::vector<std::string>{} : split(arguments.studies))
        if (study_summary(name).empty())
            return {ErrorCode::usage, "unknown study '" + name + "'; antumbra walk --help lists the known ones"};
    return {};
}

/// NAME-1.png, NAME-1.glb ..: the pictures of each study.
Status write_pictures(const WalkArguments& arguments, std::span<const Study> studies) {
    for (const Study& study : studies)
        for (std::size_t k = 0; k < study.pictures.size() && !arguments.study_pictures.empty(); ++k) {
            std::string path = arguments.study_pictures + "/" + study.name + "-" + std::to_string(k + 1);
            for (const auto& [bytes, end] : {std::pair(&study.pictures[k].png, ".png"), std::pair(&study.pictures[k].glb, ".glb")})
                if (!bytes->empty())
                    if (Status status = write_file_atomically(path + end, std::span<const std::byte>(*bytes)); !status)
                        return status;
        }
    return {};
}

int finish(const WalkArguments& arguments, const Scene& scene, const Pvs* pvs, const FoundPath& path,
           const WalkResult& result, std::span<const Study> studies) {
    for (const std::string& text : result.notes)
        note(text);
    if (arguments.common.json)
        print_json(to_json(scene, path, result, studies));
    else {
        print_text(scene, path, result);
        for (const Study& study : studies)
            print_study(study);
    }
    if (Status status = write_pictures(arguments, studies); !status)
        return fail(status);
    if (!arguments.report.empty()) {
        ReportOptions options;
        options.path_description = path.description;
        options.studies = studies;
        Result<std::string> page = make_report(scene, pvs, result, options, make_job(arguments.common));
        if (!page)
            return fail(page.status());
        if (Status status = write_file_atomically(arguments.report, *page); !status)
            return fail(status);
        if (!arguments.common.json)
            fmt::print("\nreport     {}\n", arguments.report);
    }
    if (const WalkMethod* broken = find_broken_promise(result))
        return fail(
            {ErrorCode::internal,
             fmt::format("{}: method '{}' promises to be {}, but lost {} confirmed pixels of {} objects; please "
                         "report this with the scene and the camera path",
                         arguments.scene.path, broken->name, to_string(broken->guarantee),
                         broken->false_invisible_pixels, broken->false_invisible_objects)});
    return 0;
}

int run_walk(WalkArguments& arguments) {
    if (int end = 0; std::sscanf(arguments.size.c_str(), "%ux%u%n", &arguments.options.width, &arguments.options.height,
                                 &end) != 2 ||
                     std::size_t(end) != arguments.size.size())
        return fail({ErrorCode::usage, "--size wants WIDTHxHEIGHT such as 640x360, not '" + arguments.size + "'"});
    if (Status status = check_studies(arguments); !status)
        return fail(status);
    Result<Scene> scene = arguments.scene.load();
    if (!scene)
        return fail(scene.status());
    std::optional<PvsFile> baked;
    if (!arguments.pvs.empty()) {
        Result<PvsFile> opened = open_pvs(arguments.pvs, *scene);
        if (!opened)
            return fail(opened.status());
        arguments.options.pvs = &baked.emplace(std::move(*opened)).pvs;
    }
    Job job = make_job(arguments.common);
    arguments.path_options.seed = arguments.common.seed;
    if (arguments.frames > 0)
        arguments.path_options.frames = arguments.frames;
    if (arguments.path == "orbit")
        arguments.path_options.kind = PathKind::orbit;
    bool made = arguments.path == "auto" || arguments.path == "orbit";
    Result<FoundPath> path = made ? find_path(*scene, arguments.path_options, job) : read_path(arguments, *scene);
    if (!path)
        return fail(path.status());
    if (!arguments.save_path.empty())
        if (Status status = save_path(*scene, path->views, arguments.save_path); !status)
            return fail(status);
    arguments.options.methods = choose_methods(arguments);
    arguments.options.occluder_choice = parse_occluder_choice(arguments.choice);
    arguments.options.draw = !arguments.no_draw;
    Result<WalkResult> result = walk(*scene, path->views, arguments.options, job);
    if (!result)
        return fail(result.status());
    std::vector<Study> studies;
    if (Status status = run_studies(arguments, *scene, *path, job, studies); !status)
        return fail(status);
    return finish(arguments, *scene, arguments.options.pvs, *path, *result, studies);
}

} // namespace

void add_walk(CLI::App& app) {
    auto arguments = std::make_shared<WalkArguments>();
    WalkOptions& options = arguments->options;
    CLI::App& command =
        *app.add_subcommand("walk", "Walks a camera path: times every method on the same frames, checks each by truth");
    arguments->scene.add_to(command);
    command.add_option("--pvs", arguments->pvs, "The .pvs file of the method pvs; its occluders are used, if it was prepared");
    command.add_option("--path", arguments->path, "Camera path: .json, a glTF camera animation, auto (a walk through free space) or orbit")
        ->capture_default_str();
    command.add_option("--save-path", arguments->save_path, "Write the camera path that was walked as .json");
    command.add_option("--frames", arguments->frames, "Frames [auto and orbit: 120; a file: all of it]");
    command
        .add_option("--eye-height", arguments->path_options.eye_height,
                    "For auto: scene units above the floor [guessed]")
        ->check(CLI::PositiveNumber);
    command.add_option("--size", arguments->size, "Width and height of the picture")->capture_default_str();
    std::string known;
    for (std::string_view name : culler_names())
        known += (known.empty() ? "" : ", ") + std::string(name);
    command.add_option("--cull", arguments->cull,
                       "Methods, by commas, or all [none,frustum and, with --pvs, pvs]. Known: " + known);
    std::string studies;
    for (std::string_view name : study_names())
        studies += (studies.empty() ? "" : "; ") + std::string(name) + ": " + std::string(study_summary(name));
    command.add_option("--study", arguments->studies, "Papers to make again on this scene, by commas. " + studies);
    command.add_option("--study-pictures", arguments->study_pictures,
                       "A folder for the pictures of the studies (.png, and .glb where there is a drawing)")
        ->check(CLI::ExistingDirectory);
    command.add_option("--occluders", options.occluders, "Occluders per frame, for methods that choose some [theirs]");
    add_occluder_choice(command, arguments->choice);
    command.add_option("--repeat", options.repeat, "Times that the walk is timed")
        ->check(CLI::PositiveNumber)
        ->capture_default_str();
    command.add_option("--truth-scale", options.truth_scale, "The truth has that many times the picture's sides")
        ->check(CLI::Range(1, 8))
        ->capture_default_str();
    command.add_flag("--no-draw", arguments->no_draw, "Time the culling alone");
    command.add_option("--report", arguments->report, "Write tables, plots and pictures as one HTML page");
    add_common(command, arguments->common, "antumbra walk house.glb --pvs house.pvs --report house.html",
               [arguments] { return run_walk(*arguments); });
}

} // namespace antumbra::app
