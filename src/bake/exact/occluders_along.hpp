// The occluders along a segment: triangles of the scene, and polygons inside boxes that are known to be hidden.
#pragma once

#include "bake/exact/query.hpp"
#include "bake/exact/scene_tree.hpp"

namespace antumbra::exact {

/// One cell's occluders. A hidden box may stand for all that it holds: every line from the cell that would enter it is
/// blocked before, so any polygon inside it may be taken for an occluder of both sides.
class OccludersAlong final : public OccluderSource {
  public:
    explicit OccludersAlong(const SceneTree& tree);

    void forget_hidden();
    void mark_hidden(std::uint32_t node) { hidden_[node] = 1; }
    bool is_hidden(std::uint32_t node) const { return hidden_[node] != 0; }

    bool near_segment(const Vec3d& p, const Vec3d& q, std::size_t limit, std::vector<OccluderId>& found) override;
    const certify::Polygon& polygon(OccluderId id) override;

    bool has_neighbours(OccluderId id) override { return id < kVirtual; }
    bool neighbours(OccluderId id, std::size_t edge, std::vector<OccluderId>& found) override;

    /// Ids of virtual polygons: kVirtual + 12 * node + k.
    static constexpr OccluderId kVirtual = 0x80000000u;
    static std::array<GridPoint, 4> virtual_polygon(const GridBox& box, int k);

  private:
    const SceneTree& tree_;
    std::vector<std::uint8_t> hidden_;
    certify::Polygon polygon_;
    std::vector<std::pair<double, std::uint32_t>> stack_;
};

} // namespace antumbra::exact
