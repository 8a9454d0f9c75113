// Rays per CPU second of the whole sampled bake (strict rays, exact proofs, bookkeeping) beside Embree alone with the
// same directions from the same cells, one thread each; with what the bake found and what it missed.
//
//   bench_bake SCENE.. [--cells N]    prints one CSV line per scene
#include "bake/sampled/region_sampler.hpp"
#include "rays/embree_caster.hpp"

#include <antumbra/import.hpp>

#include <bit>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <ctime>

using namespace antumbra;

namespace {

void aim(RegionSampler& sampler) {
    PriorKnowledge none;
    sampler.aim_at_unseen(none);
}

double cpu_seconds() {
    timespec now{};
    clock_gettime(CLOCK_THREAD_CPUTIME_ID, &now);
    return double(now.tv_sec) + double(now.tv_nsec) * 1e-9;
}

/// A cell of 1/16 of the scene's size.
Box3d random_cell(const Box3d& bounds, Random& random) {
    Vec3d size = bounds.size() / 16, low;
    for (int k = 0; k < 3; ++k)
        low[k] = random.uniform(bounds.min[k], bounds.max[k] - size[k]);
    return {low, low + size};
}

int measure(const char* path, int cells) {
    SceneOptions both;
    both.sides = SidesOption::both; // so that Embree needs no filter
    Result<Scene> scene = load_scene(path, {}, both);
    if (!scene)
        return std::fprintf(stderr, "%s\n", scene.status().message().c_str()), 1;
    Tracer tracer = Tracer::build(*scene);
    Result<EmbreeCaster> embree = EmbreeCaster::build(*scene);
    if (!embree)
        return std::fprintf(stderr, "%s\n", embree.status().message().c_str()), 1;
    BakeOptions options;
    options.holdout_rays = 0;
    SamplingScene shared(tracer, options);
    Random random(7);
    double bake_seconds = 0, embree_seconds = 0;
    std::uint64_t bake_rays = 0, embree_rays = 0, visible = 0, holdout = 0, misses = 0;
    std::vector<Hit> hits;
    for (int c = 0; c < cells; ++c) {
        SamplingRegion region = SamplingRegion::all_directions(random_cell(to_double(scene->local_bounds()), random));
        // The same draws twice: once to be timed as a bake does it, once to keep the rays for Embree.
        double start = cpu_seconds();
        RegionSampler timed(shared, region, std::uint64_t(c));
        timed.look_around(options.rays_per_cell);
        bake_seconds += cpu_seconds() - start;
        bake_rays += std::move(timed).finish().rays;
        RegionSampler sampler(shared, region, std::uint64_t(c));
        RayCache cache;
        sampler.look_around(options.rays_per_cell, &cache);
        std::vector<Ray> rays;
        for (const RayCache::Entry& entry : cache.entries)
            rays.push_back(entry.ray);
        hits.resize(rays.size());
        start = cpu_seconds();
        embree->first_hits(rays, hits);
        embree_seconds += cpu_seconds() - start;
        embree_rays += rays.size();
        aim(sampler);
        sampler.measure_misses(2048);
        RegionSample sample = std::move(sampler).finish();
        for (std::uint64_t word : sample.visible)
            visible += std::uint64_t(std::popcount(word));
        holdout += sample.holdout_rays;
        misses += sample.holdout_misses;
    }
    double bake_rate = double(bake_rays) / bake_seconds * 1e-6, embree_rate = double(embree_rays) / embree_seconds * 1e-6;
    const char* name = std::strrchr(path, '/');
    std::printf("%s,%zu,%zu,%d,%.3f,%.3f,%.3f,%.1f,%.6f\n", name ? name + 1 : path, scene->triangles().size(),
                scene->objects().size(), cells, bake_rate, embree_rate, bake_rate / embree_rate,
                double(visible) / cells, holdout ? double(misses) / double(holdout) : 0.0);
    return 0;
}

} // namespace

int main(int argc, char** argv) {
    int cells = 16, failed = 0;
    std::puts("scene,triangles,objects,cells,bake_mrays_per_cpu_s,embree_mrays_per_cpu_s,ratio,mean_visible,miss_rate");
    for (int i = 1; i < argc; ++i)
        if (std::strcmp(argv[i], "--cells") == 0 && i + 1 < argc)
            cells = std::atoi(argv[++i]);
        else
            failed |= measure(argv[i], cells);
    return failed;
}
