// Occluders: convex planar polygons that block sight, who shares an edge with whom, and connected patches of them.
//
// Run-time module: standard library only, no exceptions. They are found in meshes by find_occluders() (see
// occluder_finding.hpp); a CullScene turns them into what its methods need.
#pragma once

#include <antumbra/math.hpp>
#include <antumbra/status.hpp>

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

namespace antumbra {

inline constexpr std::uint32_t kNoPolygon = 0x7FFFFFFFu;
/// Set in a neighbour index when both polygons run through the shared edge in the same direction, that is, when
/// they show opposite faces to one side.
inline constexpr std::uint32_t kSameDirection = 0x80000000u;

/// A convex planar polygon. It covers nothing that the triangles it was made of do not cover.
struct OccluderPolygon {
    std::uint32_t first = 0;      ///< into OccluderSet::loops and ::neighbours
    std::uint32_t count = 0;      ///< corners, at least 3; some may be straight angles
    std::uint32_t object = 0;     ///< the object that it came from
    bool double_sided = false;    ///< blocks from both sides, else only from its front
    bool synthetic = false;       ///< face of an inner solid: see OccluderSet::solids
    std::uint32_t solid = kNoPolygon; ///< index into OccluderSet::solids, for synthetic ones
    Vec3d normal;                 ///< unit length, towards the front
    double offset = 0;            ///< normal . p + offset = 0 on the plane
    double area = 0;
    Vec3d centre;                 ///< mean of the corners
};

/// An inner solid stands for the closed shell around it. That holds only for viewers outside of the shell, and, where the
/// shell is closed but for an opening to one side (a house without a floor), on the other side of the opening.
struct OccluderSolid {
    static constexpr float kUnbounded = 3.402823466e38f;

    Box3f shell; ///< bounds of the closed mesh
    /// Lines of sight must begin in here; everywhere unless the shell has an opening.
    Box3f viewers{{-kUnbounded, -kUnbounded, -kUnbounded}, {kUnbounded, kUnbounded, kUnbounded}};

    /// Whether the faces may be used for lines of sight that begin in `start` (around eye and near rectangle).
    bool serves(const Box3d& start) const {
        for (int axis = 0; axis < 3; ++axis)
            if (!(start.min[axis] > double(viewers.min[axis]) && start.max[axis] < double(viewers.max[axis])))
                return false;
        return !to_double(shell).overlaps(start);
    }
    bool is_restricted() const {
        for (int axis = 0; axis < 3; ++axis)
            if (viewers.min[axis] != -kUnbounded || viewers.max[axis] != kUnbounded)
                return true;
        return false;
    }
};

/// A connected group of polygons, small enough to be drawn at once: polygons
/// patch_polygons[first .. first + core) belong to it, the following ones up to first + count are the neighbours
/// around it, which other patches own. Drawing a patch with its ring leaves no crack between patches.
struct OccluderPatch {
    std::uint32_t first = 0, core = 0, count = 0;
    Box3f box; ///< around the polygons it owns
};

/// Plain data; positions are local (see scene.hpp). Whoever fills it by other means than find_occluders() puts it
/// through check_occluders().
struct OccluderSet {
    std::vector<Vec3f> vertices;
    std::vector<std::uint32_t> loops; ///< corners, counter-clockwise seen from the front
    /// Parallel to loops: the polygon on the other side of the edge from corner i to i + 1, or kNoPolygon;
    /// | kSameDirection.
    std::vector<std::uint32_t> neighbours;
    std::vector<OccluderPolygon> polygons;
    std::vector<OccluderSolid> solids;
    std::vector<OccluderPatch> patches;
    std::vector<std::uint32_t> patch_polygons;

    std::span<const std::uint32_t> loop(const OccluderPolygon& polygon) const {
        return {loops.data() + polygon.first, polygon.count};
    }
};

/// Fills normal, offset, area and centre from the loop. A pure function of the corners; the normal is exactly
/// perpendicular but for its own rounding where the corners lie on the grid of a scene.
void measure_occluder(const OccluderSet& set, OccluderPolygon& polygon);

/// ErrorCode::corrupt if an index is out of range, a polygon has fewer than three corners or a number is not finite.
/// Does not check convexity: that is the promise of whoever made the set.
Status check_occluders(const OccluderSet& set);

/// Fills neighbours from equal vertex indices. At edges of more than two polygons each gets one that runs the other
/// way, if there is any. O(n log n).
void connect_occluders(OccluderSet& set);

/// Fills patches: connected polygons, grown breadth first from the largest, at most `most_polygons` owned by one.
/// Needs neighbours.
void group_occluders(OccluderSet& set, std::uint32_t most_polygons = 8);

/// The set as bytes: chunk OCCL of a .pvs file (docs/format.md, section 6). ErrorCode::usage if check_occluders() refuses
/// the set; limit if it has more than 2^32 of anything.
Result<std::vector<std::byte>> encode_occluders(const OccluderSet& set);

/// The set again, number for number. ErrorCode::corrupt for bytes that are no set, whose polygons have no area, or whose
/// neighbours share no edge with them: safe with any content. O(bytes).
Result<OccluderSet> decode_occluders(std::span<const std::byte> bytes);

} // namespace antumbra
