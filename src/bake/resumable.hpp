// A bake as independent units (cells, tiles), computed in parallel, kept in a checkpoint, in any order.
#pragma once

#include <antumbra/bake.hpp>

#include <cstddef>
#include <functional>
#include <span>
#include <string>
#include <vector>

namespace antumbra {

/// A unit's result as bytes: what the checkpoint keeps.
using Payload = std::vector<std::byte>;

struct Units {
    std::string stage, unit_name;   ///< for Progress, e.g. "bake", "cells"
    std::vector<std::uint64_t> ids; ///< names of the units, unique
    /// A pure function of the unit; called from any thread. Empty: it was stopped half-way, and is not finished.
    std::function<Payload(std::size_t index)> compute;
    /// Whether the payload of a unit read from a checkpoint is one that compute could have made.
    std::function<bool(std::size_t index, std::span<const std::byte>)> acceptable;
};

struct UnitResults {
    std::vector<Payload> payloads; ///< by index
    std::uint64_t resumed = 0;     ///< units taken from the checkpoint
    std::vector<bool> was_resumed; ///< by index: which
};

/// Computes every unit that the checkpoint does not hold. `key` names everything that the results depend on.
/// ErrorCode::cancelled after Job::cancel, with finished units kept if options.checkpoint names a file; io if the
/// checkpoint cannot be written.
Result<UnitResults> run_units(const Units& units, const std::string& key, const BakeOptions& options, const Job& job);

} // namespace antumbra
