#include "rays/prepared_ray.hpp"

#include <algorithm>
#include <cmath>

namespace antumbra::rays {
namespace {

double largest(const Vec3d& v) {
    return std::max({std::abs(v.x), std::abs(v.y), std::abs(v.z)});
}

} // namespace

bool prepare(const Vec3d& origin, const Vec3d& direction, double scene_size, PreparedRay& ray) {
    double size = largest(direction), reach = largest(origin);
    // A sum with a NaN or an infinity in it is not finite; three large numbers must not overflow.
    bool finite = std::isfinite(direction.x * 0x1p-2 + direction.y * 0x1p-2 + direction.z * 0x1p-2) &&
                  std::isfinite(origin.x * 0x1p-2 + origin.y * 0x1p-2 + origin.z * 0x1p-2);
    if (!(size > 0) || !finite || !(reach <= kFarthestOrigin))
        return false;
    if (size < kSmallestFast) {
        bool possible = prepare(origin, direction * 0x1p600, scene_size, ray);
        ray.unit *= 0x1p600;
        return possible;
    }
    ray.unit = inverse_power(size);
    ray.margin = kMargin * (reach + scene_size);
    int z = 0;
    for (int k = 0; k < 3; ++k) {
        double d = direction[k] * ray.unit;
        double o = origin[k];
        ray.origin[k] = o;
        ray.direction[k] = d;
        if (std::abs(d) > std::abs(ray.direction[z]))
            z = k;
        ray.inverse[k] = std::abs(d) < 1 / kLargestInverse ? std::copysign(kLargestInverse, d) : 1 / d;
        bool down = ray.inverse[k] < 0;
        double outward =
            2 * ray.margin + std::abs(o) * 0x1p-22; // the second part outweighs rounding to float
        ray.near_origin[k] = static_cast<float>(down ? o - outward : o + outward);
        ray.far_origin[k] = static_cast<float>(down ? o + outward : o - outward);
        ray.near_inverse[k] = static_cast<float>(ray.inverse[k] * (1 - 0x1p-21));
        ray.far_inverse[k] = static_cast<float>(ray.inverse[k] * (1 + 0x1p-21));
        ray.near_row[k] = 2 * k + down;
        ray.far_row[k] = 2 * k + !down;
    }
    choose_axes(z, ray);
    return true;
}

} // namespace antumbra::rays
