// Table 2 and figures 9 and 10 of Bittner, Havran and Slavik 1998: polygons, overhead, frame time and speed-up of the
// three methods with occlusion trees against the number of occluders.
#include "evaluate/studies/studies.hpp"

#include <antumbra/evaluate.hpp>

#include <algorithm>
#include <cmath>

namespace antumbra {
namespace {

constexpr std::size_t kMostFrames = 400; ///< the walk of figures 9 and 10
constexpr std::uint32_t kFigureOccluders = 32;

struct Published {
    const char *scene, *method;
    int occluders, polygons;
    double overhead, time, speedup; ///< ms, ms; overhead below 0: not given
};

/// Table 2, on an SGI O2.
constexpr Published kTable2[] = {
    {"soda-5", "F", 0, 18192, -1, 276.5, 1.00},   {"soda-5", "FME", 8, 9466, 3.7, 157.3, 1.75},
    {"soda-5", "FME", 16, 7390, 5.9, 139.0, 1.99}, {"soda-5", "FME", 24, 6537, 7.9, 116.0, 2.38},
    {"soda-5", "FME", 32, 5941, 9.8, 109.8, 2.52}, {"soda-5", "FME", 50, 5490, 14.2, 109.5, 2.53},
    {"soda-5", "FSE", 16, 6512, 12.7, 120.5, 2.29}, {"soda-5", "FSE", 24, 5569, 16.0, 110.5, 2.50},
    {"soda-5", "FSE", 32, 4725, 19.1, 100.1, 2.76}, {"soda-5", "FMC", 16, 7988, 5.4, 135.9, 2.03},
    {"soda-5", "FMC", 24, 7362, 7.3, 129.3, 2.14}, {"big-7", "F", 0, 12587, -1, 182.0, 1.00},
    {"big-7", "FME", 16, 3641, 8.8, 71.5, 2.55},   {"big-7", "FME", 24, 2286, 10.2, 54.6, 3.33},
    {"big-7", "FME", 32, 1818, 11.6, 48.5, 3.75},  {"big-7", "FSE", 24, 2214, 19.9, 63.4, 2.87},
    {"big-7", "FMC", 16, 3640, 8.4, 74.3, 2.44},   {"big-7", "FMC", 24, 2263, 9.7, 51.4, 3.54},
    {"soda", "F", 0, 15297, -1, 315.2, 1.00},      {"soda", "FME", 24, 4744, 10.1, 119.7, 2.63},
    {"soda", "FSE", 24, 4388, 23.7, 128.0, 2.46},
};

struct Run {
    std::uint32_t occluders;
    std::vector<std::string> methods;
    WalkResult result;
    const char* variant = ""; ///< after the method's letters
    OcclusionTreeOptions tree;
};

/// Means over the walk, as the paper's lines are.
struct Means {
    double polygons = 0, cull = 0, frame = -1;
    std::uint64_t lost = 0;
};

Means means_of(const WalkResult& result, std::string_view name) {
    Means means;
    for (std::size_t m = 0; m < result.methods.size(); ++m) {
        if (result.methods[m].name != name)
            continue;
        double frames = std::max<double>(1, double(result.frames.size())), frame = 0;
        bool drawn = true;
        for (const WalkFrame& f : result.frames) {
            means.polygons += double(f.methods[m].triangles_drawn) / frames;
            means.cull += f.methods[m].cull_ms / frames;
            frame += f.methods[m].frame_ms() / frames;
            drawn = drawn && f.methods[m].frame_ms() >= 0;
        }
        means.frame = drawn ? frame : -1;
        means.lost = result.methods[m].false_invisible_pixels;
    }
    return means;
}

const char* letters_of(const std::string& method) {
    return method == "tree-fse" ? "FSE" : method == "tree-fme" ? "FME" : method == "tree-fmc" ? "FMC" : method == "tree-f" ? "F" : method.c_str();
}

std::string file_name(const Scene& scene) {
    std::size_t slash = scene.source().find_last_of("/\\");
    return slash == std::string::npos ? scene.source() : scene.source().substr(slash + 1);
}

Result<std::vector<Run>> walk_all(const Scene& scene, const StudyOptions& options, const Job& job) {
    std::vector<Run> runs{{8, {"tree-fme"}, {}, "", {}},
                          {16, {"tree-fme", "tree-fse", "tree-fmc"}, {}, "", {}},
                          {24, {"tree-fme", "tree-fse", "tree-fmc"}, {}, "", {}},
                          {32, {"tree-fme", "tree-fse", "planes", "tree"}, {}, "", {}},
                          {50, {"tree-fme"}, {}, "", {}},
                          {128, {"tree-fme", "tree-fse"}, {}, "", {}},
                          {256, {"tree-fme", "tree-fse"}, {}, "", {}}};
    // What the paper leaves open or only sketches, one at a time.
    auto variant = [&](const char* name, std::vector<std::string> methods, auto&& change) {
        Run run{kFigureOccluders, std::move(methods), {}, name, {}};
        change(run.tree);
        runs.push_back(std::move(run));
    };
    variant(", V of the view", {"tree-fme"}, [](OcclusionTreeOptions& tree) { tree.area_angle = AreaAngle::viewing_direction; });
    variant(", tests at inner nodes", {"tree-fme"}, [](OcclusionTreeOptions& tree) { tree.inner_tests = true; });
    variant(", extra nodes", {"tree-fme", "tree-fmc"}, [](OcclusionTreeOptions& tree) { tree.extra_nodes = true; });
    variant(", no marks", {"tree-fme"}, [](OcclusionTreeOptions& tree) { tree.retest = Retest::always; });
    variant(" from the deepest node", {"tree"}, [](OcclusionTreeOptions& tree) { tree.start = TreeStart::deepest_node; });
    std::span<const View> path = options.path.subspan(0, std::min(kMostFrames, options.path.size()));
    for (Run& run : runs) {
        WalkOptions walk_options;
        walk_options.methods = {"tree-f"};
        walk_options.methods.insert(walk_options.methods.end(), run.methods.begin(), run.methods.end());
        walk_options.width = options.width;
        walk_options.height = options.height;
        walk_options.repeat = options.repeat;
        walk_options.draw = options.draw;
        walk_options.occluders = run.occluders;
        walk_options.tree = run.tree;
        walk_options.snapshot_bytes = 0;
        Result<WalkResult> result = walk(scene, path, walk_options, job);
        if (!result)
            return result.status();
        run.result = std::move(*result);
    }
    return runs;
}

StudyTable table2(const Scene& scene, const std::vector<Run>& runs) {
    StudyTable table;
    table.title = "Results of hierarchical visibility culling (table 2)";
    table.note = "Means per frame. F: view frustum alone, over the same kd-tree; S: faces split exactly; M: without splitting; "
                 "E, C: with and without a test at leaves; V of the view: area-angle as printed, with the viewing direction "
                 "in place of the line of sight; nodes with fewer than 50 polygons are not tested. Overhead: culling time "
                 "beyond that of F. Speed-up: of the frame over F's. “Pixels lost” over the whole walk must be 0.";
    table.columns = {{"scene", "", 0},  {"method", "", 0},   {"occluders", "", 0},   {"rendered polygons", "", 0},
                     {"of F", "%", 1},  {"overhead", "ms", 3}, {"frame", "ms", 2},   {"speed-up", "", 2},
                     {"pixels lost", "", 0}};
    double first = 1;
    for (const Published& row : kTable2) {
        if (row.occluders == 0)
            first = row.polygons;
        table.rows.push_back({StudyOrigin::published,
                              {row.scene, row.method, row.occluders ? StudyCell(double(row.occluders)) : StudyCell(),
                               double(row.polygons), 100 * row.polygons / first,
                               row.overhead < 0 ? StudyCell() : StudyCell(row.overhead), row.time, row.speedup, {}}});
    }
    bool frustum_shown = false;
    for (const Run& run : runs) {
        Means frustum = means_of(run.result, "tree-f");
        auto add = [&](const std::string& method, bool reference) {
            Means means = means_of(run.result, method);
            table.rows.push_back({StudyOrigin::ours,
                                  {file_name(scene), letters_of(method) + std::string(run.variant),
                                   reference ? StudyCell() : StudyCell(double(run.occluders)), means.polygons,
                                   100 * means.polygons / std::max(1.0, frustum.polygons),
                                   reference ? StudyCell() : StudyCell(means.cull - frustum.cull),
                                   means.frame < 0 ? StudyCell() : StudyCell(means.frame),
                                   means.frame <= 0 ? StudyCell() : StudyCell(frustum.frame / means.frame), double(means.lost)}});
        };
        if (!frustum_shown)
            add("tree-f", true);
        frustum_shown = true;
        for (const std::string& method : run.methods)
            add(method, false);
    }
    return table;
}

/// What no culling of objects can beat, and what a frame costs that draws nothing.
StudyTable bounds_table(const std::vector<Run>& runs) {
    StudyTable table;
    table.title = "Bounds of the speed-up on this renderer";
    const Run& run = *std::find_if(runs.begin(), runs.end(), [](const Run& r) { return r.occluders == kFigureOccluders; });
    const WalkResult& result = run.result;
    table.note = result.renderer.empty() ? "Nothing was drawn: there is no OpenGL, or drawing was switched off."
                                         : "Drawn at " + std::to_string(result.width) + "x" + std::to_string(result.height) +
                                               " by " + result.renderer + ". Perfect culling draws the objects that a ray sees and "
                                               "culls in no time.";
    table.columns = {{"frame", "", 0}, {"triangles", "", 0}, {"median", "ms", 3}, {"speed-up over F", "", 2}};
    Means frustum = means_of(result, "tree-f");
    auto time = [](double ms) { return ms < 0 ? StudyCell() : StudyCell(ms); };
    auto ratio = [&](double ms) { return ms > 0 && frustum.frame > 0 ? StudyCell(frustum.frame / ms) : StudyCell(); };
    table.rows.push_back({StudyOrigin::ours, {"view frustum (F)", frustum.polygons, time(frustum.frame), ratio(frustum.frame)}});
    table.rows.push_back({StudyOrigin::ours,
                          {"perfect culling", result.triangles_true, time(result.ceiling_ms_median), ratio(result.ceiling_ms_median)}});
    table.rows.push_back({StudyOrigin::ours, {"empty", 0.0, time(result.empty_ms_median), ratio(result.empty_ms_median)}});
    return table;
}

/// Figures 9 and 10: curve A is the frustum alone, curve B FME with 32 occluders.
StudyPlot along_walk(const WalkResult& result, bool polygons) {
    StudyPlot plot{polygons ? "Polygons rendered along the walk (figure 10)" : "Frame time along the walk (figure 9)", "frame",
                   polygons ? "polygons" : "ms", false, false, {}};
    for (const char* name : {"tree-f", "tree-fme"})
        for (std::size_t m = 0; m < result.methods.size(); ++m) {
            if (result.methods[m].name != name)
                continue;
            StudySeries series{std::string(name) == "tree-f" ? "A: F" : "B: FME, 32 occluders", StudyOrigin::ours, {}, {}};
            for (std::size_t f = 0; f < result.frames.size(); ++f) {
                const WalkSample& sample = result.frames[f].methods[m];
                double frame = sample.frame_ms();
                series.x.push_back(double(f));
                series.y.push_back(polygons ? double(sample.triangles_drawn) : frame < 0 ? std::nan("") : frame);
            }
            plot.series.push_back(std::move(series));
        }
    return plot;
}

/// Overhead against k: less than linear in the paper.
StudyPlot overhead_plot(const std::vector<Run>& runs) {
    StudyPlot plot{"Overhead against the number of occluders", "occluders", "overhead over that at 16", true, true, {}};
    auto add = [&](const char* label, StudyOrigin origin, auto&& value) {
        StudySeries series{label, origin, {}, {}};
        double first = value(16u);
        for (std::uint32_t k : {8u, 16u, 24u, 32u, 50u, 128u, 256u})
            if (double overhead = value(k); overhead > 0 && first > 0) {
                series.x.push_back(k);
                series.y.push_back(overhead / first);
            }
        if (!series.x.empty())
            plot.series.push_back(std::move(series));
    };
    for (const char* method : {"FME", "FSE"}) {
        add(method, StudyOrigin::published, [&](std::uint32_t k) {
            for (const Published& row : kTable2)
                if (std::string_view(row.scene) == "soda-5" && std::string_view(row.method) == method && row.occluders == int(k))
                    return row.overhead;
            return -1.0;
        });
        std::string name = std::string_view(method) == "FME" ? "tree-fme" : "tree-fse";
        add(method, StudyOrigin::ours, [&](std::uint32_t k) {
            for (const Run& run : runs)
                if (run.occluders == k && std::find(run.methods.begin(), run.methods.end(), name) != run.methods.end())
                    return means_of(run.result, name).cull - means_of(run.result, "tree-f").cull;
            return -1.0;
        });
    }
    return plot;
}

} // namespace

Result<Study> study_bittner(const Scene& scene, const StudyOptions& options, const Job& job) {
    if (options.path.size() < 2)
        return Status(ErrorCode::usage, "the study bittner needs a camera path of at least two frames");
    Result<std::vector<Run>> runs = walk_all(scene, options, job);
    if (!runs)
        return runs.status();
    const WalkResult& figure =
        std::find_if(runs->begin(), runs->end(), [](const Run& run) { return run.occluders == kFigureOccluders; })->result;
    Study study;
    study.name = "bittner";
    study.title = "Occlusion trees: what they save, against the number of occluders";
    study.source = "Bittner, Havran, Slavik: Hierarchical visibility culling with occlusion trees, CGI 1998";
    study.text = "The three methods of the paper on this scene, along " + std::to_string(figure.frames.size()) +
                 " frames: kd-tree, occluders by area-angle from the last frame's visible leaves, an occlusion tree per frame, "
                 "node cost 50, marks of nodes that stay visible in part. Beside them, with 32 occluders, this project's planes "
                 "and tree.\n\nThe paper's models are floors of Soda Hall and an architectural model, each with 100 plants of 644 "
                 "polygons spread at random, on an SGI O2. Its E test is unsafe as printed and is replaced by the safe one; "
                 "numbers of polygons compare by ratio, times do not.";
    study.tables = {table2(scene, *runs), bounds_table(*runs)};
    study.plots = {along_walk(figure, false), along_walk(figure, true), overhead_plot(*runs)};
    if (!options.draw || figure.renderer.empty()) {
        study.plots.erase(study.plots.begin());
        study.notes.push_back("Figure 9 is left out: nothing was drawn.");
    }
    for (const std::string& note : figure.notes)
        study.notes.push_back(note);
    return study;
}

} // namespace antumbra
