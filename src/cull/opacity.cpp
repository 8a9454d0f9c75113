// `opacity`: chosen occluders are drawn into a small bitmap with depths, then the hierarchy of boxes is tested against
// it (Poon, Wang 1999; docs/methods/opacity.md). Three forms of one test: see OpacityForm.
#include "cull/adaptive_stop.hpp"
#include "cull/box_kernels.hpp"
#include "cull/methods.hpp"
#include "cull/opacity_occluders.hpp"
#include "cull/occluder_walk.hpp"
#include "cull/result_bits.hpp"
#include "cull/seen_patches.hpp"
#include "raster/opacity_map.hpp"
#include "raster/opacity_rows.hpp"
#include "raster/sparse_depth_map.hpp"

#include <string>

namespace antumbra {
namespace {

static_assert(kWidth == EightOnScreen::kLanes);

constexpr int kPublishedSide = 128, kModernWidth = 256;
constexpr double kTrianglesPerObject = 400; ///< that many cost as much again as the object itself
constexpr float kLeastPixels = 8; ///< of a patch's box on the screen, for each of its polygons
constexpr std::uint32_t kSparseRest = 15; ///< frames without a sparse depth map after one that skipped nothing

struct Kernels {
    BoxKernel boxes = nullptr;
    ProjectEight project = nullptr;
    DrawOccluder draw = nullptr;
};

Kernels kernels_for(InstructionSet set) {
    Kernels kernels{box_kernel(set), nullptr, nullptr};
    auto take = [&](InstructionSet candidate, ProjectEight project, DrawOccluder draw) {
        if (!kernels.draw && (set == candidate || set == InstructionSet::automatic)) {
            kernels.project = project;
            kernels.draw = draw;
        }
    };
    take(InstructionSet::avx512, project_eight_avx512(), draw_occluder_avx512());
    take(InstructionSet::avx2, project_eight_avx2(), draw_occluder_avx2());
    take(InstructionSet::scalar, project_eight_scalar, draw_occluder_scalar);
    return kernels;
}

struct Entry {
    std::uint32_t node, planes;
    bool tests; ///< false: covered so little that nothing below is tested
};

struct State final : ViewState::Storage {
    State(const CullScene::Data& scene, const CullerOptions& options)
        : occluders(scene, options.occluder_choice, options.pvs), stop(options.opacity.stop_below) {}
    OpacityOccluders occluders; ///< for OpacityChoice::as_listed
    OccluderWalk walk;          ///< for OpacityChoice::by_gain
    SeenPatches seen;           ///< with a PVS
    OccluderBrush brush;
    OccluderImage image;
    OpacityMap table;
    SparseDepthMap sparse;
    OpacityRows rows;
    AdaptiveStop stop;
    double reported = 0; ///< seconds that drawing takes of what walk() has reported
    std::uint32_t sparse_rest = 0;
    bool use_sparse = false;
    std::vector<Entry> stack;
};

class Opacity final : public Culler {
  public:
    Opacity(const CullScene& scene, const CullerOptions& options, Kernels kernels)
        : scene_(scene), all_options_(options), options_(all_options_.opacity), kernels_(kernels), serial_(new_culler_serial()) {
        const CullScene::Data& data = scene.data();
        if (!data.tree_box.empty()) {
            Vec3d low = to_double(data.tree_box.min), high = to_double(data.tree_box.max);
            extent_ = length(high - low) + std::max(length(low), length(high));
        }
        for (std::uint32_t object : data.order) {
            double triangles = data.triangles.empty() ? 0 : data.triangles[object];
            costs_.push_back(costs_.back() + options_.object_seconds * (1 + triangles / kTrianglesPerObject));
        }
        if (chooses_by_gain() && database())
            owners_ = owning_patches(data.occluders);
    }
    std::string_view name() const override {
        return options_.form == OpacityForm::modern ? "opacity" : "opacity-published";
    }
    Guarantee guarantee() const override {
        return options_.coverage == OpacityCoverage::inner && options_.tolerance == 0 ? Guarantee::conservative
                                                                                      : Guarantee::approximate;
    }

