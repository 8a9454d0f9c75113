// Which patches of occluders hold something that the cell of the eye sees.
#pragma once

#include "cull/scene_data.hpp"

namespace antumbra {

/// Of one view. What a cell does not see is behind what it does see, and hides nothing that others do not hide.
class SeenPatches {
  public:
    /// Patches of solids, and all where the cell has no answer, count as seen. A few nanoseconds in the same cell, O(polygons)
    /// in a new one.
    bool holds(const Pvs& pvs, const CullScene::Data& scene, const Vec3d& eye, std::uint32_t patch) {
        if (pvs.query(eye + scene.origin, cell_) || seen_.empty())
            look(scene);
        return seen_[patch] != 0;
    }

  private:
    void look(const CullScene::Data& scene);

    PvsCursor cell_;
    std::vector<char> seen_; ///< per patch
};

} // namespace antumbra
