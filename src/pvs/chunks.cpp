#include "pvs/chunks.hpp"

#include "base/bytes.hpp"
#include "base/crc32c.hpp"

#include <algorithm>
#include <array>

namespace antumbra {
namespace {

// The first byte is no ASCII, the line ends and the end-of-file mark notice text-mode copying (as in PNG).
constexpr std::array<std::uint8_t, 8> kMagic{0x89, 'P', 'V', 'S', '\r', '\n', 0x1A, '\n'};
constexpr std::size_t kFileBytesAt = 16, kChunkCountAt = 24, kHeaderCrcAt = 28;

struct Entry {
    ChunkId id;
    std::uint32_t flags, crc;
    std::uint64_t offset, bytes;
};

Status corrupt(const std::string& where, const std::string& what) {
    return {ErrorCode::corrupt, where + ": " + what + "; the file is damaged, copy or bake it again"};
}

std::string place(ChunkId id, std::size_t index) {
    return "chunk " + to_string(id) + " (number " + std::to_string(index) + ")";
}

constexpr std::uint64_t aligned(std::uint64_t offset) {
    return (offset + kChunkAlignment - 1) / kChunkAlignment * kChunkAlignment;
}

Entry read_entry(std::span<const std::byte> file, std::size_t index) {
    std::size_t at = kHeaderBytes + index * kTableEntryBytes;
    return {ChunkId(load_u32(file, at)), load_u32(file, at + 4), load_u32(file, at + 8), load_u64(file, at + 16),
            load_u64(file, at + 24)};
}

/// The CRC of header and table, taken as if its own four bytes were zero.
std::uint32_t header_crc(std::span<const std::byte> header_and_table) {
    constexpr std::array<std::byte, 4> zeros{};
    std::uint32_t crc = crc32c(header_and_table.first(kHeaderCrcAt));
    crc = crc32c(zeros, crc);
    return crc32c(header_and_table.subspan(kHeaderCrcAt + 4), crc);
}

/// Magic, versions, table size and header CRC; returns the number of chunks.
Result<std::uint32_t> check_header(std::span<const std::byte> file) {
    if (file.size() < kHeaderBytes)
        return corrupt("header", "the file has " + std::to_string(file.size()) + " bytes and ends inside it");
    for (std::size_t i = 0; i < kMagic.size(); ++i)
        if (std::uint8_t(file[i]) != kMagic[i])
            return Status(ErrorCode::corrupt, "header: this is not a .pvs file (its first eight bytes are wrong)");
    // Before the CRC: a later major version may sum other bytes.
    if (std::uint16_t major = load_u16(file, 8); major != kMajorVersion)
        return Status(ErrorCode::unsupported, "header: format version " + std::to_string(major) +
                                                  " cannot be read by this program, which knows version " +
                                                  std::to_string(kMajorVersion) + "; use a matching one");
    std::uint32_t count = load_u32(file, kChunkCountAt);
    if (count > (file.size() - kHeaderBytes) / kTableEntryBytes)
        return corrupt("chunk table", "it is cut off or its length is wrong");
    std::size_t table_end = kHeaderBytes + count * kTableEntryBytes;
    if (header_crc(file.first(table_end)) != load_u32(file, kHeaderCrcAt))
        return corrupt("header or chunk table", "its checksum is wrong");
    if (std::uint16_t needed = load_u16(file, 12); needed > kMinorVersion)
        return Status(ErrorCode::unsupported, "header: reading this file needs a program that knows format version " +
                                                  std::to_string(kMajorVersion) + "." + std::to_string(needed));
    return count;
}

/// Bounds, order and padding of one chunk; `end` is where the one before it ends, and is moved on.
Status check_place(std::span<const std::byte> file, const Entry& entry, std::size_t index, std::uint64_t& end) {
    std::string where = place(entry.id, index);
    if (entry.offset != aligned(end))
        return corrupt(where, "it does not follow the chunk before it");
    if (entry.bytes > kMaxChunkBytes)
        return corrupt(where, "it is larger than a chunk may be");
    if (entry.offset > file.size() || entry.bytes > file.size() - entry.offset)
        return corrupt(where, "the file ends inside it");
    for (std::uint64_t i = end; i < entry.offset; ++i)
        if (file[i] != std::byte(0))
            return corrupt(where, "the padding in front of it is not zero");
    end = entry.offset + entry.bytes;
    return {};
}

/// Appends the chunk as a section of its own or as the continuation of the last one.
Status add_to_sections(std::span<const std::byte> file, const Entry& entry, std::size_t index,
                       std::uint64_t previous_bytes, std::vector<Section>& sections) {
    bool continues = !sections.empty() && sections.back().id == entry.id;
    if (continues && (previous_bytes != kMaxChunkBytes || sections.back().flags != entry.flags))
        return corrupt(place(entry.id, index), "it does not continue the chunk before it");
    if (continues) {
        Section& section = sections.back();
        section.bytes = {section.bytes.data(), section.bytes.size() + std::size_t(entry.bytes)};
        return {};
    }
    sections.push_back({entry.id, entry.flags, file.subspan(std::size_t(entry.offset), std::size_t(entry.bytes))});
    return {};
}

Status check_unique(const std::vector<Section>& sections) {
    std::vector<std::uint32_t> ids;
    for (const Section& section : sections)
        ids.push_back(std::uint32_t(section.id));
    std::sort(ids.begin(), ids.end());
    auto twice = std::adjacent_find(ids.begin(), ids.end());
    return twice == ids.end() ? Status() : corrupt("chunk " + to_string(ChunkId(*twice)), "it comes twice");
}

} // namespace

std::string to_string(ChunkId id) {
    std::string text = "'";
    for (int i = 0; i < 4; ++i) {
        char c = static_cast<char>(std::uint32_t(id) >> (8 * i) & 0xFF);
        text += c >= 0x20 && c < 0x7F ? c : '?';
    }
    return text + "'";
}

Result<std::vector<Section>> read_chunks(std::span<const std::byte> file) {
    Result<std::uint32_t> count = check_header(file);
    if (!count)
        return count.status();
    std::vector<Section> sections;
    std::uint64_t end = kHeaderBytes + std::uint64_t(*count) * kTableEntryBytes, previous_bytes = 0;
    for (std::size_t i = 0; i < *count; ++i) {
        Entry entry = read_entry(file, i);
        if (Status status = check_place(file, entry, i, end); !status)
            return status;
        if (crc32c(file.subspan(std::size_t(entry.offset), std::size_t(entry.bytes))) != entry.crc)
            return corrupt(place(entry.id, i), "its checksum is wrong");
        if (Status status = add_to_sections(file, entry, i, previous_bytes, sections); !status)
            return status;
        previous_bytes = entry.bytes;
    }
    if (end != file.size() || load_u64(file, kFileBytesAt) != file.size())
        return corrupt("header", "the file has " + std::to_string(file.size()) + " bytes instead of " +
                                     std::to_string(load_u64(file, kFileBytesAt)));
    if (Status status = check_unique(sections); !status)
        return status;
    return sections;
}

std::vector<std::byte> write_chunks(std::span<const Section> sections) {
    std::vector<Section> chunks;
    for (const Section& section : sections) {
        std::span<const std::byte> rest = section.bytes;
        do {
            std::size_t size = std::min(rest.size(), kMaxChunkBytes);
            chunks.push_back({section.id, section.flags, rest.first(size)});
            rest = rest.subspan(size);
        } while (!rest.empty());
    }
    std::uint64_t end = kHeaderBytes + chunks.size() * kTableEntryBytes;
    ByteWriter table;
    for (const Section& chunk : chunks) {
        table.u32(std::uint32_t(chunk.id));
        table.u32(chunk.flags);
        table.u32(crc32c(chunk.bytes));
        table.u32(0);
        table.u64(aligned(end));
        table.u64(chunk.bytes.size());
        end = aligned(end) + chunk.bytes.size();
    }
    ByteWriter file;
    file.bytes.reserve(std::size_t(end));
    file.raw(std::as_bytes(std::span(kMagic)));
    file.u16(kMajorVersion);
    file.u16(kMinorVersion);
    file.u16(0); // any reader of this major version will do
    file.u16(0);
    file.u64(end);
    file.u32(static_cast<std::uint32_t>(chunks.size()));
    file.u32(0);
    file.raw(table.bytes);
    std::uint32_t crc = header_crc(file.bytes);
    for (std::size_t i = 0; i < 4; ++i)
        file.bytes[kHeaderCrcAt + i] = std::byte(crc >> (8 * i));
    for (const Section& chunk : chunks) {
        file.align(kChunkAlignment);
        file.raw(chunk.bytes);
    }
    return std::move(file.bytes);
}

} // namespace antumbra
