// One loop over independent units. Results must not depend on the order in which units run.
#pragma once

#include <antumbra/job.hpp>

#include <cstddef>
#include <functional>

namespace antumbra {

/// Number of workers that job.threads asks for, at least 1.
unsigned worker_count(const Job& job);

/// Calls unit(index, worker) for index in [0, count), in parallel, worker in [0, worker_count(job)). Stops handing
/// out units once job.cancelled(). `unit` must not throw.
void parallel_for(std::size_t count, const Job& job, const std::function<void(std::size_t, unsigned)>& unit);

} // namespace antumbra
