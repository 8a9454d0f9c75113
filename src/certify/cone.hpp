// Convex cones of R^6 by the double description method (Motzkin et al. 1953), in plain integers, for the verifier.
#pragma once

#include "certify/certificate.hpp"

#include <array>
#include <vector>

namespace antumbra::certify {

using Vector6 = std::array<Integer, 6>;

/// { x : a . x >= 0 for every inserted a }, as the span of `lines` plus the positive sums of `rays`.
class Cone {
  public:
    /// All of R^6.
    Cone();
    void insert(const Vector6& constraint);
    const std::vector<Vector6>& lines() const { return lines_; }
    const std::vector<Vector6>& rays() const { return rays_; }

  private:
    std::vector<Vector6> lines_, rays_;
    std::vector<Vector6> constraints_;
    std::vector<std::vector<bool>> on_; ///< per ray: which constraints it satisfies with equality
};

Integer dot6(const Vector6& a, const Vector6& b);

} // namespace antumbra::certify
