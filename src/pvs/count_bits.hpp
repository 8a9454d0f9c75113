// Set bits of words, inlined: the library call that stands for std::popcount where the instruction may not be
// assumed costs more.
#pragma once

#include <cstdint>
#include <span>

namespace antumbra {

constexpr std::uint32_t count_bits(std::uint64_t word) {
    word -= word >> 1 & 0x5555555555555555u;
    word = (word & 0x3333333333333333u) + (word >> 2 & 0x3333333333333333u);
    word = (word + (word >> 4)) & 0x0F0F0F0F0F0F0F0Fu;
    return static_cast<std::uint32_t>(word * 0x0101010101010101u >> 56);
}

constexpr std::uint32_t count_bits(std::span<const std::uint64_t> words) {
    std::uint32_t total = 0;
    for (std::uint64_t word : words)
        total += count_bits(word);
    return total;
}

} // namespace antumbra
