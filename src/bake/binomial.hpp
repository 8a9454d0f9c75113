// Exact binomial bounds for measured rates.
#pragma once

#include <cstdint>

namespace antumbra {

/// The one-sided Clopper-Pearson upper bound: the largest probability p under which `events` or fewer in `trials`
/// still has a chance of at least 1 - confidence. 1 without trials. Accurate to about 1e-9 relative.
double clopper_pearson_upper(std::uint64_t events, std::uint64_t trials, double confidence);

} // namespace antumbra
