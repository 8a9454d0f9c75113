// Occludee volumes: a coarse grid of boxes over the scene. What a ray passes through on its way to the first hit can be
// seen; a moving thing inside a volume that is not seen from a cell cannot be seen from there either.
#pragma once

#include "rays/caster.hpp"

#include <antumbra/pvs.hpp>
#include <antumbra/scene.hpp>

#include <algorithm>
#include <array>
#include <cmath>

namespace antumbra {

class VolumeGrid {
  public:
    /// `count` boxes along each axis over the scene's bounds, grown by one step; a count of 0 means no volumes.
    VolumeGrid(const Scene& scene, const std::array<std::uint32_t, 3>& count) {
        for (std::uint32_t one : count)
            if (one == 0)
                return;
        Box3d local = to_double(scene.local_bounds());
        for (int k = 0; k < 3; ++k) {
            low_[k] = local.min[k] - scene.step();
            size_[k] = (local.max[k] + scene.step() - low_[k]) / count[std::size_t(k)];
        }
        grid_.count = count;
        Vec3d high = low_ + Vec3d{size_.x * count[0], size_.y * count[1], size_.z * count[2]};
        grid_.bounds = {scene.to_world(low_), scene.to_world(high)};
    }

    /// World coordinates; no cells where there are no volumes.
    const CellGrid& grid() const { return grid_; }
    std::uint64_t count() const { return grid_.cells(); }

    /// A point (local) uniform in a volume, from three numbers in [0, 1).
    Vec3d point_in(std::uint64_t volume, double u, double v, double w) const {
        std::array<std::uint64_t, 3> at = {volume % grid_.count[0], volume / grid_.count[0] % grid_.count[1],
                                           volume / grid_.count[0] / grid_.count[1]};
        return low_ + Vec3d{(double(at[0]) + u) * size_.x, (double(at[1]) + v) * size_.y, (double(at[2]) + w) * size_.z};
    }

    /// Calls visit(volume, middle) for the volumes that the ray passes through between its origin and `end` (in units of
    /// its direction), with a point of the ray in each. Volumes that it only grazes may be left out. O(volumes passed).
    template <class Visit>
    void walk(const Ray& ray, double end, const Visit& visit) const {
        // The parameters at which the ray crosses planes of the grid, one axis at a time, in order.
        double from = 0;
        std::array<double, 3> next{}, stride{};
        for (int k = 0; k < 3; ++k) {
            double d = ray.direction[k], o = ray.origin[k] - low_[k], whole = size_[k] * grid_.count[std::size_t(k)];
            if (d == 0) {
                if (o < 0 || o > whole)
                    return;
                next[std::size_t(k)] = stride[std::size_t(k)] = std::numeric_limits<double>::infinity();
                continue;
            }
            from = std::max(from, ((d > 0 ? 0 : whole) - o) / d);
            end = std::min(end, ((d > 0 ? whole : 0) - o) / d);
            stride[std::size_t(k)] = size_[k] / std::abs(d);
        }
        for (int k = 0; k < 3; ++k)
            if (double d = ray.direction[k]; d != 0) {
                double cell = (ray.origin[k] + d * from - low_[k]) / size_[k];
                double plane = d > 0 ? std::floor(cell) + 1 : std::ceil(cell) - 1;
                next[std::size_t(k)] = (low_[k] + plane * size_[k] - ray.origin[k]) / d;
            }
        while (from < end) {
            std::size_t axis = next[0] < next[1] ? (next[0] < next[2] ? 0 : 2) : (next[1] < next[2] ? 1 : 2);
            double to = std::min(next[axis], end);
            if (to > from) {
                Vec3d middle = ray.origin + ray.direction * ((from + to) / 2);
                if (std::int64_t volume = volume_of(middle); volume >= 0)
                    visit(std::uint64_t(volume), middle);
                from = to;
            }
            if (!(next[axis] < end))
                return;
            next[axis] += stride[axis];
        }
    }

    /// The volume strictly around a local point, -1 on a face or outside.
    std::int64_t volume_of(const Vec3d& point) const {
        std::uint64_t index = 0;
        for (int k = 2; k >= 0; --k) {
            double cell = (point[k] - low_[k]) / size_[k], whole = std::floor(cell);
            if (!(cell > whole) || whole < 0 || whole >= grid_.count[std::size_t(k)])
                return -1;
            index = index * grid_.count[std::size_t(k)] + std::uint64_t(whole);
        }
        return std::int64_t(index);
    }

  private:
    CellGrid grid_;
    Vec3d low_, size_{1, 1, 1}; ///< local
};

} // namespace antumbra
