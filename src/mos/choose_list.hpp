// One list of occluders: for one viewpoint and direction, by any of the criteria.
#pragma once

#include "mos/select_sets.hpp"

#include <antumbra/mos.hpp>

namespace antumbra {

/// What shall be hidden: an object, or small objects that lie together.
struct Occludee {
    Box3f box;
    std::uint32_t primitives = 0; ///< triangles
};

/// Of more than options.least_primitives triangles; objects are taken together down a hierarchy of boxes while they have
/// at most options.most_primitives.
std::vector<Occludee> find_occludees(const Scene& scene, const MosOptions& options);

/// Polygons of `set`, best first, at most options.limit. `screen` is perspective. A pure function of its arguments.
std::vector<std::uint32_t> choose_list(const OccluderSet& set, std::span<const Occludee> occludees,
                                       const Screen& screen, const MosOptions& options,
                                       MosStatistics* statistics = nullptr);

/// The camera of a grid point and direction: a right angle each way.
Screen picture_of(const Vec3d& point, std::uint32_t direction, int resolution, double extent);

} // namespace antumbra
