// How much of a scene a cell sees, by brute force: rays in all directions from everywhere in the cell. The scene belongs to
// its fingerprint; the share is its own, no method's.
//
//   bench_exact_truth SCENE.. [--cells N] [--seed S] [--rays N] [--skip N]     prints CSV
//
// SCENE as in bench_exact_cells, and the same cells for the same seed; --skip leaves out the first of them. A row per cell
// and power of ten of rays: distinct triangles seen, and how many of them by one ray only (their number over that of the rays
// estimates the chance that the next ray sees a new one: Good 1953).
#include "exact_setups.hpp"

#include <cstring>

using namespace antumbra;
using namespace antumbra::exact;

namespace {

Vec3d unit_direction(Random& random) {
    for (;;) {
        Vec3d v{random.uniform(-1, 1), random.uniform(-1, 1), random.uniform(-1, 1)};
        if (double square = dot(v, v); square > 1e-4 && square <= 1)
            return v;
    }
}

void run(const Setup& setup, std::size_t wanted, std::size_t skip, std::uint64_t seed, std::uint64_t rays) {
    Scene scene = generate_setup(setup);
    Tracer tracer = Tracer::build(scene);
    SceneTree tree = SceneTree::build(scene, Units::triangles(scene));
    std::vector<GridBox> cells = choose_cells(scene, tree, tracer, setup, wanted, seed);
    std::size_t count = scene.triangles().size();
    for (std::size_t c = skip; c < cells.size(); ++c) {
        auto local = [&](const GridPoint& p) {
            return tree.to_local({static_cast<double>(p.x), static_cast<double>(p.y), static_cast<double>(p.z)});
        };
        Vec3d low = local(cells[c].min), high = local(cells[c].max);
        std::vector<std::uint8_t> times(count, 0); // up to 2
        std::uint64_t seen = 0, once = 0, next = 1000000;
        Random random(seed, 0x74727574, static_cast<std::uint32_t>(c));
        double start = cpu_seconds();
        std::vector<std::uint32_t> hits;
        constexpr std::uint64_t kPerEye = 16;
        Vec3d eye;
        for (std::uint64_t r = 1; r <= rays; ++r) {
            if (r % kPerEye == 1)
                for (int k = 0; k < 3; ++k)
                    eye[k] = random.uniform(low[k], high[k]);
            hits.clear();
            tracer.seen({eye, unit_direction(random)}, hits);
            for (std::uint32_t t : hits) {
                if (times[t] == 2)
                    continue;
                ++times[t];
                seen += times[t] == 1;
                once += times[t] == 1;
                once -= times[t] == 2;
            }
            if (r != next && r != rays)
                continue;
            next *= 10;
            std::printf("%s,%zu,%s,%s,%zu,%llu,%llu,%llu,%.4f,%.1f\n", setup.kind.c_str(), count,
                        to_hex(scene.fingerprint()).c_str(), setup.cell_name().c_str(), c, (unsigned long long)r,
                        (unsigned long long)seen, (unsigned long long)once,
                        100 * static_cast<double>(seen) / static_cast<double>(count), cpu_seconds() - start);
            std::fflush(stdout);
        }
    }
}

} // namespace

int main(int argc, char** argv) {
    std::vector<Setup> setups;
    std::uint64_t rays = 100000000, seed = 1;
    std::size_t cells = 1, skip = 0;
    for (int k = 1; k < argc; ++k) {
        auto is = [&](const char* name) { return std::strcmp(argv[k], name) == 0; };
        auto value = [&] { return k + 1 < argc ? std::strtoull(argv[++k], nullptr, 10) : 0; };
        if (is("--cells"))
            cells = value();
        else if (is("--skip"))
            skip = value();
        else if (is("--seed"))
            seed = value();
        else if (is("--rays"))
            rays = value();
        else
            setups.push_back(parse_setup(argv[k]));
    }
    std::printf("scene,triangles,fingerprint,cell,number,rays,seen,seen_once,seen_percent,cpu_s\n");
    for (const Setup& setup : setups)
        run(setup, cells, skip, seed, rays);
}
