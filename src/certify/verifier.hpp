// The independent verifier of certificates. It knows rational numbers, points and lines, and shares no code with
// the solver that made the claims: rational geometry in space for witnesses, the textbook double description method
// for subdivisions.
#pragma once

#include "certify/certificate.hpp"

#include <antumbra/status.hpp>

#include <span>

namespace antumbra::certify {

/// Accepts iff p lies strictly inside s and q strictly inside t, each strictly in front of the other's plane, and
/// no occluder (its closed part in front of both planes, if that has an area) meets the segment from a side from
/// which it blocks. ErrorCode::mismatch says which test failed. Then all lines close to the segment are unblocked
/// too: the claim "visible" is proved.
Status verify_witness(const Polygon& s, const Polygon& t, std::span<const Polygon> occluders,
                      const WitnessSegment& witness);

/// Accepts iff the tree proves that no open set of lines from the front of s to the front of t is unblocked:
/// every split has two children, each node is reached once, every leaf is empty or blocked as it says. The tree may
/// be empty if nothing of s and t faces each other.
/// Cost: a double description per node, about 0.1 to 10 ms.
Status verify_hidden(const Polygon& s, const Polygon& t, std::span<const Polygon> occluders,
                     const HiddenTree& tree);

} // namespace antumbra::certify
