// `hzb` draws the patches that promise most, builds a pyramid of depths and then tests.
#include "cull/raster_culler.hpp"
#include "raster/depth_pyramid.hpp"

namespace antumbra {
namespace {

struct HzbState final : RasterState {
    DepthPyramid pyramid;
    std::vector<std::pair<float, std::uint32_t>> nearest; ///< patches in view by what they promise
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

} // namespace

Result<CullerPointer> make_hzb(const CullScene& scene, const CullerOptions& options) {
    return make_raster_culler<Hzb>(scene, options, raster_kernels(InstructionSet::scalar));
}

} // namespace antumbra
