#include "bake/exact/exact_cells.hpp"

#include "bake/keys.hpp"

#include <bit>

namespace antumbra {
namespace {

std::uint64_t count_bits(const std::vector<std::uint64_t>& bits) {
    std::uint64_t count = 0;
    for (std::uint64_t word : bits)
        count += static_cast<std::uint64_t>(std::popcount(word));
    return count;
}

} // namespace

ExactCells::ExactCells(const SamplingScene& shared)
    : shared_(shared), tree_(exact::SceneTree::build(shared.scene())) {}

/// Fresh rays must not see anything else: each that provably does is a miss, and there are none.
void ExactCells::check_with_rays(const Box3d& cell, std::uint64_t key, RegionSample& sample) const {
    constexpr std::uint32_t kStream = 0x65786163; // apart from those of the sampler
    Random random(shared_.options().seed, key, kStream);
    Arbiter arbiter(shared_.tracer());
    std::vector<std::uint32_t> hits;
    for (std::uint32_t r = 0; r < shared_.options().holdout_rays; ++r) {
        Vec3d eye = uniform_point(cell, random), direction = uniform_direction(random);
        hits.clear();
        shared_.tracer().seen({eye, direction}, hits);
        ++sample.holdout_rays;
        for (std::uint32_t t : hits) {
            std::uint32_t object = shared_.scene().triangle_objects()[t];
            if (!(sample.visible[object / 64] >> (object % 64) & 1) &&
                arbiter.sees(eye, eye + direction, t) == Verdict::clear) {
                ++sample.holdout_misses;
                break;
            }
        }
    }
    sample.rays += sample.holdout_rays;
}

Status ExactCells::check(const Box3d& cell) const {
    const Scene& scene = shared_.scene();
    for (const Vec3d& corner : {scene.to_local(cell.min), scene.to_local(cell.max)})
        for (int k = 0; k < 3; ++k)
            if (!(std::abs(corner[k]) < 0x1p24 * scene.step()))
                return {ErrorCode::usage, "exact cells must lie within twice the scene's own size around it; "
                                          "choose --where closer to the scene"};
    return {};
}

ExactCell ExactCells::solve(const Box3d& cell) const {
    const Scene& scene = shared_.scene();
    Vec3d low = scene.to_local(cell.min), high = scene.to_local(cell.max);
    RegionSampler sampler(shared_, SamplingRegion::all_directions({low, high}), cell_key(cell));
    ExactCell result;
    bool solid = !sampler.has_viewpoint();
    if (!solid) {
        std::uint32_t rays = shared_.options().rays_per_cell;
        if (shared_.options().sampling == Sampling::guided)
            sampler.look_guided(rays);
        else
            sampler.look_around(rays);
    }
    result.sample = std::move(sampler).finish();
    if (solid)
        return result;
    exact::CellOptions options;
    options.seed = cell_key(cell) ^ shared_.options().seed;
    exact::CellSolver solver(tree_, shared_.tracer(), options);
    exact::CellCounters counters;
    std::uint64_t before = count_bits(result.sample.visible);
    solver.solve({tree_.to_grid(low), tree_.to_grid(high)}, result.sample.visible, counters);
    check_with_rays({low, high}, cell_key(cell), result.sample);
    result.work = {counters.box_queries, counters.triangle_queries, counters.pairs, counters.undecided,
                   count_bits(result.sample.visible) - before};
    return result;
}

void put(PayloadWriter& writer, const ExactCell& cell) {
    writer.put(cell.sample);
    for (std::uint64_t number : {cell.work.box_queries, cell.work.triangle_queries, cell.work.pairs,
                                 cell.work.undecided, cell.work.found_by_query})
        writer.put(number);
}

ExactCell get_exact_cell(PayloadReader& reader, std::size_t words) {
    ExactCell cell;
    cell.sample = reader.get_sample(words);
    for (std::uint64_t* number : {&cell.work.box_queries, &cell.work.triangle_queries, &cell.work.pairs,
                                  &cell.work.undecided, &cell.work.found_by_query})
        *number = reader.get();
    return cell;
}

} // namespace antumbra
