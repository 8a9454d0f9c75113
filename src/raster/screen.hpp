// From local coordinates to pixels. x grows to the right, y upwards, pixel (i, j) is the square [i, i+1] x [j, j+1].
#pragma once

#include "geometry/camera.hpp"

#include <cstdint>

namespace antumbra {

inline constexpr int kTile = 8; ///< pixels along a tile's side: one 64-bit word per tile

/// Nearness is affine over the screen and grows towards the viewer: 1 / depth in perspective, - depth in
/// orthographic views.
struct Screen {
    Camera camera;
    int width = 0, height = 0;         ///< pixels, multiples of kTile
    int tiles_x = 0, tiles_y = 0;
    double scale_x = 1, scale_y = 1;   ///< pixels per unit of X / Z (perspective) or X
    double centre_x = 0, centre_y = 0; ///< pixels
    double clip_depth = 0;             ///< nothing nearer is drawn: the near plane, or just above zero
    double depth_slack = 0;            ///< rounding of depths, generously

    double nearness(double depth) const { return camera.orthographic ? -depth : 1 / depth; }
    /// Nearness made certain: what bounds an occluder from below, or an occludee from above.
    double surely_below(double value) const { return value - 1e-5 * (std::abs(value) + orthographic_slack); }
    double surely_above(double value) const { return value + 1e-5 * (std::abs(value) + orthographic_slack); }
    double orthographic_slack = 0; ///< absolute term: depths near zero have no relative precision
};

/// `width` pixels across, rounded up to whole tiles; the height follows from the camera's shape. `extent` is the
/// size of what is looked at, for tolerances.
Screen make_screen(const Camera& camera, int width, double extent);
/// The same with both sides given, so that pixels need not be square (Poon and Wang draw 128 x 128 for any window).
Screen make_screen(const Camera& camera, int width, int height, double extent);

/// Where a box lies on the screen.
struct BoxOnScreen {
    bool testable = false; ///< false: it comes nearer than the clip depth, it may be anywhere
    float min_x = 0, max_x = 0, min_y = 0, max_y = 0; ///< pixels, rounded outward
    float nearness = 0;    ///< of the nearest corner, rounded nearer
};
BoxOnScreen project_box(const Screen& screen, const Box3f& box);

} // namespace antumbra
