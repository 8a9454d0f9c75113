// `masked` draws occluder patches into a masked depth buffer as a front-to-back walk meets them.
#include "cull/patch_trials.hpp"
#include "cull/raster_culler.hpp"

namespace antumbra {
namespace {

constexpr float kTrialWorth = 2; ///< who has hidden nothing lately must promise so many times more pixels

struct ReportedObject {
    std::uint32_t object;
    PackedPlace place;
};

struct MaskedState final : RasterState {
    TileBuffer buffer;
    PatchTrials trials;
    std::vector<ReportedObject> reported;
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
            std::uint32_t owners[kMostOwners], count = 0;
            state.buffer.for_owners(place.rect(), [&](std::uint32_t patch) { owners[count++] = patch; });
            const float share = 1.0f / float(count);
            for (std::uint32_t i = 0; i < count; ++i)
                state.trials.credit(owners[i], share);
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
        /// Pixels for each polygon, in units of what a patch that has paid must promise. Where it may be anywhere: all.
        float promise_of(std::uint32_t polygons, const PackedPlace& place) const {
            const PixelRect rect = place.rect();
            const int pixels = rect.empty() ? screen.width * screen.height : rect.area();
            return float(pixels) / (culler.options_.pixels_per_polygon * float(polygons));
        }
        void patch(std::uint32_t patch, const PackedPlace& place) {
            const std::uint32_t polygons = culler.scene_.data().patches.store.patches[patch].polygon_count;
            const float promise = promise_of(polygons, place);
            if (state.trials.has_paid(patch) ? promise < 1 : !state.trials.may_try(patch, polygons, promise / kTrialWorth))
                return;
            state.trials.was_chosen(patch);
            if (!culler.draw(patch, screen, start, state, result.counters))
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
        state.trials.begin_frame(scene_.data().patches.boxes.size(), camera, extent_);
        Visitor visitor{*this, screen, near_box(camera), state, result};
        walk_front_to_back(scene_.data(), screen, kernels_.walk, state.stack, result.counters, visitor);
        // The walk is only nearly front to back: occluders that came late may hide what was reported early.
        for (auto [object, place] : state.reported)
            if (visitor.hidden(place)) {
                result.visible[object / 64] &= ~(std::uint64_t(1) << (object % 64));
                ++result.counters.hidden_by_raster;
            }
        state.trials.end_frame(scene_.data().patches.store);
    }
};

} // namespace

Result<CullerPointer> make_masked(const CullScene& scene, const CullerOptions& options) {
    return make_raster_culler<Masked>(scene, options, raster_kernels(options.instruction_set));
}

} // namespace antumbra
