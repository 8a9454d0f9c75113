#include "evaluate/item_buffer.hpp"
#include "evaluate/studies/poon_wang.hpp"

#include <algorithm>
#include <bit>
#include <chrono>
#include <cmath>

namespace antumbra::poon_wang {
namespace {

double milliseconds_since(std::chrono::steady_clock::time_point start) {
    return std::chrono::duration<double, std::milli>(std::chrono::steady_clock::now() - start).count();
}

/// How far one can go from `eye` along `way`, up to `most`.
double free_way(const Tracer& tracer, const Vec3d& eye, const Vec3d& way, double most) {
    Ray ray{eye, way};
    std::vector<std::uint32_t> seen;
    tracer.seen(ray, seen);
    double nearest = most;
    for (std::uint32_t triangle : seen) {
        // Only a choice of lines to walk on: plane distance is enough.
        Vec3d a = tracer.scene().vertex(triangle, 0), b = tracer.scene().vertex(triangle, 1),
              c = tracer.scene().vertex(triangle, 2);
        Vec3d normal = cross(b - a, c - a);
        double towards = dot(normal, way);
        if (towards != 0)
            nearest = std::min(nearest, std::max(0.0, dot(normal, a - eye) / towards));
    }
    return nearest;
}

/// The line along x with the longest free way from x0 on, among z in [low, high]; its z and length.
std::pair<double, double> freest_line(const Tracer& tracer, double x0, double y, double low, double high, double most) {
    std::pair<double, double> best{low, -1};
    constexpr int kTries = 400;
    for (int i = 0; i < kTries; ++i) {
        double z = low + (high - low) * (i + 0.5) / kTries;
        // Not along a wall: both sides must be free, too.
        double length = 1e300;
        for (double aside : {-0.002, 0.0, 0.002})
            length = std::min(length, free_way(tracer, {x0, y, z + aside * most}, {1, 0, 0}, most));
        if (length > best.second)
            best = {z, length};
    }
    return best;
}

View view_at(const Vec3d& eye, const Vec3d& way) {
    View view;
    view.eye = eye;
    view.target = eye + way;
    view.near_plane = 0;
    view.aspect = 1;
    return view;
}

} // namespace

std::vector<Route> make_routes(const Scene& scene, const Tracer& tracer, std::size_t frames) {
    Box3d box = to_double(scene.local_bounds());
    Vec3d size = box.max - box.min, middle = (box.min + box.max) * 0.5;
    double eye_height = std::min(1.7, size.y / 4);
    // Floors are at height 0 of the world in generated scenes; elsewhere the lowest point will do.
    double ground = std::clamp(scene.to_local({0, 0, 0}).y, box.min.y, box.max.y), y = ground + eye_height;
    double most = size.x * 0.4;
    auto line = [&](double x0, double low, double high) {
        return freest_line(tracer, x0, y, box.min.z + size.z * low, box.min.z + size.z * high, most);
    };
    auto along = [&](double x0, std::pair<double, double> line_of, auto&& way) {
        std::vector<View> views;
        for (std::size_t f = 0; f < frames; ++f) {
            double x = x0 + 0.9 * line_of.second * double(f) / double(frames);
            Vec3d eye{x, y, line_of.first};
            views.push_back(view_at(eye, way(eye)));
        }
        return views;
    };
    auto to_middle = [&](const Vec3d& eye) {
        Vec3d way = middle - eye;
        way.y = 0;
        return normalized(way);
    };
    Route best{"best", "from the lower left corner towards the middle", {}, 14.6, 25.5, 17.7};
    double x0 = box.min.x + 0.02 * size.x;
    best.views = along(x0, line(x0, 0.02, 0.2), to_middle);
    Route average{"average", "in the middle, looking ahead", {}, 4.4, 26.7, 19.4};
    x0 = middle.x - 0.1 * size.x;
    average.views = along(x0, line(x0, 0.4, 0.6), [](const Vec3d&) { return Vec3d{1, 0, 0}; });
    Route worst{"worst", "at the upper right corner, looking outward", {}, 0.7, 34.6, 28.8};
    for (std::size_t f = 0; f < frames; ++f) {
        Vec3d eye = box.max + Vec3d{-0.02, 0, -0.02} * size.x;
        eye.y = y;
        eye.z -= 0.2 * size.z * double(f) / double(frames);
        // A quarter of a turn or so, never back into the scene.
        double turn = 0.9 * double(f) / double(frames) - 0.2;
        worst.views.push_back(view_at(eye, {std::cos(turn), 0, std::sin(turn)}));
    }
    return {best, average, worst};
}

double Measured::mean_triangles() const {
    double sum = 0;
    for (std::uint64_t count : triangles)
        sum += double(count);
    return sum / double(std::max<std::size_t>(1, triangles.size()));
}

double Measured::mean_frame_ms() const {
    double sum = 0;
    for (double one : frame_ms)
        sum += one;
    return sum / double(std::max<std::size_t>(1, frame_ms.size()));
}

std::uint64_t triangles_of(const Scene& scene, std::span<const std::uint64_t> objects) {
    std::uint64_t sum = 0;
    for (std::size_t word = 0; word < objects.size(); ++word)
        for (std::uint64_t rest = objects[word]; rest; rest &= rest - 1)
            sum += scene.objects()[word * 64 + std::size_t(std::countr_zero(rest))].triangle_count;
    return sum;
}

Result<std::vector<Measured>> measure(const Bench& bench, std::span<const View> views,
                                      std::span<const Contender> contenders, Measured* truth) {
    std::vector<Measured> all(contenders.size());
    std::vector<std::unique_ptr<Culler>> cullers;
    for (std::size_t m = 0; m < contenders.size(); ++m) {
        auto culler = make_culler(contenders[m].culler, bench.cull_scene, contenders[m].options);
        if (!culler)
            return culler.status();
        cullers.push_back(std::move(*culler));
        all[m].name = contenders[m].name;
        all[m].cull_ms.assign(views.size(), 1e300);
        all[m].draw_ms.assign(views.size(), bench.drawing ? 1e300 : -1);
        all[m].frame_ms.assign(views.size(), 1e300);
    }
    const std::size_t turns = cullers.size() + (truth ? 1 : 0);
    for (std::uint32_t pass = 0; pass < std::max(1u, bench.repeat); ++pass) {
        std::vector<ViewState> states(cullers.size());
        CullResult result;
        for (std::size_t f = 0; f < views.size(); ++f)
            for (std::size_t k = 0; k < turns; ++k) {
                std::size_t m = (k + f + pass) % turns;
                View view = views[f];
                view.aspect = bench.aspect;
                if (m == cullers.size()) {
                    double draw = bench.drawing ? bench.drawing->draw(view, truth->visible[f]) * 1e3 : -1;
                    truth->draw_ms[f] = pass == 0 ? draw : std::min(truth->draw_ms[f], draw);
                    truth->frame_ms[f] = std::max(truth->draw_ms[f], 0.0);
                    continue;
                }
                auto start = std::chrono::steady_clock::now();
                cullers[m]->cull(view, states[m], result);
                double cull = milliseconds_since(start);
                double draw = bench.drawing ? bench.drawing->draw(view, result.visible) * 1e3 : 0;
                all[m].cull_ms[f] = std::min(all[m].cull_ms[f], cull);
                if (bench.drawing)
                    all[m].draw_ms[f] = std::min(all[m].draw_ms[f], draw);
                all[m].frame_ms[f] = std::min(all[m].frame_ms[f], cull + draw);
                if (pass == 0 && f == all[m].visible.size()) {
                    all[m].visible.push_back(result.visible);
                    all[m].triangles.push_back(triangles_of(bench.scene, result.visible));
                }
            }
    }
    return all;
}

Measured truth_of(const Bench& bench, const Tracer& tracer, std::span<const View> views, std::uint32_t pixels,
                  const Job& job) {
    Measured truth;
    truth.name = "truly visible";
    Job inner = job;
    inner.progress = nullptr;
    for (const View& view : views) {
        auto rays = PixelRays::of_view(view, static_cast<std::uint32_t>(pixels * bench.aspect), pixels);
        ItemBuffer buffer = ItemBuffer::render(tracer, rays, {}, inner);
        std::vector<std::uint64_t> seen(bench.cull_scene.words(), 0);
        mark_seen(bench.scene, buffer, seen);
        truth.triangles.push_back(triangles_of(bench.scene, seen));
        truth.cull_ms.push_back(0);
        truth.draw_ms.push_back(-1);
        truth.frame_ms.push_back(0);
        truth.visible.push_back(std::move(seen));
    }
    return truth;
}

std::uint64_t lost_objects(const Measured& method, const Measured& truth) {
    std::uint64_t sum = 0;
    for (std::size_t f = 0; f < truth.visible.size(); ++f)
        for (std::size_t word = 0; word < truth.visible[f].size(); ++word)
            sum += std::uint64_t(std::popcount(truth.visible[f][word] & ~method.visible[f][word]));
    return sum;
}

Result<OccluderDatabase> database_along(const Scene& scene, const OccluderSet& occluders, std::span<const View> views,
                                        std::uint32_t points, const MosOptions& options, const Job& job,
                                        MosStatistics* statistics) {
    Box3d eyes;
    for (const View& view : views)
        eyes.extend(view.eye);
    MosOptions along = options;
    int axis = eyes.size().x >= eyes.size().z ? 0 : 2;
    along.grid = {1, 1, 1};
    along.grid[static_cast<std::size_t>(axis)] = points;
    along.region = {scene.to_world(eyes.min), scene.to_world(eyes.max)};
    return build_occluder_database(scene, occluders, along, job, statistics);
}

OccluderDatabase one_list(std::span<const std::uint32_t> polygons) {
    OccluderDatabase database;
    database.first.assign(1, 0);
    database.polygons.assign(polygons.begin(), polygons.end());
    for (std::uint32_t d = 0; d < OccluderDatabase::kDirections; ++d)
        database.first.push_back(static_cast<std::uint32_t>(polygons.size()));
    return database;
}

Image top_view(const Scene& scene, const OccluderSet& occluders, const View& view,
               std::span<const std::uint64_t> in_frustum, std::span<const std::uint64_t> reported,
               std::span<const std::uint32_t> drawn) {
    constexpr double kLonger = 720;
    Box3d box = to_double(scene.local_bounds());
    Vec3d size = box.max - box.min;
    double scale = kLonger / std::max({size.x, size.z, 1e-9});
    Image image;
    image.width = std::max(8u, std::uint32_t(size.x * scale) + 2);
    image.height = std::max(8u, std::uint32_t(size.z * scale) + 2);
    image.rgb.assign(std::size_t(3) * image.width * image.height, 255);
    auto dot_at = [&](double x, double z, std::uint8_t r, std::uint8_t g, std::uint8_t b) {
        auto i = static_cast<std::int64_t>((x - box.min.x) * scale), j = static_cast<std::int64_t>((z - box.min.z) * scale);
        if (i < 0 || j < 0 || i >= image.width || j >= image.height)
            return;
        std::uint8_t* pixel = image.rgb.data() + 3 * (std::size_t(j) * image.width + std::size_t(i));
        pixel[0] = r, pixel[1] = g, pixel[2] = b;
    };
    // What is reported is drawn last, so that flat grounds under it do not hide it.
    for (int pass = 0; pass < 3; ++pass)
        for (std::uint32_t o = 0; o < scene.objects().size(); ++o) {
            int shade = !has_bit(in_frustum, o) ? 0 : !has_bit(reported, o) ? 1 : 2;
            const Box3f& b = scene.objects()[o].bounds;
            bool flat = b.max.y - b.min.y < 0.02 * size.y;
            if (shade != pass || flat)
                continue;
            const std::uint8_t grey[3] = {220, 130, 0};
            for (double x = b.min.x; x <= b.max.x; x += 0.9 / scale)
                for (double z = b.min.z; z <= b.max.z; z += 0.9 / scale)
                    dot_at(x, z, grey[shade], grey[shade], grey[shade]);
        }
    for (std::uint32_t p : drawn) {
        std::span<const std::uint32_t> loop = occluders.loop(occluders.polygons[p]);
        for (std::size_t i = 0; i < loop.size(); ++i) {
            Vec3d a = to_double(occluders.vertices[loop[i]]), b = to_double(occluders.vertices[loop[(i + 1) % loop.size()]]);
            for (int k = 0; k <= 60; ++k)
                dot_at(a.x + (b.x - a.x) * k / 60, a.z + (b.z - a.z) * k / 60, 220, 30, 30);
        }
    }
    for (double dx = -3; dx <= 3; ++dx)
        for (double dz = -3; dz <= 3; ++dz)
            dot_at(view.eye.x + dx / scale, view.eye.z + dz / scale, 30, 90, 220);
    return image;
}

StudyCell rate_of(const Measured& method) {
    double ms = method.mean_frame_ms();
    return method.draw_ms.empty() || method.draw_ms[0] < 0 || ms <= 0 ? StudyCell() : StudyCell(1000 / ms);
}

double culled_percent(const Measured& method, const Measured& frustum) {
    return 100 * (1 - method.mean_triangles() / std::max(1.0, frustum.mean_triangles()));
}

} // namespace antumbra::poon_wang
