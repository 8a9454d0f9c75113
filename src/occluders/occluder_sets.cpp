#include "occluders/occluder_sets.hpp"

#include <algorithm>
#include <numeric>

namespace antumbra {
namespace {

struct Scored {
    double score;
    std::uint32_t polygon;
    bool operator<(const Scored& other) const { return score != other.score ? score > other.score : polygon < other.polygon; }
};

std::array<Vec3d, OccluderSets::kDirections> directions() {
    std::array<Vec3d, OccluderSets::kDirections> list;
    for (int axis = 0; axis < 3; ++axis)
        for (int side = 0; side < 2; ++side)
            list[static_cast<std::size_t>(2 * axis + side)][axis] = side ? 1 : -1;
    double s = std::sqrt(1.0 / 3);
    for (std::size_t corner = 0; corner < 8; ++corner)
        list[6 + corner] = {corner & 1 ? s : -s, corner & 2 ? s : -s, corner & 4 ? s : -s};
    return list;
}

std::vector<std::uint32_t> largest(const OccluderSet& set, const OccluderSetsOptions& options) {
    std::vector<std::uint32_t> polygons;
    for (std::uint32_t p = 0; p < set.polygons.size(); ++p)
        if (set.polygons[p].count <= options.most_corners && !set.polygons[p].synthetic)
            polygons.push_back(p);
    std::stable_sort(polygons.begin(), polygons.end(), [&](std::uint32_t a, std::uint32_t b) {
        return set.polygons[a].area > set.polygons[b].area;
    });
    polygons.resize(std::min<std::size_t>(polygons.size(), options.most_polygons));
    return polygons;
}

} // namespace

OccluderSets OccluderSets::build(const OccluderSet& set, const Box3f& space, const OccluderSetsOptions& options) {
    OccluderSets sets;
    if (space.empty())
        return sets;
    sets.space_ = to_double(space);
    // Halving the longest side again and again is a balanced kd-tree over empty space, that is, a grid.
    Vec3d cell = sets.space_.size();
    for (std::uint32_t leaves = 1; leaves < options.leaves; leaves *= 2) {
        int axis = cell.x >= cell.y && cell.x >= cell.z ? 0 : cell.y >= cell.z ? 1 : 2;
        sets.count_[static_cast<std::size_t>(axis)] *= 2;
        cell[axis] /= 2;
    }
    std::vector<std::uint32_t> polygons = largest(set, options);
    const std::array<Vec3d, kDirections> ways = directions();
    std::vector<Scored> scored[kDirections];
    for (std::uint32_t k = 0; k < sets.count_[2]; ++k)
        for (std::uint32_t j = 0; j < sets.count_[1]; ++j)
            for (std::uint32_t i = 0; i < sets.count_[0]; ++i) {
                Vec3d middle = sets.space_.min + Vec3d{cell.x * (i + 0.5), cell.y * (j + 0.5), cell.z * (k + 0.5)};
                for (std::uint32_t p : polygons) {
                    const OccluderPolygon& polygon = set.polygons[p];
                    Vec3d sight = polygon.centre - middle;
                    double squared = dot(sight, sight) + 0.05 * polygon.area;
                    for (std::size_t d = 0; d < kDirections; ++d) {
                        double facing = -dot(polygon.normal, ways[d]);
                        if (options.shown == OccluderSetsOptions::Shown::backs)
                            facing = -facing;
                        if (polygon.double_sided)
                            facing = std::abs(facing);
                        // Behind the viewer nothing hides; large polygons may begin behind and reach ahead.
                        if (facing > 0.05 && dot(sight, ways[d]) > -std::sqrt(polygon.area))
                            scored[d].push_back({polygon.area * facing / squared, p});
                    }
                }
                for (std::vector<Scored>& list : scored) {
                    sets.first_.push_back(static_cast<std::uint32_t>(sets.polygons_.size()));
                    std::size_t keep = std::min<std::size_t>(options.per_set, list.size());
                    std::partial_sort(list.begin(), list.begin() + static_cast<std::ptrdiff_t>(keep), list.end());
                    for (std::size_t n = 0; n < keep; ++n)
                        sets.polygons_.push_back(list[n].polygon);
                    list.clear();
                }
            }
    sets.first_.push_back(static_cast<std::uint32_t>(sets.polygons_.size()));
    return sets;
}

std::span<const std::uint32_t> OccluderSets::at(const Vec3d& place, const Vec3d& direction) const {
    if (first_.empty())
        return {};
    std::size_t index = 0;
    for (int axis = 2; axis >= 0; --axis) {
        auto count = count_[static_cast<std::size_t>(axis)];
        double share = (place[axis] - space_.min[axis]) / (space_.max[axis] - space_.min[axis]);
        double cell = std::clamp(share * count, 0.0, count - 1.0); // NaN becomes 0
        index = index * count + static_cast<std::size_t>(cell > 0 ? cell : 0);
    }
    static const std::array<Vec3d, kDirections> ways = directions();
    std::size_t best = 0;
    for (std::size_t d = 1; d < kDirections; ++d)
        if (dot(ways[d], direction) > dot(ways[best], direction))
            best = d;
    std::size_t set = index * kDirections + best;
    return {polygons_.data() + first_[set], first_[set + 1] - first_[set]};
}

} // namespace antumbra
