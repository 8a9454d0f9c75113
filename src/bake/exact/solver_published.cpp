// The query in its published form (Nirenstein, Blake, Gain 2002, section 3): rays first; then every occluder in the hull of
// the pair is subtracted from a complex of polytopes with all their faces, in the order of the rays that it blocks, until
// nothing is left. With exact signs instead of floating point, and the correct quadric test.
#include "bake/exact/solver.hpp"

#include <algorithm>
#include <map>

namespace antumbra::exact {

namespace {

constexpr std::size_t kRaysLeft = 32; ///< polytopes of the complex into which a ray is cast at once

} // namespace

/// Section 3.1: clips a polygon to the hull of S and T, exactly. False if nothing of its inside is left. `left`: which of its
/// edges, from corner k to the next, reach into the hull.
template <bool F, int W>
bool Solver<F, W>::clip_to_hull(const std::vector<GridPoint>& corners, std::vector<bool>& left) const {
    struct Corner {
        Homogeneous at;
        int edge; ///< original edge that leaves it; -1: a side of the hull
    };
    std::vector<Corner> polygon, kept;
    for (std::size_t k = 0; k < corners.size(); ++k)
        polygon.push_back({{corners[k].x, corners[k].y, corners[k].z, 1}, static_cast<int>(k)});
    std::vector<Integer> value;
    for (const GridPlane& plane : around_) {
        std::size_t n = polygon.size();
        value.clear();
        bool inside = false, outside = false;
        for (const Corner& corner : polygon) {
            value.push_back(plane.at(corner.at));
            inside |= value.back().sign() < 0;
            outside |= value.back().sign() > 0;
        }
        if (!inside)
            return false;
        if (!outside)
            continue;
        kept.clear();
        for (std::size_t i = 0; i < n; ++i) {
            std::size_t j = (i + 1) % n;
            int at_i = value[i].sign(), at_j = value[j].sign();
            if (at_i <= 0) // from a corner in the plane with the next one outside, the polygon goes on along the plane
                kept.push_back({polygon[i].at, at_i == 0 && at_j > 0 ? -1 : polygon[i].edge});
            if (at_i * at_j >= 0)
                continue;
            Integer wi = abs(value[j]), wj = abs(value[i]);
            Homogeneous p;
            for (std::size_t k = 0; k < 4; ++k)
                p[k] = wi * polygon[i].at[k] + wj * polygon[j].at[k];
            make_primitive(p);
            kept.push_back({p, at_i < 0 ? -1 : polygon[i].edge});
        }
        if (kept.size() < 3)
            return false;
        polygon.swap(kept);
    }
    left.assign(corners.size(), false);
    for (const Corner& corner : polygon)
        if (corner.edge >= 0)
            left[static_cast<std::size_t>(corner.edge)] = true;
    return true;
}

template <bool F, int W>
std::vector<OccluderId> Solver<F, W>::blockers_of(const Candidate& line) {
    found_.clear();
    source_->near_segment(line.near_p, line.near_q, SIZE_MAX, found_);
    std::vector<OccluderId> blockers;
    for (OccluderId id : found_)
        if (blocks(prepare(id), line.line) != 0)
            blockers.push_back(id);
    return blockers;
}

/// The occluder that blocks most of the rays, then the one that blocks most of the rest, and so on.
template <bool F, int W>
std::vector<OccluderId> Solver<F, W>::greedy_order(const std::map<OccluderId, std::vector<std::uint32_t>>& rays_of,
                                                   std::size_t rays) const {
    std::vector<bool> blocked(rays, true);
    std::vector<OccluderId> order;
    while (rays > 0) {
        const std::pair<const OccluderId, std::vector<std::uint32_t>>* best = nullptr;
        std::ptrdiff_t most = 0;
        for (const auto& one : rays_of) {
            std::ptrdiff_t count = std::count_if(one.second.begin(), one.second.end(), [&](std::uint32_t ray) { return blocked[ray]; });
            if (count > most) {
                most = count;
                best = &one;
            }
        }
        order.push_back(best->first);
        for (std::uint32_t ray : best->second)
            if (blocked[ray]) {
                blocked[ray] = false;
                --rays;
            }
    }
    return order;
}

/// Section 3.3: the order of the rays that occluders block. A ray that nothing blocks decides, unless all unobstructed lines
/// are asked for.
template <bool F, int W>
std::vector<OccluderId> Solver<F, W>::order_by_rays(Answer& answer) {
    std::map<OccluderId, std::vector<std::uint32_t>> rays_of;
    std::uint32_t rays = 0;
    Candidate line;
    for (std::uint32_t r = 0; r < options_->rays; ++r) {
        if (!random_line(line))
            continue;
        std::vector<OccluderId> blockers = blockers_of(line);
        if (blockers.empty() && !options_->complete) {
            ++result_->counters.random_witness;
            accept(line);
            answer = Answer::visible;
            return {};
        }
        if (blockers.empty())
            continue;
        for (OccluderId id : blockers)
            rays_of[id].push_back(rays);
        ++rays;
    }
    return greedy_order(rays_of, rays);
}

/// The same for what the subtraction has left: a ray into each of some polytopes. One that nothing blocks decides.
template <bool F, int W>
std::vector<OccluderId> Solver<F, W>::order_by_rays_left(std::vector<Whole>& complex, Answer& answer) {
    std::map<OccluderId, std::vector<std::uint32_t>> rays_of;
    std::uint32_t rays = 0;
    Candidate line;
    for (std::size_t k = 0; k < complex.size() && k < kRaysLeft; ++k) {
        const Piece& shell = complex[complex.size() - 1 - k].shell;
        for (int attempt = 0; attempt <= 6; ++attempt) {
            if (attempt == 6 ? !exact_witness(shell, line) : !rounded_witness(shell, attempt, line))
                continue;
            ++result_->counters.later_rays;
            std::vector<OccluderId> blockers = blockers_of(line);
            if (blockers.empty()) {
                accept(line);
                answer = Answer::visible;
                return {};
            }
            if (attempt < 6 && !inside(shell, line.line))
                continue; // what blocks it may be subtracted already
            for (OccluderId id : blockers)
                rays_of[id].push_back(rays);
            ++rays;
            break;
        }
    }
    return greedy_order(rays_of, rays);
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
            cones.push_back({std::move(whole.lattice.vertices), std::move(whole.lattice.faces)});
        result_->counters.arithmetic.add(store_.counters);
        result_->unobstructed = std::make_shared<LineSpace>(std::move(store_), frame_.origin, std::move(cones));
        store_ = LineStore<F>();
        store_.reset(frame_.scale_bits);
    }
}

