// Long work: how it reports progress and how it is asked to stop.
#pragma once

#include <atomic>
#include <cstdint>
#include <functional>

namespace antumbra {

struct Progress {
    const char* stage = "";   ///< what is being done, e.g. "bake"
    std::uint64_t done = 0;   ///< units finished, resumed ones included
    std::uint64_t total = 0;  ///< units in all
    const char* unit = "";    ///< what a unit is, e.g. "cells"
};

/// Handed to every long call. `progress` is called from one thread at a time; `cancel`, once true, ends the work
/// after the units under way, and the call returns ErrorCode::cancelled having kept what was finished.
struct Job {
    unsigned threads = 0; ///< 0: one per hardware thread. No result depends on it.
    std::function<void(const Progress&)> progress;
    const std::atomic<bool>* cancel = nullptr;

    bool cancelled() const { return cancel && cancel->load(std::memory_order_relaxed); }
};

} // namespace antumbra
