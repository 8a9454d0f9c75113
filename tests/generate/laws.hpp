// What every generated scene must obey, whatever its kind.
#pragma once

#include <antumbra/export.hpp>
#include <antumbra/generate.hpp>

#include "support/sha256.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

namespace antumbra::test {

/// SHA-256 of the files that `generate` writes by default, by its arguments. Frozen.
inline constexpr std::pair<std::string_view, std::string_view> kPublished[] = {
    {"apartment", "9984b53917445bf95cb416be4ec42e08c308082934ea05e5fe685403a8e44dc2"},
    {"apartment --copies 18", "1aea76a214b73f0d2520ff1adf6229cf5ab65ffefc1f682bfb5ff1cee814897b"},
    {"city", "ef8ba9ae18666ea44d86f8e52511b9db2d6b0cb7d41f571ceed6f9b2609a1719"},
    {"downtown", "66bb972c64b7b36ab5b9a0ecb8d53e1725a61ec58f19649e37c73064a6c6e5af"},
    {"forest", "896fcef21744a45978914ab430cbd03c4dd62c01b7bece9ad4eb86db46cf217f"},
    {"forest-dense", "79baf6648b5804316799f2032202d28a4a1f34db9741f973da2add6575915a15"},
    {"machine", "6c6ff43202ab412c5d03744affd8a994afb1e1f10c9fa7d4b6826e787cfca7a9"},
    {"office", "25df74268607a43b115754dfbea9619abc9ad4bcecfce0e62834229c02c8fce2"},
    {"town", "8b8b106cd78cac1e6c6c0c2753237df84df2acf04117d52c6c4d524e2025f96e"},
};

inline std::string_view published(std::string_view arguments) {
    for (auto [key, hash] : kPublished)
        if (key == arguments)
            return hash;
    return "not published";
}

inline RawScene made(const char* kind, const GenerateOptions& options = {}) {
    Result<RawScene> scene = generate(kind, options);
    EXPECT_TRUE(scene.ok()) << scene.status().message();
    return scene.ok() ? std::move(*scene) : RawScene{};
}

inline std::string sha256_of(const RawScene& scene) {
    Result<std::vector<std::byte>> bytes = export_glb(scene);
    EXPECT_TRUE(bytes.ok()) << bytes.status().message();
    return bytes.ok() ? Sha256::hex(*bytes) : std::string();
}

/// Edges of one object that are not shared by exactly one face in each direction (or n and n).
inline std::size_t open_edges(const RawScene& scene, const RawObject& object) {
    std::vector<std::pair<std::uint32_t, std::uint32_t>> forth, back;
    for (std::uint32_t t = 0; t < object.triangle_count; ++t) {
        const TriangleIndices& triangle = scene.triangles[object.first_triangle + t];
        for (std::size_t k = 0; k < 3; ++k) {
            forth.emplace_back(triangle[k], triangle[(k + 1) % 3]);
            back.emplace_back(triangle[(k + 1) % 3], triangle[k]);
        }
    }
    std::sort(forth.begin(), forth.end());
    std::sort(back.begin(), back.end());
    std::size_t repeated = static_cast<std::size_t>(forth.end() - std::unique(forth.begin(), forth.end()));
    std::size_t different = 0;
    for (std::size_t i = 0; i < back.size(); ++i)
        different +=
            !std::binary_search(forth.begin(), forth.end() - static_cast<std::ptrdiff_t>(repeated), back[i]);
    return different + repeated;
}

/// Six times the volume that the surface encloses, taken about its first vertex.
inline double volume(const RawScene& scene, const RawObject& object) {
    double sum = 0;
    Vec3d origin = scene.positions[scene.triangles[object.first_triangle][0]];
    for (std::uint32_t t = 0; t < object.triangle_count; ++t) {
        const TriangleIndices& triangle = scene.triangles[object.first_triangle + t];
        Vec3d a = scene.positions[triangle[0]] - origin, b = scene.positions[triangle[1]] - origin,
              c = scene.positions[triangle[2]] - origin;
        sum += dot(a, cross(b, c));
    }
    return sum;
}

inline Box3d bounds_of(const RawScene& scene, const RawObject& object) {
    Box3d box;
    for (std::uint32_t t = 0; t < object.triangle_count; ++t)
        for (std::uint32_t v : scene.triangles[object.first_triangle + t])
            box.extend(scene.positions[v]);
    return box;
}

/// Objects whose names begin with `prefix`.
inline std::size_t count_named(const RawScene& scene, std::string_view prefix) {
    return static_cast<std::size_t>(
        std::count_if(scene.objects.begin(), scene.objects.end(),
                      [&](const RawObject& o) { return o.name.starts_with(prefix); }));
}

/// Closed solids wound outward (unless double-sided), on the grid of 1/`grid` m, without a degenerate
/// triangle, no vertex outside `world`, every name once.
inline void expect_sound(const RawScene& scene, const Box3d& world, double grid = 4096) {
    std::vector<std::string> names;
    for (const RawObject& object : scene.objects) {
        ASSERT_GT(object.triangle_count, 0u) << object.name;
        if (!(object.flags & kDoubleSided)) {
            ASSERT_EQ(open_edges(scene, object), 0u) << object.name;
            ASSERT_GT(volume(scene, object), 0) << object.name;
        }
        names.push_back(object.name);
    }
    std::sort(names.begin(), names.end());
    EXPECT_EQ(std::adjacent_find(names.begin(), names.end()), names.end()) << "a name is used twice";
    for (const Vec3d& p : scene.positions) {
        ASSERT_TRUE(world.contains(p)) << p.x << ' ' << p.y << ' ' << p.z; // false for NaN too
        for (int k = 0; k < 3; ++k)
            ASSERT_EQ(p[k] * grid, std::floor(p[k] * grid));
    }
    for (std::size_t t = 0; t < scene.triangles.size(); ++t) {
        const TriangleIndices& i = scene.triangles[t];
        Vec3d n = cross(scene.positions[i[1]] - scene.positions[i[0]],
                        scene.positions[i[2]] - scene.positions[i[0]]);
        ASSERT_NE(n, Vec3d{}) << "triangle " << t;
    }
}

} // namespace antumbra::test
