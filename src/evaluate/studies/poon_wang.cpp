// Figures 6 to 10 of Poon and Wang 1999: criteria of occluder choice, routes of high, medium and low depth complexity,
// and resolutions, with their method as published and in its modern form.
#include "evaluate/studies/poon_wang.hpp"

#include "cull/view_planes.hpp"
#include "evaluate/report/image_coding.hpp"
#include "evaluate/studies/studies.hpp"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdio>

namespace antumbra {
namespace {

using namespace poon_wang;

constexpr std::size_t kFrames = 30;          ///< of a route; the paper walks 120
constexpr std::uint32_t kPublished = 64;     ///< occluders on routes
constexpr std::uint32_t kPoints = 64;        ///< grid points along a route
constexpr std::uint32_t kLimits[] = {16, 32, 64, 96, 128, 192, 256, 384, 512, 768};
constexpr std::uint32_t kTopViewLimit = 192;
constexpr std::uint32_t kTruthSide = 512;

struct Criterion {
    OccluderCriterion criterion;
    const char *name, *letters;
};
constexpr Criterion kCriteria[] = {{OccluderCriterion::projected_size, "projected size", "PS"},
                                   {OccluderCriterion::minimum_sets, "minimum sets", "MOS"},
                                   {OccluderCriterion::first_hit, "first hit", "FH"}};

double seconds_now() {
    return std::chrono::duration<double>(std::chrono::steady_clock::now().time_since_epoch()).count();
}

std::string milliseconds(double seconds) {
    char text[32];
    std::snprintf(text, sizeof text, "%.3f", seconds * 1e3);
    return text;
}

StudyCell rate_of(const Measured& method) {
    double ms = method.mean_frame_ms();
    return method.draw_ms.empty() || method.draw_ms[0] < 0 || ms <= 0 ? StudyCell() : StudyCell(1000 / ms);
}

/// Shares of the triangles in the frustum.
double culled_percent(const Measured& method, const Measured& frustum) {
    return 100 * (1 - method.mean_triangles() / std::max(1.0, frustum.mean_triangles()));
}

class PoonWang {
  public:
    PoonWang(const Scene& scene, const StudyOptions& options, const Job& job)
        : scene_(scene), options_(options), job_(job), side_(options.height < 360 ? options.height : 512),
          tracer_(Tracer::build(scene, job)), occluders_(find_occluders(scene)),
          cull_scene_(cull_scene_of(scene, occluders_)) {}

    Result<Study> run() {
        begin();
        std::vector<Route> routes = make_routes(scene_, tracer_, side_ < 512 ? kFrames / 5 : kFrames);
        for (auto step : {&PoonWang::criteria, &PoonWang::walk_routes, &PoonWang::criteria_on_route,
                          &PoonWang::resolutions})
            if (Status status = (this->*step)(routes); !status)
                return status;
        return std::move(study_);
    }

  private:
    void begin() {
        study_.name = "poon-wang";
        study_.title = "Minimum occluder sets and opacity maps: which occluders, on which routes, what they save";
        study_.source = "Poon, Wang: Occlusion culling using minimum occluder set and opacity map, IV 1999";
        study_.text =
            "Three criteria choose occluders: projected size (PS), first hit (FH: most visible pixels) and minimum occluder "
            "sets (MOS). They are drawn into a map of 128 x 128 pixels, against which the hierarchy of boxes is tested. "
            "Unlike in the paper a pixel counts only if it is wholly covered, so that nothing visible is culled.\n\n"
            "The paper's model is thirty copies of a city of 10,018 polygons on an SGI Maximum Impact (1998); `antumbra "
            "generate downtown` is made after its description. Compare shares and ratios, not frame rates.";
        if (options_.draw)
            open_drawing(side_);
        view_seconds_ = measure_object_seconds();
    }

    void open_drawing(std::uint32_t side) {
        drawing_.reset();
        auto made = Drawing::create(scene_, side, side);
        if (made)
            drawing_ = std::move(*made);
        else
            study_.notes.push_back("Nothing was drawn: " + made.status().message());
    }

