#include "base/file.hpp"

#include <cerrno>
#include <cstdlib>
#include <cstring>
#include <fcntl.h>
#include <sys/mman.h>
#include <sys/stat.h>
#include <unistd.h>

namespace antumbra {
namespace {

Status system_error(const std::string& path, const char* action) {
    return {ErrorCode::io, path + ": cannot " + action + ": " + std::strerror(errno)};
}

Status write_all(int descriptor, std::span<const std::byte> bytes, const std::string& path) {
    while (!bytes.empty()) {
        ssize_t written = ::write(descriptor, bytes.data(), bytes.size());
        if (written < 0 && errno == EINTR)
            continue;
        if (written < 0)
            return system_error(path, "write");
        bytes = bytes.subspan(static_cast<std::size_t>(written));
    }
    return {};
}

std::string folder_of(const std::string& path) {
    std::size_t slash = path.find_last_of('/');
    return slash == std::string::npos ? "." : slash == 0 ? "/" : path.substr(0, slash);
}

Status sync_folder_of(const std::string& path) {
    std::string folder = folder_of(path);
    int descriptor = ::open(folder.c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC);
    if (descriptor < 0)
        return system_error(folder, "open folder");
    // Some file systems cannot sync folders (EINVAL); there the rename is as durable as they make it.
    bool failed = ::fsync(descriptor) != 0 && errno != EINVAL;
    Status status = failed ? system_error(folder, "sync folder") : Status();
    ::close(descriptor);
    return status;
}

} // namespace

Result<MappedFile> MappedFile::open(const std::string& path, std::uint64_t max_bytes) {
    // Non-blocking, for opening a pipe would wait for its writer; regular files do not care.
    int descriptor = ::open(path.c_str(), O_RDONLY | O_CLOEXEC | O_NONBLOCK);
    if (descriptor < 0)
        return system_error(path, "open");
    struct stat info {};
    if (::fstat(descriptor, &info) != 0 || !S_ISREG(info.st_mode)) {
        ::close(descriptor);
        return Status(ErrorCode::io, path + ": is not a regular file");
    }
    if (static_cast<std::uint64_t>(info.st_size) > max_bytes) {
        ::close(descriptor);
        return Status(ErrorCode::limit, path + ": has " + std::to_string(info.st_size) +
                                            " bytes, more than the limit of " + std::to_string(max_bytes));
    }
    MappedFile file;
    file.size_ = static_cast<std::size_t>(info.st_size);
    if (file.size_ > 0) {
        void* data = ::mmap(nullptr, file.size_, PROT_READ, MAP_PRIVATE, descriptor, 0);
        if (data == MAP_FAILED) {
            Status status = system_error(path, "map");
            ::close(descriptor);
            file.size_ = 0;
            return status;
        }
        file.data_ = static_cast<const std::byte*>(data);
    }
    ::close(descriptor);
    return file;
}

MappedFile::MappedFile(MappedFile&& other) noexcept
    : data_(std::exchange(other.data_, nullptr)), size_(std::exchange(other.size_, 0)) {}

MappedFile& MappedFile::operator=(MappedFile&& other) noexcept {
    std::swap(data_, other.data_);
    std::swap(size_, other.size_);
    return *this;
}

MappedFile::~MappedFile() {
    if (data_)
        ::munmap(const_cast<std::byte*>(data_), size_);
}

Status write_file_atomically(const std::string& path, std::span<const std::byte> bytes) {
    std::string temporary = path + ".tmp" + std::to_string(::getpid());
    int descriptor = ::open(temporary.c_str(), O_WRONLY | O_CREAT | O_TRUNC | O_CLOEXEC, 0644);
    if (descriptor < 0)
        return system_error(path, "create");
    Status status = write_all(descriptor, bytes, path);
    if (status && ::fsync(descriptor) != 0)
        status = system_error(path, "sync");
    if (::close(descriptor) != 0 && status)
        status = system_error(path, "close");
    if (status && ::rename(temporary.c_str(), path.c_str()) != 0)
        status = system_error(path, "rename to");
    if (!status) {
        ::unlink(temporary.c_str());
        return status;
    }
    return sync_folder_of(path);
}

Status write_file_atomically(const std::string& path, std::string_view text) {
    return write_file_atomically(path, std::as_bytes(std::span(text.data(), text.size())));
}

Result<AppendFile> AppendFile::open(const std::string& path, std::uint64_t keep_bytes) {
    AppendFile file;
    file.path_ = path;
    file.descriptor_ = ::open(path.c_str(), O_WRONLY | O_CREAT | O_CLOEXEC, 0644);
    if (file.descriptor_ < 0)
        return system_error(path, "create");
    if (::ftruncate(file.descriptor_, static_cast<off_t>(keep_bytes)) != 0 ||
        ::lseek(file.descriptor_, 0, SEEK_END) < 0)
        return system_error(path, "truncate");
    return file;
}

AppendFile::AppendFile(AppendFile&& other) noexcept
    : descriptor_(std::exchange(other.descriptor_, -1)), path_(std::move(other.path_)) {}

AppendFile& AppendFile::operator=(AppendFile&& other) noexcept {
    std::swap(descriptor_, other.descriptor_);
    std::swap(path_, other.path_);
    return *this;
}

AppendFile::~AppendFile() {
    if (descriptor_ >= 0)
        ::close(descriptor_);
}

Status AppendFile::append(std::span<const std::byte> bytes) { return write_all(descriptor_, bytes, path_); }

Status AppendFile::sync() {
    return ::fdatasync(descriptor_) == 0 ? Status() : system_error(path_, "sync");
}

Status remove_file(const std::string& path) {
    return ::unlink(path.c_str()) == 0 || errno == ENOENT ? Status() : system_error(path, "remove");
}

bool file_exists(const std::string& path) { return ::access(path.c_str(), F_OK) == 0; }

Result<std::string> real_path(const std::string& path) {
    char* found = ::realpath(path.c_str(), nullptr);
    if (!found)
        return system_error(path, "find");
    std::string text = found;
    std::free(found);
    return text;
}

} // namespace antumbra
