// Groups of polygons that look convex from outside: what the object-space methods take as one occluder.
#pragma once

#include <antumbra/occluders.hpp>

namespace antumbra {

/// Up to kMostMembers connected polygons; each lies behind the planes of the others (or in one plane with them,
/// convex together), like the faces of a convex solid. Only a hint: that they hide something together is decided
/// anew from each viewpoint, and is sound for any set of polygons.
struct ConvexGroups {
    static constexpr std::uint32_t kMostMembers = 8;
    struct Group {
        std::uint32_t first = 0, count = 0; ///< into members
        double area = 0;                    ///< the largest that any viewpoint sees, roughly
        Vec3d centre;
        Box3f box;
    };
    std::vector<Group> groups; ///< largest first
    std::vector<std::uint32_t> members; ///< polygons; the largest of a group comes first
};

/// Greedy, from the largest polygon on. Keeps the `most_groups` largest. O(n log n).
ConvexGroups find_convex_groups(const OccluderSet& set, std::uint32_t most_groups);

/// Chunk OGRP of a .pvs file (docs/format.md, section 6) and back. ErrorCode::corrupt for members that are not in `set` or
/// groups that are empty or too large.
std::vector<std::byte> encode_groups(const ConvexGroups& groups);
Result<ConvexGroups> decode_groups(std::span<const std::byte> bytes, const OccluderSet& set);

/// Area, centre and box of a group, from its members.
void measure_group(const OccluderSet& set, std::span<const std::uint32_t> members, ConvexGroups::Group& group);

} // namespace antumbra
