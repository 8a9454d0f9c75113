// Whole cells by the exact method (Nirenstein, Blake, Gain 2002, section 5): the papers' partitions of the generated town
// and forest, each triangle a unit.
//
//   bench_exact_cells SCENE.. [--cells N] [--csv FILE] [--seed S] [--seconds LIMIT] [--fast|--published] [--no-OPTION..]
//
// SCENE is KIND:TRIANGLES:CELL, e.g. town:1330000:2 (cells of 2 m), town:1330000:grid (32 x 32 x 16 of the scene's box, of
// which the two lowest levels) or forest:1450000:grid (20 x 20). Random cells of those that hold a point in free space.
// FILE@XxYxZ: the cells of that grid over a scene, whose units are its objects.
// CPU seconds of one thread; a machine of two cores that has cells enough needs half of that per cell.
#include "exact_setups.hpp"

#include <atomic>
#include <bit>
#include <chrono>
#include <condition_variable>
#include <cstring>
#include <mutex>
#include <thread>

using namespace antumbra;
using namespace antumbra::exact;

namespace {

/// Equal answers, equal numbers.
std::uint64_t hash_of(const std::vector<std::uint64_t>& bits) {
    std::uint64_t hash = 0xCBF29CE484222325u;
    for (std::uint64_t word : bits)
        for (int byte = 0; byte < 8; ++byte)
            hash = (hash ^ (word >> (8 * byte) & 255)) * 0x100000001B3u;
    return hash;
}

struct Options {
    std::size_t cells = 4;
    std::uint64_t seed = 1;
    const char* csv = nullptr;
    const char* queries = nullptr; ///< CSV of effective occluders and times
    unsigned seconds = 0;          ///< a cell that takes longer is stopped, and says so; 0: none is
    CellOptions cell;
};

/// Sets a flag after some seconds, unless it ends before.
class Alarm {
  public:
    Alarm(std::atomic<bool>& flag, unsigned seconds) {
        if (seconds > 0)
            thread_ = std::thread([this, &flag, seconds] {
                std::unique_lock lock(mutex_);
                if (!wake_.wait_for(lock, std::chrono::seconds(seconds), [this] { return done_; }))
                    flag = true;
            });
    }
    ~Alarm() {
        {
            std::lock_guard lock(mutex_);
            done_ = true;
        }
        wake_.notify_one();
        if (thread_.joinable())
            thread_.join();
    }

