// The frames of bench_cull, and what is truly seen in them.
#pragma once

#include <antumbra/cull.hpp>
#include <antumbra/scene.hpp>

#include "base/parallel.hpp"
#include "base/random.hpp"
#include "rays/tracer.hpp"

#include <algorithm>
#include <cmath>
#include <vector>

namespace antumbra::bench {

/// A place in the open that sees something, and the way ahead.
struct Place {
    Vec3d eye, ahead;
};

/// Tries one random place; false if it is none. `street`: not on roofs, within three steps of the scene's bottom.
inline bool find_place(const Scene& scene, const Tracer& tracer, double unit, bool street, Random& random, Place& place) {
    Box3d bounds = to_double(scene.local_bounds());
    Vec3d eye{random.uniform(bounds.min.x, bounds.max.x), 0, random.uniform(bounds.min.z, bounds.max.z)};
    eye.y = random.uniform(bounds.min.y, street ? bounds.min.y + 3 * unit : bounds.max.y);
    Hit floor = tracer.first_hit({eye, {0, -1, 0}});
    if (!floor)
        return false;
    eye.y -= floor.t - std::min(floor.t, 0.8 * unit);
    double angle = random.uniform(0, 6.28318530717958648);
    Vec3d ahead{std::cos(angle), 0, std::sin(angle)};
    bool back = false;
    Hit hit = tracer.nearest_surface({eye, ahead}, back);
    if (back || !hit || hit.t < 5 * unit)
        return false;
    for (int k = 0; k < 8; ++k) {
        tracer.nearest_surface({eye, {std::cos(k * 0.785), 0.05, std::sin(k * 0.785)}}, back);
        if (back)
            return false;
    }
    place = {eye, ahead};
    return true;
}

inline int count(const std::vector<std::uint64_t>& bits) {
    int sum = 0;
    for (std::uint64_t word : bits)
        sum += __builtin_popcountll(word);
    return sum;
}

inline Ray pixel_ray(const View& view, double x, double y) {
    Vec3d forward = normalized(view.target - view.eye), right = normalized(cross(forward, view.up));
    Vec3d up = cross(right, forward);
    double half = std::tan(view.fov_y_deg * 0.0087266462599716477);
    Vec3d direction = forward + right * (x * half * view.aspect) + up * (y * half);
    return {view.eye + direction * view.near_plane, direction};
}

/// Objects that a ray at a random point of some pixel sees, in a picture that is `across` wide: what is visible is that
/// at least.
inline std::vector<std::uint64_t> find_seen(const Scene& scene, const Tracer& tracer, const View& view, int across,
                                            std::uint64_t frame) {
    std::vector<std::uint64_t> bits((scene.objects().size() + 63) / 64);
    const int down = std::max(1, int(across / view.aspect));
    SeenBatch seen;
    std::vector<Ray> rays(static_cast<std::size_t>(across));
    for (int j = 0; j < down; ++j) {
        Random random(3, frame, static_cast<std::uint32_t>(j));
        for (int i = 0; i < across; ++i)
            rays[static_cast<std::size_t>(i)] =
                pixel_ray(view, (i + random.uniform()) * 2 / across - 1, (j + random.uniform()) * 2 / down - 1);
        tracer.seen_batch(rays, seen);
        for (std::uint32_t triangle : seen.triangles) {
            std::uint32_t object = scene.triangle_objects()[triangle];
            bits[object / 64] |= std::uint64_t(1) << (object % 64);
        }
    }
    return bits;
}

/// Walks of `length` frames, at 60 a second, forward where there is room. `share` above 0: only from places in the street with
/// that share of all objects in the view volume (within a tenth). `seen` above 0: and that see so many (within a quarter).
inline std::vector<View> street_walk(const Scene& scene, const Tracer& tracer, const Culler& frustum, int frames,
                                     int length, double speed, double share, int seen) {
    Vec3d size = to_double(scene.local_bounds()).size();
    double unit = std::max({size.x, size.y, size.z}) / 500; // a step: two thousandths of the scene
    Random random(7);
    std::vector<View> views;
    ViewState state;
    CullResult result;
    for (int attempt = 0; attempt < 100000 && int(views.size()) < frames; ++attempt) {
        Place place;
        if (!find_place(scene, tracer, unit, share > 0, random, place))
            continue;
        View view;
        view.eye = place.eye;
        view.target = place.eye + place.ahead;
        view.near_plane = 0.02 * unit;
        frustum.cull(view, state, result);
        double inside = double(result.visible_count) / double(scene.objects().size());
        if (share > 0 && std::abs(inside - share) > share / 10)
            continue;
        if (seen > 0 && std::abs(count(find_seen(scene, tracer, view, 480, 0)) - seen) > seen / 4)
            continue;
        for (int i = 0; i < length && int(views.size()) < frames; ++i) {
            view.eye = place.eye + place.ahead * (unit * 0.05 * speed * i);
            view.target = view.eye + place.ahead;
            views.push_back(view);
        }
    }
    return views;
}

struct Truth {
    std::vector<std::vector<std::uint64_t>> seen;
    double mean = 0;
};

inline Truth find_truth(const Scene& scene, const Tracer& tracer, const std::vector<View>& views, int across) {
    Truth truth;
    truth.seen.resize(views.size());
    parallel_for(views.size(), Job{}, [&](std::size_t f, unsigned) {
        truth.seen[f] = find_seen(scene, tracer, views[f], across, f);
    });
    for (const std::vector<std::uint64_t>& bits : truth.seen)
        truth.mean += double(count(bits)) / double(views.size());
    return truth;
}

} // namespace antumbra::bench
