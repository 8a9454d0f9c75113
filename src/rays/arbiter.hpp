// The exact segment arbiter: the last word on single lines of sight. Doubles filter, exact arithmetic decides;
// there is no tolerance.
#pragma once

#include "rays/tracer.hpp"

namespace antumbra {

enum class Verdict : std::uint8_t {
    clear,      ///< unblocked, and so are all lines close to it: a proof of visibility
    blocked,    ///< an occluding, drawn triangle is properly in the way
    degenerate, ///< it touches an edge, a vertex or a plane: measure zero, proves nothing
};

class Arbiter {
  public:
    explicit Arbiter(const Tracer& tracer) : tracer_(tracer) {}

    /// Does the ray from `eye` through `toward` (local) cross the interior of triangle `target` from a side from
    /// which it is drawn, with nothing that occludes strictly in front of the crossing point? A surface that
    /// coincides with the target there (equal parameter, exactly) is no blocker. `clear` is a proof that the
    /// target's object is visible from `eye`. `blocked` also when the ray misses the target.
    Verdict sees(const Vec3d& eye, const Vec3d& toward, std::uint32_t target) const;

    /// Does the open segment p..q miss every occluding triangle (those drawn towards p)?
    Verdict segment(const Vec3d& p, const Vec3d& q) const;

  private:
    const Tracer& tracer_;
};

} // namespace antumbra
