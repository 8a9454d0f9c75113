// The point that five hyperplanes of Pluecker space have in common, in integers of fixed size and without division: its
// coordinates are the 5 x 5 minors of their coefficients, built up row by row (Laplace expansion).
#pragma once

#include "bake/exact/integer.hpp"

#include <bit>
#include <cmath>
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
    /// this += x * factor, or -= if `minus`, of the lowest limbs: modulo 2^(64 Limbs), so exact if the result fits and
    /// extend_sign() follows.
    template <std::size_t Limbs>
    void add_product(const Wide& x, std::int64_t factor, bool minus) {
        auto magnitude = static_cast<std::uint64_t>(factor < 0 ? -factor : factor);
        std::uint64_t carry = 0;
        if ((factor < 0) != minus) {
            for (std::size_t k = 0; k < Limbs; ++k) {
                Unsigned128 product = static_cast<Unsigned128>(x.limb_[k]) * magnitude + carry;
                auto low = static_cast<std::uint64_t>(product);
                carry = static_cast<std::uint64_t>(product >> 64) + (limb_[k] < low ? 1 : 0);
                limb_[k] -= low;
            }
        } else {
            for (std::size_t k = 0; k < Limbs; ++k) {
                Unsigned128 sum = static_cast<Unsigned128>(x.limb_[k]) * magnitude + limb_[k] + carry;
                limb_[k] = static_cast<std::uint64_t>(sum);
                carry = static_cast<std::uint64_t>(sum >> 64);
            }
        }
    }
    /// Only the lowest limbs are set: the others follow from their sign.
    void extend_sign(std::size_t limbs) {
        std::uint64_t fill = static_cast<std::int64_t>(limb_[limbs - 1]) < 0 ? ~std::uint64_t(0) : 0;
        for (std::size_t k = limbs; k < 5; ++k)
            limb_[k] = fill;
    }
    /// As to_double() of the integer.
    double to_double(bool negate, int& exponent) const {
        exponent = 0;
        bool negative = static_cast<std::int64_t>(limb_[4]) < 0;
        std::array<std::uint64_t, 5> words = magnitude(negative);
        std::size_t top = 5;
        while (top > 0 && words[top - 1] == 0)
            --top;
        if (top == 0)
            return 0;
        int shift = std::countl_zero(words[top - 1]);
        std::uint64_t high = words[top - 1] << shift;
        if (shift > 0 && top > 1)
            high |= words[top - 2] >> (64 - shift);
        // What is dropped is below 2^-61 of it, and rounding loses 2^-53.
        double fraction = std::frexp(static_cast<double>(high >> 2), &exponent);
        exponent += 2 + 64 * static_cast<int>(top - 1) - shift;
        return negative != negate ? -fraction : fraction;
    }
    Integer to_integer(bool negate) const {
        bool negative = sign() < 0;
        std::array<std::uint64_t, 5> words = magnitude(negative);
        Integer out;
        boost::multiprecision::import_bits(out, words.begin(), words.end(), 64, false);
        return negative != negate ? Integer(-out) : out;
    }

  private:
    std::array<std::uint64_t, 5> magnitude(bool negative) const {
        std::array<std::uint64_t, 5> words = limb_;
        if (negative) {
            std::uint64_t carry = 1;
            for (std::uint64_t& word : words) {
                word = ~word + carry;
                carry = carry != 0 && word == 0 ? 1 : 0;
            }
        }
        return words;
    }
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
        std::uint64_t together = 0;
        for (std::int64_t value : row)
            together |= static_cast<std::uint64_t>(value < 0 ? -value : value);
        constexpr int kTerms[6] = {0, 0, 1, 3, 5, 7}; // bits of the number of products in a minor
        int bits = bits_ + std::bit_width(together);
        const auto limbs = std::min<std::size_t>(5, static_cast<std::size_t>(bits + kTerms[rows]) / 64 + 1); // and a sign
        bool any = false;
        switch (limbs) {
        case 1: any = expand<1>(row, rows); break;
        case 2: any = expand<2>(row, rows); break;
        case 3: any = expand<3>(row, rows); break;
        case 4: any = expand<4>(row, rows); break;
        default: any = expand<5>(row, rows);
        }
        if (any) {
            ++rank_;
            bits_ = bits;
        }
    }
    /// Coordinate k of the common point, up to one sign for all.
    Integer coordinate(unsigned k, bool negate) const { return minors_[63u & ~(1u << k)].to_integer(negate != (k % 2 == 0)); }
    double coordinate(unsigned k, bool negate, int& exponent) const {
        return minors_[63u & ~(1u << k)].to_double(negate != (k % 2 == 0), exponent);
    }
    int sign(unsigned k) const { return minors_[63u & ~(1u << k)].sign() * (k % 2 == 0 ? -1 : 1); }

  private:
    /// The minors of one row more. False: all are zero.
    template <std::size_t Limbs>
    bool expand(const SmallSix& row, std::size_t rows) {
        bool any = false;
        for (std::size_t s = 0; s < kSets.count[rows]; ++s) {
            unsigned set = kSets.of[rows][s];
            Wide minor;
            for (unsigned rest = set; rest != 0; rest &= rest - 1) {
                auto k = static_cast<unsigned>(std::countr_zero(rest));
                if (row[k] != 0)
                    minor.add_product<Limbs>(minors_[set & ~(1u << k)], row[k], kSets.odd[set >> (k + 1)]);
            }
            minor.extend_sign(Limbs);
            any |= !minor.is_zero();
            minors_[set] = minor;
        }
        return any;
    }

    std::array<Wide, 64> minors_{}; ///< of the rows so far, by their columns
    int rank_ = 0, bits_ = 0;       ///< bits_: of the largest coefficients of the rows so far, summed
};

} // namespace antumbra::exact
