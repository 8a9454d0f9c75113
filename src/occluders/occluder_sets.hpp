// Occluders per place and direction, found in preprocessing (Coorg, Teller 1997, "dynamic occluder selection"): space
// is cut into leaves, and each leaf knows, for a number of viewing directions, the polygons of the largest area-angle
//     - area (normal . direction) / |centre - viewpoint|^2
// seen from its middle.
#pragma once

#include "base/bytes.hpp"

#include <antumbra/occluders.hpp>

#include <array>

namespace antumbra {

struct OccluderSetsOptions {
    std::uint32_t leaves = 256;       ///< rounded up to a power of two
    std::uint32_t per_set = 32;
    std::uint32_t most_polygons = 8192; ///< only the largest are looked at
    std::uint32_t most_corners = 8;
    /// Single-sided polygons count when they turn this side to the leaf.
    enum class Shown : std::uint8_t { fronts, backs };
    Shown shown = Shown::fronts;
};

class OccluderSets {
  public:
    static constexpr std::size_t kDirections = 14; ///< along the axes and the diagonals

    /// `space`: where viewpoints and objects can be. O(leaves * directions * polygons).
    static OccluderSets build(const OccluderSet& set, const Box3f& space, const OccluderSetsOptions& options);

    /// Sets of anything, made elsewhere: members[leaf * kDirections + direction], leaves x first, then y, then z.
    static OccluderSets of_members(const Box3f& space, const std::array<std::uint32_t, 3>& count,
                                   const std::vector<std::vector<std::uint32_t>>& members);
    /// How build() cuts space into at least so many leaves.
    static std::array<std::uint32_t, 3> cut(const Box3f& space, std::uint32_t leaves);
    static const std::array<Vec3d, kDirections>& directions();

    /// The set of the leaf that holds `place` (the nearest one outside of the space) and the direction closest to
    /// `direction`; best first.
    std::span<const std::uint32_t> at(const Vec3d& place, const Vec3d& direction) const;

    bool empty() const { return first_.empty(); }
    /// Of all sets together.
    std::span<const std::uint32_t> members() const { return polygons_; }

    /// One family of chunk OSET of a .pvs file (docs/format.md, section 6), and back from `at`, which moves behind it.
    /// ErrorCode::corrupt unless every set holds nothing but numbers below `items`.
    void encode(ByteWriter& out) const;
    static Result<OccluderSets> decode(std::span<const std::byte> bytes, std::size_t& at, std::size_t items);

  private:
    Box3d space_;
    std::array<std::uint32_t, 3> count_{1, 1, 1};
    std::vector<std::uint32_t> first_; ///< per leaf and direction, into polygons_; one more at the end
    std::vector<std::uint32_t> polygons_;
};

} // namespace antumbra
