// Convex solids with corners on the grid, and the exact test whether a triangle enters one.
#pragma once

#include "occluder_finding/grid_geometry.hpp"

#include <optional>
#include <vector>

namespace antumbra {

/// Faces are convex polygons of exactly one plane each, counter-clockwise seen from outside, without straight corners; two
/// faces share whole edges.
struct GridPolytope {
    std::vector<grid::Point> points;
    std::vector<std::vector<std::uint32_t>> faces;

    /// Half the surface, in squared grid steps.
    double worth() const;
};

/// Exact. Nothing for points of one plane, or more than 64. O(n^4).
std::optional<GridPolytope> convex_hull(std::vector<grid::Point> points);

/// Separating axes of one solid against many triangles.
class PolytopeTest {
  public:
    explicit PolytopeTest(const GridPolytope& polytope);

    /// The inside of the solid (without its surface) and the closed triangle have a point in common. Exact for coordinates
    /// below 2^24: a triangle stays out exactly if its plane, the plane of a face, or one along an edge of each has the two on
    /// its two sides.
    bool is_entered_by(const grid::Triangle& triangle) const;

  private:
    bool separates(const grid::Point& axis, const grid::Triangle& triangle) const;

    const GridPolytope& polytope_;
    std::vector<grid::Point> normals_, edges_;
    grid::Point min_, max_;
};

} // namespace antumbra
