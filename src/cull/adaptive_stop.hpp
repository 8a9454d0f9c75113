// The adaptive stop of `opacity` (Poon, Wang 1999, 5.2): how little a node may be covered before the tests below it are
// given up, moved by what culling costs and saves. Only ever decides what is tested, never what is hidden.
#pragma once

#include <algorithm>
#include <cstdint>

namespace antumbra {

class AdaptiveStop {
  public:
    explicit AdaptiveStop(float least) : least_(least), stop_(least) {}

    /// A node covered to a lesser share is not tested further down. Above 1: not even what is half covered.
    float stop_below() const { return stop_; }
    /// Once per frame: is this one of the frames that the method sits out?
    bool sits_out() {
        if (wait_ == 0)
            return false;
        --wait_;
        return true;
    }
    /// Would hiding all that lay in the frustum of the last frame hardly pay for drawing a map? Then it is worth looking
    /// first at what the frustum holds now. True before the first frame.
    bool doubts() const { return possible_ < kLeastCost; }
    /// What it saves to hide all that lies in the frustum, in seconds.
    void learn_possible(double seconds) { possible_ = seconds; }

    /// After a frame: what it cost, and what drawing less saved, in any one unit.
    void learn(double cost, double saved) {
        if (cost <= saved) {
            stop_ = std::max(stop_ * 0.75f, least_);
            wait_ = 0;
            pause_ = 1;
            return;
        }
        // Begins where a threshold of nothing could never rise from.
        stop_ = std::max(stop_, 0.1f) * 1.5f;
        if (stop_ > 1) {
            stop_ = 1;
            wait_ = pause_;
            pause_ = std::min<std::uint32_t>(pause_ * 2, kLongestPause);
        }
    }

    static constexpr std::uint32_t kLongestPause = 64;
    static constexpr double kLeastCost = 30e-6; ///< seconds; no map is drawn and asked in less

  private:
    float least_, stop_;
    std::uint32_t wait_ = 0, pause_ = 1;
    double possible_ = 0;
};

} // namespace antumbra
