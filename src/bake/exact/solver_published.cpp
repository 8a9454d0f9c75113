// The query in its published form (Nirenstein, Blake, Gain 2002, section 3): rays first; then every occluder in the hull of
// the pair is subtracted from a complex of polytopes with all their faces, in the order of the rays that it blocks, until
// nothing is left. With exact signs instead of floating point, and the correct quadric test.
#include "bake/exact/solver.hpp"

#include <algorithm>
#include <map>

namespace antumbra::exact {

/// Section 3.3: the occluder that blocks most of the rays, then the one that blocks most of the rest, and so on. A ray that
/// nothing blocks decides, unless all unobstructed lines are asked for.
template <bool F, int W>
std::vector<OccluderId> Solver<F, W>::order_by_rays(Answer& answer) {
    std::map<OccluderId, std::vector<std::uint32_t>> rays_of;
    std::vector<bool> blocked;
    Candidate line;
    for (std::uint32_t r = 0; r < options_->rays; ++r) {
        if (!random_line(line))
            continue;
        auto ray = static_cast<std::uint32_t>(blocked.size());
        found_.clear();
        source_->near_segment(line.near_p, line.near_q, SIZE_MAX, found_);
        std::vector<OccluderId> blockers;
        for (OccluderId id : found_)
            if (blocks(prepare(id), line.line) != 0)
                blockers.push_back(id);
        if (blockers.empty()) {
            if (!options_->complete) {
                ++result_->counters.random_witness;
                accept(line);
                answer = Answer::visible;
                return {};
            }
            continue;
        }
        blocked.push_back(true);
        for (OccluderId id : blockers)
            rays_of[id].push_back(ray);
    }
    std::vector<OccluderId> order;
    std::size_t open = blocked.size();
    while (open > 0) {
        OccluderId best = 0;
        std::size_t most = 0;
        for (const auto& [id, rays] : rays_of) {
            auto count = static_cast<std::size_t>(
                std::count_if(rays.begin(), rays.end(), [&](std::uint32_t ray) { return blocked[ray]; }));
            if (count > most) {
                most = count;
                best = id;
            }
        }
        order.push_back(best);
        for (std::uint32_t ray : rays_of[best])
            if (blocked[ray]) {
                blocked[ray] = false;
                --open;
            }
    }
    return order;
}

template <bool F, int W>
bool Solver<F, W>::keeps_lines(Whole& whole) {
    whole.shell.vertices = whole.lattice.vertices;
    return keeps_lines(whole.shell);
}

/// Section 3.2.1: each polytope of the complex that crosses the occluder's polyhedron is split by its hyperplanes, what is
/// inside all of them is removed, and so is what holds no real line.
template <bool F, int W>
RunStatus Solver<F, W>::subtract_everywhere(const Prepared& occluder, int crossing, std::vector<Whole>& complex) {
    QueryCounters& counters = result_->counters;
    std::vector<Whole> next;
    next.reserve(complex.size());
    for (Whole& whole : complex) {
        // Wholly outside one half-space, it does not meet the polyhedron. The sphere tells most of the time.
        bool misses = false;
        std::vector<int> crossed;
        for (std::size_t e = 0; e < occluder.edges.size() && !misses; ++e) {
            const HalfSpace& edge = occluder.edges[e];
            int sign = edge.sign * crossing;
            ++counters.sphere_tests;
            int side = side_of_sphere(store_, whole.lattice, edge.hyperplane) * sign;
            if (side != 0) {
                ++counters.sphere_rejected;
                misses = side < 0;
                continue;
            }
            ++counters.crossing_tests;
            Crossing c = classify(store_, whole.lattice, edge.hyperplane, sign);
            misses = !c.positive;
            if (c.positive && c.negative)
                crossed.push_back(static_cast<int>(e));
        }
        if (misses) {
            next.push_back(std::move(whole));
            continue;
        }
        bool left = true; // something may still be inside
        for (int e : crossed) {
            const HalfSpace& edge = occluder.edges[static_cast<std::size_t>(e)];
            int sign = edge.sign * crossing;
            Crossing c = classify(store_, whole.lattice, edge.hyperplane, sign);
            if (!c.negative)
                continue;
            if (!c.positive) { // what is inside the other edges lies outside this one
                next.push_back(std::move(whole));
                left = false;
                break;
            }
            ++counters.splits;
            Whole in, out;
            in.shell.codes = out.shell.codes = whole.shell.codes;
            in.shell.codes.push_back(facet_code(edge.hyperplane, sign));
            out.shell.codes.push_back(facet_code(edge.hyperplane, -sign));
            split(store_, whole.lattice, edge.hyperplane, c, in.lattice, out.lattice);
            if (is_broken(in.lattice) || is_broken(out.lattice)) {
                ++counters.broken;
                return RunStatus::overflow;
            }
            counters.faces += in.lattice.count() + out.lattice.count();
            counters.most_vertices = std::max(counters.most_vertices, static_cast<std::uint32_t>(in.lattice.vertices.size()));
            if (keeps_lines(out)) {
                set_sphere(store_, chart_, out.lattice);
                next.push_back(std::move(out));
            }
            left = keeps_lines(in);
            if (!left)
                break;
            set_sphere(store_, chart_, in.lattice);
            whole = std::move(in);
        }
        (void)left; // inside all half-spaces: blocked
    }
    complex.swap(next);
    return RunStatus::done;
}

template <bool F, int W>
RunStatus Solver<F, W>::find_witness(const Whole& whole) {
    Candidate line;
    for (int attempt = 0; attempt <= 6; ++attempt) {
        if (attempt == 6 ? !exact_witness(whole.shell, line) : !rounded_witness(whole.shell, attempt, line))
            continue;
        int crossing = 0;
        if (find_blocker(line, nullptr, crossing) == nullptr) {
            accept(line);
            return RunStatus::done;
        }
    }
    ++result_->counters.broken; // a line inside a piece that is left must be unblocked
    return RunStatus::overflow;
}

template <bool F, int W>
void Solver<F, W>::keep_complex(std::vector<Whole>& complex) {
    if constexpr (F) {
        std::vector<LineSpace::Cone> cones;
        for (Whole& whole : complex)
            cones.push_back({std::move(whole.lattice.vertices)});
        result_->counters.arithmetic.add(store_.counters);
        result_->unobstructed = std::make_shared<LineSpace>(std::move(store_), frame_.origin, std::move(cones));
        store_ = LineStore<F>();
        store_.reset(frame_.scale_bits);
    }
}

template <bool F, int W>
RunStatus Solver<F, W>::search_published(Answer& answer) {
    QueryCounters& counters = result_->counters;
    answer = Answer::undecided;
    std::vector<OccluderId> order = order_by_rays(answer);
    result_->effective = static_cast<std::uint32_t>(order.size());
    if (answer == Answer::visible)
        return RunStatus::done;
    // The rest of what reaches into the hull of the pair follows.
    std::vector<GridPlane> around = frame_.planes_around();
    for (GridPlane& plane : around) { // from the frame to the grid, and turned: the hull in front
        plane.n = -plane.n;
        plane.c = -plane.c;
        for (int k = 0; k < 3; ++k)
            plane.c += static_cast<Int128>(plane.n[k]) * frame_.origin[k];
    }
    std::vector<OccluderId> rest;
    source_->in_hull(around, rest);
    std::sort(rest.begin(), rest.end());
    std::vector<OccluderId> chosen = order;
    std::sort(chosen.begin(), chosen.end());
    std::set_difference(rest.begin(), rest.end(), chosen.begin(), chosen.end(), std::back_inserter(order));

    std::vector<Whole> complex(1);
    Whole& first = complex.front();
    StartResult start = published_start(store_, frame_, first.shell);
    if (start != StartResult::ready)
        return RunStatus::overflow;
    first.lattice = enumerate_faces(first.shell);
    if (is_broken(first.lattice)) {
        ++counters.broken;
        return RunStatus::overflow;
    }
    counters.faces += first.lattice.count();
    Vec3d n[2];
    for (int k = 0; k < 2; ++k) {
        const Vec3<std::int64_t>& normal = (k == 0 ? frame_.s : frame_.t).plane.n;
        n[k] = {static_cast<double>(normal.x), static_cast<double>(normal.y), static_cast<double>(normal.z)};
        n[k] = n[k] / length(n[k]);
    }
    chart_ = {n[0].x - n[1].x, n[0].y - n[1].y, n[0].z - n[1].z, 0, 0, 0};
    set_sphere(store_, chart_, first.lattice);
    if (!keeps_lines(first))
        complex.clear();
    for (std::size_t k = 0; k < order.size() && !complex.empty(); ++k) {
        Prepared occluder = prepare(order[k]);
        if (occluder.empty)
            continue;
        std::size_t before = counters.splits;
        for (int crossing : {-1, 1}) {
            if (crossing == 1 && !occluder.both_sides)
                continue;
            if (subtract_everywhere(occluder, crossing, complex) == RunStatus::overflow)
                return RunStatus::overflow;
        }
        if (counters.splits != before || complex.empty()) {
            ++counters.subtractions;
            blocker_index(order[k]);
        }
        counters.pieces += counters.splits - before;
        if (counters.pieces > options_->max_pieces ||
            (options_->cancel && options_->cancel->load(std::memory_order_relaxed)))
            return RunStatus::done; // undecided
    }
    if (complex.empty()) {
        answer = Answer::hidden;
        return RunStatus::done;
    }
    if (find_witness(complex.front()) == RunStatus::overflow)
        return RunStatus::overflow;
    answer = Answer::visible;
    if (options_->complete)
        keep_complex(complex);
    return RunStatus::done;
}

// The class is instantiated in solver.cpp, which does not see these members.
#define ANTUMBRA_INSTANTIATE(F, W)                                                                                   \
    template std::vector<OccluderId> Solver<F, W>::order_by_rays(Answer&);                                           \
    template RunStatus Solver<F, W>::subtract_everywhere(const Prepared&, int, std::vector<Whole>&);                 \
    template bool Solver<F, W>::keeps_lines(Whole&);                                                                 \
    template RunStatus Solver<F, W>::find_witness(const Whole&);                                                     \
    template void Solver<F, W>::keep_complex(std::vector<Whole>&);                                                   \
    template RunStatus Solver<F, W>::search_published(Answer&);
ANTUMBRA_INSTANTIATE(true, 2)
ANTUMBRA_INSTANTIATE(false, 2)
ANTUMBRA_INSTANTIATE(false, 16)
#undef ANTUMBRA_INSTANTIATE

} // namespace antumbra::exact
