// Figures 6 and 7 of Poon and Wang 1999: criteria of occluder choice in one view.
#include "evaluate/studies/poon_wang.hpp"

#include "cull/view_planes.hpp"
#include "evaluate/report/image_coding.hpp"

#include <algorithm>
#include <cmath>

namespace antumbra::poon_wang {
namespace {

constexpr std::uint32_t kLimits[] = {16, 32, 64, 96, 128, 192, 256, 384, 512, 768};
constexpr std::uint32_t kTopViewLimit = 192;

struct AtLimit {
    std::uint32_t limit = 0;
    std::size_t used = 0; ///< a criterion may have fewer to offer
    double culled = 0, rate = 0;
    std::vector<std::uint32_t> list;
    Measured measured;
};

/// The frame of the routes in which about 400 occluder polygons are seen, as in the paper's view.
View rich_view(const Setting& at, const std::vector<Route>& routes) {
    View best;
    double closest = 1e300;
    for (const Route& route : routes)
        for (View view : route.views) {
            view.aspect = 1;
            MosOptions options = at.mos(OccluderCriterion::first_hit, 1u << 20);
            Screen screen = make_screen(camera_of(view), at.side, at.side, at.extent());
            double seen = double(choose_list(at.occluders, {}, screen, options).size());
            if (std::abs(seen - 400) < closest) {
                closest = std::abs(seen - 400);
                best = view;
            }
        }
    return best;
}

void add_figure_6(Setting& at, const std::vector<std::vector<AtLimit>>& all, double most) {
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
    at.study.tables.push_back(std::move(table));
    at.study.plots.push_back(std::move(culled));
    if (at.drawing)
        at.study.plots.push_back(std::move(rates));
}

/// Occluders that a criterion needs for a share; between two limits the line is straight. Negative: never reached.
double needed(const std::vector<AtLimit>& limits, double share) {
    for (std::size_t i = 0; i < limits.size(); ++i)
        if (limits[i].culled >= share) {
            if (i == 0)
                return double(limits[0].used);
            double t = (share - limits[i - 1].culled) / (limits[i].culled - limits[i - 1].culled);
            return double(limits[i - 1].used) + t * (double(limits[i].used) - double(limits[i - 1].used));
        }
    return -1;
}

void add_goal_of_sets(Setting& at, const std::vector<std::vector<AtLimit>>& all) {
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
    at.study.tables.push_back(std::move(table));
}

void add_figure_7(Setting& at, const std::vector<std::vector<AtLimit>>& all, const View& view, const Measured& frustum) {
    for (std::size_t c = 0; c < all.size(); ++c)
        for (const AtLimit& one : all[c])
            if (one.limit == kTopViewLimit)
                at.study.pictures.push_back(
                    {std::string("Figure 7, ") + kCriteria[c].name + ", " + std::to_string(one.used) +
                         " occluders (red): light grey outside the frustum, dark grey culled, black drawn; the viewer is blue",
                     encode_png(top_view(at.scene, at.occluders, view, frustum.visible[0], one.measured.visible[0],
                                         one.list)),
                     {}});
}

} // namespace

Status add_criteria(Setting& at, const std::vector<Route>& routes) {
    View view = rich_view(at, routes);
    std::vector<View> views{view};
    auto frustum = measure(at.bench(), views, std::vector<Contender>{{"frustum", "frustum", {}}});
    if (!frustum)
        return frustum.status();
    Measured truth = truth_of(at.bench(), at.tracer, views, std::min(at.side, kTruthSide), at.job);
    std::vector<std::vector<AtLimit>> all;
    std::size_t step = 0;
    for (const Criterion& criterion : kCriteria) {
        all.emplace_back();
        for (std::uint32_t limit : kLimits) {
            at.report("figure 6", ++step, std::size(kCriteria) * std::size(kLimits));
            if (Status status = at.stopped(); !status)
                return status;
            AtLimit one{limit, 0, 0, 0, {}, {}};
            MosOptions options = at.mos(criterion.criterion, limit);
            Screen screen = make_screen(camera_of(view), options.resolution, options.resolution, at.extent());
            one.list = choose_list(at.occluders, find_occludees(at.scene, options), screen, options);
            one.used = one.list.size();
            OccluderDatabase database = one_list(one.list);
            auto measured = measure(at.bench(), views,
                                    std::vector<Contender>{{criterion.letters, "opacity-published",
                                                            at.whole(&database, limit)}});
            if (!measured)
                return measured.status();
            one.measured = std::move((*measured)[0]);
            one.culled = culled_percent(one.measured, (*frustum)[0]);
            one.rate = one.measured.draw_ms[0] < 0 ? -1 : 1000 / one.measured.frame_ms[0];
            at.lost += lost_objects(one.measured, truth);
            all.back().push_back(std::move(one));
        }
    }
    double most = culled_percent(truth, (*frustum)[0]);
    add_figure_6(at, all, most);
    add_goal_of_sets(at, all);
    auto along_routes = occluders_for_shares(at.bench(), at.occluders, routes, at.job);
    if (!along_routes)
        return along_routes.status();
    at.study.tables.push_back(std::move(*along_routes));
    add_figure_7(at, all, view, (*frustum)[0]);
    return {};
}

} // namespace antumbra::poon_wang
