// The only place that touches the disk.
#pragma once

#include <antumbra/status.hpp>

#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

namespace antumbra {

/// A whole file, mapped read-only where the system can. Movable; the bytes live as long as it does.
class MappedFile {
  public:
    /// ErrorCode::io (message names the file), or limit if it has more than `max_bytes`.
    static Result<MappedFile> open(const std::string& path, std::uint64_t max_bytes = UINT64_MAX);
    MappedFile(MappedFile&& other) noexcept;
    MappedFile& operator=(MappedFile&& other) noexcept;
    ~MappedFile();
    std::span<const std::byte> bytes() const { return {data_, size_}; }

  private:
    MappedFile() = default;
    const std::byte* data_ = nullptr;
    std::size_t size_ = 0;
};

/// Writes to a temporary name in the same folder, syncs, renames over `path`, syncs the folder: after a crash
/// there is the old file or the new one, never neither.
Status write_file_atomically(const std::string& path, std::span<const std::byte> bytes);
Status write_file_atomically(const std::string& path, std::string_view text);

/// Appends records to a log; each append is handed to the system whole.
class AppendFile {
  public:
    /// Opens or creates; keeps the first `keep_bytes` bytes and drops what follows.
    static Result<AppendFile> open(const std::string& path, std::uint64_t keep_bytes);
    AppendFile(AppendFile&& other) noexcept;
    AppendFile& operator=(AppendFile&& other) noexcept;
    ~AppendFile();
    Status append(std::span<const std::byte> bytes);
    Status sync();

  private:
    AppendFile() = default;
    int descriptor_ = -1;
    std::string path_;
};

Status remove_file(const std::string& path);
bool file_exists(const std::string& path);
/// The absolute path with every link followed; ErrorCode::io if there is no such file.
Result<std::string> real_path(const std::string& path);

} // namespace antumbra
