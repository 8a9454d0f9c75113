// Which occluders to draw from where: for the points of a grid and the six directions along the axes, a list of
// occluder polygons, best first (Poon, Wang 1999: the database of minimum occluder sets, but any criterion will do).
//
// Run-time module: standard library only, no exceptions. A list is only a proposal: whatever it holds, what a
// conservative culler hides with it is hidden.
#pragma once

#include <antumbra/math.hpp>
#include <antumbra/status.hpp>

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

namespace antumbra {

/// Plain data; coordinates are local (see scene.hpp). Reading is thread-safe.
struct OccluderDatabase {
    /// +x, -x, +y, -y, +z, -z; the list of a direction serves the pyramid of a right angle around it.
    static constexpr std::uint32_t kDirections = 6;

    Vec3d origin;                                ///< of the first grid point
    Vec3d step{1, 1, 1};                         ///< between grid points, positive
    std::array<std::uint32_t, 3> count{1, 1, 1}; ///< grid points along each axis, at least 1
    /// List of point p and direction d: polygons[first[6 p + d] .. first[6 p + d + 1]), indices into
    /// OccluderSet::polygons. Points in rows along x, then y, then z.
    std::vector<std::uint32_t> first, polygons;

    std::size_t points() const { return std::size_t(count[0]) * count[1] * count[2]; }
    Vec3d point(std::size_t index) const;
    /// The grid point nearest to `eye`; NaN gives some point.
    std::size_t nearest(const Vec3d& eye) const;
    /// Empty if the database is.
    std::span<const std::uint32_t> list(std::size_t point, std::uint32_t direction) const;
    static Vec3d direction(std::uint32_t index);
};

/// ErrorCode::corrupt if the lists do not fit together, name one of `polygon_count` polygons that does not exist, or the
/// grid makes no sense. Whoever reads a database from elsewhere calls this first. O(size).
Status check_occluder_database(const OccluderDatabase& database, std::size_t polygon_count);

/// As bytes (docs/format.md, chunk MOSD), and back. decode gives ErrorCode::corrupt for anything that encode cannot
/// have written or that check_occluder_database() refuses; hostile bytes cost no more memory than eight times their own.
std::vector<std::byte> encode_occluder_database(const OccluderDatabase& database);
Result<OccluderDatabase> decode_occluder_database(std::span<const std::byte> bytes, std::size_t polygon_count);

} // namespace antumbra
