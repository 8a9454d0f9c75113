// What the methods ask that choose single polygons as occluders: does the cell of the eye see it, and what does it promise?
#pragma once

#include "cull/scene_data.hpp"
#include "cull/view_planes.hpp"

namespace antumbra {

/// Of one view. Decides what is found to be hidden, never whether it is. Takes memory in the first frame only.
class OccluderInterest {
  public:
    /// Before a choice. `pvs` may be nullptr, and must be the same every time. A few nanoseconds in the same cell; by first hit
    /// O(members of the list).
    void look(const CullScene::Data& scene, OccluderChoice choice, const Pvs* pvs, const Camera& camera);

    /// What the cell of the eye does not see hides nothing that others do not hide. Faces of solids, and all where there is no
    /// answer, count as seen.
    bool is_seen(const OccluderPolygon& polygon) const {
        return !asks_cell_ || polygon.synthetic || polygon.object / 64 >= cell_.visible.size() ||
               (cell_.visible[polygon.object / 64] >> (polygon.object % 64) & 1) != 0;
    }

    /// Groups that rays from the place of the eye hit first, most first; empty unless they are asked for and known.
    std::span<const std::uint32_t> first_hits() const { return list_; }

    /// What to order polygons by: `cosine` between normal and line of sight (or viewing direction), and the squared distance. What
    /// a list by first hit names comes before all else, in the list's order. 0: nothing.
    double promise(std::uint32_t index, const OccluderPolygon& polygon, double area, double cosine, double squared) const {
        if (!(cosine > 0) || !is_seen(polygon))
            return 0;
        if (!list_.empty() && listed_in_[index].round == round_)
            return kListed / (1 + listed_in_[index].place);
        return choice_ == OccluderChoice::projected_size ? area / squared : area * cosine / squared;
    }

  private:
    static constexpr double kListed = 1e30; ///< fits a float, and no promise comes near it
    struct Listed {
        std::uint32_t round = 0, place = 0;
    };

    OccluderChoice choice_ = OccluderChoice::area_angle;
    bool asks_cell_ = false;
    PvsCursor cell_;
    std::span<const std::uint32_t> list_; ///< of the scene
    std::vector<Listed> listed_in_;       ///< per polygon: the last list that named it, and where
    std::uint32_t round_ = 0;
};

} // namespace antumbra
