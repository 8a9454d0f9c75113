#include <antumbra/bake.hpp>

#include "bake/assemble.hpp"
#include "bake/exact/exact_cells.hpp"
#include "bake/view_cells.hpp"
#include "base/parallel.hpp"

#include <bit>
#include <chrono>
#include <ctime>
#include <optional>

namespace antumbra {
namespace {

using Clock = std::chrono::steady_clock;

double seconds_since(Clock::time_point start) {
    return std::chrono::duration<double>(Clock::now() - start).count();
}

double process_cpu_seconds() {
    timespec now{};
    ::clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &now);
    return double(now.tv_sec) + double(now.tv_nsec) * 1e-9;
}

Status check(const BakeOptions& options) {
    if (options.method != "sampled" && options.method != "exact")
        return {ErrorCode::usage, "unknown bake method '" + options.method + "'; known: sampled, exact"};
    if (options.method != "exact" && options.exact.granularity != Granularity::object)
        return {ErrorCode::usage, "clusters and triangles are listed by the exact method only; use --method exact"};
    if (options.exact.cluster_triangles == 0 || options.exact.max_pieces == 0)
        return {ErrorCode::usage, "a cluster holds one triangle or more, and the budget is one piece or more"};
    Subdivision subdivision = options.tree.subdivision;
    if (options.method == "exact" && (subdivision == Subdivision::angular || subdivision == Subdivision::five))
        return {ErrorCode::usage, "the exact method speaks of boxes in space; use --subdivision grid, boxes or spatial"};
    if (!std::has_single_bit(options.exact.block) || options.exact.block > 64)
        return {ErrorCode::usage, "exact cells are solved in blocks of 1, 2, 4 .. 64 along each axis"};
    if (options.rays_per_cell == 0 || options.rays_per_cell > 1u << 30 || options.holdout_rays > 1u << 28)
        return {ErrorCode::usage, "rays per cell must be 1 to 2^30, hold-out rays up to 2^28"};
    const SprtOptions& test = options.sequential;
    if (!(0 < test.s_t && test.s_t < test.s_1 && test.s_1 < 1 && 0 < test.b && test.b < 1 && 1 < test.a) ||
        test.most_rays == 0 || test.most_rays > 1u << 20)
        return {ErrorCode::usage, "the sequential test needs 0 < s_t < s_1 < 1, 0 < b < 1 < a, at most 2^20 rays"};
    const ViewTreeOptions& tree = options.tree;
    if (!(tree.view_space > 0 && tree.view_space <= 1000 && tree.effectiveness >= 0 && tree.effectiveness <= 1 &&
          tree.min_extent > 0 && tree.min_extent <= 1) ||
        tree.max_depth > 64 || tree.tile_depth > 12 || tree.node_rays == 0 || tree.node_rays > 1u << 24)
        return {ErrorCode::usage, "the view tree needs a view space of 0 to 1000 times the scene, effectiveness 0 to 1, "
                                  "an extent of 0 to 1, depth up to 64 below tiles of depth up to 12"};
    if (options.shard.index >= options.shard.count || options.shard.count > 1u << 20)
        return {ErrorCode::usage, "a shard has a number from 1 to their count, of which there are at most 2^20"};
    double volumes = double(options.volumes[0]) * options.volumes[1] * options.volumes[2];
    if (volumes > 1 << 20)
        return {ErrorCode::limit, "at most 2^20 occludee volumes; ask for fewer along each axis"};
    if (volumes > 0 && options.method != "sampled")
        return {ErrorCode::usage, "occludee volumes need the sampled method"};
    return {};
}

} // namespace

Result<BakeResult> bake(const Scene& scene, const BakeOptions& options, const Job& job) {
    Clock::time_point start = Clock::now();
    double cpu_start = process_cpu_seconds();
    if (Status status = check(options); !status)
        return status;
    Tracer tracer = Tracer::build(scene, job);
    SamplingScene shared(tracer, options);
    Subdivision subdivision = options.tree.subdivision;
    Result<BakeResult> result = subdivision == Subdivision::grid    ? bake_grid(shared, job)
                                : subdivision == Subdivision::boxes ? bake_boxes(shared, job)
                                                                    : bake_tree(shared, job);
    if (result) {
        result->statistics.seconds = seconds_since(start);
        result->statistics.cpu_seconds = process_cpu_seconds() - cpu_start;
    }
    return result;
}

Result<BakePlan> plan_bake(const Scene& scene, const BakeOptions& options, const Job& job) {
    constexpr std::size_t kProbedCells = 8;
    if (Status status = check(options); !status)
        return status;
    Result<ViewCells> view = lay_view_cells(scene, options);
    if (!view)
        return view.status();
    BakePlan plan;
    plan.grid = view->grid;
    plan.cells_to_bake = view->to_bake.size();
    Clock::time_point start = Clock::now();
    Tracer tracer = Tracer::build(scene, job);
    SamplingScene shared(tracer, options);
    std::optional<ExactCells> exact;
    if (options.method == "exact")
        exact.emplace(shared);
    double set_up_seconds = seconds_since(start);
    std::size_t probed = std::min(kProbedCells, view->to_bake.size());
    std::atomic<std::uint64_t> set_bits{0}, rows{0};
    start = Clock::now();
    parallel_for(probed, job, [&](std::size_t index, unsigned) {
        std::uint64_t cell = view->to_bake[(2 * index + 1) * view->to_bake.size() / (2 * probed)];
        Box3d box = view->grid.cell(cell);
        RegionSample sample = exact ? exact->solve(box).sample : sample_cell(shared, box);
        rows += !sample.solid;
        set_bits += count_objects(sample, scene.objects().size());
    });
    if (job.cancelled())
        return Status(ErrorCode::cancelled, "stopped");
    double cells = double(plan.cells_to_bake);
    plan.estimated_seconds = set_up_seconds + seconds_since(start) * cells / double(std::max<std::size_t>(probed, 1));
    // A row costs at most two bytes for each visible object and a bit for each object; the header, about 64 an object.
    double objects = double(scene.objects().size());
    double row_bytes = std::min(objects / 8, 2 * double(set_bits) / double(std::max<std::uint64_t>(rows, 1)));
    plan.estimated_bytes = std::uint64_t(64 * objects + double(plan.grid.cells()) * 4 + row_bytes * cells *
                                         double(rows) / double(std::max<std::size_t>(probed, 1)));
    return plan;
}

} // namespace antumbra