    void cull(const View& view, ViewState& view_state, CullResult& result) const override {
        const CullScene::Data& scene = scene_.data();
        begin_result(scene, result);
        if (const char* problem = problem_of(view))
            return mark_everything(scene, result, problem);
        if (scene.wide.empty())
            return finish_result(result);
        if (scene.occluders.polygons.empty())
            result.reason = "the scene has no occluders: frustum only";
        auto& state = view_state.storage<State>(serial_, scene, all_options_);
        state.stack.reserve(scene.stack_bound);
        Camera camera = camera_of(view);
        FrustumPlanes planes = frustum_planes(camera, scene.tree_box);
        if (scene.occluders.polygons.empty() || options_.occluders == 0) {
            walk({}, planes, state, result, false);
        } else if (!options_.adaptive || !is_left_to_frustum(planes, state, result)) {
            run(camera, planes, state, result);
        }
        finish_result(result);
    }

  private:
    /// Has the adaptive stop had the frustum alone decide this frame?
    bool is_left_to_frustum(const FrustumPlanes& planes, State& state, CullResult& result) const {
        const bool waits = state.stop.sits_out();
        if (!waits && !state.stop.doubts())
            return false;
        walk({}, planes, state, result, false);
        state.stop.learn_possible(state.reported);
        result.counters.switched_off = waits || state.stop.doubts();
        if (!result.counters.switched_off)
            begin_result(scene_.data(), result);
        return result.counters.switched_off;
    }

    void run(const Camera& camera, const FrustumPlanes& planes, State& state, CullResult& result) const {
        double begin = options_.clock ? options_.clock() : 0;
        Screen screen = screen_of(camera);
        draw(camera, planes, screen, state, result.counters);
        prepare(state);
        double saved = walk(screen, planes, state, result, true);
        if (!options_.adaptive)
            return;
        double seconds = options_.clock ? options_.clock() - begin : counted_seconds(screen, result.counters);
        state.stop.learn(seconds, saved);
        state.stop.learn_possible(saved + state.reported);
    }

    Screen screen_of(const Camera& camera) const {
        if (options_.form == OpacityForm::modern && options_.height == 0)
            return make_screen(camera, options_.width ? options_.width : kModernWidth, extent_);
        return make_screen(camera, options_.width ? options_.width : kPublishedSide,
                           options_.height ? options_.height : kPublishedSide, extent_);
    }

    /// About what a present processor needs. Decides only when the method gives up.
    static double counted_seconds(const Screen& screen, const CullCounters& counters) {
        return 1e-6 * double(counters.polygons_drawn) + 0.5e-9 * double(screen.width) * screen.height +
               15e-9 * double(counters.boxes_tested);
    }

    void draw(const Camera& camera, const FrustumPlanes& planes, const Screen& screen, State& state,
              CullCounters& counters) const {
        state.image.reset(screen);
        if (chooses_by_gain())
            draw_by_gain(camera, planes, screen, state, counters);
        else
            draw_as_listed(camera, planes, screen, state, counters);
    }

    bool chooses_by_gain() const {
        return options_.form == OpacityForm::modern && options_.choice == OpacityChoice::by_gain;
    }
    const OccluderDatabase* database() const {
        const OccluderDatabase& prepared = scene_.data().minimum_sets;
        return options_.database ? options_.database : !prepared.first.empty() ? &prepared : nullptr;
    }
    PixelCoverage coverage() const {
        return options_.coverage == OpacityCoverage::inner ? PixelCoverage::inner : PixelCoverage::centre;
    }

