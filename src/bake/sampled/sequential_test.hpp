// The sequential test of Gotsman, Sudarsky, Fayman 1999, section 5: how many rays tell whether an object is visible
// from a cell.
//
// Of r rays aimed at the object, h hit it first. The object's true share s of such rays is unknown. The ratio of the
// likelihoods of "visible" (s above the threshold s_t) and "invisible" decides once it leaves [B, A]. The paper's text
// allows three readings, which differ in what each likelihood is; all three are built (docs/methods/five_dimensional.md).
// Every sum is over integers and products of doubles in a fixed order: no libm, the same decisions everywhere.
#pragma once

#include <cstdint>
#include <vector>

namespace antumbra {

enum class SprtReading : std::uint8_t {
    wald,       ///< simple against simple: s_1 against s_t
    printed,    ///< the paper's integrals as printed: each over its interval, a uniform prior over [0, 1]
    normalised, ///< each likelihood averaged over its own interval
};

struct SprtOptions {
    SprtReading reading = SprtReading::wald;
    double s_t = 0.01; ///< share below which an object need not be found
    double s_1 = 0.1;  ///< share at which it should be (wald)
    double a = 50;     ///< "visible" above this ratio
    double b = 0.2;    ///< "invisible" below this ratio
    /// Pseudo-observations known before the first ray: a Beta prior in units of rays. Shifts the ratio by a factor.
    double prior_ratio = 1;
    std::uint32_t most_rays = 4096; ///< undecided by then: invisible without a hit, else visible

    bool operator==(const SprtOptions&) const = default;
};

/// Thresholds by Wald from stated error rates: `alpha` of calling an object of share s_t visible, `beta` of losing one
/// of share s_1.
struct WaldThresholds {
    double a, b;
};
constexpr WaldThresholds wald_thresholds(double alpha, double beta) {
    return {(1 - beta) / alpha, beta / (1 - alpha)};
}

/// Likelihood ratio after h hits in r rays, 0 <= h <= r. Without prior_ratio. O(r).
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
    /// Probability of losing an object of share s: that none of those rays hits.
    double miss_probability(double s) const;

  private:
    struct Bounds {
        std::uint32_t visible_from; ///< hits needed to say visible after so many rays
        std::uint32_t invisible_to; ///< hits at which it is given up, plus one; 0: not yet
    };
    std::vector<Bounds> bounds_; ///< by rays
    std::uint32_t give_up_;
};

} // namespace antumbra
