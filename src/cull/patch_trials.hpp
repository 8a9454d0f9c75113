// Which occluder patches are worth drawing: those that lately hid enough for their price, and now and then others, to see
// whether they would. Integers and sums in a fixed order: the same frames give the same choice everywhere.
#pragma once

#include "geometry/camera.hpp"
#include "raster/patch.hpp"

#include <algorithm>

namespace antumbra {

class PatchTrials {
  public:
    /// `extent`: the size of the scene.
    void begin_frame(std::size_t patches, const Camera& camera, double extent) {
        if (value_.size() != patches) {
            value_.assign(patches, 0);
            gained_.assign(patches, 0);
            rested_.assign(patches, 0);
            frame_ = 2 * kRest; // nobody rests
            trial_polygons_ = kFirstTrialPolygons;
            eye_ = camera.eye;
            forward_ = camera.forward;
        } else {
            trial_polygons_ = kTrialPolygons;
        }
        ++frame_;
        if (!(length(camera.eye - eye_) <= kStride * extent) || !(dot(camera.forward, forward_) >= kTurn)) {
            frame_ += 2 * kRest; // what hid nothing there may hide much here: all rests end
            eye_ = camera.eye;
            forward_ = camera.forward;
        }
        chosen_.clear();
        tried_polygons_ = 0;
    }

    bool has_paid(std::uint32_t patch) const { return value_[patch] > 0; }

    /// May a patch that has not paid be tried in this frame? `promise`: how many times over it covers the pixels that
    /// a trial asks for; asked for twice as much with every kTrialPolygons polygons that the frame has spent on trials.
    /// So a view that is new all over begins with the largest patches and takes the others in the frames that follow. The
    /// first frame of all spends more: it may be the only one.
    bool may_try(std::uint32_t patch, std::uint32_t polygons, float promise) {
        if (frame_ - rested_[patch] <= kRest + patch % 16) // not all on the same frame
            return false;
        if (promise < float(std::uint32_t(1) << std::min(tried_polygons_ / trial_polygons_, 30u)))
            return false;
        tried_polygons_ += polygons;
        return true;
    }

    /// It is to be drawn. What then cannot be drawn hides nothing and rests.
    void was_chosen(std::uint32_t patch) { chosen_.push_back(patch); }

    /// The patch had a share in hiding something; the shares of one thing sum to 1.
    void credit(std::uint32_t patch, float share) { gained_[patch] += share; }

    /// Those that hid too little rest.
    void end_frame(const PatchStore& store) {
        for (std::uint32_t patch : chosen_) {
            float now = gained_[patch] / float(store.patches[patch].polygon_count);
            gained_[patch] = 0;
            float average = has_paid(patch) ? kMemory * value_[patch] + (1 - kMemory) * now : now;
            value_[patch] = average;
            if (average < kLeastValue) {
                value_[patch] = 0;
                rested_[patch] = frame_;
            }
        }
    }

  private:
    static constexpr std::uint32_t kRest = 48;           ///< frames until a patch that hid too little is tried again
    static constexpr std::uint32_t kTrialPolygons = 128, kFirstTrialPolygons = 512; ///< see may_try()
    static constexpr float kLeastValue = 0.2f;           ///< boxes hidden per polygon and frame
    static constexpr double kStride = 1.0 / 64, kTurn = 0.866; ///< of the scene; cosine: where another view begins
    static constexpr float kMemory = 0.75f;              ///< of the average, per frame

    std::vector<float> value_;  ///< per patch: boxes hidden per polygon and frame, moving average; 0: has not paid
    std::vector<float> gained_; ///< of this frame, not yet by polygon; 0 between frames
    std::vector<std::uint32_t> rested_; ///< frame in which its last rest began
    std::vector<std::uint32_t> chosen_;
    std::uint32_t tried_polygons_ = 0, trial_polygons_ = kFirstTrialPolygons;
    std::uint32_t frame_ = 0;
    Vec3d eye_, forward_; ///< of the first frame since the rests were last ended
};

} // namespace antumbra