    void draw_as_listed(const Camera& camera, const FrustumPlanes& planes, const Screen& screen, State& state,
                        CullCounters& counters) const {
        const CullScene::Data& scene = scene_.data();
        state.occluders.choose(scene, database(), camera, planes, options_.occluders);
        const PatchStore& store = state.occluders.patches(scene.occluders);
        state.brush.fit(screen, store);
        for (std::uint32_t patch = 0; patch < store.patches.size(); ++patch) {
            counters.polygons_drawn += kernels_.draw(store, patch, screen, coverage(), state.brush, state.image);
            ++counters.patches_drawn;
        }
        counters.occluders_used = state.occluders.polygons().size();
    }

    void draw_by_gain(const Camera& camera, const FrustumPlanes& planes, const Screen& screen, State& state,
                      CullCounters& counters) const {
        const CullScene::Data& scene = scene_.data();
        const PatchStore& store = scene.patches.store;
        state.brush.fit(screen, store);
        auto draw = [&](std::uint32_t patch) {
            if (all_options_.pvs && !state.seen.holds(*all_options_.pvs, scene, camera.eye, patch))
                return;
            if (counters.polygons_drawn + store.patches[patch].polygon_count > options_.occluders) {
                counters.budget_spent = true;
                return;
            }
            counters.polygons_drawn += kernels_.draw(store, patch, screen, coverage(), state.brush, state.image);
            ++counters.patches_drawn;
        };
        OccluderWalk::Frame frame{scene,        camera,         planes, screen, state.image, kernels_.boxes,
                                  kernels_.project, kLeastPixels};
        if (const OccluderDatabase* lists = database())
            state.walk.run(frame, *lists, owners_, draw);
        else
            state.walk.run(frame, draw);
        counters.occluders_used = counters.polygons_drawn;
    }

    void prepare(State& state) const {
        if (options_.form == OpacityForm::modern)
            return state.rows.build(state.image);
        if (options_.form == OpacityForm::pixel_wise)
            return;
        state.table.build(state.image);
        if (state.sparse_rest > 0) {
            --state.sparse_rest;
            return;
        }
        state.sparse.build(state.image);
        state.use_sparse = state.sparse.is_worth_it();
        if (!state.use_sparse)
            state.sparse_rest = kSparseRest;
    }

    bool is_hidden(const State& state, const PixelRect& rect, float nearness) const {
        switch (options_.form) {
        case OpacityForm::modern:
            if (options_.tolerance > 0) {
                auto area = static_cast<std::uint32_t>(rect.area());
                auto open = area - OpacityRows::covered(state.image, rect);
                return open <= static_cast<std::uint32_t>(options_.tolerance * float(area)) &&
                       is_behind_pixel_wise(state.image, rect, nearness);
            }
            return state.rows.overlaps(rect) && state.rows.is_behind(state.image, rect, nearness);
        case OpacityForm::published:
            return state.table.overlaps(rect, options_.tolerance) &&
                   (state.use_sparse ? state.sparse.is_behind(state.image, rect, nearness)
                                     : is_behind_pixel_wise(state.image, rect, nearness));
        case OpacityForm::pixel_wise:
            break;
        }
        return overlaps_pixel_wise(state.image, rect) && is_behind_pixel_wise(state.image, rect, nearness);
    }

    /// The adaptive overlap test: is the node covered so little that tests below it are in vain?
    bool stops_at(const State& state, const PixelRect& rect) const {
        float stop = options_.adaptive ? state.stop.stop_below() : options_.stop_below;
        if (!(stop > 0) || options_.form == OpacityForm::pixel_wise)
            return false;
        if (options_.form == OpacityForm::published)
            return float(state.table.covered(rect)) < stop * float(rect.area());
        return OpacityRows::covered_share(state.image, rect) < stop;
    }