    /// What it costs here to draw an object, which the adaptive stop weighs.
    double measure_object_seconds() {
        if (!drawing_)
            return CullerOptions{}.opacity.object_seconds;
        View view;
        Box3d box = to_double(scene_.local_bounds());
        view.target = (box.min + box.max) * 0.5;
        view.eye = view.target + Vec3d{0.3, 0.5, 1} * length(box.size());
        view.aspect = 1;
        std::vector<std::uint64_t> all(cull_scene_.words(), ~std::uint64_t(0)), none(cull_scene_.words(), 0);
        if (scene_.objects().size() % 64)
            all.back() = (std::uint64_t(1) << (scene_.objects().size() % 64)) - 1;
        double whole = 1e300, empty = 1e300;
        for (int pass = 0; pass < 3; ++pass) {
            whole = std::min(whole, drawing_->draw(view, all));
            empty = std::min(empty, drawing_->draw(view, none));
        }
        study_.notes.push_back("An empty frame takes " + milliseconds(empty) + " ms, all objects from afar " + milliseconds(whole) +
                               " ms; what fills the picture at eye height is in the row `truly visible`.");
        return std::max(whole - empty, 0.0) / double(std::max<std::size_t>(1, scene_.objects().size()));
    }

    Bench bench() const { return {scene_, cull_scene_, drawing_.get(), 1, options_.repeat}; }

    MosOptions mos(OccluderCriterion criterion, std::uint32_t limit) const {
        MosOptions options;
        options.criterion = criterion;
        options.limit = limit;
        return options;
    }

    CullerOptions with(const OccluderDatabase* database, std::uint32_t occluders, OpacityForm form) const {
        CullerOptions options;
        options.opacity.database = database;
        options.opacity.occluders = occluders;
        options.opacity.form = form;
        options.opacity.choice = OpacityChoice::by_gain; // for the modern form; the scene is a city
        options.opacity.clock = seconds_now;
        options.opacity.object_seconds = view_seconds_;
        return options;
    }
    /// The same without giving up early, so that shares depend on the occluders alone.
    CullerOptions whole(const OccluderDatabase* database, std::uint32_t occluders) const {
        CullerOptions options = with(database, occluders, OpacityForm::published);
        options.opacity.adaptive = false;
        options.opacity.stop_below = 0;
        return options;
    }

    Status stopped() const {
        return job_.cancelled() ? Status(ErrorCode::cancelled, "stopped in the study poon-wang") : Status();
    }
    void report(const char* stage, std::uint64_t done, std::uint64_t total) const {
        if (job_.progress)
            job_.progress({stage, done, total, "steps"});
    }

    // -- figures 6 and 7 ----------------------------------------------------------------------------------------------

    struct AtLimit {
        std::uint32_t limit = 0;
        std::size_t used = 0; ///< a criterion may have fewer to offer
        double culled = 0, rate = 0;
        std::vector<std::uint32_t> list;
        Measured measured;
    };

