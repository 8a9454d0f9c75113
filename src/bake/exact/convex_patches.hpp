// Neighbouring triangles joined to larger occluders: what a wall, a floor, a side of a beam is made of.
#pragma once

#include "geometry/pluecker.hpp"

#include <cstdint>
#include <span>
#include <vector>

namespace antumbra::exact {

class SceneTree;

/// A partition of the occluding triangles into discs that are nearly flat and nearly convex.
///
/// A disc of triangles with no corner inside blocks every line that passes all edges of its rim on the same side, however
/// bent it is: an inner edge cuts the disc in two, and whichever side of it the line passes, it passes all edges of one of the
/// two parts on the same side; at last of a single triangle. In that direction, too: the triangles of a disc are oriented
/// alike. Fewer planes than its triangles have, and no cut between them. Immutable, thread-safe.
class ConvexPatches {
  public:
    static constexpr std::uint32_t kNone = 0xFFFFFFFFu;

    /// O(triangles). Deterministic.
    static ConvexPatches build(const SceneTree& tree);

    std::uint32_t count() const { return static_cast<std::uint32_t>(flat_.size()); }
    /// The patch of a triangle; kNone if it stands alone.
    std::uint32_t of(std::uint32_t triangle) const { return of_[triangle]; }
    /// The rim, oriented as its triangles are; no corner lies within an edge.
    std::span<const GridPoint> rim(std::uint32_t patch) const {
        return std::span(rims_).subspan(first_[patch], first_[patch + 1] - first_[patch]);
    }
    std::span<const std::uint32_t> members(std::uint32_t patch) const {
        return std::span(members_).subspan(first_member_[patch], first_member_[patch + 1] - first_member_[patch]);
    }
    bool both_sides(std::uint32_t patch) const { return both_sides_[patch] != 0; }
    /// Do all corners lie in one plane, exactly?
    bool is_flat(std::uint32_t patch) const { return flat_[patch] != 0; }

  private:
    std::vector<std::uint32_t> of_, first_, members_, first_member_;
    std::vector<GridPoint> rims_;
    std::vector<std::uint8_t> both_sides_, flat_;
};

} // namespace antumbra::exact
