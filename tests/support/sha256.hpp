// SHA-256 (FIPS 180-4), for golden hashes that a stranger can check with sha256sum.
#pragma once

#include <array>
#include <bit>
#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <vector>

namespace antumbra::test {

class Sha256 {
  public:
    static std::string hex(std::span<const std::byte> message) {
        Sha256 hash;
        std::size_t whole = message.size() / 64;
        for (std::size_t i = 0; i < whole; ++i)
            hash.block(message.subspan(i * 64, 64));
        std::vector<std::byte> tail(message.begin() + static_cast<std::ptrdiff_t>(whole * 64), message.end());
        tail.push_back(std::byte{0x80});
        while (tail.size() % 64 != 56)
            tail.push_back(std::byte{0});
        std::uint64_t bits = std::uint64_t(message.size()) * 8;
        for (int shift = 56; shift >= 0; shift -= 8)
            tail.push_back(static_cast<std::byte>(bits >> shift));
        for (std::size_t i = 0; i < tail.size(); i += 64)
            hash.block(std::span<const std::byte>(tail).subspan(i, 64));
        std::string text;
        for (std::uint32_t word : hash.state_)
            for (int shift = 28; shift >= 0; shift -= 4)
                text += "0123456789abcdef"[(word >> shift) & 15];
        return text;
    }

  private:
    static constexpr std::uint64_t prime(int n) {
        std::uint64_t p = 1;
        for (int found = -1; found < n;) {
            ++p;
            bool is_prime = true;
            for (std::uint64_t d = 2; d * d <= p; ++d)
                is_prime &= p % d != 0;
            found += is_prime;
        }
        return p;
    }
    /// The first 32 bits of the fraction of the `power`-th root of p: floor(root(p) * 2^32), by bisection.
    static constexpr std::uint32_t root_bits(std::uint64_t p, int power) {
        __extension__ using Wide = unsigned __int128;
        std::uint64_t low = 0, high = std::uint64_t(1) << 37;
        while (high - low > 1) {
            std::uint64_t middle = low + (high - low) / 2;
            Wide square = Wide(middle) * middle; // below 2^74
            // Compare middle^power with p * 2^(32 power) without overflow: divide both sides by middle.
            bool below = power == 2 ? square <= (Wide(p) << 64) : square <= ((Wide(p) << 96) / middle);
            (below ? low : high) = middle;
        }
        return static_cast<std::uint32_t>(low);
    }
    void block(std::span<const std::byte> bytes) {
        static const std::array<std::uint32_t, 64> kRound = [] {
            std::array<std::uint32_t, 64> k{};
            for (int i = 0; i < 64; ++i)
                k[static_cast<std::size_t>(i)] = root_bits(prime(i), 3);
            return k;
        }();
        std::array<std::uint32_t, 64> w{};
        for (std::size_t i = 0; i < 16; ++i)
            for (std::size_t b = 0; b < 4; ++b)
                w[i] = w[i] << 8 | std::to_integer<std::uint32_t>(bytes[4 * i + b]);
        for (std::size_t i = 16; i < 64; ++i) {
            std::uint32_t a = w[i - 15], b = w[i - 2];
            w[i] = w[i - 16] + (std::rotr(a, 7) ^ std::rotr(a, 18) ^ (a >> 3)) + w[i - 7] +
                   (std::rotr(b, 17) ^ std::rotr(b, 19) ^ (b >> 10));
        }
        auto [a, b, c, d, e, f, g, h] = state_;
        for (std::size_t i = 0; i < 64; ++i) {
            std::uint32_t t1 = h + (std::rotr(e, 6) ^ std::rotr(e, 11) ^ std::rotr(e, 25)) +
                               ((e & f) ^ (~e & g)) + kRound[i] + w[i];
            std::uint32_t t2 =
                (std::rotr(a, 2) ^ std::rotr(a, 13) ^ std::rotr(a, 22)) + ((a & b) ^ (a & c) ^ (b & c));
            h = g, g = f, f = e, e = d + t1, d = c, c = b, b = a, a = t1 + t2;
        }
        std::array<std::uint32_t, 8> add{a, b, c, d, e, f, g, h};
        for (std::size_t i = 0; i < 8; ++i)
            state_[i] += add[i];
    }
    std::array<std::uint32_t, 8> state_ = [] {
        std::array<std::uint32_t, 8> h{};
        for (int i = 0; i < 8; ++i)
            h[static_cast<std::size_t>(i)] = root_bits(prime(i), 2);
        return h;
    }();
};

} // namespace antumbra::test
