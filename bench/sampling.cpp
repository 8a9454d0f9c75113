// Guided beside uniform sampling: what each misses of what a reference of a hundred times the rays sees (two seeds
// united), in random cells. Rays of all kinds count, probes for viewpoints too.
//
//   bench_sampling SCENE.. [--cells N] [--rays R] [--size FRACTION]     prints CSV
#include "bake/sampled/region_sampler.hpp"

#include <antumbra/import.hpp>

#include <bit>
#include <cstdio>
#include <cstdlib>
#include <cstring>

using namespace antumbra;

namespace {

void run_test(RegionSampler& sampler) {
    PriorKnowledge none;
    sampler.aim_at_unseen(none);
}

struct Budget {
    int cells = 8;
    std::uint32_t rays = 32768;
    double size = 1.0 / 16;
};

/// A cell of the given share of the scene's size that has a viewpoint and is not far outside of everything.
SamplingRegion random_cell(const Tracer& tracer, double share, Random& random) {
    Box3d bounds = to_double(tracer.scene().local_bounds());
    Vec3d size = bounds.size() * share, low;
    for (int k = 0; k < 3; ++k)
        low[k] = random.uniform(bounds.min[k], bounds.max[k] - size[k]);
    return SamplingRegion::all_directions({low, low + size});
}

RegionSample run(const SamplingScene& shared, const SamplingRegion& region, std::uint64_t key, Sampling sampling,
                 std::uint32_t rays, bool aim) {
    RegionSampler sampler(shared, region, key);
    if (sampling == Sampling::guided)
        sampler.look_guided(rays);
    else
        sampler.look_around(rays);
    if (aim)
        run_test(sampler);
    return std::move(sampler).finish();
}

struct Tally {
    std::uint64_t rays = 0, missed = 0;
    void count(const RegionSample& sample, const std::vector<std::uint64_t>& reference) {
        rays += sample.rays;
        for (std::size_t w = 0; w < reference.size(); ++w)
            missed += std::uint64_t(std::popcount(reference[w] & ~sample.visible[w]));
    }
};

int measure(const char* path, const Budget& budget) {
    Result<Scene> scene = load_scene(path);
    if (!scene)
        return std::fprintf(stderr, "%s\n", scene.status().message().c_str()), 1;
    Tracer tracer = Tracer::build(*scene);
    BakeOptions options;
    options.sampling = Sampling::guided; // prepares both
    BakeOptions other = options;
    other.seed = 2;
    SamplingScene shared(tracer, options), second(tracer, other);
    Random random(11);
    struct Method {
        const char* name;
        Sampling sampling;
        std::uint32_t divisor;
        bool aim;
        Tally tally;
    } methods[] = {{"uniform", Sampling::uniform, 1, false, {}}, {"uniform", Sampling::uniform, 10, false, {}},
                   {"guided", Sampling::guided, 1, false, {}},   {"guided", Sampling::guided, 10, false, {}},
                   {"guided", Sampling::guided, 40, false, {}},  {"uniform+aimed", Sampling::uniform, 1, true, {}},
                   {"guided+aimed", Sampling::guided, 10, true, {}}};
    std::uint64_t reference_pairs = 0;
    for (int cell = 0, tries = 0; cell < budget.cells && tries < 1000; ++tries) {
        SamplingRegion region = random_cell(tracer, budget.size, random);
        RegionSample first = run(shared, region, 1000 + std::uint64_t(tries), Sampling::uniform, 100 * budget.rays, false);
        if (first.solid)
            continue;
        RegionSample again = run(second, region, 1000 + std::uint64_t(tries), Sampling::uniform, 100 * budget.rays, false);
        std::uint64_t pairs = 0;
        for (std::size_t w = 0; w < first.visible.size(); ++w)
            pairs += std::uint64_t(std::popcount(first.visible[w] |= again.visible[w]));
        if (pairs < 10)
            continue; // looks at nothing
        ++cell;
        reference_pairs += pairs;
        for (Method& method : methods)
            method.tally.count(run(shared, region, std::uint64_t(tries), method.sampling, budget.rays / method.divisor,
                                   method.aim),
                               first.visible);
    }
    const char* name = std::strrchr(path, '/');
    for (const Method& method : methods)
        std::printf("%s,%d,%llu,%s,%u,%llu,%llu,%.5f\n", name ? name + 1 : path, budget.cells,
                    static_cast<unsigned long long>(reference_pairs), method.name, budget.rays / method.divisor,
                    static_cast<unsigned long long>(method.tally.rays),
                    static_cast<unsigned long long>(method.tally.missed),
                    double(method.tally.missed) / double(reference_pairs));
    return 0;
}

} // namespace

int main(int argc, char** argv) {
    Budget budget;
    int failed = 0;
    std::puts("scene,cells,reference_pairs,sampling,budget_per_cell,rays_cast,missed_pairs,miss_rate");
    for (int i = 1; i < argc; ++i)
        if (i + 1 < argc && std::strcmp(argv[i], "--cells") == 0)
            budget.cells = std::atoi(argv[++i]);
        else if (i + 1 < argc && std::strcmp(argv[i], "--rays") == 0)
            budget.rays = std::uint32_t(std::atoi(argv[++i]));
        else if (i + 1 < argc && std::strcmp(argv[i], "--size") == 0)
            budget.size = std::atof(argv[++i]);
        else
            failed |= measure(argv[i], budget);
    return failed;
}
