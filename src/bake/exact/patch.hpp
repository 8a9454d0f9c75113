// Connected surfaces as one occluder: whether a patch of triangles hides T from S can often be read off a single line.
#pragma once

#include "bake/exact/frame.hpp"
#include "bake/exact/query.hpp"

namespace antumbra::exact {

/// Grows a patch from each of `starts` (blockers of `line`, strictly inside S x T) across every edge that a line from S
/// to T might meet. If the patch ends up without such an edge and keeps clear of S and T, the number of its crossings
/// with a segment from S to T, counted with sign (or modulo two, if all its triangles block from both sides), is the
/// same for all lines from S to T: if it is not zero on `line`, everything is blocked. Returns the number of triangles of
/// the patch, not zero only with that proof.
/// Needs neighbours from the source; works on products of polygons, which are connected, never on pieces.
template <bool F>
std::size_t patch_hides(LineStore<F>& store, const Frame& frame, OccluderSource& source,
                 const std::vector<OccluderId>& starts, VertexId line, QueryCounters& counters);

} // namespace antumbra::exact
