// The explanation as words, as JSON and as a drawing.
#include "bake/exact/baked_cells.hpp"
#include "evaluate/spatial_cells.hpp"

#include <antumbra/evaluate.hpp>
#include <antumbra/explain.hpp>
#include <antumbra/export.hpp>

#include <algorithm>
#include <charconv>
#include <cstdio>
#include <map>
#include <nlohmann/json.hpp>

namespace antumbra {
namespace {

using Json = nlohmann::ordered_json;

constexpr std::size_t kMostHidersInWords = 5;

std::string number(double value, const char* format = "%.6g") {
    char text[40];
    std::snprintf(text, sizeof text, format, value);
    return text;
}

std::string point(const Vec3d& p) { return "(" + number(p.x) + ", " + number(p.y) + ", " + number(p.z) + ")"; }

std::string percent(double share) { return number(100 * share, "%.3g") + "%"; }

std::string quoted(const Scene& scene, std::uint32_t object) {
    return std::to_string(object) + " '" + std::string(scene.name(object)) + "'";
}

/// Who hides, most first.
std::string hiders_in_words(const Scene& scene, const SightAnswer& answer) {
    std::string text;
    std::size_t shown = std::min(answer.hiders.size(), kMostHidersInWords);
    for (std::size_t k = 0; k < shown; ++k) {
        const Hider& hider = answer.hiders[k];
        bool needed = hider.leaves > 0;
        if (needed && k == 0)
            text += "\nEnough to hide it:";
        if (!needed && (k == 0 || answer.hiders[k - 1].leaves > 0))
            text += k == 0 ? "\nIn the way:" : "\nIn the way, too:";
        text += "\n  " + quoted(scene, hider.object);
        if (hider.share > 0)
            text += " stops " + percent(hider.share) + " of the sight lines first";
        if (hider.leaves)
            text += std::string(hider.share > 0 ? ", and" : "") + " blocks " + std::to_string(hider.leaves) + " of " +
                    std::to_string(answer.leaves) + " parts of line space";
    }
    if (answer.hiders.size() > shown)
        text += "\n  and " + std::to_string(answer.hiders.size() - shown) + " more";
    return text;
}

/// `from`: "the eye", "the cell".
std::string in_words(const Scene& scene, const SightAnswer& answer, const std::string& from) {
    switch (answer.sight) {
    case Sight::visible: {
        if (answer.touches)
            return "From " + from + " it is visible: it touches it.";
        std::string text = "From " + from + " it is visible: nothing blocks the line from " + point(answer.witness->from) +
                           " to " + point(answer.witness->to) + " on its triangle " +
                           std::to_string(answer.witness->triangle) + " (decided exactly).";
        if (answer.lines_through)
            text += " " + std::to_string(answer.lines_through) + " of " + std::to_string(answer.sight_lines) +
                    " sight lines get through.";
        else
            text += " None of " + std::to_string(answer.sight_lines) + " random sight lines got through; the exact "
                    "method found this one.";
        return text;
    }
    case Sight::hidden: {
        std::string text = "From " + from + " it is hidden, and that is proved: ";
        if (answer.parts == 0)
            return text + "none of its faces is drawn towards it." + hiders_in_words(scene, answer);
        text += "line space falls into " + std::to_string(answer.leaves) + " parts (over " +
                std::to_string(answer.parts) + " pairs of faces), each empty or blocked by one occluder";
        text += answer.verified ? "; an independent verifier agrees." : ".";
        return text + hiders_in_words(scene, answer);
    }
    case Sight::undecided:
        break;
    }
    return "From " + from + " none of " + std::to_string(answer.sight_lines) +
           " sight lines gets through; there is no proof that none can." + hiders_in_words(scene, answer);
}

std::string pvs_in_words(const Explanation& e) {
    std::string what = e.listed ? "visible" : "hidden";
    if (e.always_visible)
        return "The file says visible: the object is never culled (it moves, or was marked so).";
    switch (e.state) {
    case CellState::outside:
        return "The file says visible: the eye is outside every cell, where everything is.";
    case CellState::solid:
        return "The file says visible: cell " + std::to_string(e.cell) + " lies inside matter, where everything is.";
    case CellState::not_baked:
        return "The file says visible: cell " + std::to_string(e.cell) + " was not baked, and there everything is.";
    case CellState::baked:
        break;
    }
    std::string parts = e.clusters == 0 ? ""
                                        : " (" + std::to_string(e.clusters_listed) + " of its " + std::to_string(e.clusters) +
                                              " clusters)";
    return "The file says " + what + parts + " from cell " + std::to_string(e.cell) + ", and promises to be " +
           to_string(e.guarantee) + ".";
}

/// Does the file agree with what was proved?
std::string verdict_in_words(const Explanation& e) {
    Sight cell = e.from_cell ? e.from_cell->sight : Sight::undecided;
    bool may_lose = e.guarantee == Guarantee::aggressive || e.guarantee == Guarantee::approximate;
    if (!e.listed && (e.from_eye.sight == Sight::visible || cell == Sight::visible))
        return may_lose ? "So the file misses it: false invisible, which its guarantee allows."
                        : "So the file is wrong, against its guarantee: do not use it, and please report how it was baked.";
    if (e.listed && cell == Sight::hidden && e.state == CellState::baked && !e.always_visible)
        return e.guarantee == Guarantee::exact || e.guarantee == Guarantee::aggressive
                   ? "So the file lists what cannot be seen, against its guarantee: please report how it was baked."
                   : "So the file lists it without need: false visible, which its guarantee allows.";
    if (e.listed && e.from_eye.sight == Sight::hidden && cell == Sight::visible)
        return "So the file is right: it speaks of the whole cell, and elsewhere in the cell it can be seen.";
    return {};
}

Json json(const Vec3d& p) { return {p.x, p.y, p.z}; }

Json json(const Scene& scene, const SightAnswer& answer) {
    Json document;
    document["answer"] = to_string(answer.sight);
    document["from"] = {{"min", json(answer.from.min)}, {"max", json(answer.from.max)}};
    document["touches"] = answer.touches;
    document["witness"] = nullptr;
    if (answer.witness)
        document["witness"] = {{"from", json(answer.witness->from)},
                               {"to", json(answer.witness->to)},
                               {"triangle", answer.witness->triangle},
                               {"object", scene.triangle_objects()[answer.witness->triangle]}};
    document["sight_lines"] = answer.sight_lines;
    document["lines_through"] = answer.lines_through;
    document["undrawn"] = answer.undrawn;
    document["hiders"] = Json::array();
    for (const Hider& hider : answer.hiders)
        document["hiders"].push_back({{"id", hider.object},
                                      {"name", std::string(scene.name(hider.object))},
                                      {"share", hider.share},
                                      {"leaves", hider.leaves},
                                      {"triangles", hider.triangles}});
    document["certificate"] = {{"parts", answer.parts},
                               {"splits", answer.splits},
                               {"leaves", answer.leaves},
                               {"verified", answer.verified}};
    return document;
}

// Drawings.

constexpr std::array<float, 4> kGreen{0.05f, 0.7f, 0.1f, 1}, kRed{0.8f, 0.03f, 0.02f, 1}, kGrey{0.5f, 0.5f, 0.5f, 1},
    kBlue{0.05f, 0.15f, 0.6f, 0.35f}, kLightBlue{0.2f, 0.6f, 1, 1}, kOrange{1, 0.35f, 0, 1}, kYellow{1, 0.85f, 0, 1},
    kWhite{1, 1, 1, 1};

void add_triangle(const Scene& scene, std::uint32_t t, DrawingPart& part) {
    for (int c = 0; c < 3; ++c) {
        part.indices.push_back(std::uint32_t(part.positions.size()));
        part.positions.push_back(scene.to_world(scene.vertex(t, c)));
    }
}

DrawingPart draw_object(const Scene& scene, std::uint32_t object, const std::string& what, std::array<float, 4> colour) {
    DrawingPart part{what + " " + quoted(scene, object), colour, false, {}, {}};
    const Object& o = scene.objects()[object];
    for (std::uint32_t t = 0; t < o.triangle_count; ++t)
        add_triangle(scene, o.first_triangle + t, part);
    return part;
}

DrawingPart draw_lines(const std::string& name, std::array<float, 4> colour, std::vector<Vec3d> ends) {
    DrawingPart part{name, colour, true, std::move(ends), {}};
    for (std::uint32_t k = 0; k < part.positions.size(); ++k)
        part.indices.push_back(k);
    return part;
}

DrawingPart draw_box(const std::string& name, std::array<float, 4> colour, const Box3d& box) {
    std::vector<Vec3d> ends;
    for (int i = 0; i < 8; ++i)
        for (int axis = 1; axis < 8; axis *= 2)
            if (!(i & axis)) {
                ends.push_back(box.corner(i));
                ends.push_back(box.corner(i | axis));
            }
    return draw_lines(name, colour, std::move(ends));
}

DrawingPart draw_cross(const std::string& name, std::array<float, 4> colour, const Vec3d& at, double size) {
    std::vector<Vec3d> ends;
    for (int k = 0; k < 3; ++k) {
        Vec3d along;
        along[k] = size;
        ends.push_back(at - along);
        ends.push_back(at + along);
    }
    return draw_lines(name, colour, std::move(ends));
}

} // namespace

Result<std::uint32_t> find_object(const Scene& scene, const std::string& name_or_index) {
    std::uint32_t index = 0;
    const char* end = name_or_index.data() + name_or_index.size();
    auto [rest, error] = std::from_chars(name_or_index.data(), end, index);
    std::vector<std::uint32_t> found;
    for (std::uint32_t o = 0; o < scene.objects().size(); ++o)
        if (scene.name(o) == name_or_index)
            found.push_back(o);
    if (found.size() == 1)
        return found.front();
    bool is_number = error == std::errc() && rest == end;
    if (is_number && index < scene.objects().size())
        return index;
    std::string problem = "object '" + name_or_index + "': ";
    if (found.empty())
        return Status(ErrorCode::usage, problem + "there is none of that name or number; `antumbra query` lists them, and "
                                                  "the scene has " + std::to_string(scene.objects().size()));
    problem += std::to_string(found.size()) + " have that name; give the number of one:";
    for (std::size_t k = 0; k < std::min<std::size_t>(found.size(), 8); ++k)
        problem += " " + std::to_string(found[k]);
    return Status(ErrorCode::usage, problem + (found.size() > 8 ? " .." : ""));
}

std::string explain_in_words(const Scene& scene, const Explanation& e) {
    std::string text = "Object " + quoted(scene, e.object) + " from " + point(e.eye) + ".\n" + pvs_in_words(e) + "\n";
    bool is_point = e.from_eye.from.min == e.from_eye.from.max;
    text += in_words(scene, e.from_eye,
                     is_point || e.from_eye.sight != Sight::visible ? "the eye" : "within one grid step of the eye");
    if (e.from_cell)
        text += "\n" + in_words(scene, *e.from_cell, "the cell");
    std::string verdict = verdict_in_words(e);
    return verdict.empty() ? text : text + "\n" + verdict;
}

std::string explain_in_json(const Scene& scene, const Explanation& e) {
    const ObjectId& id = scene.objects()[e.object].id;
    Json document;
    document["object"] = {{"id", e.object},
                          {"name", std::string(scene.name(e.object))},
                          {"node", id.node},
                          {"primitive", id.primitive},
                          {"instance", id.instance}};
    document["eye"] = json(e.eye);
    document["cell"] = {{"index", e.cell}, {"state", to_string(e.state)}, {"min", nullptr}, {"max", nullptr}};
    if (e.from_cell) {
        document["cell"]["min"] = json(e.from_cell->from.min);
        document["cell"]["max"] = json(e.from_cell->from.max);
    }
    document["pvs"] = {{"listed", e.listed},
                       {"guarantee", to_string(e.guarantee)},
                       {"always_visible", e.always_visible},
                       {"clusters", e.clusters},
                       {"clusters_listed", e.clusters_listed}};
    document["words"] = explain_in_words(scene, e);
    document["from_eye"] = json(scene, e.from_eye);
    document["from_cell"] = e.from_cell ? json(scene, *e.from_cell) : Json(nullptr);
    return document.dump(2, ' ', false, Json::error_handler_t::replace);
}

Result<std::vector<std::byte>> explain_as_glb(const Scene& scene, const Explanation& e) {
    Sight sight = e.from_cell && e.from_eye.sight != Sight::visible ? e.from_cell->sight : e.from_eye.sight;
    std::vector<DrawingPart> parts;
    parts.push_back(draw_object(scene, e.object, to_string(sight),
                                sight == Sight::visible  ? kGreen
                                : sight == Sight::hidden ? kRed
                                                         : kGrey));
    std::map<std::uint32_t, std::vector<std::uint32_t>> hiders; // object, its triangles that took part
    for (const SightAnswer* answer : {&e.from_eye, e.from_cell ? &*e.from_cell : nullptr})
        if (answer)
            for (const Hider& hider : answer->hiders)
                hiders[hider.object].insert(hiders[hider.object].end(), hider.triangles.begin(), hider.triangles.end());
    for (auto& [hider, triangles] : hiders) {
        if (hider != e.object)
            parts.push_back(draw_object(scene, hider, "hider", kBlue));
        DrawingPart taking_part{"blockers of " + quoted(scene, hider), kLightBlue, false, {}, {}};
        std::sort(triangles.begin(), triangles.end());
        triangles.erase(std::unique(triangles.begin(), triangles.end()), triangles.end());
        for (std::uint32_t t : triangles)
            add_triangle(scene, t, taking_part);
        parts.push_back(std::move(taking_part));
    }
    if (e.from_eye.witness)
        parts.push_back(draw_lines("witness from the eye", kOrange, {e.from_eye.witness->from, e.from_eye.witness->to}));
    if (e.from_cell) {
        if (e.from_cell->witness)
            parts.push_back(
                draw_lines("witness from the cell", kYellow, {e.from_cell->witness->from, e.from_cell->witness->to}));
        parts.push_back(draw_box("cell", kYellow, e.from_cell->from));
    }
    double size = length(scene.world_bounds().size()) / 200;
    parts.push_back(draw_cross("eye", kWhite, e.eye, size));
    return export_drawing(parts);
}

Result<std::vector<std::byte>> cell_as_glb(const Scene& scene, const Pvs& pvs, const Vec3d& eye) {
    if (Status status = check_belongs(scene, pvs); !status)
        return status;
    PvsCursor cursor;
    pvs.query(eye, cursor);
    if (cursor.everything)
        return Status(ErrorCode::usage, "no baked cell is around the eye: everything is visible from there");
    Box3d cell;
    if (pvs.tree().nodes.empty()) {
        cell = pvs.grid().cell(std::uint64_t(pvs.grid().find(eye)));
    } else {
        for (const SpatialCell& one : spatial_cells(pvs))
            if (one.box.contains(eye))
                cell = one.box;
    }
    std::vector<DrawingPart> parts = {{"visible", kGreen, false, {}, {}}, {"hidden", kRed, false, {}, {}}};
    Result<exact::Units> units = exact::units_of(scene, pvs); // clusters, where these are listed
    if (!units)
        return units.status();
    for (std::uint32_t u = 0; u < units->count(); ++u) {
        bool seen = pvs.cluster_count() > 0 ? pvs.is_cluster_visible(u, cursor) : (cursor.visible[u / 64] >> (u % 64) & 1) != 0;
        for (std::uint32_t t : units->triangles_of(u))
            add_triangle(scene, t, parts[seen ? 0 : 1]);
    }
    static constexpr std::uint32_t faces[6][4] = {{0, 4, 6, 2}, {1, 3, 7, 5}, {0, 1, 5, 4},
                                                  {2, 6, 7, 3}, {0, 2, 3, 1}, {4, 5, 7, 6}};
    DrawingPart block{"cell", kYellow, false, {}, {}};
    for (int corner = 0; corner < 8; ++corner)
        block.positions.push_back(cell.corner(corner));
    for (const auto& f : faces)
        block.indices.insert(block.indices.end(), {f[0], f[1], f[2], f[0], f[2], f[3]});
    parts.push_back(std::move(block));
    return export_drawing(parts);
}

} // namespace antumbra
