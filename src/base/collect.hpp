// A loop over independent units each of which gives a part of the result.
#pragma once

#include "base/parallel.hpp"

#include <antumbra/status.hpp>

#include <mutex>
#include <string>
#include <vector>

namespace antumbra {

/// Calls `unit(index, worker)` for index in [0, count), in parallel, and `take(index, part)` with what it gives, one at a
/// time, in any order: sums and slots by index do not depend on it. Reports progress. ErrorCode::cancelled if stopped.
template <class Unit, class Take>
Status collect(std::size_t count, const Job& job, const char* stage, const char* units, const Unit& unit, const Take& take) {
    std::mutex mutex;
    std::uint64_t done = 0;
    parallel_for(count, job, [&](std::size_t index, unsigned worker) {
        auto part = unit(index, worker);
        std::lock_guard lock(mutex);
        take(index, std::move(part));
        if (++done; job.progress)
            job.progress({stage, done, count, units});
    });
    if (job.cancelled())
        return {ErrorCode::cancelled, "stopped after " + std::to_string(done) + " of " + std::to_string(count) + " " + units};
    return {};
}

/// The first that is not empty, or "".
inline std::string first_problem(const std::vector<std::string>& problems) {
    for (const std::string& problem : problems)
        if (!problem.empty())
            return problem;
    return {};
}

} // namespace antumbra
