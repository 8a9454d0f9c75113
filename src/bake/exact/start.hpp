// The first polytope of a query: it holds every line from S to T and no other real line.
//
// All edge lines of S and T meet the common line L0 of their planes, so that the cone of lines is a product modulo
// L0. `prism_start` closes that product with two caps; `hull_start` is the hull of the corner lines.
#pragma once

#include "bake/exact/frame.hpp"
#include "bake/exact/polytope.hpp"

namespace antumbra::exact {

enum class StartResult : std::uint8_t { ready, not_applicable, overflow };

/// Direct construction. Not applicable where a corner of S lies in the plane of T and one of T in that of S (no cap
/// can be valid then).
template <bool F, int W>
StartResult prism_start(LineStore<F>& store, const Frame& frame, Polytope<W>& out);

/// Facets by the exact double description of the dual cone. Always applicable.
template <bool F, int W>
StartResult hull_start(LineStore<F>& store, const Frame& frame, Polytope<W>& out);

/// The same polytope as prism_start, from its half-spaces alone: extreme points and incidences by the double description
/// method, as published. Falls back on hull_start where no caps are valid.
template <bool F, int W>
StartResult published_start(LineStore<F>& store, const Frame& frame, Polytope<W>& out);

} // namespace antumbra::exact
