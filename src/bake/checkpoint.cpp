#include "bake/checkpoint.hpp"

#include "base/crc32c.hpp"

#include <cstring>

namespace antumbra {
namespace {

constexpr char kMagic[8] = {'A', 'N', 'T', 'P', 'A', 'R', 'T', '1'};
constexpr std::size_t kRecordHeader = 16;

template <class T>
void put(std::vector<std::byte>& bytes, T value) {
    for (std::size_t i = 0; i < sizeof(T); ++i)
        bytes.push_back(std::byte(value >> (8 * i) & 0xFF));
}

template <class T>
T get(std::span<const std::byte> bytes, std::size_t at) {
    T value = 0;
    for (std::size_t i = 0; i < sizeof(T); ++i)
        value |= T(std::to_integer<T>(bytes[at + i])) << (8 * i);
    return value;
}

std::vector<std::byte> make_header(const std::string& key) {
    std::vector<std::byte> header;
    for (char c : kMagic)
        header.push_back(std::byte(c));
    std::span<const std::byte> bytes = std::as_bytes(std::span(key));
    put(header, std::uint32_t(bytes.size()));
    put(header, crc32c(bytes));
    header.insert(header.end(), bytes.begin(), bytes.end());
    return header;
}

std::vector<std::byte> make_record(std::uint64_t cell, std::span<const std::byte> payload) {
    std::vector<std::byte> record;
    record.reserve(kRecordHeader + payload.size());
    put(record, cell);
    put(record, std::uint32_t(payload.size()));
    std::uint32_t crc = crc32c(payload, crc32c(record));
    put(record, crc);
    record.insert(record.end(), payload.begin(), payload.end());
    return record;
}

/// Length of the intact part; its records go to `records`.
std::size_t replay(std::span<const std::byte> bytes, std::size_t at, Checkpoint::Records& records) {
    while (bytes.size() - at >= kRecordHeader) {
        auto cell = get<std::uint64_t>(bytes, at);
        auto size = get<std::uint32_t>(bytes, at + 8);
        auto crc = get<std::uint32_t>(bytes, at + 12);
        if (bytes.size() - at - kRecordHeader < size)
            break;
        std::span<const std::byte> payload = bytes.subspan(at + kRecordHeader, size);
        if (crc32c(payload, crc32c(bytes.subspan(at, 12))) != crc)
            break;
        records[cell].assign(payload.begin(), payload.end());
        at += kRecordHeader + size;
    }
    return at;
}

} // namespace

Result<std::unique_ptr<Checkpoint>> Checkpoint::open(const std::string& path, const std::string& key, bool resume,
                                                     Records& records) {
    std::vector<std::byte> header = make_header(key);
    std::uint64_t keep = 0;
    if (resume && file_exists(path)) {
        Result<MappedFile> old = MappedFile::open(path);
        if (!old)
            return old.status();
        std::span<const std::byte> bytes = old->bytes();
        bool begun = bytes.size() >= header.size();
        if (begun && std::memcmp(bytes.data(), header.data(), header.size()) == 0)
            keep = replay(bytes, header.size(), records);
        else if (begun)
            return Status(ErrorCode::mismatch, path + ": belongs to a bake of another scene or with other options; "
                                                      "use the same ones, or delete it to start anew");
    }
    Result<AppendFile> file = AppendFile::open(path, keep);
    if (!file)
        return file.status();
    if (keep == 0)
        if (Status status = file->append(header); !status)
            return status;
    return std::unique_ptr<Checkpoint>(new Checkpoint(std::move(*file)));
}

Status Checkpoint::append(std::uint64_t cell, std::span<const std::byte> payload) {
    std::vector<std::byte> record = make_record(cell, payload);
    std::scoped_lock lock(mutex_);
    return file_.append(record);
}

Status Checkpoint::sync() {
    std::scoped_lock lock(mutex_);
    return file_.sync();
}

} // namespace antumbra