    Status criteria(const std::vector<Route>& routes) {
        View view = rich_view(routes);
        std::vector<View> views{view};
        auto frustum = measure(bench(), views, std::vector<Contender>{{"frustum", "frustum", {}}});
        if (!frustum)
            return frustum.status();
        Measured truth = truth_of(bench(), tracer_, views, std::min(side_, kTruthSide), job_);
        std::vector<std::vector<AtLimit>> all;
        std::size_t step = 0;
        for (const Criterion& criterion : kCriteria) {
            all.emplace_back();
            for (std::uint32_t limit : kLimits) {
                report("figure 6", ++step, std::size(kCriteria) * std::size(kLimits));
                if (Status status = stopped(); !status)
                    return status;
                AtLimit one{limit, 0, 0, 0, {}, {}};
                MosOptions options = mos(criterion.criterion, limit);
                Screen screen = make_screen(camera_of(view), options.resolution, options.resolution, extent());
                one.list = choose_list(occluders_, find_occludees(scene_, options), screen, options);
                one.used = one.list.size();
                OccluderDatabase database = one_list(one.list);
                auto measured = measure(bench(), views,
                                        std::vector<Contender>{{criterion.letters, "opacity-published",
                                                                whole(&database, limit)}});
                if (!measured)
                    return measured.status();
                one.measured = std::move((*measured)[0]);
                one.culled = culled_percent(one.measured, (*frustum)[0]);
                one.rate = one.measured.draw_ms[0] < 0 ? -1 : 1000 / one.measured.frame_ms[0];
                lost_ += lost_objects(one.measured, truth);
                all.back().push_back(std::move(one));
            }
        }
        double most = culled_percent(truth, (*frustum)[0]);
        add_figure_6(all, most);
        add_goal_of_sets(all);
        auto along_routes = occluders_for_shares(bench(), occluders_, routes, job_);
        if (!along_routes)
            return along_routes.status();
        study_.tables.push_back(std::move(*along_routes));
        add_figure_7(all, view, (*frustum)[0]);
        return {};
    }

    /// The frame of the routes in which about 400 occluder polygons are seen, as in the paper's view.
    View rich_view(const std::vector<Route>& routes) const {
        View best;
        double closest = 1e300;
        for (const Route& route : routes)
            for (View view : route.views) {
                view.aspect = 1;
                MosOptions options = mos(OccluderCriterion::first_hit, 1u << 20);
                Screen screen = make_screen(camera_of(view), side_, side_, extent());
                double seen = double(choose_list(occluders_, {}, screen, options).size());
                if (std::abs(seen - 400) < closest) {
                    closest = std::abs(seen - 400);
                    best = view;
                }
            }
        return best;
    }

    void add_figure_6(const std::vector<std::vector<AtLimit>>& all, double most) {
        StudyTable table;
        table.title = "Criteria of occluder choice (figure 6)";
        table.note = "One view in which about 400 occluder polygons are seen. Culled: share of the triangles in the frustum; drawing only what is truly "
                     "visible would cull " + std::to_string(most).substr(0, 5) + " %. Used: a criterion may have fewer "
                     "occluders to offer than it may take.";
        table.columns = {{"criterion", "", 0}, {"occluders", "", 0}, {"used", "", 0}, {"culled", "%", 2}, {"frames", "1/s", 1}};
        table.rows = {{StudyOrigin::published, {"MOS", 192.0, {}, 94.0, {}}},
                      {StudyOrigin::published, {"first hit", 384.0, {}, 94.0, {}}},
                      {StudyOrigin::published, {"projected size", 512.0, {}, 93.0, {}}}};
        StudyPlot culled{"Culled share against occluders (figure 6)", "occluders", "% of the triangles in the frustum", true, false, {}};
        StudyPlot rates{"Frame rate against occluders (figure 6)", "occluders", "frames per second", true, false, {}};
        for (std::size_t c = 0; c < all.size(); ++c) {
            StudySeries share{kCriteria[c].letters, StudyOrigin::ours, {}, {}}, rate = share;
            for (const AtLimit& one : all[c]) {
                table.rows.push_back({StudyOrigin::ours, {kCriteria[c].name, double(one.limit), double(one.used), one.culled,
                                                          one.rate < 0 ? StudyCell() : StudyCell(one.rate)}});
                share.x.push_back(one.limit), share.y.push_back(one.culled);
                rate.x.push_back(one.limit), rate.y.push_back(one.rate);
            }
            culled.series.push_back(std::move(share));
            rates.series.push_back(std::move(rate));
        }
        study_.tables.push_back(std::move(table));
        study_.plots.push_back(std::move(culled));
        if (drawing_)
            study_.plots.push_back(std::move(rates));
    }

