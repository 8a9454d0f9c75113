#include "bake/exact/exact_cells.hpp"

#include "bake/keys.hpp"

#include <bit>

namespace antumbra {
namespace {

/// Of the published form: rays that choose the occluders, and pieces after which a box is opened without its line space.
constexpr std::uint32_t kPublishedRays = 200, kPublishedBoxPieces = 60;

std::uint64_t count_bits(const std::vector<std::uint64_t>& bits) {
    std::uint64_t count = 0;
    for (std::uint64_t word : bits)
        count += static_cast<std::uint64_t>(std::popcount(word));
    return count;
}

ExactStatistics work_of(const exact::CellCounters& counters) {
    return {counters.box_queries, counters.triangle_queries, counters.pairs,          counters.undecided, 0,
            counters.effective,   counters.with_effective,   counters.most_effective};
}

} // namespace

ExactCells::ExactCells(const SamplingScene& shared)
    : shared_(shared),
      tree_(exact::SceneTree::build(shared.scene(), exact::Units::make(shared.scene(), shared.options().exact))) {}

std::size_t ExactCells::bits() const {
    return shared_.scene().objects().size() + (lists_clusters() ? tree_.units().count() : 0);
}

std::vector<std::uint32_t> ExactCells::cluster_first() const {
    return lists_clusters() ? tree_.units().first : std::vector<std::uint32_t>();
}

std::vector<PvsTriangles> ExactCells::triangles() const {
    const Scene& scene = shared_.scene();
    std::vector<PvsTriangles> list;
    for (const Object& object : scene.objects()) {
        if (!lists_clusters())
            break;
        PvsTriangles triangles;
        triangles.in_file = object.source_triangles;
        triangles.cluster.assign(object.source_triangles, PvsTriangles::kNone);
        for (std::uint32_t t = object.first_triangle; t < object.first_triangle + object.triangle_count; ++t) {
            std::uint32_t at = scene.triangle_sources()[t]; // ascending, without gaps behind those of the file
            if (at >= triangles.cluster.size())
                triangles.cluster.resize(std::size_t(at) + 1);
            triangles.cluster[at] = tree_.units().of[t];
        }
        list.push_back(std::move(triangles));
    }
    return list;
}

/// From units to what a row holds: objects, then clusters if these are what is asked for.
void ExactCells::set_rows(const std::vector<std::uint64_t>& units, RegionSample& sample) const {
    if (!lists_clusters()) {
        sample.visible = units;
        return;
    }
    sample.visible.assign(words(), 0);
    auto set = [&](std::size_t bit) { sample.visible[bit / 64] |= std::uint64_t(1) << (bit % 64); };
    std::size_t objects = shared_.scene().objects().size();
    for (std::size_t o = 0; o < objects; ++o)
        if (shared_.scene().objects()[o].has(kAlwaysVisible))
            set(o);
    for (std::uint32_t u = 0; u < tree_.units().count(); ++u)
        if (units[u / 64] >> (u % 64) & 1) {
            set(objects + u);
            set(shared_.scene().triangle_objects()[tree_.units().triangles_of(u)[0]]);
        }
}

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
            std::size_t object = shared_.scene().triangle_objects()[t];
            if (lists_clusters())
                object = shared_.scene().objects().size() + tree_.units().of[t];
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

exact::CellOptions ExactCells::cell_options(const Box3d& cell) const {
    const BakeOptions& bake = shared_.options();
    exact::CellOptions options;
    options.seed = cell_key(cell) ^ bake.seed;
    options.max_pieces = bake.exact.max_pieces;
    options.work = bake.exact.cell_work;
    options.form = bake.exact.form;
    options.look_around = bake.rays_per_cell;
    options.follow = 4 * bake.rays_per_cell;
    options.sample_between = true;
    if (options.form == ExactForm::published) {
        options.rays = kPublishedRays;
        options.box_pieces = kPublishedBoxPieces;
    }
    return options;
}

exact::GridBox ExactCells::to_grid(const Box3d& cell) const {
    const Scene& scene = shared_.scene();
    return {tree_.to_grid(scene.to_local(cell.min)), tree_.to_grid(scene.to_local(cell.max))};
}

ExactCell ExactCells::solve(const Box3d& cell, const std::atomic<bool>* cancel, const exact::HiddenParts& hidden,
                            exact::HiddenParts* proved) const {
    const Scene& scene = shared_.scene();
    Box3d local{scene.to_local(cell.min), scene.to_local(cell.max)};
    RegionSampler probe(shared_, SamplingRegion::all_directions(local), cell_key(cell));
    ExactCell result;
    bool solid = !probe.has_viewpoint();
    result.sample = std::move(probe).finish();
    if (solid)
        return result;
    exact::CellSolver solver(tree_, shared_.tracer(), cell_options(cell));
    exact::CellCounters counters;
    std::vector<std::uint64_t> units((tree_.units().count() + 63) / 64, 0);
    result.finished = solver.solve(to_grid(cell), units, counters, hidden, cancel);
    if (!result.finished)
        return result;
    if (proved)
        *proved = solver.hidden_parts();
    set_rows(units, result.sample);
    const exact::SamplerCounters& sampled = counters.sampler;
    result.sample.rays += sampled.rays;
    result.sample.confirmed = static_cast<std::uint32_t>(sampled.uniform + sampled.guided + sampled.mutated + sampled.aimed);
    std::uint64_t before = sampled.uniform + sampled.guided;
    std::uint64_t found = count_bits(units);
    check_with_rays(local, cell_key(cell), result.sample);
    result.work = work_of(counters);
    result.work.found_by_query = found - std::min(found, before);
    return result;
}

bool ExactCells::hide(const Box3d& box, const exact::HiddenParts& hidden, exact::HiddenParts& proved,
                      ExactStatistics& work, const std::atomic<bool>* cancel) const {
    exact::CellSolver solver(tree_, shared_.tracer(), cell_options(box));
    exact::CellCounters counters;
    std::vector<std::uint64_t> units((tree_.units().count() + 63) / 64, 0);
    if (!solver.solve(to_grid(box), units, counters, hidden, cancel))
        return false;
    proved = solver.hidden_parts();
    ExactStatistics done = work_of(counters);
    done.undecided = 0; // nothing is listed of the box itself
    add(work, done);
    return true;
}

void add(ExactStatistics& total, const ExactStatistics& more) {
    total.box_queries += more.box_queries;
    total.triangle_queries += more.triangle_queries;
    total.pairs += more.pairs;
    total.undecided += more.undecided;
    total.found_by_query += more.found_by_query;
    total.effective_occluders += more.effective_occluders;
    total.queries_with_occluders += more.queries_with_occluders;
    total.most_effective = std::max(total.most_effective, more.most_effective);
}

namespace {

template <class Statistics, class Visit>
void for_each_number(Statistics& work, const Visit& visit) {
    for (auto* number : {&work.box_queries, &work.triangle_queries, &work.pairs, &work.undecided, &work.found_by_query,
                         &work.effective_occluders, &work.queries_with_occluders, &work.most_effective})
        visit(*number);
}

} // namespace

void put(PayloadWriter& writer, const ExactStatistics& work) {
    for_each_number(work, [&](std::uint64_t number) { writer.put(number); });
}

ExactStatistics get_exact_statistics(PayloadReader& reader) {
    ExactStatistics work;
    for_each_number(work, [&](std::uint64_t& number) { number = reader.get(); });
    return work;
}

void put(PayloadWriter& writer, const ExactCell& cell) {
    writer.put(cell.sample);
    put(writer, cell.work);
}

ExactCell get_exact_cell(PayloadReader& reader, std::size_t words) {
    ExactCell cell;
    cell.sample = reader.get_sample(words);
    cell.work = get_exact_statistics(reader);
    return cell;
}

} // namespace antumbra
