// Nirenstein, Blake, Gain 2002, section 5: Table 2, effective occluders and Figure 4, the share of time that the nearest
// part of the scene takes, Figure 5.
#include "bake/exact/cell.hpp"
#include "bake/viewpoint.hpp"
#include "base/random.hpp"
#include "evaluate/studies/nirenstein_picture.hpp"
#include "evaluate/studies/studies.hpp"

#include <algorithm>
#include <bit>
#include <cmath>
#include <ctime>

namespace antumbra {
namespace {

using exact::GridBox;

constexpr std::uint32_t kAcross = 32, kUp = 16; ///< the paper's partition of the town
constexpr std::size_t kCells = 8;
constexpr double kEnoughSeconds = 60;
constexpr std::uint64_t kFewSamples = 5; ///< bins of fewer queries are left out of Figure 4b

double thread_seconds() {
    timespec now{};
    ::clock_gettime(CLOCK_THREAD_CPUTIME_ID, &now);
    return double(now.tv_sec) + double(now.tv_nsec) * 1e-9;
}

/// What one form of the query did over the cells.
struct Solved {
    std::string name;
    std::size_t cells = 0;
    double seconds = 0, visible_share = 0;
    exact::CellCounters counters;
    std::vector<exact::QueryRecord> records;
    std::vector<std::uint64_t> visible; ///< triangles seen from the first cell
};

/// Random cells of the two lowest levels that hold a point in free space.
std::vector<GridBox> choose_cells(const Scene& scene, const exact::SceneTree& tree, const Tracer& tracer,
                                  std::uint64_t seed) {
    std::vector<GridBox> cells;
    Random random(seed, 0x6e697265);
    Box3d bounds = to_double(scene.local_bounds());
    Vec3d size{bounds.size().x / kAcross, bounds.size().y / kUp, bounds.size().z / kAcross};
    for (int attempt = 0; attempt < 4096 && cells.size() < kCells; ++attempt) {
        Vec3d low{bounds.min.x + size.x * random.below(kAcross), bounds.min.y + size.y * random.below(2),
                  bounds.min.z + size.z * random.below(kAcross)};
        GridBox box{tree.to_grid(low), tree.to_grid(low + size)};
        bool flat = box.min.x == box.max.x || box.min.y == box.max.y || box.min.z == box.max.z, free = false;
        for (int k = 0; k < 64 && !free && !flat; ++k)
            free = is_viewpoint(tracer, {random.uniform(low.x, low.x + size.x), random.uniform(low.y, low.y + size.y),
                                         random.uniform(low.z, low.z + size.z)});
        if (free)
            cells.push_back(box);
    }
    return cells;
}

Result<Solved> solve(const exact::SceneTree& tree, const Tracer& tracer, const std::vector<GridBox>& cells, std::string name,
                     exact::CellOptions options, std::size_t already, std::size_t total, const Job& job) {
    Solved solved;
    solved.name = std::move(name);
    options.observer = [&](const exact::QueryRecord& record) { solved.records.push_back(record); };
    exact::CellSolver solver(tree, tracer, options);
    std::size_t triangles = tree.scene().triangles().size();
    for (const GridBox& cell : cells) {
        if (solved.cells > 0 && solved.seconds > kEnoughSeconds)
            break;
        std::vector<std::uint64_t> bits((triangles + 63) / 64, 0);
        exact::CellCounters counters;
        double begin = thread_seconds();
        if (!solver.solve(cell, bits, counters, {}, job.cancel))
            return Status(ErrorCode::cancelled, "stopped");
        solved.seconds += thread_seconds() - begin;
        std::uint64_t visible = 0;
        for (std::uint64_t word : bits)
            visible += unsigned(std::popcount(word));
        solved.visible_share += double(visible) / double(triangles);
        if (solved.cells++ == 0)
            solved.visible = std::move(bits);
        solved.counters.add(counters);
        if (job.progress)
            job.progress({"study nirenstein", already + solved.cells, total, "cells"});
    }
    solved.visible_share /= double(std::max<std::size_t>(solved.cells, 1));
    return solved;
}

std::string days(double seconds) {
    char text[64];
    if (seconds >= 86400)
        std::snprintf(text, sizeof text, "%.1f days", seconds / 86400);
    else if (seconds >= 3600)
        std::snprintf(text, sizeof text, "%.1f h", seconds / 3600);
    else
        std::snprintf(text, sizeof text, "%.1f min", seconds / 60);
    return text;
}

StudyTable table_2(const Scene& scene, const std::vector<Solved>& forms) {
    StudyTable table{"Table 2: time per cell, culling, full solution",
                     "Published: two Pentium 4 of 1.7 GHz, 100 random cells, as many cells as the paper takes for a full solution "
                     "(2048, 400). Ours: processor seconds of one thread per cell; full solution: 2048 cells on two cores.",
                     {{"scene", "", 0}, {"triangles", "", 0}, {"cells", "", 0}, {"time per cell", "s", 2}, {"culled", "%", 2},
                      {"full solution", "", 0}},
                     {}};
    table.rows.push_back({StudyOrigin::published, {"town", 1.33e6, 100.0, 153.0, 99.45, "3 days 15 h"}});
    table.rows.push_back({StudyOrigin::published, {"forest", 1.45e6, 100.0, 630.0, 99.12, "2 days 22 h"}});
    for (const Solved& form : forms) {
        double seconds = form.seconds / double(form.cells);
        table.rows.push_back({StudyOrigin::ours,
                              {form.name, double(scene.triangles().size()), double(form.cells), seconds,
                               100 * (1 - form.visible_share), days(seconds * 2048 / 2)}});
    }
    return table;
}

StudyTable query_table(const std::vector<Solved>& forms) {
    StudyTable table{"Queries and effective occluders",
                     "An effective occluder is one that had to be subtracted, or is the patch that hides. Published: per query; "
                     "ours: per pair of polygons (a box is asked for through up to nine pairs of faces).",
                     {{"scene", "", 0}, {"queries per cell", "", 0}, {"effective, mean", "", 2}, {"effective, most", "", 0},
                      {"undecided", "", 0}},
                     {}};
    table.rows.push_back({StudyOrigin::published, {"town", 42900.0, 1.7, 250.0, StudyCell()}});
    table.rows.push_back({StudyOrigin::published, {"forest", 55000.0, 3.6, 472.0, StudyCell()}});
    for (const Solved& form : forms) {
        double sum = 0, most = 0, n = double(std::max<std::size_t>(form.records.size(), 1));
        for (const exact::QueryRecord& record : form.records) {
            sum += record.effective;
            most = std::max(most, double(record.effective));
        }
        table.rows.push_back({StudyOrigin::ours,
                              {form.name, double(form.records.size()) / double(form.cells), sum / n, most,
                               double(form.counters.undecided)}});
    }
    return table;
}

StudyTable distribution_table(const Solved& form) {
    StudyTable table{"Distribution of effective occluders, " + form.name,
                     "Share of the queries with so many effective occluders, and of the time that they took.",
                     {{"effective occluders", "", 0}, {"queries", "%", 2}, {"time", "%", 2}},
                     {}};
    const std::uint32_t ends[] = {0, 1, 2, 5, 10, 20, 60, ~0u};
    double seconds = 0;
    for (const exact::QueryRecord& record : form.records)
        seconds += record.seconds;
    std::uint32_t low = 0;
    for (std::uint32_t high : ends) {
        double count = 0, time = 0;
        for (const exact::QueryRecord& record : form.records)
            if (record.effective >= low && record.effective <= high) {
                ++count;
                time += record.seconds;
            }
        std::string label = high == ~0u ? "more than 60" : low == high ? std::to_string(low)
                                                                        : std::to_string(low) + " to " + std::to_string(high);
        table.rows.push_back({StudyOrigin::ours,
                              {label, 100 * count / double(std::max<std::size_t>(form.records.size(), 1)),
                               seconds > 0 ? 100 * time / seconds : 0}});
        low = high + 1;
    }
    return table;
}

/// Time by what is asked for from near to far: `share` of the scene's triangles, those nearest to the cell.
StudyTable nearest_table(const exact::SceneTree& tree, const std::vector<GridBox>& cells, const std::vector<Solved>& forms) {
    StudyTable table{"Time spent on the nearest part of the scene",
                     "Share of the query time that went to boxes and triangles no farther from the cell than the nearest part of "
                     "the scene's triangles is (of the first cell's distances, taken for all). Published: forest, 8%: 97%.",
                     {{"scene", "", 0}, {"nearest 1%", "%", 1}, {"nearest 8%", "%", 1}, {"nearest 25%", "%", 1}},
                     {}};
    table.rows.push_back({StudyOrigin::published, {"forest", StudyCell(), 97.0, StudyCell()}});
    std::vector<double> distances;
    for (std::uint32_t t = 0; t < tree.corners_count(); ++t) {
        GridBox box;
        for (const GridPoint& p : tree.corners(t))
            box.extend(p);
        double sum = 0;
        for (int k = 0; k < 3; ++k) {
            auto gap = double(std::max({std::int64_t(0), cells[0].min[k] - box.max[k], box.min[k] - cells[0].max[k]}));
            sum += gap * gap;
        }
        distances.push_back(std::sqrt(sum));
    }
    std::sort(distances.begin(), distances.end());
    for (const Solved& form : forms) {
        StudyRow row{StudyOrigin::ours, {form.name}};
        for (double share : {0.01, 0.08, 0.25}) {
            double limit = distances[std::min(distances.size() - 1, std::size_t(share * double(distances.size())))];
            double near = 0, all = 0;
            for (const exact::QueryRecord& record : form.records) {
                all += record.seconds;
                near += record.distance <= limit ? record.seconds : 0;
            }
            row.cells.push_back(all > 0 ? StudyCell(100 * near / all) : StudyCell());
        }
        table.rows.push_back(std::move(row));
    }
    return table;
}

struct Bins {
    std::vector<std::uint64_t> count;
    std::vector<double> seconds;
};

Bins by_effective(const Solved& form) {
    Bins bins;
    for (const exact::QueryRecord& record : form.records) {
        if (bins.count.size() <= record.effective) {
            bins.count.resize(record.effective + 1);
            bins.seconds.resize(record.effective + 1);
        }
        ++bins.count[record.effective];
        bins.seconds[record.effective] += record.seconds;
    }
    return bins;
}

/// Least squares over logarithms, from one effective occluder on; NaN for fewer than three bins.
double fit_exponent(const Bins& bins, std::uint64_t least, double& factor) {
    double n = 0, sx = 0, sy = 0, sxx = 0, sxy = 0;
    for (std::size_t m = 1; m < bins.count.size(); ++m) {
        if (bins.count[m] < least || bins.seconds[m] <= 0)
            continue;
        double x = std::log(double(m)), y = std::log(1e3 * bins.seconds[m] / double(bins.count[m]));
        ++n;
        sx += x;
        sy += y;
        sxx += x * x;
        sxy += x * y;
    }
    double exponent = n < 3 ? std::nan("") : (n * sxy - sx * sy) / (n * sxx - sx * sx);
    factor = n < 3 ? 0 : std::exp((sy - exponent * sx) / n);
    return exponent;
}

StudyPlot figure_4(const Solved& form, std::uint64_t least, const std::string& part, double& exponent) {
    StudyPlot plot{"Figure 4" + part + ", " + form.name, "effective occluders", "average time, ms", false, false, {}};
    Bins bins = by_effective(form);
    double factor = 0;
    exponent = fit_exponent(bins, least, factor);
    StudySeries measured{"average", StudyOrigin::ours, {}, {}}, fit{"fit", StudyOrigin::ours, {}, {}},
        published{"m^1.15 (published order), through the fit at m = 1", StudyOrigin::published, {}, {}};
    for (std::size_t m = 1; m < bins.count.size(); ++m) {
        if (bins.count[m] < least)
            continue;
        double x = double(m);
        measured.x.push_back(x);
        measured.y.push_back(1e3 * bins.seconds[m] / double(bins.count[m]));
        fit.x.push_back(x);
        fit.y.push_back(factor * std::pow(x, exponent));
        published.x.push_back(x);
        published.y.push_back(factor * std::pow(x, 1.15));
    }
    plot.series.push_back(std::move(measured));
    if (std::isfinite(exponent)) {
        plot.series.push_back(std::move(fit));
        plot.series.push_back(std::move(published));
    }
    return plot;
}

} // namespace

Result<Study> study_nirenstein(const Scene& scene, const StudyOptions& options, const Job& job) {
    Tracer tracer = Tracer::build(scene, job);
    exact::SceneTree tree = exact::SceneTree::build(scene, exact::Units::triangles(scene));
    std::vector<GridBox> cells = choose_cells(scene, tree, tracer, options.seed);
    if (cells.empty())
        return Status(ErrorCode::usage, "the study nirenstein finds no cell in free space on the two lowest of 16 levels of "
                                        "the scene");
    exact::CellOptions fast;
    fast.look_around = 100000; // as in a bake
    fast.follow = 400000;
    fast.sample_between = true;
    fast.seed = options.seed;
    std::vector<Solved> forms;
    Result<Solved> solved = solve(tree, tracer, cells, "this scene", fast, 0, cells.size(), job);
    if (!solved)
        return solved.status();
    forms.push_back(std::move(*solved));
    Study study;
    study.name = "nirenstein";
    study.title = "Exact from-region visibility: time, culling, effective occluders";
    study.source = "Nirenstein, Blake, Gain: Exact from-region visibility culling, Eurographics Workshop on Rendering 2002";
    study.text = "The exact method (each triangle on its own) on " + std::to_string(forms[0].cells) +
                 " random cells in free space of the two lowest levels of a 32 x 16 x 32 partition of this scene, as the paper "
                 "did with its town. Rays first, then boxes from near to far, hidden ones as occluders. Every answer is "
                 "exact.\n\nThe paper's scenes and machines (2002) are others: compare shares and orders of growth.";
    study.tables = {table_2(scene, forms), query_table(forms), distribution_table(forms[0]),
                    nearest_table(tree, cells, forms)};
    double all = 0, common = 0;
    study.plots = {figure_4(forms[0], 1, "a", all), figure_4(forms[0], kFewSamples, "b", common)};
    char text[160];
    if (std::isfinite(all) && std::isfinite(common)) {
        std::snprintf(text, sizeof text,
                      "Time grows as effective occluders to the power %.2f; over bins of at least five queries %.2f "
                      "(published 1.15).",
                      all, common);
        study.notes.push_back(text);
    } else {
        study.notes.push_back("Too few queries needed several occluders here to fit an order of growth.");
    }
    if (forms[0].cells < cells.size())
        study.notes.push_back("Stopped after " + std::to_string(forms[0].cells) + " cells, which took more than a minute.");
    GridBox first = cells[0];
    auto corner = [&](const GridPoint& p) { return tree.to_local({double(p.x), double(p.y), double(p.z)}); };
    Result<StudyPicture> picture =
        seen_from_cell(tracer, {corner(first.min), corner(first.max)}, forms[0].visible, options, job);
    if (!picture)
        return picture.status();
    study.pictures = {std::move(*picture)};
    if (job.cancelled())
        return Status(ErrorCode::cancelled, "stopped");
    return study;
}

} // namespace antumbra