    /// Occluders that a criterion needs for a share; between two limits the line is straight. Negative: never reached.
    static double needed(const std::vector<AtLimit>& limits, double share) {
        for (std::size_t i = 0; i < limits.size(); ++i)
            if (limits[i].culled >= share) {
                if (i == 0)
                    return double(limits[0].used);
                double t = (share - limits[i - 1].culled) / (limits[i].culled - limits[i - 1].culled);
                return double(limits[i - 1].used) + t * (double(limits[i].used) - double(limits[i - 1].used));
            }
        return -1;
    }

    void add_goal_of_sets(const std::vector<std::vector<AtLimit>>& all) {
        StudyTable table;
        table.title = "Occluders needed for the same culled share";
        table.note = "Shares that minimum sets reach with 16 to 768 occluders, and how many each criterion needs for them "
                     "(straight lines between the measured numbers).";
        table.columns = {{"culled", "%", 2}, {"MOS", "", 0}, {"first hit", "", 0}, {"projected size", "", 0},
                         {"first hit / MOS", "", 2}};
        table.rows.push_back({StudyOrigin::published, {94.0, 192.0, 384.0, {}, 2.0}});
        auto cell = [](double value) { return value < 0 ? StudyCell("not reached") : StudyCell(value); };
        double last = -1;
        for (const AtLimit& sets : all[1]) {
            if (sets.culled == last) // nothing more to offer
                continue;
            last = sets.culled;
            double hit = needed(all[2], sets.culled);
            table.rows.push_back({StudyOrigin::ours, {sets.culled, double(sets.used), cell(hit),
                                                      cell(needed(all[0], sets.culled)),
                                                      hit > 0 ? StudyCell(hit / double(sets.used)) : StudyCell()}});
        }
        study_.tables.push_back(std::move(table));
    }

    void add_figure_7(const std::vector<std::vector<AtLimit>>& all, const View& view, const Measured& frustum) {
        for (std::size_t c = 0; c < all.size(); ++c)
            for (const AtLimit& one : all[c])
                if (one.limit == kTopViewLimit)
                    study_.pictures.push_back(
                        {std::string("Figure 7, ") + kCriteria[c].name + ", " + std::to_string(one.used) +
                             " occluders (red): light grey outside the frustum, dark grey culled, black drawn; the viewer is blue",
                         encode_png(top_view(scene_, occluders_, view, frustum.visible[0], one.measured.visible[0],
                                             one.list))});
    }

    // -- figure 8 -----------------------------------------------------------------------------------------------------

    Status walk_routes(const std::vector<Route>& routes) {
        StudyTable table;
        table.title = "Routes of high, medium and low depth complexity (figure 8)";
        table.note = "Means per frame. OM: as published, 64 occluders of the nearest grid point's minimum sets, 128 x 128. PC: "
                     "the same with pixel-wise comparison. Opacity: the modern form, 256 of them; without a database it chooses "
                     "as it walks. Truly visible: drawing what rays see, culled for free. Adaptive stops weigh measured times.";
        table.columns = {{"route", "", 0},       {"method", "", 0},      {"frames", "1/s", 1},        {"speed-up over frustum", "", 2},
                         {"of the possible", "%", 0}, {"cull", "ms", 4}, {"triangles", "", 0}, {"fewer than frustum", "x", 2}, {"objects lost", "", 0}};
        for (const Route& route : routes) {
            table.rows.push_back({StudyOrigin::published, {route.name, "OM", route.published_rate, route.published_speedup, {}, {}, {}, {}, {}}});
            table.rows.push_back({StudyOrigin::published, {route.name, "PC", route.published_pixel_wise_rate, {}, {}, {}, {}, {}, {}}});
        }
        std::size_t step = 0;
        for (const Route& route : routes) {
            report("figure 8", ++step, routes.size());
            if (Status status = stopped(); !status)
                return status;
            MosStatistics statistics;
            auto database = database_along(scene_, occluders_, route.views, kPoints,
                                           mos(OccluderCriterion::minimum_sets, 256), job_, &statistics);
            if (!database)
                return database.status();
            const std::vector<Contender> contenders{
                {"none", "none", {}},
                {"frustum", "frustum", {}},
                {"OM", "opacity-published", with(&*database, kPublished, OpacityForm::published)},
                {"PC", "opacity-published", with(&*database, kPublished, OpacityForm::pixel_wise)},
                {"opacity", "opacity", with(&*database, 256, OpacityForm::modern)},
                {"opacity, no database", "opacity", with(nullptr, 256, OpacityForm::modern)}};
            Measured truth = truth_of(bench(), tracer_, route.views, std::min(side_, kTruthSide), job_);
            auto measured = measure(bench(), route.views, contenders, &truth);
            if (!measured)
                return measured.status();
            add_route(route, *measured, truth, table);
            if (&route == &routes[0]) {
                best_database_ = std::move(*database);
                study_.notes.push_back("Preprocessing the best route: " + std::to_string(statistics.pictures) + " pictures, " +
                                       std::to_string(statistics.occludees) + " occludees in view, " +
                                       std::to_string(statistics.sets) + " minimum sets, " +
                                       std::to_string(statistics.searches_cut) + " searches ended by the bound on work");
            }
        }
        study_.tables.push_back(std::move(table));
        return {};
    }

