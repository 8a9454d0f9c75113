// A walk in two parts: truth and judgement of every frame first, then nothing but timing.
#include "bake/viewpoint.hpp"
#include "evaluate/cull_scene.hpp"
#include "evaluate/gl/drawing.hpp"
#include "evaluate/item_buffer.hpp"
#include "evaluate/metrics.hpp"

#include <antumbra/occluder_finding.hpp>

#include <algorithm>
#include <array>
#include <bit>
#include <chrono>
#include <sys/resource.h>

namespace antumbra {
namespace {

using Bits = std::vector<std::uint64_t>;

Status check(const Scene& scene, std::span<const View> path, const WalkOptions& options) {
    if (path.empty())
        return {ErrorCode::usage, "the camera path has no frame"};
    for (std::size_t f = 0; f < path.size(); ++f)
        if (const char* problem = problem_of(path[f]))
            return {ErrorCode::usage, "frame " + std::to_string(f) + " of the camera path: " + problem};
    if (options.width == 0 || options.height == 0 || options.width > 8192 || options.height > 8192)
        return {ErrorCode::usage, "a picture needs 1 to 8192 pixels along each side"};
    if (options.truth_scale < 1 || options.truth_scale > 8 || options.repeat < 1)
        return {ErrorCode::usage, "the truth scale goes from 1 to 8, and a walk is timed at least once"};
    if (options.pvs)
        return check_belongs(scene, *options.pvs);
    return {};
}

struct Method {
    std::unique_ptr<Culler> culler;
    ViewState state;
    CullResult result;
};

Result<std::vector<Method>> make_methods(const CullScene& scene, const WalkOptions& options) {
    std::vector<std::string> names = options.methods;
    if (std::find(names.begin(), names.end(), "frustum") == names.end())
        names.insert(names.begin(), "frustum");
    std::vector<Method> methods;
    for (const std::string& name : names) {
        CullerOptions culler_options;
        culler_options.pvs = options.pvs;
        culler_options.occluder_choice = options.occluder_choice;
        culler_options.tree = options.tree;
        if (options.occluders > 0)
            culler_options.occluders = culler_options.opacity.occluders = options.occluders;
        Result<std::unique_ptr<Culler>> culler = make_culler(name, scene, culler_options);
        if (!culler)
            return culler.status();
        methods.push_back({std::move(*culler), {}, {}});
    }
    return methods;
}

std::uint32_t count(const Bits& bits) {
    std::uint32_t sum = 0;
    for (std::uint64_t word : bits)
        sum += std::uint32_t(std::popcount(word));
    return sum;
}

std::uint32_t count_without(const Bits& bits, const Bits& without) {
    std::uint32_t sum = 0;
    for (std::size_t word = 0; word < bits.size(); ++word)
        sum += std::uint32_t(std::popcount(bits[word] & ~without[word]));
    return sum;
}

std::uint64_t count_triangles(const Scene& scene, const Bits& bits) {
    std::uint64_t sum = 0;
    for (std::uint32_t o = 0; o < scene.objects().size(); ++o)
        if (has_bit(bits, o))
            sum += scene.objects()[o].triangle_count;
    return sum;
}

/// Whatever else runs on the machine only ever adds time.
double fastest(const std::vector<double>& milliseconds) {
    return milliseconds.empty() ? -1 : *std::min_element(milliseconds.begin(), milliseconds.end());
}

double milliseconds_since(std::chrono::steady_clock::time_point start) {
    return std::chrono::duration<double, std::milli>(std::chrono::steady_clock::now() - start).count();
}

/// How often this thread had to give way to other work so far; 0 where the system does not tell.
long interruptions() {
#ifdef RUSAGE_THREAD
    rusage usage{};
    if (::getrusage(RUSAGE_THREAD, &usage) == 0)
        return usage.ru_nivcsw;
#endif
    return 0;
}

/// More than that many interruptions a second are no background noise.
constexpr double kBusy = 10;

class Walk {
  public:
    Walk(const Scene& scene, std::span<const View> path, const WalkOptions& options, const Job& job,
         std::vector<Method> methods)
        : scene_(scene), path_(path), options_(options), job_(job), methods_(std::move(methods)) {
        for (std::size_t m = 0; m < methods_.size(); ++m)
            if (methods_[m].culler->name() == "frustum")
                frustum_ = m;
    }

    Result<WalkResult> run() {
        prepare();
        if (Status status = judge(); !status)
            return status;
        if (Status status = time_all(); !status)
            return status;
        for (std::size_t f = 0; f < path_.size(); ++f)
            take_fastest(f);
        summarise(result_);
        take_notable();
        add_notes();
        return std::move(result_);
    }