    /// Seconds that leaving out what was hidden saves. `tests`: against the map, not the frustum alone.
    double walk(const Screen& screen, const FrustumPlanes& planes, State& state, CullResult& result,
                       bool tests) const {
        const CullScene::Data& scene = scene_.data();
        CullCounters& counters = result.counters;
        double saved = 0;
        state.reported = 0;
        state.stack.clear();
        state.stack.push_back({0, planes.mask(), tests});
        BoxVerdicts verdicts;
        EightOnScreen boxes;
        while (!state.stack.empty()) {
            Entry entry = state.stack.back();
            state.stack.pop_back();
            const CullNode& node = scene.wide[entry.node];
            kernels_.boxes({node.min, node.max}, planes, entry.planes, verdicts);
            std::uint32_t inside = node.mask() & ~verdicts.outside;
            ++counters.nodes_visited;
            counters.boxes_tested += node.used;
            counters.outside_frustum += static_cast<std::uint32_t>(std::popcount(node.mask() & ~inside));
            if (entry.tests && inside)
                kernels_.project(screen, node.min, node.max, boxes);
            for (std::uint32_t rest = inside; rest; rest &= rest - 1) {
                int slot = std::countr_zero(rest);
                bool below = entry.tests, object = (node.child[slot] & kObjectChild) != 0;
                if (entry.tests && (boxes.testable >> slot & 1)) {
                    PixelRect rect = boxes.rect(slot);
                    ++counters.overlap_tests;
                    if (is_hidden(state, rect, boxes.nearness[slot])) {
                        ++counters.hidden_by_raster;
                        saved += costs_[node.first[slot] + node.count[slot]] - costs_[node.first[slot]];
                        continue;
                    }
                    if (!object && stops_at(state, rect)) {
                        ++counters.stopped_early;
                        below = false;
                    }
                }
                if (!object && (below || verdicts.crossing[slot])) {
                    state.stack.push_back({node.child[slot], verdicts.crossing[slot], below});
                    continue;
                }
                state.reported += costs_[node.first[slot] + node.count[slot]] - costs_[node.first[slot]];
                if (object)
                    mark_visible(result, node.child[slot] & ~kObjectChild);
                else
                    for (std::uint32_t i = node.first[slot]; i < node.first[slot] + node.count[slot]; ++i)
                        mark_visible(result, scene.order[i]);
            }
        }
        return saved;
    }

    CullScene scene_;
    CullerOptions all_options_;
    const OpacityOptions& options_; ///< of these
    Kernels kernels_;
    double extent_ = 1;
    std::vector<std::uint32_t> owners_; ///< per polygon its patch, where there is a database
    std::vector<double> costs_{0}; ///< of drawing the objects, summed up in the order of the tree
    std::uint64_t serial_;
};

Status check(const CullScene& scene, const OpacityOptions& options) {
    auto usage = [](const std::string& text) { return Status(ErrorCode::usage, "opacity: " + text); };
    for (int side : {options.width, options.height})
        if (side != 0 && (side < kTile || side > 2048))
            return usage("a map of " + std::to_string(side) + " pixels; a side has 8 to 2048, or 0 for the default");
    if (!(options.tolerance >= 0 && options.tolerance <= 1))
        return usage("the tolerance is a share from 0 to 1");
    if (!(options.stop_below >= 0 && options.stop_below <= 1))
        return usage("stop_below is a share from 0 to 1");
    if (!(options.object_seconds >= 0))
        return usage("object_seconds is negative or not a number");
    if (options.database)
        return check_occluder_database(*options.database, scene.data().occluders.polygons.size());
    return {};
}

} // namespace

Result<CullerPointer> make_opacity(const CullScene& scene, const CullerOptions& options) {
    Kernels kernels = kernels_for(options.instruction_set);
    if (!kernels.boxes || !kernels.draw || !kernels.project)
        return Status(ErrorCode::unsupported,
                      "this processor lacks the instruction set that was asked for; use automatic");
    if (Status status = check(scene, options.opacity); !status)
        return status;
    return CullerPointer(std::make_unique<Opacity>(scene, options, kernels));
}

} // namespace antumbra
