// Proof by rays: what a culler hides must be hidden for every line of sight, decided by the strict tracer and, where it
// disagrees, by the exact arbiter. Shares nothing with the rasterisers.
#pragma once

#include <antumbra/cull.hpp>
#include <antumbra/import.hpp>
#include <antumbra/occluder_finding.hpp>

#include "base/random.hpp"
#include "cull/random_views.hpp"
#include "evaluate/cull_scene.hpp"
#include "rays/arbiter.hpp"
#include "rays/tracer.hpp"

#include <gtest/gtest.h>

#include <cstdlib>
#include <filesystem>
#include <memory>
#include <string>

namespace antumbra::test {

/// A scene with everything that culls it or proves.
struct Stage {
    std::unique_ptr<Scene> scene;
    std::unique_ptr<Tracer> tracer;
    OccluderSet occluders;
    CullScene cull_scene;

    explicit Stage(Scene&& made, const OccluderOptions& options = {}) {
        scene = std::make_unique<Scene>(std::move(made));
        tracer = std::make_unique<Tracer>(Tracer::build(*scene));
        occluders = find_occluders(*scene, options);
        cull_scene = cull_scene_of(*scene, occluders);
    }
};

/// A line of sight of the picture, from the near plane on; x, y in [-1, 1].
inline Ray line_of_sight(const Volume& volume, double x, double y) {
    long double from[3], to[3];
    volume.point(x, y, volume.near_plane, from);
    volume.point(x, y, volume.near_plane + 1, to);
    Ray ray;
    for (int k = 0; k < 3; ++k) {
        ray.origin[k] = double(from[k]);
        ray.direction[k] = double(to[k] - from[k]);
    }
    return ray;
}

/// The line of sight through `point`; false if the point is not in the picture.
inline bool line_through(const Volume& volume, const Vec3d& point, Ray& ray) {
    long double offset[3], depth = 0, x = 0, y = 0;
    for (int k = 0; k < 3; ++k) {
        offset[k] = point[k] - volume.eye[k];
        depth += offset[k] * volume.forward[k];
        x += offset[k] * volume.right[k];
        y += offset[k] * volume.up[k];
    }
    long double scale = volume.orthographic ? 1 : depth;
    if (!(depth > volume.near_plane && depth < volume.far_plane && std::abs(x) < scale * volume.half_width &&
          std::abs(y) < scale * volume.half_height))
        return false;
    ray = line_of_sight(volume, double(x / (scale * volume.half_width)), double(y / (scale * volume.half_height)));
    return true;
}

/// Does a line of sight (from the near plane, one unit of depth per length) meet the triangle beyond the far plane?
inline bool is_beyond_far(const Scene& scene, std::uint32_t triangle, const Ray& ray, const View& view) {
    Vec3d a = scene.vertex(triangle, 0);
    Vec3d normal = cross(scene.vertex(triangle, 1) - a, scene.vertex(triangle, 2) - a);
    double t = dot(normal, a - ray.origin) / dot(normal, ray.direction);
    return std::isfinite(view.far_plane) && !(view.near_plane + t < view.far_plane * (1 - 1e-9));
}

struct ProofCounts {
    std::uint64_t rays = 0, seen = 0, hidden = 0, in_frustum = 0, frames = 0;
};

/// Casts `across` x `across` jittered lines of sight, and `aimed` ones at each object that was hidden; every object
/// that one of them sees must be reported.
inline void prove(const Stage& stage, const Culler& culler, const View& view, ViewState& state, int across, int aimed,
                  Random& random, ProofCounts& counts) {
    CullResult result, frustum;
    culler.cull(view, state, result);
    ViewState plain;
    (*make_culler("frustum", stage.cull_scene))->cull(view, plain, frustum);
    counts.in_frustum += frustum.visible_count;
    counts.hidden += frustum.visible_count - result.visible_count;
    ++counts.frames;
    Volume volume(view);
    Arbiter arbiter(*stage.tracer);
    std::vector<std::uint32_t> triangles;
    bool lost = false;
    auto check = [&](const Ray& ray) {
        triangles.clear();
        stage.tracer->seen(ray, triangles);
        ++counts.rays;
        for (std::uint32_t triangle : triangles) {
            std::uint32_t object = stage.scene->triangle_objects()[triangle];
            ++counts.seen;
            // Beyond the far plane nothing is drawn: methods that cull parts of objects need not report it.
            if (is_beyond_far(*stage.scene, triangle, ray, view))
                continue;
            if (lost || result.is_visible(object) || !frustum.is_visible(object))
                continue;
            lost = arbiter.sees(ray.origin, ray.origin + ray.direction, triangle) == Verdict::clear;
            EXPECT_FALSE(lost) << culler.name() << " hides object " << object << " (" << stage.scene->name(object)
                               << "), which is seen; eye " << view.eye.x << " " << view.eye.y << " " << view.eye.z
                               << " target " << view.target.x << " " << view.target.y << " " << view.target.z;
        }
    };
    for (int j = 0; j < across; ++j)
        for (int i = 0; i < across; ++i)
            check(line_of_sight(volume, (i + random.uniform()) * 2 / across - 1, (j + random.uniform()) * 2 / across - 1));
    // Lines aimed at what was hidden find the narrowest gaps.
    for (std::uint32_t o = 0; o < stage.scene->objects().size() && !lost; ++o) {
        const Object& object = stage.scene->objects()[o];
        if (result.is_visible(o) || !frustum.is_visible(o))
            continue;
        for (int i = 0; i < aimed; ++i) {
            std::uint32_t triangle = object.first_triangle + random.below(object.triangle_count);
            double u = random.uniform(), v = random.uniform();
            if (u + v > 1)
                u = 1 - u, v = 1 - v;
            Vec3d a = stage.scene->vertex(triangle, 0), b = stage.scene->vertex(triangle, 1);
            Vec3d point = a + (b - a) * u + (stage.scene->vertex(triangle, 2) - a) * v;
            Ray ray;
            if (line_through(volume, point, ray))
                check(ray);
        }
    }
}

/// Quads and boxes of every attitude, some huge, many coplanar, touching or duplicate.
inline RawScene random_soup(Random& random, int objects, double size) {
    RawScene raw;
    raw.source = "soup";
    auto add_vertex = [&](const Vec3d& p) {
        raw.positions.push_back(p);
        return std::uint32_t(raw.positions.size() - 1);
    };
    auto begin = [&](bool double_sided) {
        RawObject object;
        object.name = "o" + std::to_string(raw.objects.size());
        object.flags = kOccludes | (double_sided ? std::uint32_t(kDoubleSided) : 0u);
        if (random.below(16) == 0)
            object.flags &= ~std::uint32_t(kOccludes);
        object.first_triangle = std::uint32_t(raw.triangles.size());
        return object;
    };
    auto end = [&](RawObject object) {
        object.triangle_count = std::uint32_t(raw.triangles.size()) - object.first_triangle;
        raw.objects.push_back(object);
    };
    auto around = [&](double reach) {
        return Vec3d{random.uniform(-reach, reach), random.uniform(-reach, reach), random.uniform(-reach, reach)};
    };
    for (int o = 0; o < objects; ++o) {
        Vec3d centre = around(size);
        if (random.below(3) == 0) // on a coarse lattice: faces coincide and touch
            for (int k = 0; k < 3; ++k)
                centre[k] = std::round(centre[k] / (size / 4)) * (size / 4);
        double reach = size * (random.below(3) ? random.uniform(0.02, 0.2) : random.uniform(0.2, 0.8));
        if (random.below(2)) { // a box, axis-aligned or turned about y
            Vec3d half{reach * random.uniform(0.2, 1), reach * random.uniform(0.2, 1), reach * random.uniform(0.2, 1)};
            double c = 1, s = 0;
            if (random.below(2)) {
                c = random.uniform(-1, 1);
                s = std::sqrt(1 - c * c);
            }
            RawObject object = begin(random.below(3) == 0);
            std::uint32_t v[8];
            for (int i = 0; i < 8; ++i) {
                Vec3d p{i & 1 ? half.x : -half.x, i & 2 ? half.y : -half.y, i & 4 ? half.z : -half.z};
                v[i] = add_vertex(centre + Vec3d{c * p.x - s * p.z, p.y, s * p.x + c * p.z});
            }
            const int faces[6][4] = {{0, 4, 6, 2}, {1, 3, 7, 5}, {0, 1, 5, 4}, {2, 6, 7, 3}, {0, 2, 3, 1}, {4, 5, 7, 6}};
            for (auto& f : faces) {
                raw.triangles.push_back({v[f[0]], v[f[1]], v[f[2]]});
                raw.triangles.push_back({v[f[0]], v[f[2]], v[f[3]]});
            }
            end(object);
        } else { // a sheet of n x m quads, flat or rippled
            RawObject object = begin(random.below(2));
            Vec3d u = around(reach), w = around(reach);
            if (random.below(2)) {
                u = {reach, 0, 0};
                w = {0, random.below(2) ? reach : 0, 0};
                w.z = w.y == 0 ? reach : 0;
            }
            std::uint32_t n = 1 + random.below(4), m = 1 + random.below(4);
            double ripple = random.below(3) ? 0 : 0.1 * reach;
            std::uint32_t base = std::uint32_t(raw.positions.size());
            for (std::uint32_t j = 0; j <= m; ++j)
                for (std::uint32_t i = 0; i <= n; ++i)
                    add_vertex(centre + u * (double(i) / n) + w * (double(j) / m) + around(ripple));
            for (std::uint32_t j = 0; j < m; ++j)
                for (std::uint32_t i = 0; i < n; ++i) {
                    std::uint32_t a = base + i + (n + 1) * j, b = a + 1, c2 = a + n + 1, d = c2 + 1;
                    raw.triangles.push_back({a, b, d});
                    raw.triangles.push_back({a, d, c2});
                }
            end(object);
        }
    }
    return raw;
}

/// A wall of many parts with slits between them, parts in front of and behind each other, and small things behind:
/// what gaps narrower than a pixel show.
inline RawScene slit_wall(Random& random, int parts, int things) {
    RawScene raw;
    raw.source = "slits";
    auto quad = [&](const Vec3d& a, const Vec3d& u, const Vec3d& w, const char* name) {
        RawObject object;
        object.name = name;
        object.flags = kOccludes | kDoubleSided;
        object.first_triangle = std::uint32_t(raw.triangles.size());
        object.triangle_count = 2;
        auto base = std::uint32_t(raw.positions.size());
        for (const Vec3d& p : {a, a + u, a + u + w, a + w})
            raw.positions.push_back(p);
        raw.triangles.push_back({base, base + 1, base + 2});
        raw.triangles.push_back({base, base + 2, base + 3});
        raw.objects.push_back(object);
    };
    double x = -10;
    for (int i = 0; i < parts; ++i) {
        double width = random.uniform(0.2, 2), depth = random.below(2) ? 0 : random.uniform(-1, 1);
        double gap = random.below(3) ? std::ldexp(random.uniform(), -int(random.below(16))) * 0.2 : 0;
        double y = random.below(2) ? random.uniform(-0.5, 0.5) : 0; // steps: T-junctions
        quad({x, -5, depth}, {width, 0, 0}, {0, 5 + y, 0}, "wall");
        quad({x, y + (random.below(2) ? gap : 0), depth}, {width, 0, 0}, {random.below(4) ? 0 : 0.3, 5 - y, 0}, "wall");
        x += width + gap;
    }
    for (int i = 0; i < things; ++i) {
        double size = std::ldexp(1.0, -int(random.below(8)));
        Vec3d u{size * random.uniform(-1, 1), size * random.uniform(-1, 1), size * random.uniform(-1, 1)};
        Vec3d w{size * random.uniform(-1, 1), size * random.uniform(-1, 1), size * random.uniform(-1, 1)};
        quad({random.uniform(-10, x), random.uniform(-5, 5), -random.uniform(1.01, 6)}, u, w, "thing");
    }
    return raw;
}

/// The folder of development scenes, or empty.
inline std::string scenes_folder() {
    if (const char* folder = std::getenv("ANTUMBRA_SCENES"))
        return folder;
    std::string beside = std::string(ANTUMBRA_SOURCE_DIR) + "/../shared/scenes";
    return std::filesystem::exists(beside) ? beside : "";
}

} // namespace antumbra::test
