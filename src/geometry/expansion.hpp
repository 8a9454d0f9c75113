// Exact sums and products of doubles, as expansions: arrays of doubles, smallest first, that do not overlap
// and whose sum is the value (Shewchuk, "Adaptive Precision Floating-Point Arithmetic and Fast Robust
// Geometric Predicates", 1997). Zeros are left out, so the last component carries the sign; no component
// means zero.
//
// Exact as long as nothing over- or underflows; rounds to nearest even; uses no FMA. Every operation here
// keeps its results strongly nonoverlapping, which is what the next operation needs.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <span>

namespace antumbra {

namespace exact {

/// a + b = sum + error, exactly (Knuth).
inline void two_sum(double a, double b, double& sum, double& error) {
    sum = a + b;
    double b_part = sum - a;
    double a_part = sum - b_part;
    error = (a - a_part) + (b - b_part);
}

/// The same, when |a| >= |b| or a == 0 (Dekker).
inline void fast_two_sum(double a, double b, double& sum, double& error) {
    sum = a + b;
    error = b - (sum - a);
}

/// a = high + low with 26 bits in each (Veltkamp).
inline void split(double a, double& high, double& low) {
    double c = 134217729.0 * a; // 2^27 + 1
    high = c - (c - a);
    low = a - high;
}

/// a * b = product + error, exactly (Dekker).
inline void two_product(double a, double b, double& product, double& error) {
    product = a * b;
    double ah, al, bh, bl;
    split(a, ah, al);
    split(b, bh, bl);
    error = al * bl - (((product - ah * bh) - al * bh) - ah * bl);
}

/// h = e + f; room for e.size() + f.size() components. Returns how many are used.
std::size_t sum(std::span<const double> e, std::span<const double> f, double* h);
/// h = e * b; room for 2 * e.size() components. Returns how many are used.
std::size_t scale(std::span<const double> e, double b, double* h);

} // namespace exact

/// An expansion of at most N components, on the stack.
template <std::size_t N>
class Expansion {
  public:
    Expansion() = default;
    /// a - b
    static Expansion difference(double a, double b) requires(N == 2) {
        double high, low;
        exact::two_sum(a, -b, high, low);
        Expansion result;
        if (low != 0)
            result.push(low);
        if (high != 0)
            result.push(high);
        return result;
    }
    std::span<const double> terms() const { return {terms_.data(), count_}; }
    int sign() const { return count_ == 0 ? 0 : terms_[count_ - 1] > 0 ? 1 : -1; }
    Expansion operator-() const {
        Expansion result = *this;
        for (std::size_t i = 0; i < count_; ++i)
            result.terms_[i] = -result.terms_[i];
        return result;
    }
    template <std::size_t M>
    Expansion<N + M> operator+(const Expansion<M>& other) const {
        Expansion<N + M> result;
        result.set_count(exact::sum(terms(), other.terms(), result.data()));
        return result;
    }
    template <std::size_t M>
    Expansion<N + M> operator-(const Expansion<M>& other) const {
        return *this + (-other);
    }
    template <std::size_t M>
    Expansion<2 * N * M> operator*(const Expansion<M>& other) const {
        std::array<double, 2 * N> part;
        std::array<double, 2 * N * M> before;
        Expansion<2 * N * M> result;
        for (double factor : other.terms()) {
            std::span<const double> so_far = result.terms();
            std::copy(so_far.begin(), so_far.end(), before.begin());
            std::size_t parts = exact::scale(terms(), factor, part.data());
            result.set_count(exact::sum({before.data(), so_far.size()}, {part.data(), parts}, result.data()));
        }
        return result;
    }
    double* data() { return terms_.data(); }
    void set_count(std::size_t count) { count_ = count; }

  private:
    void push(double term) { terms_[count_++] = term; }
    std::array<double, N> terms_;
    std::size_t count_ = 0;
};

} // namespace antumbra
