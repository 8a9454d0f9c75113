// The generated scenes and the cells of the studies of the exact method, shared by their benchmarks: the papers' partitions
// of town and forest (Nirenstein, Blake, Gain 2002, section 5).
#pragma once

#include "bake/exact/cell.hpp"
#include "bake/viewpoint.hpp"
#include "base/random.hpp"

#include <antumbra/generate.hpp>
#include <antumbra/import.hpp>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <ctime>
#include <string>
#include <vector>

namespace antumbra::exact {

/// CPU seconds of the calling thread.
inline double cpu_seconds() {
    timespec now{};
    ::clock_gettime(CLOCK_THREAD_CPUTIME_ID, &now);
    return static_cast<double>(now.tv_sec) + static_cast<double>(now.tv_nsec) * 1e-9;
}

/// KIND:TRIANGLES:CELL, e.g. town:1330000:2 (cells of 2 m), town:1330000:grid (32 x 32 x 16 of the scene's box, of which the
/// two lowest levels) or forest:1450000:grid (20 x 20, 2 m high, above
/// the ground of the cell; forest-dense as well).
struct Setup {
    std::string kind;
    std::uint64_t triangles = 0;
    double cell = 0; ///< edge in metres, 0: the paper's grid
    std::string file; ///< FILE@XxYxZ: a scene of that many cells, whose units are its objects
    unsigned across[3] = {1, 1, 1};

    Units units(const Scene& scene) const { return file.empty() ? Units::triangles(scene) : Units::objects(scene); }
    std::string cell_name() const { return !file.empty() ? "file" : cell > 0 ? std::to_string(static_cast<int>(cell)) + " m" : "grid"; }
};

/// Ends the program if it is none.
inline Setup parse_setup(const char* text) {
    char kind[32] = "", cell[32] = "";
    if (const char* at = std::strrchr(text, '@')) {
        Setup setup;
        setup.file.assign(text, at);
        setup.kind = setup.file.substr(setup.file.find_last_of('/') + 1);
        if (std::sscanf(at + 1, "%ux%ux%u", &setup.across[0], &setup.across[1], &setup.across[2]) != 3)
            std::exit((std::fprintf(stderr, "not FILE@XxYxZ: %s\n", text), 2));
        return setup;
    }
    unsigned long long triangles = 0;
    if (std::sscanf(text, "%31[^:]:%llu:%31s", kind, &triangles, cell) != 3) {
        std::fprintf(stderr, "not KIND:TRIANGLES:CELL: %s\n", text);
        std::exit(2);
    }
    return {kind, triangles, std::atof(cell), {}, {1, 1, 1}};
}

/// The same scene on every machine: its fingerprint says so. Ends the program on failure.
inline Scene generate_setup(const Setup& setup) {
    if (!setup.file.empty()) {
        Result<Scene> scene = load_scene(setup.file);
        if (!scene)
            std::exit((std::fprintf(stderr, "%s\n", scene.status().message().c_str()), 1));
        return std::move(*scene);
    }
    Result<RawScene> raw = generate(setup.kind, {setup.triangles, 1, 1});
    if (!raw) {
        std::fprintf(stderr, "%s\n", raw.status().message().c_str());
        std::exit(1);
    }
    return std::move(*Scene::create(std::move(*raw)));
}

/// The highest point of a forest's ground within an upright prism, local; the scene's lowest if there is none.
inline double ground_below(const Scene& scene, const Vec3d& low, const Vec3d& high) {
    double top = to_double(scene.local_bounds()).min.y;
    for (std::uint32_t t = 0; t < scene.triangles().size(); ++t) {
        if (!scene.name(scene.triangle_objects()[t]).starts_with("ground "))
            continue;
        Box3d box;
        for (int k = 0; k < 3; ++k)
            box.extend(scene.vertex(t, k));
        if (box.min.x <= high.x && box.max.x >= low.x && box.min.z <= high.z && box.max.z >= low.z)
            top = std::max(top, box.max.y);
    }
    return top;
}

/// Random cells (local, on the grid) that hold a point in free space; the first `n` do not depend on `wanted`.
inline std::vector<GridBox> choose_cells(const Scene& scene, const SceneTree& tree, const Tracer& tracer, const Setup& setup,
                                         std::size_t wanted, std::uint64_t seed) {
    std::vector<GridBox> cells;
    Random random(seed, 77);
    Box3d bounds = to_double(scene.local_bounds());
    bool forest = setup.kind.starts_with("forest");
    if (!setup.file.empty()) {
        for (unsigned c = 0; c < setup.across[0] * setup.across[1] * setup.across[2] && cells.size() < wanted; ++c) {
            unsigned at[3] = {c % setup.across[0], c / setup.across[0] % setup.across[1], c / setup.across[0] / setup.across[1]};
            Vec3d low, high;
            for (int k = 0; k < 3; ++k) {
                low[k] = bounds.min[k] + bounds.size()[k] * at[k] / setup.across[k];
                high[k] = bounds.min[k] + bounds.size()[k] * (at[k] + 1) / setup.across[k];
            }
            cells.push_back({tree.to_grid(low), tree.to_grid(high)});
        }
        return cells;
    }
    for (int attempt = 0; attempt < 100000 && cells.size() < wanted; ++attempt) {
        Vec3d low, size;
        if (setup.cell > 0) {
            size = {setup.cell, std::min(setup.cell, 2.0), setup.cell};
            for (int k = 0; k < 3; ++k)
                low[k] = k == 1 ? bounds.min.y + 1 : random.uniform(bounds.min[k], bounds.max[k] - size[k]);
        } else {
            double across = forest ? 20 : 32;
            size = {bounds.size().x / across, bounds.size().y / 16, bounds.size().z / across};
            double level = forest ? 0 : random.below(2);
            low = {bounds.min.x + size.x * random.below(static_cast<std::uint32_t>(across)), bounds.min.y + size.y * level,
                   bounds.min.z + size.z * random.below(static_cast<std::uint32_t>(across))};
        }
        if (forest) { // where somebody walks, above all ground of the cell
            size.y = 2;
            low.y = std::ceil(ground_below(scene, low, low + size) / scene.step()) * scene.step();
        }
        GridBox box{tree.to_grid(low), tree.to_grid(low + size)};
        bool free = false;
        for (int k = 0; k < 64 && !free; ++k)
            free = is_viewpoint(tracer, {random.uniform(low.x, low.x + size.x), random.uniform(low.y, low.y + size.y),
                                         random.uniform(low.z, low.z + size.z)});
        if (free)
            cells.push_back(box);
    }
    return cells;
}

} // namespace antumbra::exact
