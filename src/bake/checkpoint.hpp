// The log of finished cells that makes a bake resumable: append-only, one checked record per cell.
//
// Layout, little-endian: "ANTPART1", u32 size and CRC-32C of the key, the key, then records of
// u64 cell, u32 payload bytes, u32 CRC-32C over cell, size and payload, payload.
#pragma once

#include "base/file.hpp"

#include <map>
#include <memory>
#include <mutex>

namespace antumbra {

/// Thread-safe. Records may be appended in any order.
class Checkpoint {
  public:
    using Records = std::map<std::uint64_t, std::vector<std::byte>>;

    /// Opens `path`. With `resume`, and if the file was written under the same `key` (which names scene, options and
    /// grid), its intact records go to `records` and a torn tail is cut off; a file of another key is
    /// ErrorCode::mismatch. Without `resume` the file is begun anew.
    static Result<std::unique_ptr<Checkpoint>> open(const std::string& path, const std::string& key, bool resume,
                                                    Records& records);
    Status append(std::uint64_t cell, std::span<const std::byte> payload);
    Status sync();

  private:
    explicit Checkpoint(AppendFile file) : file_(std::move(file)) {}
    std::mutex mutex_;
    AppendFile file_;
};

} // namespace antumbra
