// What a ray's tests share, computed once per ray.
#pragma once

#include "rays/caster.hpp"

#include <bit>

namespace antumbra::rays {

/// The direction is scaled by a power of two such that its largest component lies in [1, 2); `t` of kernels
/// is in units of that direction.
struct alignas(32) PreparedRay {
    double origin[4], direction[4]; ///< (three, and one for company)
    double inverse[4];              ///< 1 / direction, at most 2^64 in size
    double shear_x, shear_y, shear_z;
    double margin;                    ///< by which boxes grow: see prepare()
    double unit;                      ///< t of a kernel times this is t of the caller's ray
    int axis_x, axis_y, axis_z;       ///< cyclic; z is the direction's largest component
    bool against;                     ///< direction[axis_z] < 0
    alignas(16) float near_origin[4]; ///< for the planes of a box met first and last: the origin, rounded and
                                      ///< moved by twice the margin so that boxes grow
    alignas(16) float far_origin[4];
    alignas(16) float near_inverse[4];
    alignas(16) float far_inverse[4];
    int near_row[3], far_row[3]; ///< rows of WideNode::bounds
};

/// Prepares a ray for a scene whose largest coordinate is `scene_size`; false if it cannot hit anything:
/// origin or direction not finite, no direction, or an origin so far away that the scene is a point.
///
/// The margin. Let S = the largest |origin| plus the largest |coordinate|, u = 2^-53. A corner relative to
/// the origin is off by u S at most, sheared by 8 u S, so the triangle that the kernels' edge test sees lies
/// within 8 sqrt(2) u S of the true one: whenever the edges accept it by more than the noise of collinear
/// corners, the ray passes within that of a point of the triangle, thus within 12 u S of its box. The margin
/// is 128 u S.
///
/// Components of the direction below 2^-64 move a point by less than 2^-64 S on its way through the scene,
/// far less than the margin; their inverse is cut off there, which keeps 0 * infinity out of the slabs and an
/// origin on a box plane inside the (grown) slab.
bool prepare(const Vec3d& origin, const Vec3d& direction, double scene_size, PreparedRay& ray);

// What the SIMD twins of prepare() share with it.

inline constexpr double kFarthestOrigin = 0x1p100;
inline constexpr double kLargestInverse = 0x1p64;
inline constexpr double kMargin = 0x1p-46;
inline constexpr double kSmallestFast = 0x1p-900; ///< shorter directions take a detour

/// 2^-e for a normal x = f * 2^e, f in [1, 2).
inline double inverse_power(double x) {
    auto exponent = std::bit_cast<std::uint64_t>(x) >> 52; // biased: e + 1023
    return exponent >= 2046 ? 0x1p-1023 : std::bit_cast<double>((2046 - exponent) << 52);
}

/// Fills in what follows from the direction's largest component.
inline void choose_axes(int z, PreparedRay& ray) {
    ray.axis_z = z;
    ray.axis_x = z == 2 ? 0 : z + 1;
    ray.axis_y = z == 0 ? 2 : z - 1;
    ray.shear_z = ray.inverse[z];
    ray.shear_x = ray.direction[ray.axis_x] * ray.inverse[z];
    ray.shear_y = ray.direction[ray.axis_y] * ray.inverse[z];
    ray.against = ray.direction[z] < 0;
}

} // namespace antumbra::rays
