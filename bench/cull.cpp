// bench_cull [SCENE.glb ..]: run-time culling side by side on the same frames of a walk. One thread. Every time
// stands beside its quality: what was culled, what is really seen (rays), and what was lost (must be 0).
//
//   bench_cull [SCENE.glb or the name of a generated scene: city] --frames 240 --occluders 64 --width 384
//
// ratio: of frustum-scalar. spike: the 99th percentile of a frame's time over the median of its own walk (--walk 60
// frames from one place), where p99/med also mixes cheap places with dear ones. false vis: reported, but no ray of the truth sees it.
// --share 0.3 --seen 87: only from streets that have 30% of the objects in the view volume and see 87 of them. --peers 1: see peers/README.md.
#include <antumbra/bake.hpp>
#include <antumbra/cull.hpp>
#include <antumbra/generate.hpp>
#include <antumbra/import.hpp>
#include <antumbra/occluder_finding.hpp>

#include "cull_walks.hpp"
#include "peers/peers.hpp"

#include "cull/tangent_table.hpp"
#include "evaluate/cull_scene.hpp"

#include <algorithm>
#include <chrono>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <string>
#include <vector>

using namespace antumbra;
using bench::Truth;

namespace {

using Clock = std::chrono::steady_clock;
double milliseconds_since(Clock::time_point start) {
    return std::chrono::duration<double, std::milli>(Clock::now() - start).count();
}

struct Options {
    std::vector<std::string> scenes;
    std::vector<std::string> methods;
    int frames = 240, walk = 60, passes = 5, truth = 960;
    double speed = 1; ///< walking speed
    double share = 0; ///< of the objects in the view volume, or 0: any
    int seen = 0;     ///< objects that the places see, or 0: any
    bool peers = false;
    bool prepared = false; ///< through the chunks of a file
    std::string each;      ///< file for a line per frame
    OccluderOptions finding;
    CullerOptions culler;
};

struct Row {
    std::string name;
    double median = 0, p99 = 0, reported = 0;
    double spike = 0; ///< 99th percentile of a frame's time over the median of its own walk
    std::uint64_t lost = 0;
    CullCounters sum;
    std::vector<double> times; ///< of each frame, milliseconds
    std::vector<CullCounters> frames;
};

double percentile(std::vector<double> values, double part) {
    std::sort(values.begin(), values.end());
    return values[static_cast<std::size_t>(double(values.size()) * part)];
}

Row measure(const Culler& culler, const std::vector<View>& views, const Truth& truth, const Options& options) {
    Row row;
    row.name = culler.name();
    std::vector<double> best(views.size(), 1e9);
    CullResult result;
    for (int pass = 0; pass < options.passes; ++pass) {
        ViewState state;
        for (int warm = 0; warm < 2; ++warm)
            culler.cull(views[0], state, result);
        for (std::size_t f = 0; f < views.size(); ++f) {
            Clock::time_point start = Clock::now();
            culler.cull(views[f], state, result);
            best[f] = std::min(best[f], milliseconds_since(start));
            if (pass > 0)
                continue;
            row.frames.push_back(result.counters);
            row.reported += double(result.visible_count) / double(views.size());
            row.sum.patches_drawn += result.counters.patches_drawn;
            row.sum.occluders_used += result.counters.occluders_used;
            row.sum.shadow_tests += result.counters.shadow_tests;
            row.sum.polygons_drawn += result.counters.polygons_drawn;
            row.sum.boxes_tested += result.counters.boxes_tested;
            row.sum.nodes_visited += result.counters.nodes_visited;
            row.sum.relations_cached += result.counters.relations_cached;
            row.sum.tree_tests += result.counters.tree_tests;
            row.sum.tree_queries += result.counters.tree_queries;
            row.sum.tree_nodes += result.counters.tree_nodes;
            row.sum.tree_planes_tested += result.counters.tree_planes_tested;
            row.sum.hidden_by_tree += result.counters.hidden_by_tree;
            row.sum.relations_made += result.counters.relations_made;
            for (std::size_t word = 0; word < truth.seen[f].size(); ++word)
                row.lost += std::uint64_t(__builtin_popcountll(truth.seen[f][word] & ~result.visible[word]));
        }
    }
    row.times = best;
    std::vector<double> spikes;
    for (std::size_t first = 0; first < best.size(); first += std::size_t(options.walk)) {
        std::size_t last = std::min(best.size(), first + std::size_t(options.walk));
        double own = percentile({best.begin() + std::ptrdiff_t(first), best.begin() + std::ptrdiff_t(last)}, 0.5);
        for (std::size_t f = first; f < last; ++f)
            spikes.push_back(best[f] / own);
    }
    row.median = percentile(best, 0.5);
    row.p99 = percentile(best, 0.99);
    row.spike = percentile(spikes, 0.99);
    return row;
}

/// Appends a line per frame.
void write_frames(const std::string& file, const std::string& scene, const Row& row) {
    std::FILE* out = std::fopen(file.c_str(), "a");
    if (!out)
        return;
    for (std::size_t f = 0; f < row.times.size(); ++f) {
        const CullCounters& counters = row.frames[f];
        std::fprintf(out, "%s,%s,%zu,%.4f,%llu,%llu,%llu,%llu\n", scene.c_str(), row.name.c_str(), f, row.times[f],
                     (unsigned long long)counters.boxes_tested, (unsigned long long)counters.patches_drawn,
                     (unsigned long long)counters.polygons_drawn, (unsigned long long)counters.occluders_used);
    }
    std::fclose(out);
}

/// Tangent vertices by table against trying all eight (Coorg and Teller: about ten times).
void measure_tangents() {
    Random random(5);
    constexpr int kCount = 20000;
    std::vector<Box3d> boxes(kCount);
    std::vector<Vec3d> origins(kCount), directions(kCount);
    for (int i = 0; i < kCount; ++i)
        for (int k = 0; k < 3; ++k) {
            boxes[std::size_t(i)].min[k] = random.uniform(-1, 0);
            boxes[std::size_t(i)].max[k] = random.uniform(0, 1);
            origins[std::size_t(i)][k] = random.uniform(-4, 4);
            directions[std::size_t(i)][k] = random.uniform(-1, 1);
        }
    auto time = [&](auto&& find) {
        double best = 1e9;
        unsigned sum = 0;
        for (int pass = 0; pass < 9; ++pass) {
            Clock::time_point start = Clock::now();
            for (std::size_t i = 0; i < kCount; ++i) {
                Tangents tangents = find(boxes[i], origins[i], directions[i]);
                sum += tangents.valid ? unsigned(tangents.first ^ tangents.second) : 0;
            }
            best = std::min(best, milliseconds_since(start));
        }
        return std::pair(best * 1e6 / kCount, sum);
    };
    auto [table, a] = time(find_tangents);
    auto [naive, b] = time(find_tangents_naive);
    std::printf("tangent vertices: table %.1f ns, all eight %.1f ns, ratio %.1f%s\n", table, naive, naive / table,
                a == b ? "" : " (they disagree!)");
}

/// A file, or the name of a generated scene.
Result<Scene> load(const std::string& path) {
    std::span<const std::string_view> kinds = generator_names();
    if (std::find(kinds.begin(), kinds.end(), path) == kinds.end())
        return load_scene(path);
    Result<RawScene> raw = generate(path);
    if (!raw)
        return raw.status();
    return Scene::create(std::move(*raw));
}

void run(const std::string& path, const Options& options) {
    Result<Scene> scene = load(path);
    if (!scene) {
        std::fprintf(stderr, "%s\n", scene.status().message().c_str());
        return;
    }
    Clock::time_point start = Clock::now();
    OccluderStatistics found;
    OccluderSet occluders = find_occluders(*scene, options.finding, &found);
    double finding = milliseconds_since(start);
    Tracer tracer = Tracer::build(*scene);
    const CullSceneObjects objects(*scene);
    const CullSceneInput input = objects.input(&occluders);
    start = Clock::now();
    CullScene cull_scene = CullScene::create(input);
    double preparing = milliseconds_since(start);
    std::vector<std::byte> file;
    if (options.prepared) {
        start = Clock::now();
        std::vector<PvsChunk> chunks = *prepare_chunks(cull_scene);
        std::printf("prepared in %.0f ms", milliseconds_since(start));
        file = *add_pvs_chunks(*encode_pvs(describe_scene(*scene)), chunks);
        start = Clock::now();
        cull_scene = *CullScene::open(*Pvs::open(file));
        std::printf(", %zu bytes, opened in %.0f ms\n", file.size(), milliseconds_since(start));
    }
    auto frustum_culler = make_culler("frustum", cull_scene);
    std::vector<View> views =
        bench::street_walk(*scene, tracer, **frustum_culler, options.frames, options.walk, options.speed,
                           options.share, options.seen);
    if (views.empty()) {
        std::printf("%s: found no place to walk\n", path.c_str());
        return;
    }
    Truth truth = bench::find_truth(*scene, tracer, views, options.truth);
    std::printf("\n%s: %zu triangles, %zu objects; %llu triangles -> %llu polygons, %llu patches, %llu inner boxes (%llu of several objects) in "
                "%.0f ms; scene in %.0f ms; %zu frames, seen (lower bound) %.1f\n",
                path.c_str(), scene->triangles().size(), scene->objects().size(),
                (unsigned long long)found.triangles, (unsigned long long)found.polygons,
                (unsigned long long)found.patches, (unsigned long long)found.inner_boxes,
                (unsigned long long)found.joined_boxes, finding, preparing,
                views.size(), truth.mean);
    std::printf("%-18s %9s %9s %7s %7s %6s %9s %8s %9s %9s %6s %8s %8s %8s\n", "method", "ms", "p99", "ratio", "p99/med",
                "spike", "reported", "culled%", "rep/true", "false vis", "lost", "patches", "polygons", "boxes");
    double base = 0, frustum = 0;
    std::vector<std::unique_ptr<Culler>> cullers;
    for (const std::string& name : options.methods) {
        auto culler = make_culler(name, cull_scene, options.culler);
        if (culler)
            cullers.push_back(std::move(*culler));
        else
            std::printf("%-18s %s\n", name.c_str(), culler.status().message().c_str());
    }
    if (options.peers)
        for (std::unique_ptr<Culler>& peer : bench::make_peers(*scene, input))
            cullers.push_back(std::move(peer));
    for (const std::unique_ptr<Culler>& culler : cullers) {
        Row row = measure(*culler, views, truth, options);
        if (!options.each.empty())
            write_frames(options.each, path, row);
        if (row.name == "frustum-scalar") {
            base = row.median;
            frustum = row.reported;
        }
        double frames = double(views.size());
        double false_visible = row.reported - (truth.mean - double(row.lost) / frames);
        std::printf("%-18s %9.4f %9.4f %7.2f %7.2f %6.2f %9.1f %8.2f %9.2f %9.1f %6llu %8.0f %8.0f %8.0f\n", row.name.c_str(),
                    row.median, row.p99, row.median / base, row.p99 / row.median, row.spike, row.reported,
                    100 * (1 - row.reported / frustum), row.reported / truth.mean, false_visible,
                    (unsigned long long)row.lost, double(row.sum.patches_drawn) / frames,
                    double(row.sum.polygons_drawn) / frames, double(row.sum.boxes_tested) / frames);
        if (row.sum.occluders_used)
            std::printf("%-18s per frame: %.1f occluders, %.0f of eight boxes with one of them\n", "",
                        double(row.sum.occluders_used) / frames, double(row.sum.shadow_tests) / frames);
        if (row.sum.tree_tests)
            std::printf("%-18s tree per frame: %.0f nodes, %.0f boxes tested, %.0f queries, %.0f hidden, %.0f planes tested\n", "",
                        double(row.sum.tree_nodes) / frames, double(row.sum.tree_tests) / frames, double(row.sum.tree_queries) / frames,
                        double(row.sum.hidden_by_tree) / frames, double(row.sum.tree_planes_tested) / frames);
        if (row.sum.relations_made)
            std::printf("%-18s relations per frame: %.0f made, %.0f cached\n", "",
                        double(row.sum.relations_made) / frames, double(row.sum.relations_cached) / frames);
    }
}

} // namespace

