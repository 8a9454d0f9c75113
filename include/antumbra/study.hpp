// Studies: the tables and plots of a paper, made again with our build of its method, published figures beside ours.
//
//     Result<Study> study = run_study("coorg-teller", scene, {.path = views});
//
// A study is plain data; `antumbra walk --study NAME` shows it in the report and prints it as JSON.
#pragma once

#include <antumbra/cull.hpp>
#include <antumbra/job.hpp>
#include <antumbra/pvs.hpp>
#include <antumbra/scene.hpp>

#include <cstddef>
#include <cstdint>
#include <limits>
#include <span>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

namespace antumbra {

/// Whose figures a row or a line of a plot holds.
enum class StudyOrigin : std::uint8_t { published, ours };

/// Nothing (not published, not measured), words, or a number in the unit of the column.
struct StudyCell {
    std::string words;
    double number = std::numeric_limits<double>::quiet_NaN(); ///< not finite: no number

    StudyCell() = default;
    StudyCell(double value) : number(value) {}
    StudyCell(std::string text) : words(std::move(text)) {}
    StudyCell(const char* text) : words(text) {}
};

struct StudyColumn {
    std::string title;
    std::string unit; ///< shown in the head; empty for words and counts
    int digits = 0;   ///< behind the point; the data keeps all
};

struct StudyRow {
    StudyOrigin origin = StudyOrigin::ours;
    std::vector<StudyCell> cells; ///< as many as the table has columns
};

struct StudyTable {
    std::string title;
    std::string note; ///< what the reader needs to compare the rows; may be empty
    std::vector<StudyColumn> columns;
    std::vector<StudyRow> rows;
};

struct StudySeries {
    std::string label;
    StudyOrigin origin = StudyOrigin::ours;
    std::vector<double> x, y; ///< of the same length, x ascending; NaN in y leaves a gap
};

struct StudyPlot {
    std::string title, x_title, y_title;
    bool logarithmic_x = false, logarithmic_y = false; ///< values must then be above 0
    std::vector<StudySeries> series;
};

struct StudyPicture {
    std::string caption;
    std::vector<std::byte> png; ///< a whole PNG file
    std::vector<std::byte> glb = {}; ///< the same as a drawing to turn around, or empty
};

struct Study {
    std::string name;   ///< of study_names()
    std::string title;
    std::string source; ///< the paper: authors, title, year
    std::string text;   ///< paragraphs, parted by empty lines: what was made again, and on what
    std::vector<StudyTable> tables;
    std::vector<StudyPlot> plots;
    std::vector<StudyPicture> pictures;
    std::vector<std::string> notes; ///< what was left out or is in doubt
};

struct StudyOptions {
    std::span<const View> path;    ///< local coordinates, as for walk(); most studies need it
    std::string path_description;  ///< of FoundPath
    const Pvs* pvs = nullptr;      ///< must belong to the scene
    std::uint32_t width = 640, height = 360; ///< of pictures drawn and of truth
    std::uint32_t occluders = 0;   ///< per frame; 0: what the paper used
    std::uint32_t repeat = 3;      ///< times that anything is timed; the fastest counts
    bool draw = true;              ///< measure drawing, if there is an OpenGL
    std::uint64_t seed = 1;
};

/// Names that run_study() knows.
std::span<const std::string_view> study_names();

/// One line about a study, for help texts; "" for an unknown name.
std::string_view study_summary(std::string_view name);

/// ErrorCode::usage: an unknown name (the message lists the known ones) or an option that this study needs is missing;
/// ErrorCode::cancelled if job says so. Everything but times is a pure function of the arguments.
Result<Study> run_study(std::string_view name, const Scene& scene, const StudyOptions& options = {},
                        const Job& job = {});

/// nullptr, or what is wrong with a study's shape ("a row has other cells than columns"): for tests.
const char* problem_of(const Study& study);

/// The study as a JSON text: what walk --json prints and the report shows. Pictures are base64 where `with_pictures`.
std::string study_json(const Study& study, bool with_pictures);

} // namespace antumbra
