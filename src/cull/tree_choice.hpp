// Which occluders `tree` puts into the occlusion tree of a frame: polygons of objects that are known to be seen.
#pragma once

#include "cull/occluder_interest.hpp"
#include "cull/scene_data.hpp"
#include "cull/view_planes.hpp"
#include "occlusion_tree/tree_occluders.hpp"

namespace antumbra {

/// Immutable, one per culler.
class TreeChoice {
  public:
    /// What a view keeps. Takes its memory once.
    struct Memory {
        Memory(const TreeChoice& owner, std::uint32_t most);
        std::vector<std::uint32_t> chosen; ///< polygons, the largest area-angle first
        std::vector<std::uint32_t> looked; ///< per listed polygon: the last choice that looked at it
        std::vector<std::pair<float, std::uint32_t>> candidates;
        std::uint32_t choice = 0;
    };

    /// O(polygons * objects that they touch), bounded for each polygon.
    static TreeChoice build(const CullScene::Data& scene, const TreeOccluders& occluders);

    /// Up to `most` polygons that promise most (`interest` has looked), as a rule by area-angle (Bittner, Havran, Slavik 1998,
    /// section 3), among those that touch objects of `visible` without `hidden` (bits over objects): what a hidden object hides is hidden by what hides it. All of them
    /// show a side that blocks, with nothing of it nearer than the near plane, and may be in view. A pure function of its
    /// arguments.
    void choose(const CullScene::Data& scene, const Camera& camera, std::span<const std::uint64_t> visible,
                std::span<const std::uint64_t> hidden, const OccluderInterest& interest, std::uint32_t most, Memory& memory) const;

  private:
    /// What the choice looks at, together in memory.
    struct Listed {
        Vec3f centre, normal;
        float area;
        std::uint32_t polygon;
        bool double_sided;
        Box3f box;
    };
    static float promise(const CullScene::Data& scene, const Listed& polygon, const Vec3f& eye, const OccluderInterest& interest);

    std::vector<Listed> listed_;                          ///< the largest first
    std::vector<std::uint32_t> first_polygon_, polygons_; ///< per object: places in listed_
};

} // namespace antumbra
