// Counter-based random numbers: a value is a pure function of its keys, so that any part of a computation can be
// repeated alone. Philox4x32-10 (Salmon et al., SC 2011).
#pragma once

#include <array>
#include <cstddef>
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
        : key_{std::uint32_t(seed), std::uint32_t(seed >> 32)}, b_(b), a_{std::uint32_t(a), std::uint32_t(a >> 32)} {}

    constexpr std::uint32_t next_u32() {
        if (next_ == kBuffered)
            refill();
        return buffer_[next_++];
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
    static constexpr std::size_t kBlocks = 4, kBuffered = 4 * kBlocks;

    /// The next blocks side by side, so that compilers can use vector instructions. The numbers of a block are handed
    /// out from the last to the first.
    constexpr void refill() {
        std::uint32_t c0[kBlocks], c1[kBlocks], c2[kBlocks], c3[kBlocks];
        std::uint32_t k0 = key_[0], k1 = key_[1];
        for (std::size_t i = 0; i < kBlocks; ++i) {
            c0[i] = block_ + std::uint32_t(i);
            c1[i] = b_;
            c2[i] = a_[0];
            c3[i] = a_[1];
        }
        for (int round = 0; round < 10; ++round) {
            for (std::size_t i = 0; i < kBlocks; ++i) {
                std::uint64_t x = std::uint64_t(0xD2511F53u) * c0[i];
                std::uint64_t y = std::uint64_t(0xCD9E8D57u) * c2[i];
                std::uint32_t n0 = std::uint32_t(y >> 32) ^ c1[i] ^ k0, n2 = std::uint32_t(x >> 32) ^ c3[i] ^ k1;
                c0[i] = n0;
                c1[i] = std::uint32_t(y);
                c2[i] = n2;
                c3[i] = std::uint32_t(x);
            }
            k0 += 0x9E3779B9u;
            k1 += 0xBB67AE85u;
        }
        for (std::size_t i = 0; i < kBlocks; ++i) {
            buffer_[4 * i] = c3[i];
            buffer_[4 * i + 1] = c2[i];
            buffer_[4 * i + 2] = c1[i];
            buffer_[4 * i + 3] = c0[i];
        }
        block_ += kBlocks;
        next_ = 0;
    }

    std::array<std::uint32_t, 2> key_;
    std::uint32_t b_, block_ = 0;
    std::array<std::uint32_t, 2> a_;
    std::array<std::uint32_t, kBuffered> buffer_{};
    std::size_t next_ = kBuffered;
};

} // namespace antumbra
