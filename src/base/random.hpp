// Counter-based random numbers: a value is a pure function of its keys, so that any part of a computation can be
// repeated alone. Philox4x32-10 (Salmon et al., SC 2011).
#pragma once

#include <array>
#include <cstdint>

namespace antumbra {

constexpr std::array<std::uint32_t, 4> philox(std::array<std::uint32_t, 4> counter,
                                              std::array<std::uint32_t, 2> key) {
    for (int round = 0; round < 10; ++round) {
        std::uint64_t a = std::uint64_t(0xD2511F53u) * counter[0];
        std::uint64_t b = std::uint64_t(0xCD9E8D57u) * counter[2];
        counter = {std::uint32_t(b >> 32) ^ counter[1] ^ key[0], std::uint32_t(b),
                   std::uint32_t(a >> 32) ^ counter[3] ^ key[1], std::uint32_t(a)};
        key = {key[0] + 0x9E3779B9u, key[1] + 0xBB67AE85u};
    }
    return counter;
}

/// A stream of numbers named by (seed, a, b): e.g. (seed, cell key, object key).
class Random {
  public:
    explicit constexpr Random(std::uint64_t seed, std::uint64_t a = 0, std::uint32_t b = 0)
        : key_{std::uint32_t(seed), std::uint32_t(seed >> 32)},
          counter_{0, b, std::uint32_t(a), std::uint32_t(a >> 32)} {}

    constexpr std::uint32_t next_u32() {
        if (left_ == 0) {
            block_ = philox(counter_, key_);
            ++counter_[0];
            left_ = 4;
        }
        return block_[--left_];
    }
    constexpr std::uint64_t next_u64() {
        std::uint64_t high = next_u32();
        return high << 32 | next_u32();
    }
    /// Uniform in [0, 1), a multiple of 2^-53.
    constexpr double uniform() { return double(next_u64() >> 11) * 0x1p-53; }
    constexpr double uniform(double low, double high) { return low + (high - low) * uniform(); }
    /// Uniform in 0..n-1, n > 0. Bias below n / 2^32.
    constexpr std::uint32_t below(std::uint32_t n) {
        return std::uint32_t((std::uint64_t(next_u32()) * n) >> 32);
    }

  private:
    std::array<std::uint32_t, 2> key_;
    std::array<std::uint32_t, 4> counter_;
    std::array<std::uint32_t, 4> block_{};
    unsigned left_ = 0;
};

} // namespace antumbra
