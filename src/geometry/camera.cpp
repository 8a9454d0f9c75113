#include "geometry/camera.hpp"

namespace antumbra {
namespace {

constexpr double kPi = 3.14159265358979323846;

/// Sine and cosine of x in [0, pi/4], Taylor: the first term left out is below 1e-18.
void small_sine_cosine(double x, double& sine, double& cosine) {
    double square = x * x;
    sine = cosine = 0;
    for (int n = 10; n >= 1; --n) {
        sine = (1 + sine) * (-square / double((2 * n) * (2 * n + 1)));
        cosine = (1 + cosine) * (-square / double((2 * n - 1) * (2 * n)));
    }
    sine = x * (1 + sine);
    cosine = 1 + cosine;
}

double norm1(const Vec3d& v) { return std::abs(v.x) + std::abs(v.y) + std::abs(v.z); }

/// The plane through eye + way * reach with that normal; `way` has unit length.
HalfSpace through(const Camera& camera, const Vec3d& way, double reach, const Vec3d& normal) {
    Vec3d unit = normalized(normal);
    HalfSpace plane{unit, -dot(unit, camera.eye + way * reach)};
    plane.error_slope = camera.turn;
    plane.error_at_origin = camera.turn * (norm1(camera.eye) + std::abs(reach));
    return plane;
}

} // namespace

HalfAngle half_angle(double degrees) {
    HalfAngle result;
    if (degrees <= 90)
        small_sine_cosine(degrees * (kPi / 360), result.sine, result.cosine);
    else // 90 - degrees/2 is exact, so that the cosine of a wide angle keeps its digits
        small_sine_cosine((90 - degrees / 2) * (kPi / 180), result.cosine, result.sine);
    return result;
}

Camera look_along(const Vec3d& eye, const Vec3d& direction, const Vec3d& up) {
    Camera camera;
    camera.eye = eye;
    camera.forward = normalized(direction);
    Vec3d right = cross(camera.forward, normalized(up));
    camera.right = normalized(right);
    camera.turn = 1e-14 / length(right);
    camera.up = cross(camera.right, camera.forward);
    return camera;
}

ViewVolume view_volume(const Camera& camera) {
    ViewVolume volume;
    auto add = [&](const HalfSpace& plane) { volume.planes[static_cast<std::size_t>(volume.count++)] = plane; };
    for (double sign : {1.0, -1.0}) {
        if (camera.orthographic) {
            add(through(camera, camera.right, -sign * camera.half_width, camera.right * sign));
            add(through(camera, camera.up, -sign * camera.half_height, camera.up * sign));
        } else {
            add(through(camera, camera.right, 0, camera.right * sign + camera.forward * camera.half_width));
            add(through(camera, camera.up, 0, camera.up * sign + camera.forward * camera.half_height));
        }
    }
    add(through(camera, camera.forward, camera.near_plane, camera.forward));
    if (std::isfinite(camera.far_plane))
        add(through(camera, camera.forward, camera.far_plane, -camera.forward));
    return volume;
}

} // namespace antumbra
