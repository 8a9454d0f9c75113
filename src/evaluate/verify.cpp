#include "bake/viewpoint.hpp"
#include "base/collect.hpp"
#include "base/random.hpp"
#include "evaluate/item_buffer.hpp"

#include <antumbra/evaluate.hpp>

#include <algorithm>
#include <bit>
#include <map>
#include <cstdio>
#include <nlohmann/json.hpp>

namespace antumbra {
namespace {

/// How often a viewpoint is drawn before the search counts as hopeless.
constexpr std::uint32_t kMostDraws = 4096;

struct Viewpoint {
    Vec3d world, local;
};

/// Draws viewpoints from the free space of what is baked: a grid cell by cell, a view tree from its whole box.
class ViewpointSource {
  public:
    ViewpointSource(const Tracer& tracer, const Pvs& pvs, std::uint64_t seed)
        : tracer_(tracer), pvs_(pvs), seed_(seed) {
        if (pvs.tree().nodes.empty())
            for (std::uint64_t cell = 0; cell < pvs.grid().cells(); ++cell)
                if (pvs.cell_row(cell) < pvs.row_count())
                    baked_.push_back(cell);
    }

    bool empty() const { return pvs_.tree().nodes.empty() && baked_.empty(); }

    /// Nothing if only matter and unbaked space was met. Leaves the answer for the viewpoint in `cursor`.
    std::optional<Viewpoint> draw(std::uint32_t sample, PvsCursor& cursor, std::uint64_t& in_matter) const {
        Random random(seed_, sample);
        for (std::uint32_t k = 0; k < kMostDraws; ++k) {
            Box3d box =
                baked_.empty() ? pvs_.tree().bounds : pvs_.grid().cell(baked_[random.next_u64() % baked_.size()]);
            Viewpoint viewpoint;
            for (int axis = 0; axis < 3; ++axis)
                viewpoint.world[axis] = random.uniform(box.min[axis], box.max[axis]);
            viewpoint.local = tracer_.scene().to_local(viewpoint.world);
            pvs_.query(viewpoint.world, cursor);
            // Rounding can carry a point over the face of its cell, and a tree has leaves that are not baked.
            if (cursor.everything)
                continue;
            if (is_viewpoint(tracer_, viewpoint.local))
                return viewpoint;
            ++in_matter;
        }
        return {};
    }

  private:
    const Tracer& tracer_;
    const Pvs& pvs_;
    std::uint64_t seed_;
    std::vector<std::uint64_t> baked_;
};

/// The six answers for the six faces. A view tree answers per direction, so each face asks with its own frustum.
class FaceAnswers {
  public:
    FaceAnswers(const Pvs& pvs, const Viewpoint& viewpoint, const PvsCursor& all_around)
        : pvs_(pvs), viewpoint_(viewpoint), cursor_(all_around), cell_(all_around.cell),
          directed_(!pvs.tree().nodes.empty()) {
        visible_.assign(all_around.visible.size(), 0);
    }

    std::span<const std::uint64_t> ask(int face) {
        if (directed_) {
            Vec3d forward, up;
            forward[face / 2] = face % 2 ? -1 : 1;
            up[(face / 2 + 2) % 3] = 1;
            Box3d point{viewpoint_.world, viewpoint_.world};
            pvs_.query_range(camera_range(point, forward, up, 1, 1), cursor_);
        }
        for (std::size_t word = 0; word < visible_.size(); ++word)
            visible_[word] |= cursor_.visible[word];
        return cursor_.visible;
    }

    /// The union of what was answered.
    const std::vector<std::uint64_t>& all() const { return visible_; }
    std::int64_t cell() const { return cell_; }