  private:
    std::mutex mutex_;
    std::condition_variable wake_;
    bool done_ = false;
    std::thread thread_;
};

struct ByEffective {
    std::uint64_t count = 0;
    double seconds = 0;
};

void run(const Setup& setup, const Options& options) {
    Scene scene = generate_setup(setup);
    double start = cpu_seconds();
    Tracer tracer = Tracer::build(scene);
    SceneTree tree = SceneTree::build(scene, setup.units(scene));
    double build = cpu_seconds() - start;
    std::vector<GridBox> cells = choose_cells(scene, tree, tracer, setup, options.cells, options.seed);
    CellOptions cell_options = options.cell;
    std::vector<ByEffective> by_effective(1000);
    ByEffective by_kind[2][3];
    if (options.queries)
        cell_options.observer = [&](const QueryRecord& record) {
            ByEffective& kind = by_kind[record.box][static_cast<std::size_t>(record.answer)];
            ++kind.count;
            kind.seconds += record.seconds;
            ByEffective& bin = by_effective[std::min<std::size_t>(record.effective, by_effective.size() - 1)];
            ++bin.count;
            bin.seconds += record.seconds;
        };
    CellSolver solver(tree, tracer, cell_options);
    CellCounters total;
    double visible_share = 0, worst = 0, sum = 0;
    std::size_t count = tree.units().count();
    std::vector<double> times;
    for (const GridBox& cell : cells) {
        std::vector<std::uint64_t> bits((tree.units().count() + 63) / 64, 0);
        CellCounters counters;
        double begin = cpu_seconds();
        std::atomic<bool> stop{false};
        bool finished = false;
        {
            Alarm alarm(stop, options.seconds);
            finished = solver.solve(cell, bits, counters, {}, &stop);
        }
        double seconds = cpu_seconds() - begin;
        std::uint64_t visible = 0;
        for (std::uint64_t word : bits)
            visible += static_cast<std::uint64_t>(std::popcount(word));
        std::uint64_t sampled = counters.sampler.uniform + counters.sampler.guided;
        std::fprintf(stderr,
                     "  %s%.2f s, visible %llu (first sampled %llu, aimed %llu, mutated %llu, extended %llu), rays %llu, boxes %llu "
                     "(hidden %llu, by ray %llu), triangles %llu (hidden %llu), pairs %llu (+%llu handed down), windows %llu (hidden %llu), pieces %llu, "
                     "effective mean %.1f most %u, undecided %llu, answer %016llx\n",
                     finished ? "" : "STOPPED after ", seconds, (unsigned long long)visible, (unsigned long long)sampled,
                     (unsigned long long)counters.sampler.aimed, (unsigned long long)counters.sampler.mutated,
                     (unsigned long long)counters.extended, (unsigned long long)counters.sampler.rays,
                     (unsigned long long)counters.box_queries, (unsigned long long)counters.boxes_hidden,
                     (unsigned long long)counters.boxes_by_ray, (unsigned long long)counters.triangle_queries,
                     (unsigned long long)counters.triangles_hidden, (unsigned long long)counters.pairs,
                     (unsigned long long)counters.pairs_handed_down, (unsigned long long)counters.windows,
                     (unsigned long long)counters.windows_hidden, (unsigned long long)counters.query.pieces,
                     (double)counters.effective / (double)std::max<std::uint64_t>(1, counters.with_effective),
                     counters.most_effective, (unsigned long long)counters.undecided, (unsigned long long)hash_of(bits));
        sum += seconds;
        worst = std::max(worst, seconds);
        times.push_back(seconds);
        visible_share += static_cast<double>(visible) / static_cast<double>(count);
        total.add(counters);
    }
    double n = static_cast<double>(std::max<std::size_t>(cells.size(), 1));
    std::sort(times.begin(), times.end());
    double median = times.empty() ? 0 : times[times.size() / 2];
    std::string cell = setup.cell_name();
    std::printf("%s,%zu,%s,%zu,%.2f,%.3f,%.3f,%.3f,%.4f,%.0f,%.0f,%.0f,%.0f,%.2f,%u,%llu\n", setup.kind.c_str(), count,
                cell.c_str(), cells.size(), build, sum / n, median, worst, 100 * (1 - visible_share / n),
                (double)total.sampler.rays / n, (double)total.box_queries / n, (double)total.triangle_queries / n,
                (double)total.pairs / n,
                (double)total.effective / (double)std::max<std::uint64_t>(1, total.with_effective), total.most_effective,
                (unsigned long long)total.undecided);
    std::fflush(stdout);
    if (options.csv)
        if (std::FILE* file = std::fopen(options.csv, "a")) {
            std::fprintf(file, "%s,%zu,%s,%zu,%.2f,%.3f,%.3f,%.3f,%.4f,%.0f,%.0f,%.0f,%.0f,%.2f,%u,%llu\n", setup.kind.c_str(),
                         count, cell.c_str(), cells.size(), build, sum / n, median, worst, 100 * (1 - visible_share / n),
                         (double)total.sampler.rays / n, (double)total.box_queries / n, (double)total.triangle_queries / n,
                         (double)total.pairs / n,
                         (double)total.effective / (double)std::max<std::uint64_t>(1, total.with_effective),
                         total.most_effective, (unsigned long long)total.undecided);
            std::fclose(file);
        }
    if (!options.queries)
        return;
    for (int box = 0; box < 2; ++box)
        for (std::size_t answer = 0; answer < 3; ++answer)
            std::fprintf(stderr, "  %s %s: %llu queries, %.2f s\n", box ? "boxes" : "triangles",
                         answer == 0   ? "hidden"
                         : answer == 1 ? "visible"
                                       : "undecided",
                         (unsigned long long)by_kind[box][answer].count, by_kind[box][answer].seconds);
    const ArithmeticCounters& a = total.query.arithmetic;
    std::fprintf(stderr, "  signs %llu small %llu residue %llu exact %llu; quadric %llu undecided %llu; side %llu undecided %llu; "
                 "exact vertices %llu forced %llu; prisms %llu hulls %llu; splits %llu crossing %llu known %llu pieces %llu pairs %llu single %llu random %llu patches %llu of %llu exactw %llu retries %llu\n",
                 (unsigned long long)a.signs, (unsigned long long)a.signs_small, (unsigned long long)a.signs_residue,
                 (unsigned long long)a.signs_exact, (unsigned long long)a.quadric_signs, (unsigned long long)a.quadric_undecided,
                 (unsigned long long)a.side_signs, (unsigned long long)a.side_undecided, (unsigned long long)a.exact_vertices,
                 (unsigned long long)a.forced_vertices, (unsigned long long)total.query.prisms, (unsigned long long)total.query.hulls,
                 (unsigned long long)total.query.splits, (unsigned long long)total.query.crossing_tests,
                 (unsigned long long)total.query.known, (unsigned long long)total.query.pieces, (unsigned long long)total.query.pairs,
                 (unsigned long long)total.query.single_cover, (unsigned long long)total.query.random_witness,
                 (unsigned long long)total.query.patches_proved, (unsigned long long)total.query.patches_tried,
                 (unsigned long long)total.query.exact_witnesses, (unsigned long long)total.query.witness_retries);
    // Least squares on logarithms, over bins of at least five queries (as in the paper), from one occluder up.
    double sx = 0, sy = 0, sxx = 0, sxy = 0, weight = 0;
    if (std::FILE* file = std::fopen(options.queries, "a")) {
        for (std::size_t m = 1; m + 1 < by_effective.size(); ++m) {
            const ByEffective& bin = by_effective[m];
            if (bin.count == 0)
                continue;
            double microseconds = 1e6 * bin.seconds / static_cast<double>(bin.count);
            std::fprintf(file, "%s,%zu,%s,%zu,%llu,%.1f\n", setup.kind.c_str(), count, cell.c_str(), m,
                         (unsigned long long)bin.count, microseconds);
            if (bin.count < 5)
                continue;
            double x = std::log(static_cast<double>(m)), y = std::log(microseconds);
            sx += x;
            sy += y;
            sxx += x * x;
            sxy += x * y;
            weight += 1;
        }
        std::fclose(file);
    }
    if (weight > 1)
        std::fprintf(stderr, "  time grows as effective occluders to the power %.2f (published 1.15)\n",
                     (weight * sxy - sx * sy) / (weight * sxx - sx * sx));
}

} // namespace

