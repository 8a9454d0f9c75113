// How many occluders each criterion needs for the same culled share, along routes: what figure 6 of Poon and Wang says of one
// view.
#include "evaluate/studies/poon_wang.hpp"

#include "cull/view_planes.hpp"

#include <algorithm>

namespace antumbra::poon_wang {
namespace {

constexpr std::size_t kFrames = 8; ///< of a route, evenly spread
constexpr double kPublishedShare = 94;
constexpr OccluderCriterion kCompared[] = {OccluderCriterion::minimum_sets, OccluderCriterion::first_hit,
                                           OccluderCriterion::projected_size};

struct Point {
    double occluders = 0, culled = 0; ///< means over the frames
};
using Curve = std::vector<Point>;

/// On straight lines between the points, the first of which is (0, 0); negative: never reached.
double needed(const Curve& curve, double share) {
    Point before;
    for (const Point& point : curve) {
        if (point.culled >= share) {
            double part = point.culled > before.culled ? (share - before.culled) / (point.culled - before.culled) : 1;
            return before.occluders + part * (point.occluders - before.occluders);
        }
        before = point;
    }
    return -1;
}

std::vector<View> some_of(const Route& route) {
    std::vector<View> views;
    for (std::size_t f = 0; f < std::min(kFrames, route.views.size()); ++f)
        views.push_back(route.views[f * route.views.size() / std::min(kFrames, route.views.size())]);
    return views;
}

/// One number of occluders: chosen at each frame's own eye, drawn as published.
Result<Point> measure_limit(const Bench& bench, const OccluderSet& occluders, std::span<const View> views,
                            const MosOptions& mos, OpacityCoverage coverage, double frustum) {
    Point point;
    double drawn = 0, extent = length(to_double(bench.scene.local_bounds()).size());
    const std::vector<Occludee> occludees = find_occludees(bench.scene, mos);
    for (const View& view : views) {
        Screen screen = make_screen(camera_of(view), mos.resolution, mos.resolution, extent);
        std::vector<std::uint32_t> list = choose_list(occluders, occludees, screen, mos);
        OccluderDatabase database = one_list(list);
        CullerOptions options;
        options.opacity.database = &database;
        options.opacity.occluders = mos.limit;
        options.opacity.coverage = coverage;
        options.opacity.adaptive = false;
        options.opacity.stop_below = 0;
        Bench once{bench.scene, bench.cull_scene, nullptr, bench.aspect, 1};
        auto measured = measure(once, std::span(&view, 1), std::vector<Contender>{{"", "opacity-published", options}});
        if (!measured)
            return measured.status();
        drawn += (*measured)[0].mean_triangles();
        point.occluders += double(list.size());
    }
    point.occluders /= double(views.size());
    point.culled = 100 * (1 - drawn / double(views.size()) / std::max(1.0, frustum));
    return point;
}

void add_rows(const Route& route, OpacityCoverage coverage, const std::vector<Curve>& curves, StudyTable& table) {
    const Curve &sets = curves[0], &first_hit = curves[1];
    std::vector<double> shares{kPublishedShare, first_hit.back().culled};
    for (const Point& point : sets)
        shares.push_back(point.culled);
    std::sort(shares.begin(), shares.end());
    auto cell = [](double value) { return value < 0 ? StudyCell("never") : StudyCell(value); };
    double last = 0;
    for (double share : shares) {
        double by_sets = needed(sets, share), by_first_hit = needed(first_hit, share);
        if ((by_sets < 0 && by_first_hit < 0) || share - last < 0.05)
            continue;
        last = share;
        table.rows.push_back({StudyOrigin::ours,
                              {route.name, coverage == OpacityCoverage::inner ? "inner" : "centre", share, cell(by_sets),
                               cell(by_first_hit), cell(needed(curves[2], share)),
                               by_sets > 0 && by_first_hit > 0 ? StudyCell(by_first_hit / by_sets) : StudyCell()}});
    }
}

} // namespace

Result<StudyTable> occluders_for_shares(const Bench& bench, const OccluderSet& occluders,
                                        std::span<const Route> routes, const Job& job) {
    StudyTable table;
    table.title = "Occluders needed for the same culled share, along routes";
    table.note = "Means over " + std::to_string(kFrames) + " frames of a route, occluders chosen at each frame's own eye, 128 x 128, "
                 "straight lines between 4, 8, 16 .. 512 occluders. Shares: what minimum sets reach, the most that first hit "
                 "reaches, and the published 94 %. Centre is the paper's coverage (approximate), inner is ours.";
    table.columns = {{"route", "", 0}, {"coverage", "", 0}, {"culled", "%", 2}, {"MOS", "", 1}, {"first hit", "", 1},
                     {"projected size", "", 1}, {"first hit / MOS", "", 2}};
    table.rows.push_back({StudyOrigin::published, {"one view", "centre", 94.0, 192.0, 384.0, {}, 2.0}});
    for (const Route& route : routes.first(2)) { // the worst has nothing to cull
        const std::vector<View> views = some_of(route);
        auto frustum = measure({bench.scene, bench.cull_scene, nullptr, bench.aspect, 1}, views,
                               std::vector<Contender>{{"", "frustum", {}}});
        if (!frustum)
            return frustum.status();
        for (OpacityCoverage coverage : {OpacityCoverage::inner, OpacityCoverage::centre}) {
            std::vector<Curve> curves;
            for (OccluderCriterion criterion : kCompared) {
                curves.emplace_back();
                for (std::uint32_t limit = 4; limit <= 512; limit *= 2) {
                    if (job.cancelled())
                        return Status(ErrorCode::cancelled, "stopped in the study poon-wang");
                    MosOptions mos;
                    mos.criterion = criterion;
                    mos.limit = limit;
                    auto point = measure_limit(bench, occluders, views, mos, coverage, (*frustum)[0].mean_triangles());
                    if (!point)
                        return point.status();
                    curves.back().push_back(*point);
                }
            }
            add_rows(route, coverage, curves, table);
        }
    }
    return table;
}

} // namespace antumbra::poon_wang
