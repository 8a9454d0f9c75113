// Which occluders `opacity` draws in a frame, and how they are joined to patches.
#pragma once

#include "cull/occluder_interest.hpp"
#include "cull/patch_layout.hpp"
#include "cull/scene_data.hpp"
#include "cull/view_planes.hpp"

namespace antumbra {

/// Per view. Without a database: the polygons of the convex groups that promise most (CullerOptions::occluder_choice), by a
/// search that is spread over frames, or those of a list by first hit. With one: the lists of the nearest grid point, taken in
/// turns from the directions that the view touches. Either way only what is in view, safe to use and, with a PVS, seen from
/// the cell of the eye.
class OpacityOccluders {
  public:
    explicit OpacityOccluders(const CullScene::Data& scene, OccluderChoice choice = OccluderChoice::area_angle,
                              const Pvs* pvs = nullptr);

    /// Fills polygons(), best first, at most `most`.
    void choose(const CullScene::Data& scene, const OccluderDatabase* database, const Camera& camera,
                const FrustumPlanes& planes, std::uint32_t most);
    std::span<const std::uint32_t> polygons() const { return chosen_; }

    /// The chosen polygons as connected patches: at most kMostMembers, and the chosen neighbours around them, so that
    /// there is no crack between patches. O(chosen); kept while the choice stays the same.
    const PatchStore& patches(const OccluderSet& set);

    static constexpr std::uint32_t kMostMembers = 24;

  private:
    void choose_by_promise(const CullScene::Data& scene, const Camera& camera, const FrustumPlanes& planes);
    void choose_from(const CullScene::Data& scene, const OccluderDatabase& database, const Camera& camera,
                     const FrustumPlanes& planes);
    double promise(const CullScene::Data& scene, std::uint32_t group) const;
    void take_groups(const CullScene::Data& scene, std::span<const std::uint32_t> groups, const FrustumPlanes& planes);
    bool take(const CullScene::Data& scene, std::uint32_t polygon, const FrustumPlanes& planes);
    void join(const OccluderSet& set);

    OccluderChoice choice_;
    const Pvs* pvs_;
    OccluderInterest interest_;
    PatchLayout layout_;
    PatchStore store_;
    OccluderSearch search_;
    bool searched_ = false, partial_ = false;
    Vec3d searched_from_;
    double size_ = 1;
    std::uint32_t most_ = 0;
    Camera camera_;
    Box3d start_;
    std::vector<std::uint32_t> chosen_, laid_out_;
    std::vector<std::uint32_t> taken_at_, patch_of_; ///< per polygon: the round in which it was taken, its patch
    std::uint32_t round_ = 0;
    std::vector<std::uint32_t> members_;
};

} // namespace antumbra
