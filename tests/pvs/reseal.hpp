// Makes the checksums of a changed file right again, as an attacker would: what is refused after this is refused
// for its content. Shared by the tests and the fuzzer.
#pragma once

#include "base/bytes.hpp"
#include "base/crc32c.hpp"
#include "pvs/chunks.hpp"

#include <algorithm>
#include <vector>

namespace antumbra::test {

inline void store_u32(std::span<std::byte> bytes, std::size_t at, std::uint32_t value) {
    for (std::size_t i = 0; i < 4; ++i)
        bytes[at + i] = std::byte(value >> (8 * i));
}

struct TableEntry {
    ChunkId id;
    std::uint64_t offset, bytes;
};

/// The entries of the table that lie in the file, whatever they say.
inline std::vector<TableEntry> table_of(std::span<const std::byte> file) {
    std::vector<TableEntry> entries;
    if (file.size() < kHeaderBytes)
        return entries;
    std::size_t count = std::min<std::size_t>(load_u32(file, 24), (file.size() - kHeaderBytes) / kTableEntryBytes);
    for (std::size_t i = 0; i < count; ++i) {
        std::size_t at = kHeaderBytes + i * kTableEntryBytes;
        entries.push_back({ChunkId(load_u32(file, at)), load_u64(file, at + 16), load_u64(file, at + 24)});
    }
    return entries;
}

/// Recomputes the CRC of each chunk that lies in the file, then that of header and table.
inline void reseal(std::span<std::byte> file) {
    std::vector<TableEntry> entries = table_of(file);
    if (file.size() < kHeaderBytes)
        return;
    for (std::size_t i = 0; i < entries.size(); ++i) {
        const TableEntry& entry = entries[i];
        if (entry.offset <= file.size() && entry.bytes <= file.size() - entry.offset)
            store_u32(file, kHeaderBytes + i * kTableEntryBytes + 8,
                      crc32c(file.subspan(std::size_t(entry.offset), std::size_t(entry.bytes))));
    }
    store_u32(file, 28, 0);
    store_u32(file, 28, crc32c(file.first(kHeaderBytes + entries.size() * kTableEntryBytes)));
}

} // namespace antumbra::test
