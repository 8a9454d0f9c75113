// `masked` draws occluder patches into a masked depth buffer as a front-to-back walk meets them; `hzb` draws the
// nearest patches first, builds a pyramid of depths and then tests. Both share projection and coverage.
#include "cull/methods.hpp"
#include "cull/occlusion_walk.hpp"
#include "raster/depth_pyramid.hpp"
#include "raster/tile_buffer.hpp"

#include <string>

namespace antumbra {
namespace {

struct Kernels {
    WalkKernels walk;
    DrawPatch draw = nullptr;
    IsHidden hidden = nullptr;
    bool complete() const { return walk.boxes && walk.project && draw && hidden; }
};

Kernels kernels_for(InstructionSet set) {
    Kernels kernels{{box_kernel(set), nullptr}, nullptr, nullptr};
    if (set == InstructionSet::avx512 || set == InstructionSet::automatic) {
        kernels.draw = draw_patch_avx512();
        kernels.hidden = is_hidden_avx512();
        kernels.walk.project = project_eight_avx512();
    }
    if (set == InstructionSet::avx2 || (set == InstructionSet::automatic && !kernels.draw)) {
        kernels.draw = draw_patch_avx2();
        kernels.hidden = is_hidden_avx2();
        kernels.walk.project = project_eight_avx2();
    }
    if (set == InstructionSet::scalar || (set == InstructionSet::automatic && !kernels.draw)) {
        kernels.draw = draw_patch_scalar;
        kernels.hidden = is_hidden_scalar;
        kernels.walk.project = project_eight_scalar;
    }
    return kernels;
}

double extent_of(const CullScene::Data& scene) {
    if (scene.tree_box.empty())
        return 1;
    Vec3d low = to_double(scene.tree_box.min), high = to_double(scene.tree_box.max);
    return length(high - low) + std::max(length(low), length(high));
}

struct ReportedObject {
    std::uint32_t object;
    PackedPlace place;
};

/// What both methods keep per view.
struct RasterState : ViewState::Storage {
    std::vector<WalkEntry> stack;
    PatchCoverage coverage;
    int width = 0, height = 0;
    std::vector<ReportedObject> reported;

    void fit(const Screen& screen, const CullScene::Data& scene) {
        if (width == screen.width && height == screen.height)
            return;
        width = screen.width;
        height = screen.height;
        coverage.fit(screen, scene.patches.store);
        reported.reserve(scene.object_count());
    }
};

constexpr std::uint16_t kIdle = 24; ///< frames that a patch may hide nothing; then it rests
constexpr std::uint16_t kRest = 48; ///< frames until it is tried again
constexpr float kTrialWorth = 8;    ///< who has hidden nothing lately must promise so many times more pixels

struct MaskedState final : RasterState {
    TileBuffer buffer;
    std::uint16_t frame = 0;
    std::vector<std::uint16_t> hid, tried; ///< per patch: the frame in which it last hid something, or its trial began

    void begin_frame(std::size_t patches) {
        if (hid.empty()) {
            hid.assign(patches, 0);
            tried.assign(patches, 0);
            frame = kIdle + 2 * kRest; // nobody has been tried
        }
        ++frame;
    }
    /// Patches that have hidden nothing for a while, or nothing that others did not hide, rest.
    bool has_paid(std::uint32_t patch) const { return static_cast<std::uint16_t>(frame - hid[patch]) <= kIdle; }
    bool is_worth_a_try(std::uint32_t patch) {
        auto since_trial = static_cast<std::uint16_t>(frame - tried[patch]);
        bool rested = since_trial > kRest + patch % 16; // not all on the same frame
        if (!rested && since_trial > 1)
            return false;
        if (rested)
            tried[patch] = frame;
        return true;
    }
};
struct HzbState final : RasterState {
    DepthPyramid pyramid;
    std::vector<std::pair<float, std::uint32_t>> nearest; ///< patches in view by what they promise
};

class RasterCuller : public Culler {
  public:
    RasterCuller(const CullScene& scene, const CullerOptions& options, Kernels kernels)
        : scene_(scene), options_(options), kernels_(kernels), extent_(extent_of(scene.data())),
          serial_(new_culler_serial()) {}
    Guarantee guarantee() const override { return Guarantee::conservative; }

