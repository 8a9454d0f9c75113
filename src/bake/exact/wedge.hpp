// The point that five hyperplanes of Pluecker space have in common, in integers of fixed size and without division: its
// coordinates are the 5 x 5 minors of their coefficients, built up row by row (Laplace expansion).
#pragma once

#include "bake/exact/integer.hpp"

#include <bit>
#include <span>

namespace antumbra::exact {

/// Two's complement of 320 bits: five factors below 2^61 in magnitude and a sum of 120 of them fit.
class Wide {
  public:
    bool is_zero() const { return (limb_[0] | limb_[1] | limb_[2] | limb_[3] | limb_[4]) == 0; }
    int sign() const { return is_zero() ? 0 : static_cast<std::int64_t>(limb_[4]) < 0 ? -1 : 1; }
    static Wide from(std::int64_t value) {
        Wide w;
        w.limb_.fill(value < 0 ? ~std::uint64_t(0) : 0);
        w.limb_[0] = static_cast<std::uint64_t>(value);
        return w;
    }
    /// this += x * factor, or -= if `minus`; modulo 2^320, so exact if the result fits.
    void add_product(const Wide& x, std::int64_t factor, bool minus) {
        bool negative = (factor < 0) != minus;
        auto magnitude = static_cast<std::uint64_t>(factor < 0 ? -factor : factor);
        std::uint64_t carry = 0, carry_out = negative ? 1 : 0;
        for (std::size_t k = 0; k < 5; ++k) { // -p is ~p + 1
            Unsigned128 product = static_cast<Unsigned128>(x.limb_[k]) * magnitude + carry;
            carry = static_cast<std::uint64_t>(product >> 64);
            auto low = static_cast<std::uint64_t>(product);
            Unsigned128 sum = static_cast<Unsigned128>(limb_[k]) + (negative ? ~low : low) + carry_out;
            limb_[k] = static_cast<std::uint64_t>(sum);
            carry_out = static_cast<std::uint64_t>(sum >> 64);
        }
    }
    Integer to_integer(bool negate) const {
        bool negative = sign() < 0;
        std::array<std::uint64_t, 5> words = limb_;
        if (negative) {
            std::uint64_t carry = 1;
            for (std::uint64_t& word : words) {
                word = ~word + carry;
                carry = carry != 0 && word == 0 ? 1 : 0;
            }
        }
        Integer out;
        boost::multiprecision::import_bits(out, words.begin(), words.end(), 64, false);
        return negative != negate ? Integer(-out) : out;
    }

  private:
    std::array<std::uint64_t, 5> limb_{};
};

/// Sets of columns by their size, and whether a set has an odd number.
struct ColumnSets {
    std::array<std::array<std::uint8_t, 20>, 7> of{};
    std::array<std::uint8_t, 7> count{};
    std::array<bool, 64> odd{};
    constexpr ColumnSets() {
        for (unsigned set = 0; set < 64; ++set) {
            std::size_t size = 0;
            for (unsigned rest = set; rest != 0; rest &= rest - 1)
                ++size;
            of[size][count[size]++] = static_cast<std::uint8_t>(set);
            odd[set] = size % 2 == 1;
        }
    }
};
inline constexpr ColumnSets kSets{};

/// Rows are taken in one after the other, those that depend on earlier ones are dropped, until there are five.
class Wedge {
  public:
    Wedge() { minors_[0] = Wide::from(1); }
    bool complete() const { return rank_ == 5; }
    /// |row[k]| < 2^61.
    void add(const SmallSix& row) {
        if (complete())
            return;
        // Minors of one row more go to other places of the table than those that they are made of.
        const auto rows = static_cast<std::size_t>(rank_ + 1);
        bool any = false;
        for (std::size_t s = 0; s < kSets.count[rows]; ++s) {
            unsigned set = kSets.of[rows][s];
            Wide& minor = minors_[set];
            minor = Wide();
            for (unsigned rest = set; rest != 0; rest &= rest - 1) {
                auto k = static_cast<unsigned>(std::countr_zero(rest));
                if (row[k] != 0)
                    minor.add_product(minors_[set & ~(1u << k)], row[k], kSets.odd[set >> (k + 1)]);
            }
            any |= !minor.is_zero();
        }
        rank_ += any ? 1 : 0;
    }
    /// Coordinate k of the common point, up to one sign for all.
    Integer coordinate(unsigned k, bool negate) const { return minors_[63u & ~(1u << k)].to_integer(negate != (k % 2 == 0)); }
    int sign(unsigned k) const { return minors_[63u & ~(1u << k)].sign() * (k % 2 == 0 ? -1 : 1); }

  private:
    std::array<Wide, 64> minors_{}; ///< of the rows so far, by their columns
    int rank_ = 0;
};

} // namespace antumbra::exact
