#include "base/parallel.hpp"

#include <algorithm>
#include <thread>
#include <vector>

namespace antumbra {

unsigned worker_count(const Job& job) {
    return job.threads ? job.threads : std::max(1u, std::thread::hardware_concurrency());
}

void parallel_for(std::size_t count, const Job& job, const std::function<void(std::size_t, unsigned)>& unit) {
    std::atomic<std::size_t> next{0};
    auto work = [&](unsigned worker) {
        while (!job.cancelled()) {
            std::size_t index = next.fetch_add(1, std::memory_order_relaxed);
            if (index >= count)
                return;
            unit(index, worker);
        }
    };
    unsigned workers = static_cast<unsigned>(std::min<std::size_t>(worker_count(job), std::max<std::size_t>(count, 1)));
    std::vector<std::thread> threads;
    for (unsigned worker = 1; worker < workers; ++worker)
        threads.emplace_back(work, worker);
    work(0);
    for (std::thread& thread : threads)
        thread.join();
}

} // namespace antumbra
