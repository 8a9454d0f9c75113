// The list of studies, and what all have in common.
#include "evaluate/studies/studies.hpp"

#include "evaluate/report/image_coding.hpp"

#include <nlohmann/json.hpp>

#include <array>
#include <cmath>

namespace antumbra {
namespace {

using Json = nlohmann::ordered_json;

struct Entry {
    std::string_view name, summary;
    Result<Study> (*run)(const Scene&, const StudyOptions&, const Job&);
};

constexpr std::array kStudies{
    Entry{"bittner", "polygons, overhead, frame time and speed-up against the number of occluders (Bittner et al. 1998)",
          study_bittner},
    Entry{"coorg-teller", "polygons left, culling and drawing time, time against walking speed (Coorg, Teller 1997)",
          study_coorg_teller},
    Entry{"poon-wang", "criteria of occluder choice, routes by depth complexity, resolutions (Poon, Wang 1999); made for "
                       "generate downtown",
          study_poon_wang},
    Entry{"nirenstein", "time per cell, culling, effective occluders, what a cell sees (Nirenstein, Blake, Gain 2002)",
          study_nirenstein},
};

Json cell_json(const StudyCell& cell) {
    if (!cell.words.empty())
        return cell.words;
    return std::isfinite(cell.number) ? Json(cell.number) : Json(nullptr);
}

const char* origin_name(StudyOrigin origin) {
    return origin == StudyOrigin::published ? "published" : "ours";
}

Json table_json(const StudyTable& table) {
    Json columns = Json::array(), rows = Json::array();
    for (const StudyColumn& column : table.columns)
        columns.push_back({{"title", column.title}, {"unit", column.unit}, {"digits", column.digits}});
    for (const StudyRow& row : table.rows) {
        Json cells = Json::array();
        for (const StudyCell& cell : row.cells)
            cells.push_back(cell_json(cell));
        rows.push_back({{"origin", origin_name(row.origin)}, {"cells", cells}});
    }
    return {{"title", table.title}, {"note", table.note}, {"columns", columns}, {"rows", rows}};
}

Json plot_json(const StudyPlot& plot) {
    Json series = Json::array();
    for (const StudySeries& one : plot.series) {
        Json y = Json::array();
        for (double value : one.y)
            y.push_back(std::isfinite(value) ? Json(value) : Json(nullptr));
        series.push_back({{"label", one.label}, {"origin", origin_name(one.origin)}, {"x", one.x}, {"y", y}});
    }
    return {{"title", plot.title},
            {"x_title", plot.x_title},
            {"y_title", plot.y_title},
            {"logarithmic_x", plot.logarithmic_x},
            {"logarithmic_y", plot.logarithmic_y},
            {"series", series}};
}

} // namespace

std::span<const std::string_view> study_names() {
    static const auto names = [] {
        std::array<std::string_view, kStudies.size()> list;
        for (std::size_t i = 0; i < kStudies.size(); ++i)
            list[i] = kStudies[i].name;
        return list;
    }();
    return names;
}

std::string_view study_summary(std::string_view name) {
    for (const Entry& entry : kStudies)
        if (entry.name == name)
            return entry.summary;
    return "";
}

Result<Study> run_study(std::string_view name, const Scene& scene, const StudyOptions& options, const Job& job) {
    std::string known;
    for (const Entry& entry : kStudies) {
        if (entry.name == name)
            return entry.run(scene, options, job);
        known += (known.empty() ? "" : ", ") + std::string(entry.name);
    }
    return Status(ErrorCode::usage, "unknown study '" + std::string(name) + "'; known are: " + known);
}

const char* problem_of(const Study& study) {
    if (study.name.empty() || study.title.empty() || study.source.empty())
        return "a study has no name, no title or no source";
    for (const StudyTable& table : study.tables) {
        if (table.title.empty() || table.columns.empty())
            return "a table has no title or no columns";
        for (const StudyRow& row : table.rows)
            if (row.cells.size() != table.columns.size())
                return "a row has other cells than columns";
    }
    for (const StudyPlot& plot : study.plots)
        for (const StudySeries& series : plot.series) {
            if (series.x.size() != series.y.size())
                return "a line of a plot has other values than places";
            for (std::size_t i = 0; i < series.x.size(); ++i) {
                if (!std::isfinite(series.x[i]) || (i > 0 && !(series.x[i] > series.x[i - 1])))
                    return "the places of a line do not ascend";
                if ((plot.logarithmic_x && !(series.x[i] > 0)) || (plot.logarithmic_y && series.y[i] <= 0))
                    return "a logarithmic plot has a value that is not above 0";
            }
        }
    for (const StudyPicture& picture : study.pictures)
        if (picture.png.size() < 8 || picture.png[1] != std::byte('P') || picture.caption.empty())
            return "a picture is no PNG or has no caption";
    return nullptr;
}

std::string study_json(const Study& study, bool with_pictures) {
    Json document{{"name", study.name}, {"title", study.title}, {"source", study.source}, {"text", study.text}};
    for (const char* list : {"tables", "plots", "pictures", "notes"})
        document[list] = Json::array();
    for (const StudyTable& table : study.tables)
        document["tables"].push_back(table_json(table));
    for (const StudyPlot& plot : study.plots)
        document["plots"].push_back(plot_json(plot));
    for (const StudyPicture& picture : study.pictures) {
        document["pictures"].push_back({{"caption", picture.caption}});
        if (with_pictures)
            document["pictures"].back()["png"] = to_base64(picture.png);
    }
    document["notes"] = study.notes;
    return document.dump(-1, ' ', false, Json::error_handler_t::replace);
}

} // namespace antumbra
