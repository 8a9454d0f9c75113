// The sequential test of Gotsman, Sudarsky, Fayman 1999, section 5: how many rays tell whether an object is visible
// from a cell.
//
// Of r rays aimed at the object, h hit it first. The object's true share s of such rays is unknown. The ratio of the
// likelihoods of "visible" (s above the threshold s_t) and "invisible" decides once it leaves [B, A]. The paper's text
// allows three readings (SprtReading); all three are built (docs/methods/five_dimensional.md).
// Every sum is over integers and products of doubles in a fixed order: no libm, the same decisions everywhere.
#pragma once

#include <antumbra/bake.hpp>

#include <cstdint>
#include <vector>

namespace antumbra {

/// Thresholds by Wald from stated error rates: `alpha` of calling an object of share s_t visible, `beta` of losing one
/// of share s_1.
struct WaldThresholds {
    double a, b;
};
constexpr WaldThresholds wald_thresholds(double alpha, double beta) {
    return {(1 - beta) / alpha, beta / (1 - alpha)};
}

/// Likelihood ratio after h hits in r rays, 0 <= h <= r. O(r).
double sprt_ratio(const SprtOptions& options, std::uint32_t hits, std::uint32_t rays);

enum class SprtDecision : std::uint8_t { go_on, visible, invisible };

/// Decisions by table look-up. Immutable, thread-safe.
class SequentialTest {
  public:
    explicit SequentialTest(const SprtOptions& options);
    /// "visible" always needs a hit, whatever the ratio says.
    SprtDecision decide(std::uint32_t hits, std::uint32_t rays) const;
    /// Misses in a row after which an object that was never hit is given up.
    std::uint32_t misses_to_give_up() const { return give_up_; }
    /// The same if "visible" was `odds` times as likely as "invisible" before the first ray.
    std::uint32_t misses_to_give_up(double odds) const;
    /// Probability that none of `rays` rays hits an object of share s.
    static double miss_probability(double s, std::uint32_t rays);

  private:
    struct Bounds {
        std::uint32_t visible_from; ///< hits needed to say visible after so many rays
        std::uint32_t invisible_to; ///< hits at which it is given up, plus one; 0: not yet
    };
    std::vector<Bounds> bounds_; ///< by rays
    std::vector<double> ratio_without_hit_; ///< by rays
    double b_;
    std::uint32_t give_up_;
};

} // namespace antumbra
