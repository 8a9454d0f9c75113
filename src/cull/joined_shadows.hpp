// Boxes that no single shadow holds, but several together: what of a box lies beyond a plane of one shadow lies in another, or out
// of view.
//
// Why that is sound: a point of the box that is inside of all planes of shadow A is hidden by A. Any other is beyond some plane e of
// A that the box crosses; for each such plane another shadow B holds all of the box that is beyond e. For a plane p of B that is
// certain if p + k e is positive on the whole box for some k >= 0: where e is not, p is then. Which k does not matter; those at which a
// coefficient of p + k e vanishes are all that need be tried, since its least value over a box is concave and piecewise linear in k.
#pragma once

#include "cull/shadow.hpp"
#include "cull/view_planes.hpp"

#include <span>

namespace antumbra {

/// One of several shadows, and those that hold what it does not.
struct JoinedShadows {
    int first = -1;          ///< -1: none
    std::uint64_t used = 0;  ///< bit per shadow, the first included
};

/// Tries `relevant` shadows (bit per shadow), first `preferred` (-1: none), then at most `most` more. `crossing`: bits of the planes of
/// view that the box may cross. O(most * planes of all relevant shadows).
JoinedShadows find_joined_shadows(const Box3f& box, std::span<const Shadow> shadows, std::uint64_t relevant, int preferred, int most,
                                  const FrustumPlanes& view, std::uint32_t crossing);

} // namespace antumbra
