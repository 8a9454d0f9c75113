// Relations of one occluder and one box (Coorg, Teller 1997, "conservative visibility testing"): the supporting and
// separating planes, which do not depend on the viewpoint, formed by tangent look-up and kept while the viewer moves.
#pragma once

#include <antumbra/occluders.hpp>

#include <cstdint>
#include <vector>

namespace antumbra {

inline constexpr std::uint32_t kMostEdges = 8; ///< of an occluder

enum class Occlusion : std::uint8_t { none, partial, full };

/// Where lines of sight come from: a point, or a direction (weight 0), as of parallel lines of sight. The planes of a relation do
/// not depend on it, and a viewpoint that moves away for ever along a direction is in the end on the side that the direction
/// points to.
struct Viewpoint {
    Vec3d at;
    double weight = 1;
    Viewpoint(const Vec3d& place, double of_weight) : at(place), weight(of_weight) {}
};

/// Unit normal and offset; the occluder is on the positive side.
struct RelationPlane {
    Vec3d normal;
    double offset = 0;
    double at(const Vec3d& p) const { return dot(normal, p) + offset; }
    double at(const Viewpoint& v) const { return dot(normal, v.at) + offset * v.weight; }
};

/// A pair of planes per occluder edge.
struct Relation {
    std::uint64_t key = ~std::uint64_t(0);
    std::uint32_t last_used = 0; ///< frame
    std::uint32_t edges = 0;
    bool possible = false; ///< false: the box does not lie wholly behind the occluder, or a plane is uncertain
    RelationPlane supporting[kMostEdges], separating[kMostEdges];
};

/// Which side of an occluder is its front for an eye: relations of the two sides are apart.
inline std::uint64_t relation_key(std::uint32_t box, std::uint32_t occluder, bool front) {
    return (std::uint64_t(box) << 32 | occluder) << 1 | std::uint64_t(front);
}

/// Strictly, as seen from `side` (1: the polygon's front, -1: its back), by more than `margin`: coplanar walls stay
/// visible.
bool is_behind(const Box3f& box, const OccluderPolygon& polygon, double side, double margin);

/// Fills all but key and last_used. `margin`: the planes are no more certain than that.
void form_relation(const OccluderSet& set, const OccluderPolygon& polygon, const Box3d& box, double margin,
                   Relation& relation);

/// Full: the viewpoint is certainly inside of all supporting planes; none: certainly outside of a separating one.
Occlusion classify(const Relation& relation, const Viewpoint& viewpoint, double margin);
inline Occlusion classify(const Relation& relation, const Vec3d& eye, double margin) {
    return classify(relation, Viewpoint(eye, 1), margin);
}

/// Relations in at most `bytes` (rounded down to a power of two of entries). What was used longest ago makes room, so
/// that relations of boxes outside the frustum, or below nodes that are decided already, stay until they are needed.
class RelationCache {
  public:
    void reset(std::uint64_t bytes);
    bool empty() const { return entries_.empty(); }
    void begin_frame() { ++frame_; }
    std::uint64_t bytes() const { return entries_.size() * sizeof(Relation); }

    /// The relation with that key. `known` tells whether it was there; if not, it is to be formed by the caller.
    Relation& find(std::uint64_t key, bool& known);

  private:
    static constexpr std::size_t kWays = 4;
    std::vector<Relation> entries_;
    std::uint32_t frame_ = 0;
    int shift_ = 63; ///< of the hash, to the number of a set of kWays entries
};

} // namespace antumbra