  private:
    void prepare() {
        result_.width = options_.width;
        result_.height = options_.height;
        result_.repeat = options_.repeat;
        result_.truth_scale = options_.truth_scale;
        for (const Method& method : methods_) {
            WalkMethod summary;
            summary.name = std::string(method.culler->name());
            summary.guarantee = method.culler->guarantee();
            summary.from_region = summary.name == "pvs";
            result_.methods.push_back(summary);
        }
        std::uint64_t words = (scene_.objects().size() + 63) / 64;
        std::uint64_t bytes = words * 8 * (methods_.size() + 1);
        std::uint64_t affordable = std::max<std::uint64_t>(options_.snapshot_bytes / bytes, 1);
        snapshot_stride_ = (path_.size() + affordable - 1) / affordable;
    }

    View view_of(std::size_t f) const {
        View view = path_[f];
        view.aspect = double(options_.width) / options_.height;
        // The truth knows no near and far planes, and judges by what it knows.
        view.near_plane = 0;
        view.far_plane = std::numeric_limits<double>::infinity();
        return view;
    }

    /// Truth of each frame, and what each method makes of it.
    Status judge() {
        Tracer tracer = Tracer::build(scene_, job_);
        Arbiter arbiter(tracer);
        Job inner = job_;
        inner.progress = nullptr;
        for (std::size_t f = 0; f < path_.size(); ++f) {
            WalkFrame frame;
            frame.view = view_of(f);
            frame.in_matter = !is_viewpoint(tracer, frame.view.eye);
            PixelRays rays = PixelRays::of_view(frame.view, options_.width * options_.truth_scale,
                                                options_.height * options_.truth_scale);
            ItemBuffer buffer = ItemBuffer::render(tracer, rays, {}, inner);
            if (job_.cancelled())
                return {ErrorCode::cancelled, "stopped at frame " + std::to_string(f) + " of the walk"};
            result_.truth_pixels += rays.pixels();
            Bits seen((scene_.objects().size() + 63) / 64, 0);
            mark_seen(scene_, buffer, seen);
            for (Method& method : methods_)
                method.culler->cull(frame.view, method.state, method.result);
            frame.objects_true = count(seen);
            frame.triangles_true = count_triangles(scene_, seen);
            frame.objects_in_frustum = methods_[frustum_].result.visible_count;
            for (Method& method : methods_)
                frame.methods.push_back(judge_method(arbiter, buffer, seen, method));
            result_.frames.push_back(std::move(frame));
            keep_snapshot(f, seen);
            seen_.push_back(std::move(seen));
            if (job_.progress)
                job_.progress({"truth", f + 1, path_.size(), "frames"});
        }
        return {};
    }

    WalkSample judge_method(const Arbiter& arbiter, const ItemBuffer& buffer, const Bits& seen,
                            const Method& method) const {
        const Bits& reported = method.result.visible;
        WalkSample sample;
        sample.objects_reported = method.result.visible_count;
        sample.triangles_drawn = count_triangles(scene_, reported);
        sample.false_visible_objects = count_without(reported, seen);
        sample.culled_of_frustum = count_without(methods_[frustum_].result.visible, reported);
        if (count_without(seen, reported) == 0)
            return sample;
        for (const LostPixels& lost : find_lost_pixels(scene_, arbiter, buffer, reported)) {
            sample.false_invisible_objects += lost.confirmed > 0;
            sample.false_invisible_pixels += lost.confirmed;
            sample.grazing_pixels += lost.grazing;
            sample.unconfirmed_pixels += lost.unconfirmed;
        }
        return sample;
    }

    void keep_snapshot(std::size_t f, const Bits& seen) {
        if (f % snapshot_stride_ == 0)
            result_.snapshots.push_back(snapshot(f, seen, ""));
        const WalkFrame& frame = result_.frames[f];
        std::uint64_t culled = 0, lost = 0;
        for (const WalkSample& sample : frame.methods) {
            culled = std::max<std::uint64_t>(culled, sample.culled_of_frustum);
            lost = std::max(lost, sample.false_invisible_pixels);
        }
        const std::uint64_t values[3] = {culled, lost, frame.triangles_true};
        static const char* const reasons[3] = {"most culled", "most pixels lost", "most triangles seen"};
        for (std::size_t k = 0; k < 3; ++k)
            if (values[k] > most_[k]) {
                most_[k] = values[k];
                best_[k] = snapshot(f, seen, reasons[k]);
            }
    }

    WalkSnapshot snapshot(std::size_t f, const Bits& seen, const char* why) const {
        WalkSnapshot made{std::uint32_t(f), why, seen, {}};
        for (const Method& method : methods_)
            made.reported.push_back(method.result.visible);
        return made;
    }

    /// One entry per frame, even if it stands out twice; the first frame if none does.
    void take_notable() {
        for (WalkSnapshot& best : best_) {
            if (best.why.empty())
                continue;
            auto same = std::find_if(result_.notable.begin(), result_.notable.end(),
                                     [&](const WalkSnapshot& other) { return other.frame == best.frame; });
            if (same == result_.notable.end())
                result_.notable.push_back(std::move(best));
            else
                same->why += ", " + best.why;
        }
        if (result_.notable.empty()) {
            result_.notable.push_back(result_.snapshots.front());
            result_.notable.front().why = "first";
        }
    }

