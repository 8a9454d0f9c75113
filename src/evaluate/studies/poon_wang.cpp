// Figures 8 to 10 of Poon and Wang 1999: routes of high, medium and low depth complexity, criteria along the best,
// and resolutions, with their method as published and in its modern form.
#include "evaluate/studies/poon_wang.hpp"

#include "evaluate/studies/studies.hpp"

#include <algorithm>
#include <cmath>

namespace antumbra {
namespace {

using namespace poon_wang;

constexpr std::size_t kFrames = 30;          ///< of a route; the paper walks 120
constexpr std::uint32_t kPublished = 64;     ///< occluders on routes
constexpr std::uint32_t kPoints = 64;        ///< grid points along a route

class PoonWang {
  public:
    PoonWang(const Scene& scene, const StudyOptions& options, const Job& job)
        : at_(scene, options, job) {}

    Result<Study> run() {
        std::vector<Route> routes = make_routes(at_.scene, at_.tracer, at_.side < 512 ? kFrames / 5 : kFrames);
        if (Status status = add_criteria(at_, routes); !status)
            return status;
        for (auto step : {&PoonWang::walk_routes, &PoonWang::criteria_on_route, &PoonWang::resolutions})
            if (Status status = (this->*step)(routes); !status)
                return status;
        return std::move(at_.study);
    }

  private:
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
            at_.report("figure 8", ++step, routes.size());
            if (Status status = at_.stopped(); !status)
                return status;
            MosStatistics statistics;
            auto database = database_along(at_.scene, at_.occluders, route.views, kPoints,
                                           at_.mos(OccluderCriterion::minimum_sets, 256), at_.job, &statistics);
            if (!database)
                return database.status();
            const std::vector<Contender> contenders{
                {"none", "none", {}},
                {"frustum", "frustum", {}},
                {"OM", "opacity-published", at_.with(&*database, kPublished, OpacityForm::published)},
                {"PC", "opacity-published", at_.with(&*database, kPublished, OpacityForm::pixel_wise)},
                {"opacity", "opacity", at_.with(&*database, 256, OpacityForm::modern)},
                {"opacity, no database", "opacity", at_.with(nullptr, 256, OpacityForm::modern)}};
            Measured truth = truth_of(at_.bench(), at_.tracer, route.views, std::min(at_.side, kTruthSide), at_.job);
            auto measured = measure(at_.bench(), route.views, contenders, &truth);
            if (!measured)
                return measured.status();
            add_route(route, *measured, truth, table);
            if (&route == &routes[0]) {
                best_database_ = std::move(*database);
                at_.study.notes.push_back("Preprocessing the best route: " + std::to_string(statistics.pictures) + " pictures, " +
                                       std::to_string(statistics.occludees) + " occludees in view, " +
                                       std::to_string(statistics.sets) + " minimum sets, " +
                                       std::to_string(statistics.searches_cut) + " searches ended by the bound on work");
            }
        }
        at_.study.tables.push_back(std::move(table));
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
            bool drawn = at_.drawing != nullptr;
            std::uint64_t lost = judged ? lost_objects(method, truth) : 0;
            at_.lost += lost;
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
        if (at_.drawing)
            at_.study.plots.push_back(std::move(plot));
    }

    // -- figures 9 and 10 ---------------------------------------------------------------------------------------------

    Status criteria_on_route(const std::vector<Route>& routes) {
        at_.report("figure 9", 1, 1);
        std::vector<OccluderDatabase> databases;
        for (const Criterion& criterion : kCriteria) {
            auto database = criterion.criterion == OccluderCriterion::minimum_sets
                                ? Result<OccluderDatabase>(best_database_)
                                : database_along(at_.scene, at_.occluders, routes[0].views, kPoints,
                                                 at_.mos(criterion.criterion, kPublished), at_.job);
            if (!database)
                return database.status();
            databases.push_back(std::move(*database));
        }
        std::vector<Contender> contenders{{"frustum", "frustum", {}}};
        for (std::size_t c = 0; c < databases.size(); ++c)
            contenders.push_back({kCriteria[c].letters, "opacity-published", at_.whole(&databases[c], kPublished)});
        auto measured = measure(at_.bench(), routes[0].views, contenders);
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
        at_.study.tables.push_back(std::move(table));
        at_.study.plots.push_back(std::move(plot));
        return {};
    }

    Status resolutions(const std::vector<Route>& routes) {
        if (at_.lost > 0)
            at_.study.notes.push_back(std::to_string(at_.lost) + " objects were culled that rays see: this is a bug, please report it");
        if (!at_.drawing)
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
            {"frustum", "frustum", {}}, {"OM", "opacity-published", at_.with(&best_database_, kPublished, OpacityForm::published)}};
        std::uint32_t step = 0;
        for (std::uint32_t side : {at_.side, at_.side * 3 / 2, at_.side * 2}) {
            at_.report("figure 10", ++step, 3);
            if (Status status = at_.stopped(); !status)
                return status;
            at_.open_drawing(side);
            auto measured = measure(at_.bench(), views, contenders);
            if (!measured)
                return measured.status();
            std::string size = std::to_string(side);
            table.rows.push_back({StudyOrigin::ours, {size + " x " + size, rate_of((*measured)[0]), rate_of((*measured)[1]),
                                                      (*measured)[0].mean_frame_ms() / std::max(1e-9, (*measured)[1].mean_frame_ms())}});
        }
        at_.study.tables.push_back(std::move(table));
        return {};
    }

    Setting at_;
    OccluderDatabase best_database_;
};

} // namespace

Result<Study> study_poon_wang(const Scene& scene, const StudyOptions& options, const Job& job) {
    if (scene.objects().empty())
        return Status(ErrorCode::usage, "the study poon-wang needs a scene with objects");
    return PoonWang(scene, options, job).run();
}

} // namespace antumbra
