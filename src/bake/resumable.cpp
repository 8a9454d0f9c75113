#include "bake/resumable.hpp"

#include "bake/checkpoint.hpp"
#include "base/parallel.hpp"

#include <mutex>

namespace antumbra {

Result<UnitResults> run_units(const Units& units, const std::string& key, const BakeOptions& options, const Job& job) {
    Checkpoint::Records records;
    std::unique_ptr<Checkpoint> checkpoint;
    if (!options.checkpoint.empty()) {
        auto opened = Checkpoint::open(options.checkpoint, key, options.resume, records);
        if (!opened)
            return opened.status();
        checkpoint = std::move(*opened);
    }
    UnitResults results;
    results.payloads.resize(units.ids.size());
    results.was_resumed.resize(units.ids.size());
    std::vector<std::size_t> open;
    for (std::size_t i = 0; i < units.ids.size(); ++i) {
        auto record = records.find(units.ids[i]);
        if (record != records.end() && units.acceptable(i, record->second)) {
            results.payloads[i] = std::move(record->second);
            results.was_resumed[i] = true;
        } else
            open.push_back(i);
    }
    results.resumed = units.ids.size() - open.size();
    records.clear();

    std::mutex mutex;
    Status failure;
    std::size_t done = results.resumed;
    std::atomic<bool> stop{false};
    parallel_for(open.size(), job, [&](std::size_t index, unsigned) {
        if (stop.load(std::memory_order_relaxed))
            return;
        std::size_t i = open[index];
        Payload payload = units.compute(i);
        if (payload.empty())
            return;
        Status appended = checkpoint ? checkpoint->append(units.ids[i], payload) : Status();
        std::scoped_lock lock(mutex);
        results.payloads[i] = std::move(payload);
        if (!appended.ok()) {
            failure = appended;
            stop = true;
        }
        ++done;
        if (job.progress)
            job.progress({units.stage.c_str(), done, units.ids.size(), units.unit_name.c_str()});
    });
    if (!failure.ok())
        return failure;
    if (checkpoint)
        if (Status status = checkpoint->sync(); !status)
            return status;
    if (done < units.ids.size())
        return Status(ErrorCode::cancelled,
                      "stopped after " + std::to_string(done) + " of " + std::to_string(units.ids.size()) + " " +
                          units.unit_name + (checkpoint ? "; go on with --resume" : ""));
    return results;
}

} // namespace antumbra
