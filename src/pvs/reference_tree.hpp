// Which row each row is best described by its difference from.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

namespace antumbra {

inline constexpr std::uint32_t kNoReference = 0xFFFFFFFFu;

/// For each of `rows` bit sets of `words` words the row that it refers to, or kNoReference (then: the empty set). No
/// row is more than most_depth references away from one without. Minimises the number of differing bits greedily
/// (Prim's tree over Hamming distances, in blocks of rows where all pairs would be too many). Deterministic.
/// O(rows * block * words), at most about 2^33 word operations; `block` shrinks to fit.
std::vector<std::uint32_t> choose_references(std::span<const std::uint64_t> bits, std::size_t rows, std::size_t words,
                                             std::uint32_t most_depth);

} // namespace antumbra
