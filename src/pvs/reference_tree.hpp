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

/// How files write a reference: 0 for none; 2d - 1 for the d-th row before, 2d for the d-th after.
constexpr std::uint64_t reference_code(std::uint32_t row, std::uint32_t reference) {
    if (reference == kNoReference)
        return 0;
    return reference < row ? 2 * std::uint64_t(row - reference) - 1 : 2 * std::uint64_t(reference - row);
}
/// The inverse. False if there is no such row.
constexpr bool read_reference(std::uint32_t row, std::uint32_t rows, std::uint64_t code, std::uint32_t& reference) {
    std::uint64_t distance = (code + 1) / 2;
    bool is_before = code % 2 == 1;
    reference = kNoReference;
    if (code == 0)
        return true;
    if (is_before ? distance > row : distance >= rows - row)
        return false;
    reference = static_cast<std::uint32_t>(is_before ? row - distance : row + distance);
    return true;
}

} // namespace antumbra
