#include "evaluate/report/image_coding.hpp"
#include "evaluate/report/pictures.hpp"
#include "evaluate/report/plan.hpp"
#include "evaluate/report/report_page.hpp"

#include "evaluate/pixel_rays.hpp"
#include "evaluate/walk_json.hpp"

#include <antumbra/evaluate.hpp>

#include <nlohmann/json.hpp>

#include <cmath>

namespace antumbra {
namespace {

using Json = nlohmann::ordered_json;

/// Short decimals: a page of float noise is of no use to anyone.
Json rounded(double value, double digits = 1e4) {
    if (value < 0)
        return nullptr;
    return std::floor(value * digits + 0.5) / digits;
}

std::string file_name(const std::string& path) {
    std::size_t slash = path.find_last_of("/\\");
    return slash == std::string::npos ? path : path.substr(slash + 1);
}

Json scene_facts(const Scene& scene) {
    Vec3d size = scene.world_bounds().size();
    return {{"name", file_name(scene.source())},
            {"objects", scene.objects().size()},
            {"triangles", scene.triangles().size()},
            {"extent", {size.x, size.y, size.z}},
            {"fingerprint", to_hex(scene.fingerprint())}};
}

Json pvs_facts(const Pvs* pvs) {
    if (!pvs)
        return nullptr;
    std::uint64_t cells = pvs->grid().cells(), baked = 0;
    for (std::uint64_t cell = 0; cell < cells; ++cell)
        baked += pvs->cell_row(cell) < pvs->row_count();
    for (const ViewNode& node : pvs->tree().nodes) {
        cells += node.axis == ViewNode::kLeaf;
        baked += node.axis == ViewNode::kLeaf && node.link < pvs->row_count();
    }
    return {{"method", std::string(pvs->method())},
            {"guarantee", to_string(pvs->guarantee())},
            {"cells", cells},
            {"baked", baked},
            {"bytes", pvs->file_bytes()}};
}

Json walk_facts(const WalkResult& result, const ReportOptions& options) {
    return {{"width", result.width},
            {"height", result.height},
            {"repeat", result.repeat},
            {"truth_scale", result.truth_scale},
            {"truth_pixels", result.truth_pixels},
            {"path", options.path_description.empty() ? "follows a given path" : options.path_description},
            {"renderer", result.renderer},
            {"objects_true", result.objects_true},
            {"triangles_true", result.triangles_true},
            {"empty_ms", figure_json(result.empty_ms_median)},
            {"ceiling_ms", figure_json(result.ceiling_ms_median)},
            {"ceiling_speedup", figure_json(result.ceiling_speedup)},
            {"notes", result.notes}};
}

Json method_facts(const WalkResult& result) {
    Json methods = Json::array();
    for (const WalkMethod& method : result.methods)
        methods.push_back(method_json(method, result));
    return methods;
}

template <class Value>
Json per_frame(const WalkResult& result, Value&& value) {
    Json column = Json::array();
    for (const WalkFrame& frame : result.frames)
        column.push_back(value(frame));
    return column;
}

/// A list per method of a value per frame.
template <class Value>
Json per_method(const WalkResult& result, Value&& value) {
    Json columns = Json::array();
    for (std::size_t m = 0; m < result.methods.size(); ++m)
        columns.push_back(per_frame(result, [&](const WalkFrame& frame) { return Json(value(frame.methods[m])); }));
    return columns;
}

/// The cell of the eye from above, [x0, z0, x1, z1] local, or null.
Json cell_outline(const Scene& scene, const Pvs* pvs, const View& view) {
    bool grid = pvs && pvs->grid().cells() > 0;
    std::int64_t cell = grid ? pvs->grid().find(scene.to_world(view.eye)) : -1;
    if (cell < 0)
        return nullptr;
    Box3d box = pvs->grid().cell(std::uint64_t(cell));
    Vec3d low = scene.to_local(box.min), high = scene.to_local(box.max);
    return {low.x, low.z, high.x, high.z};
}

Json frame_columns(const Scene& scene, const Pvs* pvs, const WalkResult& result, const Plans& plans) {
    Json frames;
    frames["eye"] = per_frame(result, [](const WalkFrame& f) { return Json{f.view.eye.x, f.view.eye.z}; });
    frames["direction"] = per_frame(result, [](const WalkFrame& f) {
        Vec3d direction = f.view.target - f.view.eye;
        double level = std::sqrt(direction.x * direction.x + direction.z * direction.z);
        return level > 0 ? Json{direction.x / level, direction.z / level} : Json{0, 0};
    });
    frames["opening"] = per_frame(result, [](const WalkFrame& f) {
        return Json(f.view.projection == Projection::perspective ? half_tangent(f.view.fov_y_deg) * f.view.aspect
                                                                 : 0.5);
    });
    frames["plan"] = plans.of_frame;
    frames["cell"] = per_frame(result, [&](const WalkFrame& f) { return cell_outline(scene, pvs, f.view); });
    frames["objects_true"] = per_frame(result, [](const WalkFrame& f) { return Json(f.objects_true); });
    frames["triangles_true"] = per_frame(result, [](const WalkFrame& f) { return Json(f.triangles_true); });
    frames["in_frustum"] = per_frame(result, [](const WalkFrame& f) { return Json(f.objects_in_frustum); });
    frames["ceiling"] = per_frame(result, [](const WalkFrame& f) { return rounded(f.ceiling_ms); });
    frames["cull"] = per_method(result, [](const WalkSample& s) { return rounded(s.cull_ms, 1e6); });
    frames["draw"] = per_method(result, [](const WalkSample& s) { return rounded(s.draw_ms); });
    frames["reported"] = per_method(result, [](const WalkSample& s) { return s.objects_reported; });
    frames["triangles"] = per_method(result, [](const WalkSample& s) { return s.triangles_drawn; });
    frames["false_visible"] = per_method(result, [](const WalkSample& s) { return s.false_visible_objects; });
    frames["lost"] = per_method(result, [](const WalkSample& s) { return s.false_invisible_pixels; });
    return frames;
}

/// Bits from the lowest, eight objects a byte, on every machine.
std::string bits_text(std::span<const std::uint64_t> bits, std::size_t objects) {
    std::vector<std::byte> bytes((objects + 7) / 8);
    for (std::size_t k = 0; k < bytes.size(); ++k)
        bytes[k] = std::byte(bits[k / 8] >> (k % 8 * 8) & 255);
    return to_base64(bytes);
}

Json snapshot_list(const Scene& scene, const WalkResult& result) {
    Json list = Json::array();
    for (const WalkSnapshot& snapshot : result.snapshots) {
        Json reported = Json::array();
        for (const auto& bits : snapshot.reported)
            reported.push_back(bits_text(bits, scene.objects().size()));
        list.push_back({{"frame", snapshot.frame},
                        {"seen", bits_text(snapshot.seen, scene.objects().size())},
                        {"reported", reported}});
    }
    return list;
}

Json plan_list(const Plans& plans) {
    Json list = Json::array();
    for (const Plan& plan : plans.plans)
        list.push_back({{"width", plan.width},
                        {"height", plan.height},
                        {"x", plan.x0},
                        {"z", plan.z0},
                        {"scale", plan.scale},
                        {"runs", to_base64(plan.runs)}});
    return list;
}

std::string data_uri(const Image& image) {
    return "data:image/png;base64," + to_base64(encode_png(image));
}

Json picture_list(const std::vector<FramePictures>& pictures) {
    Json list = Json::array();
    for (const FramePictures& picture : pictures) {
        Json methods = Json::array();
        for (const MethodPicture& method : picture.methods)
            methods.push_back({{"differing_pixels", method.differing_pixels},
                               {"on", method.on ? Json(data_uri(*method.on)) : Json(nullptr)},
                               {"difference", method.difference ? Json(data_uri(*method.difference)) : Json(nullptr)}});
        list.push_back(
            {{"frame", picture.frame}, {"why", picture.why}, {"off", data_uri(picture.off)}, {"methods", methods}});
    }
    return list;
}

std::string escape_html(std::string_view text) {
    std::string escaped;
    for (char c : text)
        escaped += c == '&' ? "&amp;" : c == '<' ? "&lt;" : c == '>' ? "&gt;" : c == '"' ? "&quot;" : std::string(1, c);
    return escaped;
}

/// JSON that can stand in a script element: no '<' (it occurs in strings only), names that are not UTF-8 replaced.
std::string script_json(const Json& document) {
    std::string text = document.dump(-1, ' ', false, Json::error_handler_t::replace), safe;
    safe.reserve(text.size());
    for (char c : text)
        c == '<' ? safe += "\\u003c" : safe += c;
    return safe;
}

/// Puts the parts at their {{names}}. What is put in is not looked at again.
std::string fill_template(std::string_view page,
                          const std::vector<std::pair<std::string_view, std::string_view>>& parts) {
    std::string filled;
    while (!page.empty()) {
        std::size_t open = page.find("{{");
        filled += page.substr(0, open);
        if (open == std::string_view::npos)
            break;
        std::size_t close = page.find("}}", open);
        std::string_view name = page.substr(open + 2, close - open - 2);
        for (const auto& [key, value] : parts)
            if (key == name)
                filled += value;
        page.remove_prefix(close + 2);
    }
    return filled;
}

} // namespace

Result<std::string> make_report(const Scene& scene, const Pvs* pvs, const WalkResult& result,
                                const ReportOptions& options, const Job& job) {
    Tracer tracer = Tracer::build(scene, job);
    Job inner = job;
    inner.progress = nullptr;
    Plans plans = make_plans(tracer, result, std::clamp(options.plan_pixels, 16u, 4096u), inner);
    std::vector<FramePictures> pictures = make_pictures(tracer, result, inner);
    if (job.cancelled())
        return Status(ErrorCode::cancelled, "stopped while making the report");
    Json data;
    data["scene"] = scene_facts(scene);
    data["pvs"] = pvs_facts(pvs);
    data["walk"] = walk_facts(result, options);
    data["methods"] = method_facts(result);
    data["frames"] = frame_columns(scene, pvs, result, plans);
    data["snapshots"] = snapshot_list(scene, result);
    data["plans"] = plan_list(plans);
    data["outdoors"] = plans.outdoors;
    data["pictures"] = picture_list(pictures);
    data["studies"] = Json::array();
    for (const Study& study : options.studies)
        data["studies"].push_back(Json::parse(study_json(study, true)));
    std::string json = script_json(data);
    std::string title = escape_html(file_name(scene.source()) + " - Antumbra walk");
    return fill_template(report_template, {{"title", title},
                                           {"uplot_style", uplot_style},
                                           {"style", report_style},
                                           {"uplot_script", uplot_script},
                                           {"script", report_script},
                                           {"data", json}});
}

} // namespace antumbra
