// Sight lines from a box of viewpoints to an object, and who blocks them.
#pragma once

#include "rays/tracer.hpp"

#include <antumbra/explain.hpp>

namespace antumbra::explain {

/// Aims `count` lines from random points of the box (local; a single point: min == max) at random points of the object's
/// surface, in proportion to area, from a single point to (roughly) the solid angle. Sets Sight::visible with the first
/// line that the exact arbiter finds clear as witness, else undecided; counts in any case, with a Hider for every object
/// that lines meet first. A pure function of its arguments.
void aim(const Tracer& tracer, const Box3d& box, std::uint32_t object, std::uint32_t count, std::uint64_t seed,
         SightAnswer& answer);

} // namespace antumbra::explain
