#include "bake/binomial.hpp"

#include <cmath>

namespace antumbra {
namespace {

/// P(X <= events) for X ~ Binomial(trials, p), summed in logarithms from the largest term down.
double lower_tail(std::uint64_t events, std::uint64_t trials, double p) {
    double n = double(trials), k = double(events);
    double log_term = std::lgamma(n + 1) - std::lgamma(k + 1) - std::lgamma(n - k + 1) + k * std::log(p) +
                      (n - k) * std::log1p(-p);
    // Below the mean the terms fall away from `events` downwards; each is the one above times this ratio.
    double sum = 0, scale = 1;
    for (double i = k; i >= 0; --i) {
        sum += scale;
        scale *= i / (n - i + 1) * (1 - p) / p;
        if (scale < 1e-18 * sum)
            break;
    }
    return std::exp(log_term) * sum;
}

} // namespace

double clopper_pearson_upper(std::uint64_t events, std::uint64_t trials, double confidence) {
    if (events >= trials)
        return 1;
    double low = double(events) / double(trials), high = 1;
    for (int step = 0; step < 100; ++step) {
        double middle = (low + high) / 2;
        (lower_tail(events, trials, middle) > 1 - confidence ? low : high) = middle;
    }
    return high;
}

} // namespace antumbra
