#include "evaluate/pixel_rays.hpp"

namespace antumbra {

double half_tangent(double degrees) {
    constexpr double kPi = 3.14159265358979323846;
    // Above 90 degrees through the complement, where the fraction converges best.
    bool wide = degrees > 90;
    double angle = (wide ? 90 - degrees / 2 : degrees / 2) * (kPi / 180);
    double square = angle * angle, fraction = 0;
    for (int odd = 29; odd >= 3; odd -= 2)
        fraction = square / (odd - fraction);
    double tangent = angle / (1 - fraction);
    return wide ? 1 / tangent : tangent;
}

PixelRays PixelRays::of_view(const View& view, std::uint32_t width, std::uint32_t height) {
    PixelRays rays;
    rays.orthographic_ = view.projection == Projection::orthographic;
    rays.eye_ = view.eye;
    rays.width_ = width;
    rays.height_ = height;
    rays.forward_ = normalized(view.target - view.eye);
    Vec3d right = normalized(cross(rays.forward_, view.up));
    double half_height = rays.orthographic_ ? view.height / 2 : half_tangent(view.fov_y_deg);
    rays.right_ = right * (half_height * width / height);
    rays.up_ = cross(right, rays.forward_) * half_height;
    return rays;
}

PixelRays PixelRays::of_cube_face(const Vec3d& eye, int face, std::uint32_t size) {
    PixelRays rays;
    rays.eye_ = eye;
    rays.width_ = rays.height_ = size;
    int axis = face / 2;
    rays.forward_[axis] = face % 2 ? -1 : 1;
    rays.right_[(axis + 1) % 3] = 1;
    rays.up_[(axis + 2) % 3] = 1;
    return rays;
}

} // namespace antumbra
