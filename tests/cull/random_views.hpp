// Random views and boxes for the culling tests, and the view volume in long double, written apart from the library.
#pragma once

#include <antumbra/cull.hpp>

#include "base/random.hpp"

#include <cmath>
#include <vector>

namespace antumbra::test {

struct Volume {
    using Real = long double;
    Real eye[3], right[3], up[3], forward[3], half_width, half_height;
    bool orthographic;
    Real near_plane, far_plane;

    explicit Volume(const View& view) {
        auto unit = [](Real* v) {
            Real size = std::sqrt(v[0] * v[0] + v[1] * v[1] + v[2] * v[2]);
            for (int k = 0; k < 3; ++k)
                v[k] /= size;
        };
        auto crossed = [](const Real* a, const Real* b, Real* out) {
            for (int k = 0; k < 3; ++k)
                out[k] = a[(k + 1) % 3] * b[(k + 2) % 3] - a[(k + 2) % 3] * b[(k + 1) % 3];
        };
        Real given_up[3];
        for (int k = 0; k < 3; ++k) {
            eye[k] = view.eye[k];
            forward[k] = Real(view.target[k]) - Real(view.eye[k]);
            given_up[k] = view.up[k];
        }
        unit(forward);
        unit(given_up);
        crossed(forward, given_up, right);
        unit(right);
        crossed(right, forward, up);
        orthographic = view.projection == Projection::orthographic;
        const Real pi = 3.14159265358979323846264338327950288L;
        half_height = orthographic ? Real(view.height) / 2 : std::tan(Real(view.fov_y_deg) * pi / 360);
        half_width = half_height * Real(view.aspect);
        near_plane = view.near_plane;
        far_plane = view.far_plane;
    }

    /// x, y in [-1, 1] across the picture.
    void point(Real x, Real y, Real depth, Real* out) const {
        Real scale = orthographic ? 1 : depth;
        for (int k = 0; k < 3; ++k)
            out[k] = eye[k] + forward[k] * depth + right[k] * (x * half_width * scale) +
                     up[k] * (y * half_height * scale);
    }

    /// How far the box lies outside of the nearest plane that excludes it (0 if none does), as a share of `scale`.
    Real outside(const Box3f& box) const {
        Real worst = 0;
        auto plane = [&](const Real* n, Real at_eye) {
            Real size = std::sqrt(n[0] * n[0] + n[1] * n[1] + n[2] * n[2]), sum = at_eye;
            for (int k = 0; k < 3; ++k)
                sum += std::max(n[k] * (Real(box.min[k]) - eye[k]), n[k] * (Real(box.max[k]) - eye[k]));
            worst = std::max(worst, -sum / size);
        };
        for (int sign : {1, -1}) {
            Real across[3], along[3];
            for (int k = 0; k < 3; ++k) {
                across[k] = Real(sign) * right[k] + (orthographic ? 0 : half_width * forward[k]);
                along[k] = Real(sign) * up[k] + (orthographic ? 0 : half_height * forward[k]);
            }
            plane(across, orthographic ? half_width : 0);
            plane(along, orthographic ? half_height : 0);
        }
        plane(forward, -near_plane);
        Real back[3] = {-forward[0], -forward[1], -forward[2]};
        if (std::isfinite(far_plane))
            plane(back, far_plane);
        return worst;
    }
};

/// Any kind of view whose eye is within `size` of `centre`.
inline View random_view(Random& random, const Vec3d& centre, double size) {
    View view;
    auto around = [&](double reach) {
        return Vec3d{random.uniform(-reach, reach), random.uniform(-reach, reach), random.uniform(-reach, reach)};
    };
    view.eye = centre + around(size);
    view.target = random.below(4) ? view.eye + around(1) : view.eye + Vec3d{0, 0, random.below(2) ? 1.0 : -1.0};
    view.up = random.below(4) ? around(1) : Vec3d{0, 1, 0};
    view.fov_y_deg = random.below(8) ? random.uniform(20, 100) : random.uniform(0.01, 179);
    view.aspect = random.uniform(0.3, 3);
    view.near_plane = random.below(4) ? random.uniform(0, 0.1) * size : 0;
    if (random.below(2))
        view.far_plane = view.near_plane + random.uniform(0.01, 3) * size;
    if (random.below(4) == 0) {
        view.projection = Projection::orthographic;
        view.height = random.uniform(0.01, 2) * size;
        if (random.below(2))
            view.near_plane = random.uniform(-1, 0) * size;
    }
    return view;
}

inline float nearest_below(double value) {
    auto rounded = static_cast<float>(value);
    return double(rounded) <= value ? rounded : std::nextafter(rounded, -INFINITY);
}
inline float nearest_above(double value) {
    auto rounded = static_cast<float>(value);
    return double(rounded) >= value ? rounded : std::nextafter(rounded, INFINITY);
}

inline std::vector<Box3f> random_boxes(Random& random, std::size_t count, const Vec3d& centre, double size) {
    std::vector<Box3f> boxes(count);
    for (Box3f& box : boxes)
        for (int k = 0; k < 3; ++k) {
            double middle = centre[k] + random.uniform(-size, size);
            double half = random.below(8) ? random.uniform(0, 0.05) * size : 0;
            box.min[k] = nearest_below(middle - half);
            box.max[k] = nearest_above(middle + half);
        }
    return boxes;
}

} // namespace antumbra::test
