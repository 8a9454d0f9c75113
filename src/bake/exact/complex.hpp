// The complete unobstructed complex of a pair of polygons, in a form that can be written down: every convex piece of line
// space with its vertices and its facets (Nirenstein, Blake, Gain 2002, sections 3.2.1 and 4.2).
#pragma once

#include "bake/exact/query.hpp"

namespace antumbra::exact {

struct ComplexFacet {
    Six hyperplane; ///< primitive integers h; lines x of the piece have h . x >= 0
    std::vector<std::uint32_t> vertices;
};

/// A convex cone of Pluecker space: the real lines in it, points with d . m = 0, are unblocked.
struct ComplexPiece {
    std::vector<Six> vertices; ///< primitive integers (d, m), about the grid's origin
    std::vector<ComplexFacet> facets;
    std::array<std::uint64_t, 5> faces{}; ///< of dimension 0 to 4

    /// Does the line from p to q (grid coordinates) lie in it? In doubles: for measuring.
    bool holds(const Vec3d& p, const Vec3d& q) const;
};

/// All pieces of what a query with QueryOptions::complete kept. O(facets) eliminations of 5 x 6 integers.
std::vector<ComplexPiece> complete_complex(LineSpace& space);

/// The share of the lines between two convex polygons, uniform over both, that lie in some piece; from `samples` of them.
double visible_share(std::span<const ComplexPiece> pieces, std::span<const GridPoint> s, std::span<const GridPoint> t,
                     std::uint32_t samples, std::uint64_t seed);

} // namespace antumbra::exact
