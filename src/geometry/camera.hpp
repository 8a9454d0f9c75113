// A view volume as an orthonormal frame and as half-spaces. No libm transcendental takes part, so that the same
// camera is the same on every machine.
#pragma once

#include <antumbra/math.hpp>

#include <array>

namespace antumbra {

/// Orthonormal frame (right, up, forward) at `eye`. Perspective: a point at depth z = dot(p - eye, forward) is in
/// view when |x| <= z * half_width and |y| <= z * half_height; orthographic: |x| <= half_width, |y| <= half_height.
struct Camera {
    bool orthographic = false;
    Vec3d eye, right, up, forward;
    double half_width = 1, half_height = 1; ///< perspective: at depth 1
    double near_plane = 0, far_plane = std::numeric_limits<double>::infinity();
    /// Bound of the angle (radians) by which rounding may have turned the frame; grows as up nears forward.
    double turn = 0;
};

/// Half-space normal . p + offset >= 0; the normal has unit length. At a point p the computed value is off by at
/// most error_at_origin + error_slope * |p|_1, the rounding of the camera itself included.
struct HalfSpace {
    Vec3d normal;
    double offset = 0;
    double error_at_origin = 0, error_slope = 0;
};

/// The four sides, near, and far if it is finite.
struct ViewVolume {
    std::array<HalfSpace, 6> planes;
    int count = 0;
};

/// `direction` and `up` finite, not zero, not parallel. tan(fov/2) is formed from sine_half and cosine_half.
Camera look_along(const Vec3d& eye, const Vec3d& direction, const Vec3d& up);

/// Sine and cosine of half the angle `degrees` in (0, 180], by series, error below 2e-16.
struct HalfAngle {
    double sine = 0, cosine = 0;
};
HalfAngle half_angle(double degrees);

ViewVolume view_volume(const Camera& camera);

} // namespace antumbra
