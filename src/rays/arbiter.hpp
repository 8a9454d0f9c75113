// The exact segment arbiter: the last word on single lines of sight. Doubles filter, exact arithmetic
// decides; there is no tolerance.
#pragma once

#include "geometry/predicates.hpp"
#include "rays/tracer.hpp"

namespace antumbra {

enum class Verdict : std::uint8_t {
    clear,      ///< unblocked, and so are all lines close to it: a proof of visibility
    blocked,    ///< an occluding, drawn triangle is properly in the way
    degenerate, ///< it touches an edge, a vertex or a plane: measure zero, proves nothing
};

/// Thread-safe. A verdict costs a few microseconds; exact arithmetic (counted in the caller's tally, if
/// given) is needed only within about 1e-14 of a degeneracy. Points with coordinates beyond in_exact_range()
/// are always `degenerate`.
class Arbiter {
  public:
    explicit Arbiter(const Tracer& tracer) : tracer_(tracer) {}

    /// Does the ray from `eye` through `toward` (local) cross the interior of triangle `target` from a side
    /// from which it is drawn, with nothing that occludes strictly in front of the crossing point? `clear` is
    /// a proof that the target's object is visible from `eye`. `blocked` also when the ray misses the target
    /// or meets a side that is not drawn.
    ///
    /// A blocker is an occluding triangle, drawn towards the eye, in a plane other than the target's
    /// (coplanar surfaces coincide with the target and hide nothing). Crossed in its interior strictly
    /// between eye and target: blocked, whatever else is touched. Touched otherwise at or before the target
    /// (edge, vertex, a line in its plane, the eye on it, or a crossing exactly at the target's point):
    /// degenerate. Triangles that show the ray only an undrawn back are not there.
    Verdict sees(const Vec3d& eye, const Vec3d& toward, std::uint32_t target,
                 PredicateTally* tally = nullptr) const;

    /// Does the open segment p..q miss every occluding triangle drawn towards p? Touching one, also with p or
    /// q: degenerate.
    Verdict segment(const Vec3d& p, const Vec3d& q, PredicateTally* tally = nullptr) const;

  private:
    const Tracer& tracer_;
};

} // namespace antumbra