    void cull(const View& view, ViewState& state, CullResult& result) const override {
        const CullScene::Data& scene = scene_.data();
        begin_result(scene, result);
        if (const char* problem = problem_of(view))
            return mark_everything(scene, result, problem);
        if (scene.occluders.polygons.empty())
            result.reason = "the scene has no occluders: frustum only";
        Camera camera = camera_of(view);
        run(camera, make_screen(camera, options_.raster_width, extent_), state, result);
        finish_result(result);
    }

  protected:
    virtual void run(const Camera& camera, const Screen& screen, ViewState& state, CullResult& result) const = 0;

    /// Draws a patch unless that is unsafe or the budget is spent. False if nothing came of it.
    bool draw(std::uint32_t patch, const Screen& screen, const Box3d& start, RasterState& state,
              CullCounters& counters) const {
        const CullScene::Data& scene = scene_.data();
        const PatchStore& store = scene.patches.store;
        if (is_unusable_solid(scene, patch, start))
            return false;
        if (counters.polygons_drawn + store.patches[patch].polygon_count > options_.polygon_budget) {
            counters.budget_spent = true;
            return false;
        }
        kernels_.draw(store, patch, screen, state.coverage);
        counters.polygons_drawn += state.coverage.polygons;
        if (state.coverage.touched.empty())
            return false;
        ++counters.patches_drawn;
        return true;
    }

    /// Large enough on the screen for the number of its polygons.
    bool is_worth_drawing(std::uint32_t patch, const PackedPlace& place, float factor) const {
        PixelRect rect = place.rect();
        float polygons = float(scene_.data().patches.store.patches[patch].polygon_count);
        return rect.empty() || float(rect.area()) >= factor * options_.pixels_per_polygon * polygons;
    }

    CullScene scene_;
    CullerOptions options_;
    Kernels kernels_;
    double extent_;
    std::uint64_t serial_;
};

class Masked final : public RasterCuller {
  public:
    using RasterCuller::RasterCuller;
    std::string_view name() const override { return "masked"; }

  private:
    struct Visitor {
        const Masked& culler;
        const Screen& screen;
        const Box3d start;
        MaskedState& state;
        CullResult& result;

        bool hidden(const PackedPlace& place) const {
            if (!culler.kernels_.hidden(state.buffer, place.rect(), place.nearness))
                return false;
            state.buffer.for_owners(place.rect(), [&](std::uint32_t patch) { state.hid[patch] = state.frame; });
            return true;
        }
        void object(std::uint32_t object, const PackedPlace& place) {
            mark_visible(result, object);
            state.reported.push_back({object, place});
        }
        /// Cheap and rough: the area of the patch's box over its squared distance.
        bool wants_patch(std::uint32_t patch, float squared_distance) const {
            if (screen.camera.orthographic)
                return true;
            const ScenePatches& patches = culler.scene_.data().patches;
            float pixels = patches.area[patch] * float(screen.scale_x * screen.scale_y);
            return pixels >= culler.options_.pixels_per_polygon * squared_distance;
        }
        void patch(std::uint32_t patch, const PackedPlace& place) {
            bool paid = state.has_paid(patch);
            if (!culler.is_worth_drawing(patch, place, paid ? 1 : kTrialWorth) ||
                !(paid || state.is_worth_a_try(patch)) || !culler.draw(patch, screen, start, state, result.counters))
                return;
            state.buffer.merge(state.coverage, patch);
            state.coverage.clear(screen);
        }
    };

