// How much of a scene a cell sees, by brute force: rays in all directions from everywhere in the cell. The scene belongs to
// its fingerprint; the share is its own, no method's.
//
//   bench_exact_truth SCENE.. [--cells N] [--seed S] [--rays N] [--skip N] [--threads N]     prints CSV
//
// SCENE as in bench_exact_cells, and the same cells for the same seed; --skip leaves out the first of them. A row per cell
// and power of ten of rays: distinct triangles seen, and how many of them by one ray only (their number over that of the rays
// estimates the chance that the next ray sees a new one: Good 1953). The number of threads changes the time only; cpu_s is the sum
// over them.
#include "exact_setups.hpp"

#include <atomic>
#include <cstring>
#include <thread>

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

/// How often each triangle was seen, up to twice: what parts of the rays add up to, in any order.
class Tally {
  public:
    explicit Tally(std::size_t triangles) : times_(triangles, 0) {}
    void see(std::uint32_t t, std::uint8_t times = 1) { times_[t] = static_cast<std::uint8_t>(std::min(2, times_[t] + times)); }
    /// Adds another one and clears it.
    void take(Tally& other) {
        for (std::uint32_t t = 0; t < times_.size(); ++t)
            if (other.times_[t] != 0) {
                see(t, other.times_[t]);
                other.times_[t] = 0;
            }
    }
    std::uint64_t seen() const { return times_.size() - static_cast<std::size_t>(std::count(times_.begin(), times_.end(), 0)); }
    std::uint64_t once() const { return static_cast<std::uint64_t>(std::count(times_.begin(), times_.end(), 1)); }

  private:
    std::vector<std::uint8_t> times_;
};

/// Rays are drawn in parts, each from a random stream of its own: the same rays whatever the threads.
constexpr std::uint64_t kPart = 100000;
/// Rays from one eye, in all directions, share the top of the tree in the caches.
constexpr std::uint64_t kPerEye = 16;

void cast_part(const Tracer& tracer, const Vec3d& low, const Vec3d& high, Random random, std::uint64_t rays, Tally& tally) {
    std::vector<std::uint32_t> hits;
    Vec3d eye;
    for (std::uint64_t r = 0; r < rays; ++r) {
        if (r % kPerEye == 0)
            for (int k = 0; k < 3; ++k)
                eye[k] = random.uniform(low[k], high[k]);
        hits.clear();
        tracer.seen({eye, unit_direction(random)}, hits);
        for (std::uint32_t t : hits)
            tally.see(t);
    }
}

struct Options {
    std::size_t cells = 1, skip = 0;
    std::uint64_t seed = 1, rays = 100000000;
    std::size_t threads = 2;
};

void run(const Setup& setup, const Options& options) {
    Scene scene = generate_setup(setup);
    Tracer tracer = Tracer::build(scene);
    SceneTree tree = SceneTree::build(scene, Units::triangles(scene));
    std::vector<GridBox> cells = choose_cells(scene, tree, tracer, setup, options.cells, options.seed);
    std::size_t count = scene.triangles().size();
    for (std::size_t c = options.skip; c < cells.size(); ++c) {
        auto local = [&](const GridPoint& p) {
            return tree.to_local({static_cast<double>(p.x), static_cast<double>(p.y), static_cast<double>(p.z)});
        };
        Vec3d low = local(cells[c].min), high = local(cells[c].max);
        Tally total(count);
        std::vector<Tally> tallies(options.threads, Tally(count));
        std::uint64_t done = 0;
        double seconds = 0;
        for (std::uint64_t next = std::min<std::uint64_t>(1000000, options.rays); done < options.rays;
             next = std::min(next * 10, options.rays)) {
            std::atomic<std::uint64_t> part{done / kPart};
            std::vector<double> times(options.threads, 0);
            std::vector<std::thread> threads;
            for (std::size_t i = 0; i < options.threads; ++i)
                threads.emplace_back([&, i] {
                    double start = cpu_seconds();
                    for (std::uint64_t p = part++; p * kPart < next; p = part++)
                        cast_part(tracer, low, high, Random(options.seed, 0x74727574 + c, static_cast<std::uint32_t>(p)), std::min(kPart, next - p * kPart), tallies[i]);
                    times[i] = cpu_seconds() - start;
                });
            for (std::thread& thread : threads)
                thread.join();
            for (Tally& tally : tallies)
                total.take(tally);
            for (double time : times)
                seconds += time;
            done = next;
            std::printf("%s,%zu,%s,%s,%zu,%llu,%llu,%llu,%.4f,%.1f\n", setup.kind.c_str(), count,
                        to_hex(scene.fingerprint()).c_str(), setup.cell_name().c_str(), c, (unsigned long long)done,
                        (unsigned long long)total.seen(), (unsigned long long)total.once(),
                        100 * static_cast<double>(total.seen()) / static_cast<double>(count), seconds);
            std::fflush(stdout);
        }
    }
}

} // namespace

int main(int argc, char** argv) {
    std::vector<Setup> setups;
    Options options;
    for (int k = 1; k < argc; ++k) {
        auto is = [&](const char* name) { return std::strcmp(argv[k], name) == 0; };
        auto value = [&] { return k + 1 < argc ? std::strtoull(argv[++k], nullptr, 10) : 0; };
        if (is("--cells"))
            options.cells = value();
        else if (is("--skip"))
            options.skip = value();
        else if (is("--seed"))
            options.seed = value();
        else if (is("--rays"))
            options.rays = value() / kPart * kPart;
        else if (is("--threads"))
            options.threads = std::max<std::size_t>(1, value());
        else
            setups.push_back(parse_setup(argv[k]));
    }
    std::printf("scene,triangles,fingerprint,cell,number,rays,seen,seen_once,seen_percent,cpu_s\n");
    for (const Setup& setup : setups)
        run(setup, options);
}
