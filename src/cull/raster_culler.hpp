// What the methods that draw occluders share: a patch at a time into its coverage.
#pragma once

#include "cull/methods.hpp"
#include "cull/occlusion_walk.hpp"
#include "cull/seen_patches.hpp"
#include "raster/patch_raster.hpp"
#include "raster/tile_buffer.hpp"

#include <string>

namespace antumbra {

/// The machine code that a culler uses.
struct RasterKernels {
    WalkKernels walk;
    DrawPatch draw = nullptr;
    IsHidden hidden = nullptr;
    bool complete() const { return walk.boxes && walk.project && draw && hidden; }
};

/// Incomplete if the processor lacks the set.
RasterKernels raster_kernels(InstructionSet set);

/// The size of what is looked at, for tolerances.
inline double extent_of(const CullScene::Data& scene) {
    if (scene.tree_box.empty())
        return 1;
    Vec3d low = to_double(scene.tree_box.min), high = to_double(scene.tree_box.max);
    return length(high - low) + std::max(length(low), length(high));
}

/// What both methods keep per view.
struct RasterState : ViewState::Storage {
    std::vector<WalkEntry> stack;
    PatchCoverage coverage;
    SeenPatches seen; ///< used with a PVS
    int width = 0, height = 0;

    void fit(const Screen& screen, const CullScene::Data& scene) {
        if (width == screen.width && height == screen.height)
            return;
        width = screen.width;
        height = screen.height;
        coverage.fit(screen, scene.patches.store);
    }
};

class RasterCuller : public Culler {
  public:
    RasterCuller(const CullScene& scene, const CullerOptions& options, RasterKernels kernels)
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
        if (is_unusable_solid(scene, patch, start) ||
            (options_.pvs && !state.seen.holds(*options_.pvs, scene, screen.camera.eye, patch)))
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


    CullScene scene_;
    CullerOptions options_;
    RasterKernels kernels_;
    double extent_;
    std::uint64_t serial_;
};

template <class Method>
Result<CullerPointer> make_raster_culler(const CullScene& scene, const CullerOptions& options, const RasterKernels& kernels) {
    if (!kernels.complete())
        return Status(ErrorCode::unsupported,
                      "this processor lacks the instruction set that was asked for; use automatic");
    if (options.raster_width < kTile || options.raster_width > 2048)
        return Status(ErrorCode::usage, "raster_width is " + std::to_string(options.raster_width) +
                                            "; it must be between 8 and 2048");
    return CullerPointer(std::make_unique<Method>(scene, options, kernels));
}

} // namespace antumbra