    void add_route(const Route& route, const std::vector<Measured>& measured, const Measured& truth, StudyTable& table) {
        StudyPlot plot{"Frame rates, " + route.name + " case: " + route.place, "frame", "frames per second", false, false, {}};
        const Measured& frustum = measured[1];
        double possible = frustum.mean_frame_ms() / std::max(1e-9, truth.mean_frame_ms());
        auto add = [&](const Measured& method, bool judged) {
            double speed_up = frustum.mean_frame_ms() / std::max(1e-9, method.mean_frame_ms());
            double cull = 0;
            for (double one : method.cull_ms)
                cull += one / double(method.cull_ms.size());
            bool drawn = drawing_ != nullptr;
            std::uint64_t lost = judged ? lost_objects(method, truth) : 0;
            lost_ += lost;
            table.rows.push_back({StudyOrigin::ours,
                                  {route.name, method.name, rate_of(method), drawn ? StudyCell(speed_up) : StudyCell(),
                                   drawn ? StudyCell(100 * speed_up / possible) : StudyCell(),
                                   judged ? StudyCell(cull) : StudyCell(), method.mean_triangles(),
                                   frustum.mean_triangles() / std::max(1.0, method.mean_triangles()),
                                   judged ? StudyCell(double(lost)) : StudyCell()}});
            StudySeries series{method.name, StudyOrigin::ours, {}, {}};
            for (std::size_t f = 0; f < method.frame_ms.size(); ++f) {
                series.x.push_back(double(f + 1));
                series.y.push_back(method.frame_ms[f] > 0 ? 1000 / method.frame_ms[f] : NAN);
            }
            plot.series.push_back(std::move(series));
        };
        for (const Measured& method : measured)
            add(method, true);
        add(truth, false);
        if (drawing_)
            study_.plots.push_back(std::move(plot));
    }

    // -- figures 9 and 10 ---------------------------------------------------------------------------------------------

