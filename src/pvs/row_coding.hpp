// Row coding 1: each row stands alone and is stored in whichever of three ways takes the fewest bytes, so that
// any row can be decoded at any time without the others. Byte layout: docs/format.md, section 4.
#pragma once

#include "base/bytes.hpp"

#include <cstdint>
#include <span>

namespace antumbra {

/// First byte of a coded row.
enum class RowWay : std::uint8_t {
    raw = 0,  ///< the bytes of the bit set
    runs = 1, ///< runs of zero bytes, of 0xFF bytes and of literal bytes
    gaps = 2, ///< distances between set bits
};

constexpr std::size_t words_for(std::size_t objects) { return (objects + 63) / 64; }
constexpr std::size_t bytes_for(std::size_t objects) { return (objects + 7) / 8; }

/// Appends the row of `objects` bits in `words` (bits beyond are zero).
void encode_row(std::span<const std::uint64_t> words, std::size_t objects, ByteWriter& out);

/// Whether `coded` is exactly one row of `objects` bits. O(coded bytes), writes nothing.
bool is_row(std::span<const std::byte> coded, std::size_t objects);

/// Decodes into words_for(objects) words. False if `coded` is no such row; then `words` holds anything. Never
/// reads or writes out of range, whatever the bytes. O(objects / 8 + set bits).
bool decode_row(std::span<const std::byte> coded, std::size_t objects, std::span<std::uint64_t> words);

} // namespace antumbra