  private:
    const Pvs& pvs_;
    const Viewpoint& viewpoint_;
    PvsCursor cursor_;
    std::int64_t cell_;
    bool directed_;
    std::vector<std::uint64_t> visible_;
};

/// Everything about one viewpoint: six faces against their answers.
VerifyResult judge_viewpoint(const Tracer& tracer, const Viewpoint& viewpoint, FaceAnswers answers,
                             const VerifyOptions& options, std::uint32_t sample) {
    const Scene& scene = tracer.scene();
    Arbiter arbiter(tracer);
    VerifyResult result;
    result.viewpoints = 1;
    std::vector<std::uint64_t> seen((scene.objects().size() + 63) / 64, 0);
    std::map<std::uint32_t, std::uint64_t> confirmed;
    for (int face = 0; face < 6; ++face) {
        PixelRays rays = PixelRays::of_cube_face(viewpoint.local, face, options.face_size);
        ItemOptions item_options{PixelSampling::jittered, options.seed, std::uint64_t(sample) * 6 + unsigned(face)};
        Job alone;
        alone.threads = 1; // the viewpoints are what runs in parallel
        ItemBuffer buffer = ItemBuffer::render(tracer, rays, item_options, alone);
        mark_seen(scene, buffer, seen);
        for (const LostPixels& lost : find_lost_pixels(scene, arbiter, buffer, answers.ask(face))) {
            if (lost.confirmed > 0)
                confirmed[lost.object] += lost.confirmed;
            result.false_invisible_pixels += lost.confirmed;
            result.grazing_pixels += lost.grazing;
            result.unconfirmed_pixels += lost.unconfirmed;
        }
        result.pixels += rays.pixels();
    }
    result.false_invisible_objects = confirmed.size();
    for (auto [object, pixels] : confirmed)
        result.worst.push_back({viewpoint.world, answers.cell(), object, pixels});
    for (std::size_t word = 0; word < seen.size(); ++word) {
        result.seen_objects += unsigned(std::popcount(seen[word]));
        result.reported_objects += unsigned(std::popcount(answers.all()[word]));
        result.false_visible_objects += unsigned(std::popcount(answers.all()[word] & ~seen[word]));
    }
    return result;
}

void add(VerifyResult& total, const VerifyResult& one) {
    total.viewpoints += one.viewpoints;
    total.in_matter += one.in_matter;
    total.pixels += one.pixels;
    total.false_invisible_objects += one.false_invisible_objects;
    total.false_invisible_pixels += one.false_invisible_pixels;
    total.grazing_pixels += one.grazing_pixels;
    total.unconfirmed_pixels += one.unconfirmed_pixels;
    total.false_visible_objects += one.false_visible_objects;
    total.reported_objects += one.reported_objects;
    total.seen_objects += one.seen_objects;
    total.worst.insert(total.worst.end(), one.worst.begin(), one.worst.end());
}

void keep_worst(std::vector<FalseInvisible>& worst, std::uint32_t count) {
    std::stable_sort(worst.begin(), worst.end(),
                     [](const FalseInvisible& a, const FalseInvisible& b) { return a.pixels > b.pixels; });
    if (worst.size() > count)
        worst.resize(count);
}

} // namespace

double crack_width(const Pvs& pvs) {
    nlohmann::json options = nlohmann::json::parse(pvs.options_json(), nullptr, false);
    if (options.is_object() && options.contains("options")) // a part of a bake
        options = nlohmann::json(options["options"]);
    return options.is_object() && options.contains("crack_width") && options["crack_width"].is_number()
               ? options["crack_width"].get<double>()
               : 0;
}

std::string describe_guarantee(const Pvs& pvs) {
    double width = crack_width(pvs);
    char text[64] = "";
    if (width > 0)
        std::snprintf(text, sizeof text, " for cracks closed up to %g", width);
    return to_string(pvs.guarantee()) + std::string(text);
}

Status check_belongs(const Scene& scene, const Pvs& pvs) {
    if (crack_width(pvs) != scene.crack_width()) {
        char text[128];
        std::snprintf(text, sizeof text, "was baked with --crack-width %g, the scene is read with %g; give the same",
                      crack_width(pvs), scene.crack_width());
        return {ErrorCode::mismatch, text};
    }
    if (pvs.scene_fingerprint() == scene.fingerprint() && pvs.object_count() == scene.objects().size())
        return {};
    if (pvs.structure_fingerprint() != scene.structure_fingerprint() || pvs.object_count() != scene.objects().size())
        return {ErrorCode::mismatch, "was baked from another scene (" + std::to_string(pvs.object_count()) +
                                         " objects, here " + std::to_string(scene.objects().size()) +
                                         "); bake this scene again"};
    if (pvs.sides() != std::uint8_t(scene.sides()))
        return {ErrorCode::mismatch, std::string("was baked with --sides ") + (pvs.sides() ? "both" : "material") +
                                         "; give the same, or bake again"};
    return {ErrorCode::mismatch, "was baked from an earlier state of this scene: only the structure (its objects and "
                                 "their triangle counts) matches, not the geometry or the flags; bake again"};
}

bool may_lose_pixels(Guarantee guarantee) {
    return guarantee != Guarantee::exact && guarantee != Guarantee::conservative;
}

Result<VerifyResult> verify(const Scene& scene, const Pvs& pvs, const VerifyOptions& options, const Job& job) {
    if (options.face_size == 0 || options.face_size > 8192 || options.samples == 0)
        return Status(ErrorCode::usage, "verify needs at least one viewpoint and 1 to 8192 pixels along a face");
    if (Status status = check_belongs(scene, pvs); !status)
        return status;
    Tracer tracer = Tracer::build(scene, job);
    ViewpointSource source(tracer, pvs, options.seed);
    if (source.empty())
        return Status(ErrorCode::usage, "no cell of the file is baked: there is nothing to verify");
    std::vector<VerifyResult> results(options.samples);
    std::vector<PvsCursor> cursors(worker_count(job));
    auto judge = [&](std::size_t sample, unsigned worker) {
        std::uint64_t in_matter = 0;
        VerifyResult one;
        if (std::optional<Viewpoint> viewpoint = source.draw(std::uint32_t(sample), cursors[worker], in_matter))
            one = judge_viewpoint(tracer, *viewpoint, FaceAnswers(pvs, *viewpoint, cursors[worker]), options,
                                  std::uint32_t(sample));
        one.in_matter = in_matter;
        return one;
    };
    auto take = [&](std::size_t sample, VerifyResult one) { results[sample] = std::move(one); };
    if (Status status = collect(options.samples, job, "verify", "viewpoints", judge, take); !status)
        return status;
    VerifyResult result;
    for (const VerifyResult& one : results) {
        if (one.viewpoints == 0)
            return Status(ErrorCode::usage, "what is baked holds hardly a viewpoint outside matter; if the scene is "
                                            "inside out, bake and verify it with --sides both");
        add(result, one);
    }
    keep_worst(result.worst, options.worst);
    return result;
}

} // namespace antumbra
