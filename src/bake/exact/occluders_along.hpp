// The occluders along a segment: triangles of the scene, and polygons inside boxes that are known to be hidden.
#pragma once

#include "bake/exact/frame.hpp"
#include "bake/exact/query.hpp"
#include "bake/exact/scene_tree.hpp"

namespace antumbra::exact {

/// One cell's occluders. A hidden box may stand for all that it holds: every line from the cell that would enter it is
/// blocked before, so any polygon inside it may be taken for an occluder of both sides. Of a box that is not hidden as a
/// whole, a face that no line from one face of the cell reaches occludes from its front, for lines from that face
/// (proven-empty line sets, handed down to what lies behind).
class OccludersAlong final : public OccluderSource {
  public:
    /// `joined`: neighbouring triangles also as one occluder (ConvexPatches); never for certificates, whose blockers are triangles.
    explicit OccludersAlong(const SceneTree& tree, bool joined = false);

    void forget_hidden();
    void mark_hidden(std::uint32_t node) { mark(node, kHidden); }
    bool is_hidden(std::uint32_t node) const { return (marks_[node] & kHidden) != 0; }
    /// No line from face `from` of the cell reaches face `to` of the node's box (faces: 2 * axis + side).
    void mark_pair(std::uint32_t node, int from, int to) { mark(node, std::uint64_t(1) << (6 * from + to)); }
    bool is_pair_hidden(std::uint32_t node, int from, int to) const { return marks_[node] >> (6 * from + to) & 1; }
    const std::vector<std::uint32_t>& marked() const { return marked_; } ///< nodes with any mark
    /// The face of the cell that the following queries start from; -1: hidden faces do not take part.
    void start_from(int face) { from_ = face; }
    /// Walk along segments from their ends? Where lines are closer to each other, an occluder blocks more of them.
    void look_from_end(bool from_end) { from_end_ = from_end; }

    bool near_segment(const Vec3d& p, const Vec3d& q, std::size_t limit, std::vector<OccluderId>& found) override;
    bool in_hull(std::span<const GridPlane> around, std::vector<OccluderId>& found) override;
    const certify::Polygon& polygon(OccluderId id) override;
    bool is_flat(OccluderId id) override { return !is_patch(id) || tree_.patches().is_flat(id - kPatch); }
    OccluderId whole_of(OccluderId id) override {
        std::uint32_t patch = joined_ && id < kPatch ? tree_.patches().of(id) : ConvexPatches::kNone;
        return patch == ConvexPatches::kNone ? id : kPatch + patch;
    }

    bool has_neighbours(OccluderId id) override { return id < kPatch; }
    bool neighbours(OccluderId id, std::size_t edge, std::vector<OccluderId>& found) override;

    /// Ids of polygons inside hidden boxes: kVirtual + 12 * node + k; of hidden faces: kFace + 6 * node + face; of joined
    /// triangles: kPatch + patch.
    static constexpr OccluderId kVirtual = 0x80000000u, kFace = 0x40000000u, kPatch = 0x20000000u;
    static bool is_patch(OccluderId id) { return id >= kPatch && id < kFace; }
    static std::array<GridPoint, 4> virtual_polygon(const GridBox& box, int k);

  private:
    static constexpr std::uint64_t kHidden = std::uint64_t(1) << 63;
    void mark(std::uint32_t node, std::uint64_t bits) {
        if (marks_[node] == 0)
            marked_.push_back(node);
        marks_[node] |= bits;
    }
    const SceneTree& tree_;
    bool joined_;
    std::vector<std::uint64_t> marks_; ///< per node
    std::vector<std::uint32_t> marked_;
    int from_ = -1;
    bool from_end_ = false;
    certify::Polygon polygon_;
    std::vector<std::uint32_t> stack_;
};

} // namespace antumbra::exact
