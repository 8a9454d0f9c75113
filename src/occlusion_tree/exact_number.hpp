// Exact numbers for signs that doubles cannot decide: an expansion of fixed room, so that nothing is allocated.
#pragma once

#include "geometry/expansion.hpp"

#include <antumbra/math.hpp>

namespace antumbra {

/// A sum of doubles that is never rounded. What does not fit, or comes near the smallest or largest double, is
/// `broken`: its sign is not known, and users take the answer that hides nothing.
class ExactNumber {
  public:
    static constexpr std::size_t kRoom = 256;
    ExactNumber() = default;
    /// a - b
    static ExactNumber difference(double a, double b);
    ExactNumber operator+(const ExactNumber& other) const;
    ExactNumber operator-(const ExactNumber& other) const;
    ExactNumber operator*(const ExactNumber& other) const;
    ExactNumber operator-() const;
    bool broken() const { return broken_; }
    /// -1, 0, 1; only if not broken().
    int sign() const { return count_ == 0 ? 0 : terms_[count_ - 1] > 0 ? 1 : -1; }

  private:
    std::span<const double> terms() const { return {terms_.data(), count_}; }
    /// Packs the value into few terms (Shewchuk 1997, COMPRESS).
    void compress();

    std::array<double, kRoom> terms_; ///< smallest first, the first `count_` are used
    std::size_t count_ = 0;
    bool broken_ = false;
};

using ExactVector = Vec3<ExactNumber>;

} // namespace antumbra
