// The three tables of Coorg and Teller 1997 (section 4): polygons left after each culling, culling and drawing time,
// and time against the speed of the observer, with their method as published and in its modern form.
#include "evaluate/cull_scene.hpp"
#include "evaluate/metrics.hpp"
#include "evaluate/studies/studies.hpp"

#include <antumbra/evaluate.hpp>
#include <antumbra/occluder_finding.hpp>

#include <algorithm>
#include <chrono>
#include <cmath>

namespace antumbra {
namespace {

constexpr std::uint32_t kWalkFrames = 60;   ///< of the path, spread evenly: tables 1 and 2
constexpr std::uint32_t kPublishedSet = 64; ///< occluders per leaf and direction; the paper's number is not legible
constexpr double kDivision = 16;            ///< of the path's steps: walking speed
constexpr std::size_t kSlowFrames = 480;    ///< at walking speed

const char* const kMethods[] = {"frustum", "planes-published", "planes"};

double milliseconds_since(std::chrono::steady_clock::time_point start) {
    return std::chrono::duration<double, std::milli>(std::chrono::steady_clock::now() - start).count();
}

StudyCell measured(double value) {
    return value < 0 ? StudyCell() : StudyCell(value);
}

/// The words of the paper where its numbers did not survive in the copy at hand.
StudyRow quoted(const char* scene, std::vector<StudyCell> cells) {
    cells.insert(cells.begin(), std::string(scene));
    return {StudyOrigin::published, std::move(cells)};
}

std::string name_of(const Scene& scene) {
    std::size_t slash = scene.source().find_last_of("/\\");
    return slash == std::string::npos ? scene.source() : scene.source().substr(slash + 1);
}

// -- tables 1 and 2 ---------------------------------------------------------------------------------------------------

Result<WalkResult> walk_evenly(const Scene& scene, const StudyOptions& options, const Job& job) {
    std::vector<View> path;
    std::size_t frames = std::min<std::size_t>(kWalkFrames, options.path.size());
    for (std::size_t k = 0; k < frames; ++k)
        path.push_back(options.path[k * options.path.size() / frames]);
    WalkOptions walk_options;
    walk_options.methods.assign(std::begin(kMethods), std::end(kMethods));
    walk_options.width = options.width;
    walk_options.height = options.height;
    walk_options.repeat = options.repeat;
    walk_options.draw = options.draw;
    walk_options.occluders = options.occluders;
    walk_options.snapshot_bytes = 0;
    return walk(scene, path, walk_options, job);
}

StudyTable polygons_left(const Scene& scene, const WalkResult& result) {
    StudyTable table;
    table.title = "Polygons left to draw (table 1)";
    table.note = "Share of all polygons that is drawn after culling by the frustum alone and after occlusion culling; "
                 "means per frame. Objects are culled whole. The published figures could not be had (see the note). “Seen” is the share of the objects that a ray sees; “lost” must "
                 "be 0.";
    table.columns = {{"scene", "", 0},      {"polygons", "", 0},    {"frustum", "%", 2}, {"occlusion, as published", "%", 2},
                     {"occlusion, modern", "%", 2}, {"seen", "%", 2}, {"pixels lost", "", 0}};
    table.rows.push_back(quoted("Soda Hall, fifth floor", {{}, {}, {}, {}, {}, {}}));
    table.rows.push_back(quoted("city", {{}, {}, {}, {}, {}, {}}));
    double all = std::max<double>(1, double(scene.triangles().size()));
    StudyRow row{StudyOrigin::ours, {name_of(scene), double(scene.triangles().size())}};
    std::uint64_t lost = 0;
    for (const WalkMethod& method : result.methods) {
        row.cells.push_back(100 * method.triangles_drawn / all);
        lost += method.false_invisible_pixels;
    }
    row.cells.push_back(100 * result.triangles_true / all);
    row.cells.push_back(double(lost));
    table.rows.push_back(std::move(row));
    return table;
}

StudyTable times(const Scene& scene, const WalkResult& result) {
    StudyTable table;
    table.title = "Culling and drawing time (table 2)";
    table.note = result.renderer.empty() ? "Medians per frame. Nothing was drawn: there is no OpenGL, or drawing was switched off."
                                         : "Medians per frame; drawn by " + result.renderer + ".";
    table.columns = {{"scene", "", 0},     {"machine", "", 0}, {"method", "", 0},         {"cull", "ms", 4},
                     {"draw", "ms", 2},    {"total", "ms", 2}, {"total, of frustum", "%", 1}};
    for (const char* place : {"Soda Hall, fifth floor", "city"})
        for (const char* machine : {"SGI Onyx", "SGI Indigo2 Elan"})
            table.rows.push_back(quoted(place, {machine, "frustum and occlusion", {}, {}, "less than frustum alone", {}}));
    for (const WalkMethod& method : result.methods)
        table.rows.push_back({StudyOrigin::ours,
                              {name_of(scene), "here", method.name, measured(method.cull_ms_median),
                               measured(method.draw_ms_median), measured(method.frame_ms_median),
                               method.speedup_over_frustum > 0 ? StudyCell(100 / method.speedup_over_frustum) : StudyCell()}});
    return table;
}

// -- table 3 ----------------------------------------------------------------------------------------------------------

View between(const View& a, const View& b, double share) {
    View view = a;
    view.eye = a.eye + (b.eye - a.eye) * share;
    view.target = view.eye + normalized(a.target - a.eye) * (1 - share) + normalized(b.target - b.eye) * share;
    view.up = normalized(a.up) * (1 - share) + normalized(b.up) * share;
    return problem_of(view) ? a : view; // turned right round between two frames
}

/// The first part of the path in steps of 1/kDivision of its own, times `speed`: the same way at every speed.
std::vector<View> walk_at(const StudyOptions& options, double speed) {
    std::vector<View> views;
    double step = speed / kDivision, end = double(kSlowFrames) / kDivision;
    end = std::min(end, double(options.path.size() - 1));
    for (std::size_t k = 0; double(k) * step <= end; ++k) {
        double at = double(k) * step;
        auto from = std::min(std::size_t(at), options.path.size() - 1);
        auto to = std::min(from + 1, options.path.size() - 1);
        View view = between(options.path[from], options.path[to], at - double(from));
        view.aspect = double(options.width) / options.height;
        view.near_plane = 0;
        views.push_back(view);
    }
    return views;
}

struct Speed {
    double factor = 1, milliseconds = 0, frustum_milliseconds = 0;
    double made = 0, cached = 0; ///< relations per frame
    double modern_milliseconds = 0;
    std::size_t frames = 0;
};

struct Timed {
    double milliseconds = 0, made = 0, cached = 0; ///< per frame
};

/// A warm walk: the first round fills caches, as walking on does; of the following the fastest counts, frame by frame.
Timed time_walk(const Culler& culler, std::span<const View> views, std::uint32_t repeat) {
    std::vector<double> best(views.size(), 1e300);
    Timed timed;
    for (std::uint32_t pass = 0; pass < repeat; ++pass) {
        ViewState state;
        CullResult result;
        for (std::size_t f = 0; f < views.size(); ++f) {
            auto start = std::chrono::steady_clock::now();
            culler.cull(views[f], state, result);
            best[f] = std::min(best[f], milliseconds_since(start));
            if (pass > 0)
                continue;
            timed.made += double(result.counters.relations_made) / double(views.size());
            timed.cached += double(result.counters.relations_cached) / double(views.size());
        }
    }
    for (double one : best)
        timed.milliseconds += one / double(views.size());
    return timed;
}

Result<std::vector<Speed>> time_speeds(const Scene& scene, const StudyOptions& options, const Job& job) {
    CullScene cull_scene = cull_scene_of(scene, find_occluders(scene));
    CullerOptions culler_options;
    culler_options.occluders = options.occluders > 0 ? options.occluders : kPublishedSet;
    std::vector<std::unique_ptr<Culler>> cullers;
    for (const char* name : kMethods) {
        auto made = make_culler(name, cull_scene, culler_options);
        if (!made)
            return made.status();
        cullers.push_back(std::move(*made));
    }
    std::vector<Speed> speeds;
    for (double factor : {1.0, 2.0, 4.0}) {
        if (job.cancelled())
            return Status(ErrorCode::cancelled, "stopped in the study coorg-teller");
        std::vector<View> views = walk_at(options, factor);
        Timed published = time_walk(*cullers[1], views, options.repeat);
        Speed speed{factor, published.milliseconds, 0, published.made, published.cached, 0, views.size()};
        speed.frustum_milliseconds = time_walk(*cullers[0], views, options.repeat).milliseconds;
        speed.modern_milliseconds = time_walk(*cullers[2], views, options.repeat).milliseconds;
        speeds.push_back(speed);
    }
    return speeds;
}

StudyTable speed_table(const Scene& scene, const std::vector<Speed>& speeds) {
    StudyTable table;
    table.title = "Time against the speed of the observer (table 3)";
    table.note = "Time per frame that the visibility algorithm takes beyond culling by the frustum, on the same way at 1, "
                 "2 and 4 times walking speed, and the share of relations (planes of one occluder and one node) found in "
                 "the cache.";
    table.columns = {{"scene", "", 0}, {"figure", "", 0}, {"1x", "", 4}, {"2x", "", 4}, {"4x", "", 4}};
    for (const char* place : {"Soda Hall, fifth floor", "city"})
        table.rows.push_back(quoted(place, {"visibility, ms", "less for slow observers", {}, {}}));
    auto row = [&](const char* figure, auto&& value) {
        StudyRow made{StudyOrigin::ours, {name_of(scene), std::string(figure)}};
        for (const Speed& speed : speeds)
            made.cells.push_back(value(speed));
        table.rows.push_back(std::move(made));
    };
    row("as published, ms", [](const Speed& s) { return s.milliseconds - s.frustum_milliseconds; });
    row("relations made per frame", [](const Speed& s) { return s.made; });
    row("relations from the cache, %",
        [](const Speed& s) { return s.made + s.cached > 0 ? 100 * s.cached / (s.made + s.cached) : 0; });
    row("modern, ms", [](const Speed& s) { return s.modern_milliseconds - s.frustum_milliseconds; });
    return table;
}

StudyPlot speed_plot(const std::vector<Speed>& speeds) {
    StudyPlot plot{"Visibility time against speed", "times walking speed", "ms per frame", true, false, {}};
    StudySeries published{"planes-published", StudyOrigin::ours, {}, {}}, modern{"planes", StudyOrigin::ours, {}, {}};
    for (const Speed& speed : speeds) {
        published.x.push_back(speed.factor);
        published.y.push_back(speed.milliseconds - speed.frustum_milliseconds);
        modern.x.push_back(speed.factor);
        modern.y.push_back(speed.modern_milliseconds - speed.frustum_milliseconds);
    }
    plot.series = {published, modern};
    return plot;
}

StudyPlot triangle_plot(const WalkResult& result) {
    StudyPlot plot{"Polygons drawn along the walk", "frame", "polygons", false, false, {}};
    for (std::size_t m = 0; m < result.methods.size(); ++m) {
        StudySeries series{result.methods[m].name, StudyOrigin::ours, {}, {}};
        for (std::size_t f = 0; f < result.frames.size(); ++f) {
            series.x.push_back(double(f));
            series.y.push_back(double(result.frames[f].methods[m].triangles_drawn));
        }
        plot.series.push_back(std::move(series));
    }
    return plot;
}

} // namespace

Result<Study> study_coorg_teller(const Scene& scene, const StudyOptions& options, const Job& job) {
    if (options.path.size() < 2)
        return Status(ErrorCode::usage, "the study coorg-teller needs a camera path of at least two frames");
    Result<WalkResult> result = walk_evenly(scene, options, job);
    if (!result)
        return result.status();
    Result<std::vector<Speed>> speeds = time_speeds(scene, options, job);
    if (!speeds)
        return speeds.status();
    Study study;
    study.name = "coorg-teller";
    study.title = "Large occluders: what occlusion culling saves, and what slow observers save";
    study.source = "Coorg, Teller: Real-time occlusion culling for models with large occluders, I3D 1997";
    study.text = "The method as published (kd-tree, relations of occluders and nodes, cached while the observer moves, "
                 "occluder sets per leaf and direction) and its modern form (eight boxes at a time) on this scene, along " +
                 std::to_string(result->frames.size()) + " frames of the walk; table 3 walks its beginning in " +
                 std::to_string(speeds->front().frames) +
                 " small steps.\n\nThe paper's models are the fifth floor of Soda Hall and a city, on machines of 1997: compare "
                 "shares and shapes, not milliseconds.";
    study.tables = {polygons_left(scene, *result), times(scene, *result), speed_table(scene, *speeds)};
    study.plots = {speed_plot(*speeds), triangle_plot(*result)};
    study.notes.push_back("The paper's rows hold words only. The copy that this study was made from lacks the figures of its tables, and "
                          "no excerpt that a search for them brought up repeats them.");
    return study;
}

} // namespace antumbra
