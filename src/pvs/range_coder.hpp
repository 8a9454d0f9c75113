// A binary arithmetic coder: one bit at a time, each with the probability that a model gives it. Integers only, so
// that every machine writes and reads the same bytes.
//
// Source: the carry-free coder of Mahoney's lpaq (2007), after Witten, Neal, Cleary 1987, with 16-bit probabilities.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

namespace antumbra {

/// Probability of a 1 in units of 2^-16, within 1..65535.
using Probability = std::uint32_t;

class RangeEncoder {
  public:
    void put(bool bit, Probability one) {
        std::uint32_t middle = low_ + static_cast<std::uint32_t>(std::uint64_t(high_ - low_) * one >> 16);
        (bit ? high_ : low_) = bit ? middle : middle + 1;
        for (; (low_ ^ high_) >> 24 == 0; low_ <<= 8, high_ = high_ << 8 | 0xFF)
            bytes_.push_back(std::byte(high_ >> 24));
    }

    /// The bytes; the decoder takes zeros for those beyond, so as few as tell the last interval are written.
    std::vector<std::byte> finish() {
        for (unsigned kept = 0; kept <= 32; kept += 8) {
            std::uint32_t below = kept == 32 ? 0 : 0xFFFFFFFFu >> kept;
            std::uint64_t value = (std::uint64_t(low_) + below) & ~std::uint64_t(below);
            if (value > high_)
                continue;
            for (unsigned shift = 24, left = kept; left > 0; shift -= 8, left -= 8)
                bytes_.push_back(std::byte(value >> shift & 0xFF));
            break;
        }
        while (!bytes_.empty() && bytes_.back() == std::byte(0))
            bytes_.pop_back();
        return std::move(bytes_);
    }

  private:
    std::uint32_t low_ = 0, high_ = 0xFFFFFFFFu;
    std::vector<std::byte> bytes_;
};

/// Takes any bytes: those that no encoder wrote give some bits, too.
class RangeDecoder {
  public:
    explicit RangeDecoder(std::span<const std::byte> bytes) : bytes_(bytes) {
        for (int i = 0; i < 4; ++i)
            value_ = value_ << 8 | next();
    }

    bool get(Probability one) {
        std::uint32_t middle = low_ + static_cast<std::uint32_t>(std::uint64_t(high_ - low_) * one >> 16);
        bool bit = value_ <= middle;
        (bit ? high_ : low_) = bit ? middle : middle + 1;
        for (; (low_ ^ high_) >> 24 == 0; low_ <<= 8, high_ = high_ << 8 | 0xFF)
            value_ = value_ << 8 | next();
        return bit;
    }

  private:
    std::uint32_t next() { return at_ < bytes_.size() ? std::to_integer<std::uint32_t>(bytes_[at_++]) : 0; }

    std::span<const std::byte> bytes_;
    std::size_t at_ = 0;
    std::uint32_t low_ = 0, high_ = 0xFFFFFFFFu, value_ = 0;
};

} // namespace antumbra