    Status criteria_on_route(const std::vector<Route>& routes) {
        report("figure 9", 1, 1);
        std::vector<OccluderDatabase> databases;
        for (const Criterion& criterion : kCriteria) {
            auto database = criterion.criterion == OccluderCriterion::minimum_sets
                                ? Result<OccluderDatabase>(best_database_)
                                : database_along(scene_, occluders_, routes[0].views, kPoints,
                                                 mos(criterion.criterion, kPublished), job_);
            if (!database)
                return database.status();
            databases.push_back(std::move(*database));
        }
        std::vector<Contender> contenders{{"frustum", "frustum", {}}};
        for (std::size_t c = 0; c < databases.size(); ++c)
            contenders.push_back({kCriteria[c].letters, "opacity-published", whole(&databases[c], kPublished)});
        auto measured = measure(bench(), routes[0].views, contenders);
        if (!measured)
            return measured.status();
        StudyTable table;
        table.title = "Criteria along the best route (figure 9)";
        table.note = "64 occluders. Means per frame.";
        table.columns = {{"criterion", "", 0}, {"frames", "1/s", 1}, {"culled", "%", 2}, {"triangles", "", 0}};
        table.rows = {{StudyOrigin::published, {"PS", 5.4, {}, {}}},
                      {StudyOrigin::published, {"MOS", 25.5, {}, {}}},
                      {StudyOrigin::published, {"FH", 24.5, {}, {}}}};
        StudyPlot plot{"Triangles drawn by criterion, best route (figure 9)", "frame", "triangles", false, false, {}};
        for (std::size_t m = 1; m < measured->size(); ++m) {
            const Measured& one = (*measured)[m];
            table.rows.push_back({StudyOrigin::ours, {one.name, rate_of(one), culled_percent(one, (*measured)[0]), one.mean_triangles()}});
            StudySeries series{one.name, StudyOrigin::ours, {}, {}};
            for (std::size_t f = 0; f < one.triangles.size(); ++f) {
                series.x.push_back(double(f + 1));
                series.y.push_back(double(one.triangles[f]));
            }
            plot.series.push_back(std::move(series));
        }
        study_.tables.push_back(std::move(table));
        study_.plots.push_back(std::move(plot));
        return {};
    }

    Status resolutions(const std::vector<Route>& routes) {
        if (lost_ > 0)
            study_.notes.push_back(std::to_string(lost_) + " objects were culled that rays see: this is a bug, please report it");
        if (!drawing_)
            return {};
        StudyTable table;
        table.title = "Resolutions of the picture (figure 10)";
        table.note = "Best route, minimum sets, 64 occluders; the map stays at 128 x 128.";
        table.columns = {{"picture", "", 0}, {"frustum", "1/s", 1}, {"OM", "1/s", 1}, {"speed-up", "", 2}};
        table.rows = {{StudyOrigin::published, {"512 x 512", {}, 25.6, 14.6}},
                      {StudyOrigin::published, {"768 x 768", {}, 20.1, 9.8}},
                      {StudyOrigin::published, {"1024 x 1024", {}, 16.7, 11.6}}};
        std::vector<View> views;
        for (std::size_t f = 0; f < routes[0].views.size(); f += 3)
            views.push_back(routes[0].views[f]);
        const std::vector<Contender> contenders{
            {"frustum", "frustum", {}}, {"OM", "opacity-published", with(&best_database_, kPublished, OpacityForm::published)}};
        std::uint32_t step = 0;
        for (std::uint32_t side : {side_, side_ * 3 / 2, side_ * 2}) {
            report("figure 10", ++step, 3);
            if (Status status = stopped(); !status)
                return status;
            open_drawing(side);
            auto measured = measure(bench(), views, contenders);
            if (!measured)
                return measured.status();
            std::string size = std::to_string(side);
            table.rows.push_back({StudyOrigin::ours, {size + " x " + size, rate_of((*measured)[0]), rate_of((*measured)[1]),
                                                      (*measured)[0].mean_frame_ms() / std::max(1e-9, (*measured)[1].mean_frame_ms())}});
        }
        study_.tables.push_back(std::move(table));
        return {};
    }

    double extent() const {
        Box3d box = to_double(scene_.local_bounds());
        return length(box.size());
    }

    const Scene& scene_;
    const StudyOptions& options_;
    const Job& job_;
    std::uint32_t side_;
    Tracer tracer_;
    OccluderSet occluders_;
    CullScene cull_scene_;
    std::unique_ptr<Drawing> drawing_;
    double view_seconds_ = 0;
    OccluderDatabase best_database_;
    std::uint64_t lost_ = 0;
    Study study_;
};

} // namespace

Result<Study> study_poon_wang(const Scene& scene, const StudyOptions& options, const Job& job) {
    if (scene.objects().empty())
        return Status(ErrorCode::usage, "the study poon-wang needs a scene with objects");
    return PoonWang(scene, options, job).run();
}

} // namespace antumbra
