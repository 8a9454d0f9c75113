#include <antumbra/bake.hpp>

#include "bake/assemble.hpp"
#include "bake/check_options.hpp"
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

} // namespace

Status check_options(const BakeOptions& options) {
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

Result<BakeResult> bake(const Scene& scene, const BakeOptions& options, const Job& job) {
    Clock::time_point start = Clock::now();
    double cpu_start = process_cpu_seconds();
    if (Status status = check_options(options); !status)
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

} // namespace antumbra
