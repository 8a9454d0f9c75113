// The container of a .pvs file: a header, a table of chunks, the chunks. Knows nothing of what they hold.
// Byte layout: docs/format.md, sections 1 and 2.
#pragma once

#include <antumbra/pvs.hpp>
#include <antumbra/status.hpp>

#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <vector>

namespace antumbra {

inline constexpr std::uint16_t kMajorVersion = kPvsFormatVersion >> 16;
inline constexpr std::uint16_t kMinorVersion = kPvsFormatVersion & 0xFFFF;
inline constexpr std::size_t kHeaderBytes = 32;
inline constexpr std::size_t kTableEntryBytes = 32;
inline constexpr std::size_t kChunkAlignment = 16;
/// A larger section is cut into chunks of exactly this size and a rest. A multiple of the alignment, so that the
/// pieces lie side by side in the file and a reader sees one span.
inline constexpr std::size_t kMaxChunkBytes = std::size_t(64) << 20;

/// Four letters, the first in the lowest byte.
enum class ChunkId : std::uint32_t {};
constexpr ChunkId chunk_id(const char (&name)[5]) {
    std::uint32_t value = 0;
    for (int i = 0; i < 4; ++i)
        value |= std::uint32_t(static_cast<unsigned char>(name[i])) << (8 * i);
    return ChunkId(value);
}
/// The four letters, in quotes; others than printable ASCII as '?'.
std::string to_string(ChunkId id);

enum ChunkFlag : std::uint32_t {
    kRequired = 1u << 0, ///< a reader that does not know the chunk must refuse the file
};

/// One section: everything that the chunks of one id hold together.
struct Section {
    ChunkId id{};
    std::uint32_t flags = 0;
    std::span<const std::byte> bytes;
};

/// Checks header, table, padding and every CRC, and returns the sections in file order. ErrorCode::corrupt names the
/// chunk, unsupported the version that is needed. O(bytes).
Result<std::vector<Section>> read_chunks(std::span<const std::byte> file);

/// The bytes of a file of these sections, in this order; ids must differ.
std::vector<std::byte> write_chunks(std::span<const Section> sections);

} // namespace antumbra
