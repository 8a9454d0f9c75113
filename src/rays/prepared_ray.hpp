// What a ray's tests share, computed once per ray.
#pragma once

#include "rays/caster.hpp"

namespace antumbra::rays {

/// The direction is scaled by a power of two such that its largest component lies in [1, 2); `t` of kernels is in
/// units of that direction.
struct PreparedRay {
    double origin[3], direction[3];
    double inverse[3];       ///< 1 / direction, at most 2^64 in size
    double shear_x, shear_y, shear_z;
    double margin;           ///< by which boxes grow: see prepare()
    double unit;             ///< t of a kernel times this is t of the caller's ray
    int axis_x, axis_y, axis_z; ///< cyclic; z is the direction's largest component
    bool against;            ///< direction[axis_z] < 0
    float near_origin[3], far_origin[3]; ///< for the planes of a box met first and last: the origin, rounded and
                                         ///< moved by twice the margin so that boxes grow
    float near_inverse[3], far_inverse[3];
    int near_row[3], far_row[3]; ///< rows of WideNode::bounds
};

/// Prepares a ray for a scene whose largest coordinate is `scene_size`; false if it cannot hit anything: origin or
/// direction not finite, no direction, or an origin so far away that the scene is a point.
///
/// The margin. Let S = the largest |origin| plus the largest |coordinate|, u = 2^-53. A corner relative to the origin
/// is off by u S at most, sheared by 7 u S, so the triangle that the kernels' edge test sees lies within 7 sqrt(2) u S
/// of the true one: whenever the edges accept it by more than the noise of collinear corners, the ray passes
/// within that of a point of the triangle, thus within 10 u S of its box. The margin is 128 u S.
///
/// Components of the direction below 2^-64 move a point by less than 2^-64 S on its way through the scene, far less
/// than the margin; their inverse is cut off there, which keeps 0 * infinity out of the slabs and an origin on a box
/// plane inside the (grown) slab.
bool prepare(const Vec3d& origin, const Vec3d& direction, double scene_size, PreparedRay& ray);

} // namespace antumbra::rays
