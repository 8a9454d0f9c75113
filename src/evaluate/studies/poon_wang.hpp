// What the parts of the study poon-wang share.
#pragma once

#include "evaluate/cull_scene.hpp"
#include "evaluate/gl/drawing.hpp"
#include "mos/choose_list.hpp"
#include "rays/tracer.hpp"

#include <antumbra/occluder_finding.hpp>
#include <antumbra/study.hpp>

#include <functional>
#include <memory>
#include <string>
#include <vector>

namespace antumbra::poon_wang {

/// A walk on a straight line, as those of the paper.
struct Route {
    std::string name, place;
    std::vector<View> views; ///< local
    double published_speedup = 0, published_rate = 0, published_pixel_wise_rate = 0;
};

/// Best: from a corner along a free line, looking at the middle. Average: in the middle, looking ahead. Worst: at the
/// opposite corner, looking outward.
std::vector<Route> make_routes(const Scene& scene, const Tracer& tracer, std::size_t frames);

/// One method along a route. Times are the fastest of the repetitions.
struct Measured {
    std::string name;
    std::vector<double> cull_ms, draw_ms, frame_ms;     ///< per frame; draw_ms is negative if nothing was drawn
    std::vector<std::uint64_t> triangles;               ///< drawn
    std::vector<std::vector<std::uint64_t>> visible;    ///< reported
    double mean_triangles() const;
    double mean_frame_ms() const;
};

struct Contender {
    std::string name, culler;
    CullerOptions options;
};

struct Bench {
    const Scene& scene;
    const CullScene& cull_scene;
    Drawing* drawing = nullptr; ///< may be nullptr
    double aspect = 1;
    std::uint32_t repeat = 1;
};

/// All contenders on the same frames, side by side in turning order. `truth` (of the same frames) takes its turn, too, and
/// gets its times: what is drawn among large frames must not be compared with what is drawn alone.
Result<std::vector<Measured>> measure(const Bench& bench, std::span<const View> views,
                                      std::span<const Contender> contenders, Measured* truth = nullptr);

/// What rays see of each frame; no times.
Measured truth_of(const Bench& bench, const Tracer& tracer, std::span<const View> views, std::uint32_t pixels,
                  const Job& job);

/// Objects that `method` does not report although a pixel sees them, over all frames.
std::uint64_t lost_objects(const Measured& method, const Measured& truth);

/// Lists for the eyes of a route: a row of grid points along it.
Result<OccluderDatabase> database_along(const Scene& scene, const OccluderSet& occluders, std::span<const View> views,
                                        std::uint32_t points, const MosOptions& options, const Job& job,
                                        MosStatistics* statistics = nullptr);

/// The same list from everywhere.
OccluderDatabase one_list(std::span<const std::uint32_t> polygons);

/// How many occluders each criterion needs for the same culled share on the best and the average route, with either
/// coverage.
Result<StudyTable> occluders_for_shares(const Bench& bench, const OccluderSet& occluders,
                                        std::span<const Route> routes, const Job& job);

/// The scene from above (figure 7): light grey outside the frustum, dark grey culled, black reported, red occluders.
Image top_view(const Scene& scene, const OccluderSet& occluders, const View& view,
               std::span<const std::uint64_t> in_frustum, std::span<const std::uint64_t> reported,
               std::span<const std::uint32_t> drawn);

/// How the paper picks occluders, and what it calls that.
struct Criterion {
    OccluderCriterion criterion;
    const char *name, *letters;
};
inline constexpr Criterion kCriteria[] = {{OccluderCriterion::projected_size, "projected size", "PS"},
                                          {OccluderCriterion::minimum_sets, "minimum sets", "MOS"},
                                          {OccluderCriterion::first_hit, "first hit", "FH"}};
inline constexpr std::uint32_t kTruthSide = 512;

/// What all figures stand on, and the study that they add to.
struct Setting {
    Setting(const Scene& scene, const StudyOptions& options, const Job& job);

    const Scene& scene;
    const StudyOptions& options;
    const Job& job;
    std::uint32_t side; ///< of the picture, pixels
    Tracer tracer;
    OccluderSet occluders;
    CullScene cull_scene;
    std::unique_ptr<Drawing> drawing; ///< null: nothing can be drawn here
    double view_seconds = 0;          ///< what an object costs to draw
    std::uint64_t lost = 0;
    Study study;

    void open_drawing(std::uint32_t pixels);
    Bench bench() const;
    MosOptions mos(OccluderCriterion criterion, std::uint32_t limit) const;
    CullerOptions with(const OccluderDatabase* database, std::uint32_t count, OpacityForm form) const;
    /// The same without giving up early, so that shares depend on the occluders alone.
    CullerOptions whole(const OccluderDatabase* database, std::uint32_t count) const;
    Status stopped() const;
    void report(const char* stage, std::uint64_t done, std::uint64_t total) const;
    double extent() const;

  private:
    double measure_object_seconds();
};

/// Figures 6 and 7.
Status add_criteria(Setting& at, const std::vector<Route>& routes);

/// Frames per second; nothing if nothing was drawn.
StudyCell rate_of(const Measured& method);

/// Shares of the triangles in the frustum.
double culled_percent(const Measured& method, const Measured& frustum);

std::uint64_t triangles_of(const Scene& scene, std::span<const std::uint64_t> objects);

} // namespace antumbra::poon_wang
