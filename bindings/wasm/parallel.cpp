// A module has one thread: units run one after the other. In place of src/base/parallel.cpp.
#include "base/parallel.hpp"

namespace antumbra {

unsigned worker_count(const Job&) { return 1; }

void parallel_for(std::size_t count, const Job& job, const std::function<void(std::size_t, unsigned)>& unit) {
    for (std::size_t index = 0; index < count && !job.cancelled(); ++index)
        unit(index, 0);
}

} // namespace antumbra
