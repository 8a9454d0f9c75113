// What every reader of a file in memory does around its work.
#pragma once

#include <antumbra/import.hpp>
#include <antumbra/scene.hpp>

#include <cstddef>
#include <new>
#include <span>
#include <string>

namespace antumbra {

/// Calls `read` (returns Result<RawScene>) once `bytes` are some and within the limit. Errors are named after the file;
/// running out of memory is ErrorCode::limit.
template <class Read>
Result<RawScene> import_bytes(std::span<const std::byte> bytes, const std::string& name, const ImportOptions& options,
                              Read&& read) try {
    if (bytes.empty())
        return Status(ErrorCode::corrupt, name + ": the file is empty");
    if (bytes.size() > options.limits.bytes)
        return Status(ErrorCode::limit, name + ": has " + std::to_string(bytes.size()) +
                                            " bytes, more than the limit of " + std::to_string(options.limits.bytes));
    Result<RawScene> raw = read();
    if (!raw)
        return raw.status().in(name);
    raw->source = name;
    return raw;
} catch (const std::bad_alloc&) {
    return Status(ErrorCode::limit, name + ": not enough memory");
}

} // namespace antumbra