template <bool F, int W>
bool Solver<F, W>::over_budget() const {
    return result_->counters.pieces > options_->max_pieces ||
           (options_->cancel && options_->cancel->load(std::memory_order_relaxed));
}

/// Occluders that reach into the hull of the pair and have not been subtracted.
template <bool F, int W>
std::vector<OccluderId> Solver<F, W>::rest_of_hull() {
    std::vector<GridPlane> front = around_;
    for (GridPlane& plane : front) { // from the frame to the grid, and turned: the hull in front
        plane.n = -plane.n;
        plane.c = -plane.c;
        for (int k = 0; k < 3; ++k)
            plane.c += static_cast<Int128>(plane.n[k]) * frame_.origin[k];
    }
    std::vector<OccluderId> rest;
    source_->in_hull(front, rest);
    std::sort(rest.begin(), rest.end());
    rest.erase(std::remove_if(rest.begin(), rest.end(), [&](OccluderId id) { return blocker_index_.count(id) != 0; }), rest.end());
    return rest;
}

/// One occluder, from either side that it blocks from.
template <bool F, int W>
RunStatus Solver<F, W>::subtract_next(OccluderId id, std::vector<Whole>& complex) {
    QueryCounters& counters = result_->counters;
    Prepared occluder = prepare(id);
    if (occluder.empty)
        return RunStatus::done;
    std::size_t before = counters.splits;
    for (int crossing : {-1, 1}) {
        if (crossing == 1 && !occluder.both_sides)
            continue;
        if (subtract_everywhere(occluder, crossing, complex) == RunStatus::overflow)
            return RunStatus::overflow;
    }
    if (counters.splits != before || complex.empty()) {
        ++counters.subtractions;
        blocker_index(id);
    }
    counters.pieces += counters.splits - before;
    return RunStatus::done;
}

template <bool F, int W>
RunStatus Solver<F, W>::search_published(Answer& answer) {
    QueryCounters& counters = result_->counters;
    answer = Answer::undecided;
    std::vector<OccluderId> order = order_by_rays(answer);
    result_->effective = static_cast<std::uint32_t>(order.size());
    if (answer == Answer::visible)
        return RunStatus::done;
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
    // The occluders of the first rays, then those of rays into what is left, until nothing is or a ray gets through.
    while (!order.empty() && !complex.empty()) {
        for (std::size_t k = 0; k < order.size() && !complex.empty(); ++k) {
            if (subtract_next(order[k], complex) == RunStatus::overflow)
                return RunStatus::overflow;
            if (over_budget())
                return RunStatus::done; // undecided
        }
        if (options_->complete || complex.empty())
            break;
        order = order_by_rays_left(complex, answer);
        result_->effective += static_cast<std::uint32_t>(order.size());
        if (answer == Answer::visible)
            return RunStatus::done;
    }
    if (!complex.empty()) { // what is left of the hull's occluders, for the sake of all unobstructed lines
        for (OccluderId id : rest_of_hull()) {
            if (complex.empty())
                break;
            if (subtract_next(id, complex) == RunStatus::overflow)
                return RunStatus::overflow;
            if (over_budget())
                return RunStatus::done;
        }
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
    template std::vector<OccluderId> Solver<F, W>::order_by_rays_left(std::vector<Whole>&, Answer&);                 \
    template std::vector<OccluderId> Solver<F, W>::greedy_order(                                                     \
        const std::map<OccluderId, std::vector<std::uint32_t>>&, std::size_t) const;                                 \
    template std::vector<OccluderId> Solver<F, W>::blockers_of(const Candidate&);                                    \
    template std::vector<OccluderId> Solver<F, W>::rest_of_hull();                                                   \
    template RunStatus Solver<F, W>::subtract_next(OccluderId, std::vector<Whole>&);                                 \
    template bool Solver<F, W>::clip_to_hull(const std::vector<GridPoint>&, std::vector<bool>&) const;               \
    template bool Solver<F, W>::over_budget() const;                                                                 \
    template bool Solver<F, W>::keeps_lines(Whole&);                                                                 \
    template RunStatus Solver<F, W>::find_witness(const Whole&);                                                     \
    template void Solver<F, W>::keep_complex(std::vector<Whole>&);                                                   \
    template RunStatus Solver<F, W>::search_published(Answer&);
ANTUMBRA_INSTANTIATE(true, 2)
ANTUMBRA_INSTANTIATE(false, 2)
ANTUMBRA_INSTANTIATE(false, 16)
#undef ANTUMBRA_INSTANTIATE

} // namespace antumbra::exact
