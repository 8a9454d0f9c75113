// From samples to the numbers of a table.
#pragma once

#include <antumbra/evaluate.hpp>

namespace antumbra {

/// The middle value, of two the mean; -1 of nothing.
double median(std::vector<double> values);

/// The smallest value that at least `share` (0..1] of the values do not exceed; -1 of nothing.
double percentile(std::vector<double> values, double share);

/// Fills the summaries of `result` (all but names and guarantees) from its frames.
void summarise(WalkResult& result);

} // namespace antumbra
