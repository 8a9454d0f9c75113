// What all figures of the study poon-wang stand on: the scene, its occluders, a picture to draw into.
#include "evaluate/studies/poon_wang.hpp"

#include <algorithm>
#include <chrono>
#include <cstdio>

namespace antumbra::poon_wang {
namespace {

double seconds_now() {
    return std::chrono::duration<double>(std::chrono::steady_clock::now().time_since_epoch()).count();
}

std::string milliseconds(double seconds) {
    char text[32];
    std::snprintf(text, sizeof text, "%.3f", seconds * 1e3);
    return text;
}

} // namespace

Setting::Setting(const Scene& s, const StudyOptions& o, const Job& j)
    : scene(s), options(o), job(j), side(o.height < 360 ? o.height : 512), tracer(Tracer::build(s, j)),
      occluders(find_occluders(s)), cull_scene(cull_scene_of(s, occluders)) {
    study.name = "poon-wang";
    study.title = "Minimum occluder sets and opacity maps: which occluders, on which routes, what they save";
    study.source = "Poon, Wang: Occlusion culling using minimum occluder set and opacity map, IV 1999";
    study.text =
        "Three criteria choose occluders: projected size (PS), first hit (FH: most visible pixels) and minimum occluder "
        "sets (MOS). They are drawn into a map of 128 x 128 pixels, against which the hierarchy of boxes is tested. "
        "Unlike in the paper a pixel counts only if it is wholly covered, so that nothing visible is culled.\n\n"
        "The paper's model is thirty copies of a city of 10,018 polygons on an SGI Maximum Impact (1998); `antumbra "
        "generate downtown` is made after its description. Compare shares and ratios, not frame rates.";
    if (options.draw)
        open_drawing(side);
    view_seconds = measure_object_seconds();
}

void Setting::open_drawing(std::uint32_t pixels) {
    drawing.reset();
    auto made = Drawing::create(scene, pixels, pixels);
    if (made)
        drawing = std::move(*made);
    else
        study.notes.push_back("Nothing was drawn: " + made.status().message());
}

/// What it costs here to draw an object, which the adaptive stop weighs.
double Setting::measure_object_seconds() {
    if (!drawing)
        return CullerOptions{}.opacity.object_seconds;
    View view;
    Box3d box = to_double(scene.local_bounds());
    view.target = (box.min + box.max) * 0.5;
    view.eye = view.target + Vec3d{0.3, 0.5, 1} * length(box.size());
    view.aspect = 1;
    std::vector<std::uint64_t> all(cull_scene.words(), ~std::uint64_t(0)), none(cull_scene.words(), 0);
    if (scene.objects().size() % 64)
        all.back() = (std::uint64_t(1) << (scene.objects().size() % 64)) - 1;
    double whole = 1e300, empty = 1e300;
    for (int pass = 0; pass < 3; ++pass) {
        whole = std::min(whole, drawing->draw(view, all));
        empty = std::min(empty, drawing->draw(view, none));
    }
    study.notes.push_back("An empty frame takes " + milliseconds(empty) + " ms, all objects from afar " + milliseconds(whole) +
                           " ms; what fills the picture at eye height is in the row `truly visible`.");
    return std::max(whole - empty, 0.0) / double(std::max<std::size_t>(1, scene.objects().size()));
}

Bench Setting::bench() const { return {scene, cull_scene, drawing.get(), 1, options.repeat}; }

MosOptions Setting::mos(OccluderCriterion criterion, std::uint32_t limit) const {
    MosOptions chosen;
    chosen.criterion = criterion;
    chosen.limit = limit;
    return chosen;
}

CullerOptions Setting::with(const OccluderDatabase* database, std::uint32_t count, OpacityForm form) const {
    CullerOptions chosen;
    chosen.opacity.database = database;
    chosen.opacity.occluders = count;
    chosen.opacity.form = form;
    chosen.opacity.choice = OpacityChoice::by_gain; // for the modern form; the scene is a city
    chosen.opacity.clock = seconds_now;
    chosen.opacity.object_seconds = view_seconds;
    return chosen;
}
CullerOptions Setting::whole(const OccluderDatabase* database, std::uint32_t count) const {
    CullerOptions chosen = with(database, count, OpacityForm::published);
    chosen.opacity.adaptive = false;
    chosen.opacity.stop_below = 0;
    return chosen;
}

Status Setting::stopped() const {
    return job.cancelled() ? Status(ErrorCode::cancelled, "stopped in the study poon-wang") : Status();
}

void Setting::report(const char* stage, std::uint64_t done, std::uint64_t total) const {
    if (job.progress)
        job.progress({stage, done, total, "steps"});
}

double Setting::extent() const {
    Box3d box = to_double(scene.local_bounds());
    return length(box.size());
}

} // namespace antumbra::poon_wang
