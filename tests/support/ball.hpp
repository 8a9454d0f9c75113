// A closed mesh of many triangles.
#pragma once

#include "support/make_scene.hpp"

#include <cmath>

namespace antumbra::test {

/// A ball of radius 4 with `sides` meridians, whose radius waves by `wave`.
inline void add_ball(SceneMaker& maker, Vec3d centre, int sides, double wave) {
    auto at = [&](int i, int j) {
        double u = 6.283185307179586 * (i % sides) / sides, v = 3.141592653589793 * j / (sides / 2);
        double r = 4 + wave * std::sin(3 * u) * std::sin(v) * std::sin(v);
        Vec3d at_centre = j == 0 ? Vec3d{0, 4, 0} : j == sides / 2 ? Vec3d{0, -4, 0}
                                                        : Vec3d{r * std::sin(v) * std::cos(u), 4 * std::cos(v), -r * std::sin(v) * std::sin(u)};
        return centre + at_centre;
    };
    for (int j = 0; j < sides / 2; ++j)
        for (int i = 0; i < sides; ++i) {
            if (j > 0)
                maker.triangle(at(i, j), at(i + 1, j + 1), at(i + 1, j));
            if (j + 1 < sides / 2)
                maker.triangle(at(i, j), at(i, j + 1), at(i + 1, j + 1));
        }
}

inline SceneMaker ball(int sides, double wave, std::uint32_t flags = kOccludes) {
    SceneMaker maker;
    maker.object("ball", flags);
    add_ball(maker, {0, 0, 0}, sides, wave);
    return maker;
}

} // namespace antumbra::test