    Status time_all() {
        std::unique_ptr<Drawing> drawing;
        if (options_.draw) {
            auto made = Drawing::create(scene_, options_.width, options_.height);
            if (made) {
                drawing = std::move(*made);
                result_.renderer = drawing->description();
            } else {
                result_.notes.push_back("Nothing was drawn: " + made.status().message());
            }
        }
        Bits nothing((scene_.objects().size() + 63) / 64, 0);
        timings_.resize(path_.size());
        auto start = std::chrono::steady_clock::now();
        long interruptions_before = interruptions();
        for (std::uint32_t pass = 0; pass < options_.repeat; ++pass) {
            for (Method& method : methods_)
                method.state = {}; // each walk starts cold, so that all do the same work
            for (std::size_t f = 0; f < path_.size(); ++f) {
                time_frame(f, pass, drawing.get(), nothing);
                if (job_.cancelled())
                    return {ErrorCode::cancelled, "stopped while timing"};
                if (job_.progress)
                    job_.progress({"timing", pass * path_.size() + f + 1, options_.repeat * path_.size(), "frames"});
            }
        }
        double seconds = milliseconds_since(start) * 1e-3;
        double rate = double(interruptions() - interruptions_before) / std::max(seconds, 1e-3);
        if (rate > kBusy)
            result_.notes.push_back("The machine was busy: the timed walks were interrupted " +
                                    std::to_string(long(rate)) +
                                    " times a second. Time again on an idle machine before quoting times or speed-ups; "
                                    "what was culled and what was lost is not affected");
        return {};
    }

    struct Timing {
        std::vector<std::vector<double>> cull, draw; ///< per method, per pass
        std::vector<double> empty, ceiling;
    };

    void time_frame(std::size_t f, std::uint32_t pass, Drawing* drawing, const Bits& nothing) {
        View view = view_of(f);
        Timing& timing = timings_[f];
        timing.cull.resize(methods_.size());
        timing.draw.resize(methods_.size());
        for (std::size_t k = 0; k < methods_.size(); ++k) {
            // Whoever comes first finds colder caches: take turns.
            std::size_t m = (k + f + pass) % methods_.size();
            Method& method = methods_[m];
            auto start = std::chrono::steady_clock::now();
            method.culler->cull(view, method.state, method.result);
            timing.cull[m].push_back(milliseconds_since(start));
            if (drawing)
                timing.draw[m].push_back(drawing->draw(view, method.result.visible) * 1e3);
        }
        if (drawing) {
            timing.empty.push_back(drawing->draw(view, nothing) * 1e3);
            timing.ceiling.push_back(drawing->draw(view, seen_[f]) * 1e3);
        }
    }

    void take_fastest(std::size_t f) {
        WalkFrame& frame = result_.frames[f];
        for (std::size_t m = 0; m < methods_.size(); ++m) {
            frame.methods[m].cull_ms = fastest(timings_[f].cull[m]);
            frame.methods[m].draw_ms = fastest(timings_[f].draw[m]);
        }
        frame.empty_ms = fastest(timings_[f].empty);
        frame.ceiling_ms = fastest(timings_[f].ceiling);
    }

    void add_notes() {
        if (result_.frames_in_matter > 0)
            result_.notes.push_back(std::to_string(result_.frames_in_matter) + " of " +
                                    std::to_string(result_.frames.size()) +
                                    " frames lie inside solid matter, where a baked file promises nothing; they are "
                                    "left out of its false invisible");
        for (const WalkMethod& method : result_.methods)
            if (method.unconfirmed_pixels > 0)
                result_.notes.push_back(std::to_string(method.unconfirmed_pixels) + " pixels against " + method.name +
                                        " were not confirmed by exact arithmetic and do not count");
    }

    const Scene& scene_;
    std::span<const View> path_;
    const WalkOptions& options_;
    const Job& job_;
    std::vector<Method> methods_;
    std::size_t frustum_ = 0, snapshot_stride_ = 1;
    std::vector<Bits> seen_;
    std::array<std::uint64_t, 3> most_{};
    std::array<WalkSnapshot, 3> best_;
    std::vector<Timing> timings_;
    WalkResult result_;
};

} // namespace

Result<WalkResult> walk(const Scene& scene, std::span<const View> path, const WalkOptions& options, const Job& job) {
    if (Status status = check(scene, path, options); !status)
        return status;
    auto start = std::chrono::steady_clock::now();
    Result<CullScene> cull_scene = cull_scene_for(scene, options.pvs);
    if (!cull_scene)
        return cull_scene.status();
    double occluder_seconds = milliseconds_since(start) * 1e-3;
    Result<std::vector<Method>> methods = make_methods(*cull_scene, options);
    if (!methods)
        return methods.status();
    Result<WalkResult> result = Walk(scene, path, options, job, std::move(*methods)).run();
    if (result)
        result->occluder_seconds = occluder_seconds;
    return result;
}

} // namespace antumbra
