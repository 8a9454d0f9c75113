// How much is seen in the generated scenes: for docs/scenes.md. Brute force, no bake: many uniform rays per
// view cell, 16 from each of many uniform viewpoints. A viewpoint counts only if a walker finds room there,
// 0.3 m to each side (not within a wardrobe), except in the machine.
//
//   bench_scenes [KIND..] [--rays N]    prints a markdown table; KIND may be one of generate's or `block`
//
// Columns: view cells with free space in them; objects that are seen from a cell, on average and at most, and
// the average as a share of all objects; share of the triangles of the seen objects; depth complexity: how
// many surfaces that are drawn towards it an endless ray from a cell crosses, on average.
#include "base/parallel.hpp"
#include "base/random.hpp"
#include "rays/tracer.hpp"

#include <antumbra/generate.hpp>

#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <string>

using namespace antumbra;

namespace {

/// Where somebody walks (or, in the machine, looks about), in a regular grid.
struct Walk {
    const char* kind;
    GenerateOptions options;
    Box3d region;
    std::array<std::uint32_t, 3> cells;
    double room; ///< to each side of a viewpoint, metres
};

const Walk kWalks[] = {
    {"apartment", {}, {{0, 0.5, 0}, {8.625, 2, 4.4}}, {8, 2, 4}, 0.3},
    {"block", {0, 1, 18}, {{0, 0.5, 0}, {30.625, 16.5, 4.4}}, {9, 6, 2}, 0.3},
    {"office", {}, {{0, 0.5, 0}, {50.4, 8.5, 12.25}}, {12, 6, 3}, 0.3},
    {"machine", {}, {{0.01, 0.01, 0.01}, {1.19, 1.09, 0.69}}, {5, 5, 4}, 0},
    {"city", {}, {{-7, 1, -7}, {337, 2.5, 427}}, {8, 1, 8}, 0.3},
    {"town", {}, {{-80, 1, -80}, {80, 2.5, 80}}, {8, 1, 8}, 0.3},
    {"forest", {}, {{10, 1, 10}, {210, 4, 210}}, {8, 1, 8}, 0.3},
};

Vec3d random_direction(Random& random) {
    for (;;) {
        Vec3d v;
        for (int k = 0; k < 3; ++k)
            v[k] = random.uniform(-1, 1);
        double square = dot(v, v);
        if (square > 0.01 && square <= 1)
            return v / std::sqrt(square);
    }
}

/// Does the ray meet the inside of the triangle, in front of its origin and from a side that is drawn?
bool crosses(const Scene& scene, std::uint32_t triangle, const Vec3d& origin, const Vec3d& direction) {
    Vec3d a = scene.vertex(triangle, 0) - origin, b = scene.vertex(triangle, 1) - origin,
          c = scene.vertex(triangle, 2) - origin;
    double u = dot(direction, cross(b, c)), v = dot(direction, cross(c, a)), w = dot(direction, cross(a, b));
    bool front = u < 0 && v < 0 && w<0, back = u> 0 && v > 0 && w > 0;
    Vec3d normal = cross(b - a, c - a);
    double ahead = dot(normal, a) * dot(normal, direction);
    return ahead > 0 && (front || (back && scene.object_of(triangle).has(kDoubleSided)));
}

struct CellCount {
    std::uint64_t rays = 0, objects = 0, triangles = 0, deep_rays = 0, surfaces = 0;
};

bool has_room(const Tracer& tracer, const Vec3d& eye, double room) {
    bool back = false;
    tracer.nearest_surface({eye, {0, 1, 0}}, back);
    if (back) // within something solid: nobody looks from there
        return false;
    for (Vec3d side : {Vec3d{1, 0, 0}, Vec3d{-1, 0, 0}, Vec3d{0, 0, 1}, Vec3d{0, 0, -1}})
        if (room > 0 && tracer.first_hit({eye, side}).t < room)
            return false;
    return true;
}

CellCount look(const Tracer& tracer, const Box3d& cell, std::uint64_t key, std::uint64_t rays, double room) {
    const Scene& scene = tracer.scene();
    Random random(1, key, 0x7363656e);
    std::vector<bool> seen(scene.objects().size());
    std::vector<std::uint32_t> triangles;
    double far = length(to_double(scene.local_bounds()).size());
    CellCount count;
    Ray ray;
    bool free = false;
    for (std::uint64_t i = 0; i < rays; ++i) {
        if (i % 16 == 0) {
            for (int k = 0; k < 3; ++k)
                ray.origin[k] = random.uniform(cell.min[k], cell.max[k]);
            free = has_room(tracer, ray.origin, room);
        }
        if (!free)
            continue;
        ray.direction = random_direction(random);
        ++count.rays;
        triangles.clear();
        tracer.seen(ray, triangles);
        for (std::uint32_t t : triangles)
            seen[scene.triangle_objects()[t]] = true;
        if (i % 64)
            continue;
        ++count.deep_rays;
        tracer.for_each_near_segment(ray.origin, ray.origin + ray.direction * far, [&](std::uint32_t t) {
            count.surfaces += crosses(scene, t, ray.origin, ray.direction);
            return true;
        });
    }
    for (std::size_t o = 0; o < seen.size(); ++o)
        if (seen[o]) {
            ++count.objects;
            count.triangles += scene.objects()[o].triangle_count;
        }
    return count;
}

int measure(const Walk& walk, std::uint64_t rays) {
    bool block = std::strcmp(walk.kind, "block") == 0;
    Result<RawScene> raw = generate(block ? "apartment" : walk.kind, walk.options);
    if (!raw)
        return std::fprintf(stderr, "%s\n", raw.status().message().c_str()), 1;
    Result<Scene> scene = Scene::create(std::move(*raw));
    if (!scene)
        return std::fprintf(stderr, "%s\n", scene.status().message().c_str()), 1;
    Tracer tracer = Tracer::build(*scene);
    std::size_t cells = std::size_t(walk.cells[0]) * walk.cells[1] * walk.cells[2];
    std::vector<CellCount> counts(cells);
    parallel_for(cells, {}, [&](std::size_t i, unsigned) {
        std::size_t place[3] = {i % walk.cells[0], i / walk.cells[0] % walk.cells[1],
                                i / walk.cells[0] / walk.cells[1]};
        Box3d cell;
        for (int k = 0; k < 3; ++k) {
            double step = walk.region.size()[k] / walk.cells[std::size_t(k)];
            cell.min[k] = walk.region.min[k] + double(place[k]) * step - scene->origin()[k];
            cell.max[k] = cell.min[k] + step;
        }
        counts[i] = look(tracer, cell, i, rays, walk.room);
    });
    double objects = 0, triangles = 0, most = 0, surfaces = 0, deep_rays = 0, used = 0;
    for (const CellCount& count : counts) {
        if (count.rays < rays / 50) // next to nothing of the cell is free
            continue;
        used += 1;
        objects += double(count.objects);
        triangles += double(count.triangles);
        most = std::max(most, double(count.objects));
        surfaces += double(count.surfaces);
        deep_rays += double(count.deep_rays);
    }
    double all = double(scene->objects().size()), all_triangles = double(scene->triangles().size());
    std::printf("| %s | %zu | %zu | %.0f | %.1f | %.0f | %.2f %% | %.2f %% | %.1f |\n", walk.kind,
                scene->objects().size(), scene->triangles().size(), used, objects / used, most,
                100 * objects / used / all, 100 * triangles / used / all_triangles, surfaces / deep_rays);
    std::fflush(stdout);
    return 0;
}

} // namespace

int main(int argc, char** argv) {
    std::uint64_t rays = 65536;
    std::vector<std::string> kinds;
    for (int i = 1; i < argc; ++i)
        if (std::strcmp(argv[i], "--rays") == 0 && i + 1 < argc)
            rays = std::strtoull(argv[++i], nullptr, 10);
        else
            kinds.push_back(argv[i]);
    std::printf("| scene | objects | triangles | cells | seen per cell | at most | of the objects | "
                "triangles of these | depth "
                "complexity |\n|---|---|---|---|---|---|---|---|---|\n");
    int failed = 0;
    for (const Walk& walk : kWalks) {
        bool wanted = kinds.empty();
        for (const std::string& kind : kinds)
            wanted |= kind == walk.kind;
        if (wanted)
            failed |= measure(walk, rays);
    }
    return failed;
}
