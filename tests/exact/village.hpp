// A small scene for exact bakes.
#pragma once

#include <antumbra/bake.hpp>

#include <gtest/gtest.h>

namespace antumbra {

/// A street of closed houses with a thing in each and a few outside.
inline Scene village() {
    RawScene raw;
    raw.source = "village";
    auto box = [&](const std::string& name, Vec3d a, Vec3d b) {
        RawObject object;
        object.name = name;
        object.flags = kOccludes | kDoubleSided;
        object.first_triangle = static_cast<std::uint32_t>(raw.triangles.size());
        auto first = static_cast<std::uint32_t>(raw.positions.size());
        for (int i = 0; i < 8; ++i)
            raw.positions.push_back({i & 1 ? b.x : a.x, i & 2 ? b.y : a.y, i & 4 ? b.z : a.z});
        for (std::array<std::uint32_t, 4> f : {std::array<std::uint32_t, 4>{0, 4, 6, 2}, {1, 3, 7, 5}, {0, 1, 5, 4},
                                               {2, 6, 7, 3}, {0, 2, 3, 1}, {4, 5, 7, 6}}) {
            raw.triangles.push_back({first + f[0], first + f[1], first + f[2]});
            raw.triangles.push_back({first + f[0], first + f[2], first + f[3]});
        }
        object.triangle_count = 12;
        raw.objects.push_back(object);
    };
    for (int k = 0; k < 6; ++k) {
        double x = 6.0 * k, y = k % 2 * 10.0;
        box("house " + std::to_string(k), {x, 0, y}, {x + 4, 3.0 + k % 3, y + 4});
        box("thing " + std::to_string(k), {x + 1, 0.5, y + 1}, {x + 2, 1, y + 2});
        box("tree " + std::to_string(k), {x + 4.5, 0, y}, {x + 5, 2, y + 0.5});
    }
    Result<Scene> scene = Scene::create(std::move(raw));
    EXPECT_TRUE(scene.ok());
    return std::move(*scene);
}

/// Exact cells, of which rays find little.
inline BakeOptions exact_options() {
    BakeOptions o;
    o.method = "exact";
    o.cells = {4, 1, 3};
    o.rays_per_cell = 200; // few: the proofs do the rest
    o.holdout_rays = 3000;
    return o;
}

} // namespace antumbra
