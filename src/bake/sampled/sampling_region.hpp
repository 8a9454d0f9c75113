// A box in the five-dimensional space of views: where the eye is and which way it looks (Gotsman, Sudarsky, Fayman
// 1999, section 3).
//
// Angles are the numbers of pvs.hpp (see ViewAxis there), which grow with the angle and need no trigonometry: theta, the
// heading about the up axis (y), in quarter turns from 0 (+x) over 1 (+z), 2, 3 to 4, straight in |z| / (|x| + |z|)
// between; phi, the elevation, as y / (|x| + |y| + |z|), from -1 (down) to 1 (up).
#pragma once

#include "base/random.hpp"

#include <antumbra/math.hpp>

#include <array>

namespace antumbra {

/// Axes of view space, as indices.
enum : int { kAxisX, kAxisY, kAxisZ, kAxisTheta, kAxisPhi, kViewAxes };

using ViewPoint5 = std::array<double, kViewAxes>;

/// Heading in [0, 4) and elevation in [-1, 1] of a direction that is not zero. Straight up and down have heading 0.
inline std::array<double, 2> view_angles(const Vec3d& direction) {
    double x = direction.x, z = direction.z, sum = std::abs(x) + std::abs(z);
    double theta = 0;
    if (sum > 0)
        theta = z >= 0 ? (x >= 0 ? z / sum : 1 - x / sum) : (x < 0 ? 2 - z / sum : 3 + x / sum);
    if (theta >= 4) // a hair below a full turn may round up to it
        theta = 0;
    return {theta, direction.y / (sum + std::abs(direction.y))};
}

/// Half-open in theta, closed in the rest. Space is local.
struct SamplingRegion {
    ViewPoint5 min{0, 0, 0, 0, -1}, max{0, 0, 0, 4, 1};

    static SamplingRegion all_directions(const Box3d& space) {
        return {{space.min.x, space.min.y, space.min.z, 0, -1}, {space.max.x, space.max.y, space.max.z, 4, 1}};
    }
    Box3d space() const { return {{min[0], min[1], min[2]}, {max[0], max[1], max[2]}}; }
    double extent(int axis) const { return max[std::size_t(axis)] - min[std::size_t(axis)]; }
    bool whole_sphere() const { return min[3] == 0 && max[3] == 4 && min[4] == -1 && max[4] == 1; }
    bool holds_direction(const Vec3d& direction) const {
        if (whole_sphere())
            return true;
        auto [theta, phi] = view_angles(direction);
        return theta >= min[3] && (theta < max[3]) && phi >= min[4] && phi <= max[4];
    }
    /// Volume in five dimensions, in the numbers of the angles.
    double volume() const {
        double volume = 1;
        for (int axis = 0; axis < kViewAxes; ++axis)
            volume *= extent(axis);
        return volume;
    }
};

inline Vec3d uniform_point(const Box3d& box, Random& random) {
    Vec3d point;
    for (int k = 0; k < 3; ++k)
        point[k] = random.uniform(box.min[k], box.max[k]);
    return point;
}

/// Uniform on the sphere, of length 1 up to rounding (Marsaglia 1972). Square roots are rounded exactly, so that no libm
/// function is involved.
inline Vec3d uniform_direction(Random& random) {
    for (;;) {
        double u = double(random.next_u32()) * 0x1p-31 - 1, v = double(random.next_u32()) * 0x1p-31 - 1;
        double s = u * u + v * v;
        if (s < 1) {
            double root = 2 * std::sqrt(1 - s);
            return {u * root, 1 - 2 * s, v * root};
        }
    }
}

/// Uniform over the directions of the box. Expected draws: the sphere's share of one quadrant over the box's.
Vec3d uniform_direction(const SamplingRegion& box, Random& random);

/// False only if no direction from a point of `box` to a point of `target` (local) lies in the box's angles.
bool may_look_at(const SamplingRegion& box, const Box3d& target);

} // namespace antumbra
