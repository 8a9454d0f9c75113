#include "bake/sampled/sequential_test.hpp"

#include <algorithm>
#include <limits>

namespace antumbra {
namespace {

/// base^exponent by squaring: a fixed order of products.
double power(double base, std::uint32_t exponent) {
    double result = 1;
    for (; exponent; exponent >>= 1, base *= base)
        if (exponent & 1)
            result *= base;
    return result;
}

/// P(first <= X <= last) for X ~ Binomial(n, s), 0 < s < 1; terms by their ratios, from the smaller index up.
double binomial_sum(std::uint32_t n, double s, std::uint32_t first, std::uint32_t last) {
    double term = power(1 - s, n), sum = 0;
    for (std::uint32_t i = 0; i <= last; ++i) {
        if (i >= first)
            sum += term;
        term *= double(n - i) / double(i + 1) * (s / (1 - s));
    }
    return sum;
}

} // namespace

double sprt_ratio(const SprtOptions& options, std::uint32_t hits, std::uint32_t rays) {
    double s_t = options.s_t;
    if (options.reading == SprtReading::wald)
        return power(options.s_1 / s_t, hits) * power((1 - options.s_1) / (1 - s_t), rays - hits);
    // I = I_{s_t}(h+1, r-h+1) = P(X > h) for X ~ Binomial(r+1, s_t), and 1-I = P(X <= h).
    double below = binomial_sum(rays + 1, s_t, 0, hits);
    double above = binomial_sum(rays + 1, s_t, hits + 1, rays + 1);
    double ratio = above > 0 ? below / above : std::numeric_limits<double>::infinity();
    return options.reading == SprtReading::printed ? ratio : ratio * s_t / (1 - s_t);
}

SequentialTest::SequentialTest(const SprtOptions& options) : b_(options.b), give_up_(options.most_rays) {
    // The ratio grows with the hits and falls with the rays, so both bounds only grow along the rays.
    std::uint32_t visible_from = 1, invisible_to = 0;
    for (std::uint32_t rays = 0; rays <= options.most_rays; ++rays) {
        auto ratio = [&](std::uint32_t hits) { return sprt_ratio(options, hits, rays); };
        ratio_without_hit_.push_back(ratio(0));
        while (invisible_to <= rays && ratio(invisible_to) < options.b)
            ++invisible_to;
        while (visible_from <= rays && ratio(visible_from) <= options.a)
            ++visible_from;
        bounds_.push_back({visible_from, invisible_to});
        if (invisible_to > 0) {
            give_up_ = std::min(give_up_, rays);
            // Beyond a few hundred rays after the first decision, hits decide at once.
            if (rays > give_up_ + 256)
                break;
        }
    }
}

SprtDecision SequentialTest::decide(std::uint32_t hits, std::uint32_t rays) const {
    if (rays >= bounds_.size())
        return hits > 0 ? SprtDecision::visible : SprtDecision::invisible;
    const Bounds& bounds = bounds_[rays];
    if (hits < bounds.invisible_to)
        return SprtDecision::invisible;
    if (hits >= bounds.visible_from && hits > 0)
        return SprtDecision::visible;
    return rays + 1 >= bounds_.size() ? (hits > 0 ? SprtDecision::visible : SprtDecision::invisible)
                                      : SprtDecision::go_on;
}

std::uint32_t SequentialTest::misses_to_give_up(double odds) const {
    auto below = [&](double ratio) { return ratio * odds < b_; };
    auto first = std::find_if(ratio_without_hit_.begin(), ratio_without_hit_.end(), below);
    return std::uint32_t(first - ratio_without_hit_.begin());
}

double SequentialTest::miss_probability(double s, std::uint32_t rays) { return power(1 - s, rays); }

} // namespace antumbra