int main(int argc, char** argv) {
    Options options;
    std::vector<Setup> setups;
    CellOptions& cell = options.cell;
    cell.look_around = 60000;
    cell.follow = 8000000;
    cell.sample_between = true;
    cell.rays = 1;
    for (int k = 1; k < argc; ++k) {
        auto is = [&](const char* name) { return std::strcmp(argv[k], name) == 0; };
        auto value = [&] { return k + 1 < argc ? argv[++k] : "0"; };
        if (is("--cells"))
            options.cells = static_cast<std::size_t>(std::atoi(value()));
        else if (is("--seed"))
            options.seed = static_cast<std::uint64_t>(std::atoll(value()));
        else if (is("--csv"))
            options.csv = value();
        else if (is("--queries"))
            options.queries = value();
        else if (is("--seconds"))
            options.seconds = static_cast<unsigned>(std::atoi(value()));
        else if (is("--look-around"))
            cell.look_around = static_cast<std::uint32_t>(std::atoi(value()));
        else if (is("--follow"))
            cell.follow = static_cast<std::uint32_t>(std::atoi(value()));
        else if (is("--rays"))
            cell.rays = static_cast<std::uint32_t>(std::atoi(value()));
        else if (is("--box-pieces"))
            cell.box_pieces = static_cast<std::uint32_t>(std::atoi(value()));
        else if (is("--no-between"))
            cell.sample_between = false;
        else if (is("--no-windows"))
            cell.windows = false;
        else if (is("--window-pieces"))
            cell.window_pieces = static_cast<std::uint32_t>(std::atoi(value()));
        else if (is("--rays-at-box"))
            cell.rays_at_box = static_cast<std::uint32_t>(std::atoi(value()));
        else if (is("--no-virtual"))
            cell.virtual_occluders = false;
        else if (is("--no-joined"))
            cell.joined = false;
        else if (is("--no-patches"))
            cell.patches = false;
        else if (is("--published")) {
            cell.form = ExactForm::published;
            cell.rays = 200;
            cell.box_pieces = 60;
        } else {
            setups.push_back(parse_setup(argv[k]));
        }
    }
    std::printf("scene,triangles,cell,cells,build_s,mean_s,median_s,worst_s,culled_percent,rays,box_queries,triangle_queries,"
                "pairs,mean_effective,most_effective,undecided\n");
    for (const Setup& setup : setups)
        run(setup, options);
}