    void run(const Camera& camera, const Screen& screen, ViewState& view_state, CullResult& result) const override {
        auto& state = view_state.storage<MaskedState>(serial_);
        state.fit(screen, scene_.data());
        state.buffer.reset(screen);
        state.reported.clear();
        state.begin_frame(scene_.data().patches.boxes.size());
        Visitor visitor{*this, screen, near_box(camera), state, result};
        walk_front_to_back(scene_.data(), screen, kernels_.walk, state.stack, result.counters, visitor);
        // The walk is only nearly front to back: occluders that came late may hide what was reported early.
        for (auto [object, place] : state.reported)
            if (visitor.hidden(place)) {
                result.visible[object / 64] &= ~(std::uint64_t(1) << (object % 64));
                ++result.counters.hidden_by_raster;
            }
    }
};

/// Everything is drawn before anything is tested: only what promises more is worth that.
constexpr float kWorth = 16;

class Hzb final : public RasterCuller {
  public:
    using RasterCuller::RasterCuller;
    std::string_view name() const override { return "hzb"; }

  private:
    struct Visitor {
        const DepthPyramid& pyramid;
        CullResult& result;
        bool hidden(const PackedPlace& place) const { return pyramid.is_hidden(place.rect(), place.nearness); }
        void object(std::uint32_t object, const PackedPlace&) { mark_visible(result, object); }
        void patch(std::uint32_t, const PackedPlace&) {}
        bool wants_patch(std::uint32_t, float) const { return false; }
    };

    void run(const Camera& camera, const Screen& screen, ViewState& view_state, CullResult& result) const override {
        auto& state = view_state.storage<HzbState>(serial_);
        state.fit(screen, scene_.data());
        state.pyramid.reset(screen);
        choose(screen, state, result.counters);
        Box3d start = near_box(camera);
        for (auto [size, patch] : state.nearest) {
            if (!draw(patch, screen, start, state, result.counters))
                continue;
            state.pyramid.merge(state.coverage);
            state.coverage.clear(screen);
        }
        state.pyramid.build();
        walk_front_to_back(scene_.data(), screen, kernels_.walk, state.stack, result.counters,
                           Visitor{state.pyramid, result});
    }

    /// Patches in view that promise enough, those that promise most first: pixels (roughly: the area over the squared
    /// distance) for each polygon.
    void choose(const Screen& screen, HzbState& state, CullCounters& counters) const {
        state.nearest.clear();
        CullCounters walk_counters;
        walk_front_to_back(scene_.data(), screen, kernels_.walk, state.stack, walk_counters,
                           Chooser{*this, screen, state});
        counters.boxes_tested += walk_counters.boxes_tested;
        std::sort(state.nearest.begin(), state.nearest.end());
    }

    struct Chooser {
        const Hzb& culler;
        const Screen& screen;
        HzbState& state;
        bool hidden(const PackedPlace&) const { return false; }
        void object(std::uint32_t, const PackedPlace&) {}
        void patch(std::uint32_t, const PackedPlace&) {}
        bool wants_patch(std::uint32_t patch, float squared_distance) const {
            float pixels = culler.scene_.data().patches.area[patch] * float(screen.scale_x * screen.scale_y);
            if (!screen.camera.orthographic)
                pixels /= squared_distance + 1e-6f * float(culler.extent_ * culler.extent_);
            if (pixels >= kWorth * culler.options_.pixels_per_polygon)
                state.nearest.push_back({-pixels, patch});
            return false;
        }
    };
};

template <class Method>
Result<CullerPointer> make(const CullScene& scene, const CullerOptions& options, Kernels kernels) {
    if (!kernels.complete())
        return Status(ErrorCode::unsupported,
                      "this processor lacks the instruction set that was asked for; use automatic");
    if (options.raster_width < kTile || options.raster_width > 2048)
        return Status(ErrorCode::usage, "raster_width is " + std::to_string(options.raster_width) +
                                            "; it must be between 8 and 2048");
    return CullerPointer(std::make_unique<Method>(scene, options, kernels));
}

} // namespace

Result<CullerPointer> make_masked(const CullScene& scene, const CullerOptions& options) {
    return make<Masked>(scene, options, kernels_for(options.instruction_set));
}

Result<CullerPointer> make_hzb(const CullScene& scene, const CullerOptions& options) {
    return make<Hzb>(scene, options, kernels_for(InstructionSet::scalar));
}

} // namespace antumbra