int main(int argc, char** argv) {
    Options options;
    for (int i = 1; i < argc; ++i) {
        auto value = [&] { return i + 1 < argc ? argv[++i] : "0"; };
        if (!std::strcmp(argv[i], "--frames"))
            options.frames = std::atoi(value());
        else if (!std::strcmp(argv[i], "--walk"))
            options.walk = std::max(1, std::atoi(value()));
        else if (!std::strcmp(argv[i], "--passes"))
            options.passes = std::atoi(value());
        else if (!std::strcmp(argv[i], "--truth"))
            options.truth = std::atoi(value());
        else if (!std::strcmp(argv[i], "--share"))
            options.share = std::atof(value());
        else if (!std::strcmp(argv[i], "--seen"))
            options.seen = std::atoi(value());
        else if (!std::strcmp(argv[i], "--peers"))
            options.peers = std::atoi(value()) != 0;
        else if (!std::strcmp(argv[i], "--each"))
            options.each = value();
        else if (!std::strcmp(argv[i], "--width"))
            options.culler.raster_width = std::atoi(value());
        else if (!std::strcmp(argv[i], "--speed"))
            options.speed = std::atof(value());
        else if (!std::strcmp(argv[i], "--occluders"))
            options.culler.occluders = std::uint32_t(std::atoi(value()));
        else if (!std::strcmp(argv[i], "--isa")) {
            std::string isa = value();
            options.culler.instruction_set = isa == "scalar" ? InstructionSet::scalar
                                             : isa == "avx2" ? InstructionSet::avx2
                                                             : InstructionSet::automatic;
        } else if (!std::strcmp(argv[i], "--choice"))
            options.culler.occluder_choice = OccluderChoice(std::atoi(value()));
        else if (!std::strcmp(argv[i], "--prepared"))
            options.prepared = std::atoi(value()) != 0;
        else if (!std::strcmp(argv[i], "--without")) { // a part of planes-published
            std::string part = value();
            (part == "joined"   ? options.culler.published.joined
             : part == "detail" ? options.culler.published.detail
             : part == "reuse"  ? options.culler.published.reuse
                                : options.culler.published.adapt) = false;
        } else if (!std::strcmp(argv[i], "--pixels"))
            options.culler.pixels_per_polygon = float(std::atof(value()));
        else if (!std::strcmp(argv[i], "--budget"))
            options.culler.polygon_budget = std::uint32_t(std::atoi(value()));
        else if (!std::strcmp(argv[i], "--patch"))
            options.finding.patch_polygons = std::uint32_t(std::max(1, std::atoi(value())));
        else if (!std::strcmp(argv[i], "--method"))
            options.methods.push_back(value());
        else
            options.scenes.push_back(argv[i]);
    }
    if (options.methods.empty())
        for (std::string_view name : culler_names())
            if (name != "none" && name != "pvs" && name != "frustum-scalar")
                options.methods.emplace_back(name);
    options.methods.insert(options.methods.begin(), "frustum-scalar");
    if (options.scenes.empty())
        options.scenes.push_back("city");
    measure_tangents();
    for (const std::string& path : options.scenes)
        run(path, options);
}
