// The rays of a picture: a camera restated for the truth, on purpose without a line of the projection code that
// cullers and rasterisers share, so that a bug there cannot hide itself here.
#pragma once

#include "rays/caster.hpp"

#include <antumbra/cull.hpp>

namespace antumbra {

/// Picture coordinates (x, y) run over [0, width) x [0, height) with y downward; pixel (i, j) has its centre at
/// (i + 0.5, j + 0.5). Near and far planes do not exist for the truth unless asked for (from_depth): a perspective
/// ray starts at the eye, a parallel one in the plane through the eye.
class PixelRays {
  public:
    /// The picture of `view` (local coordinates). The aspect is that of width and height: view.aspect is not read.
    /// `view` must be free of problems (problem_of).
    static PixelRays of_view(const View& view, std::uint32_t width, std::uint32_t height);

    /// Face 0..5 (+x, -x, +y, -y, +z, -z) of the cube around `eye`; the six together see every direction once.
    static PixelRays of_cube_face(const Vec3d& eye, int face, std::uint32_t size);

    /// The same rays, begun at depth `near_plane`: nothing nearer is drawn, so nothing nearer hides.
    PixelRays from_depth(double near_plane) const {
        PixelRays rays = *this;
        rays.near_plane_ = near_plane;
        return rays;
    }

    std::uint32_t width() const { return width_; }
    std::uint32_t height() const { return height_; }
    std::uint64_t pixels() const { return std::uint64_t(width_) * height_; }

    /// The ray through the picture point (x, y). The direction is not of unit length: t is depth along the view.
    Ray at(double x, double y) const {
        double right = 2 * x / width_ - 1, up = 1 - 2 * y / height_;
        Vec3d offset = right_ * right + up_ * up;
        Ray ray = orthographic_ ? Ray{eye_ + offset, forward_} : Ray{eye_, forward_ + offset};
        if (near_plane_ != 0)
            ray.origin = ray.origin + ray.direction * near_plane_;
        return ray;
    }

  private:
    bool orthographic_ = false;
    double near_plane_ = 0;
    Vec3d eye_, forward_;
    Vec3d right_, up_; ///< from the middle of the picture to the middle of its right and upper edge, at depth 1
    std::uint32_t width_ = 0, height_ = 0;
};

/// tan(degrees/2 * pi/180) for degrees in (0, 180), by Lambert's continued fraction: the same on every machine.
double half_tangent(double degrees);

} // namespace antumbra
