// Row coding 6: the fewest bytes. Every bit is told through an adaptive model that looks at two rows like it and at
// what stands before; so all rows are decoded together, on opening.
#pragma once

#include <antumbra/status.hpp>

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

namespace antumbra {

/// The bytes of ROWS. About 10 ns a bit, and what choose_references takes.
std::vector<std::byte> encode_archive(std::span<const std::uint64_t> bits, std::size_t row_count, std::size_t objects);

/// All rows, words_for(objects) words each. ErrorCode::corrupt if a row refers to none or to itself through others; any
/// other bytes decode to something. O(row_count * objects).
Result<std::vector<std::uint64_t>> decode_archive(std::span<const std::byte> coded, std::uint32_t row_count,
                                                  std::size_t objects);

} // namespace antumbra
