#include "bake/exact/cell.hpp"

#include "bake/exact/frame.hpp"
#include "bake/exact/occluders_along.hpp"
#include "bake/keys.hpp"

#include <algorithm>
#include <queue>

namespace antumbra::exact {
namespace {

bool is_set(const std::vector<std::uint64_t>& bits, std::uint32_t k) { return bits[k / 64] >> (k % 64) & 1; }

double distance_squared(const GridBox& a, const GridBox& b) {
    double sum = 0;
    for (int k = 0; k < 3; ++k) {
        auto gap = static_cast<double>(std::max({std::int64_t(0), a.min[k] - b.max[k], b.min[k] - a.max[k]}));
        sum += gap * gap;
    }
    return sum;
}

/// Does `box` reach beyond the plane of this face of `cell`?
bool reaches_beyond(const GridBox& box, const GridBox& cell, int axis, int side) {
    return side ? box.max[axis] > cell.max[axis] : box.min[axis] < cell.min[axis];
}

bool is_flat_across(const GridBox& box, int axis) {
    int b = (axis + 1) % 3, c = (axis + 2) % 3;
    return box.min[b] == box.max[b] || box.min[c] == box.max[c];
}

/// Signs of the plane of a triangle over the corners of a box: is some corner in front, is some behind?
struct SidesOfBox {
    bool front = false, back = false;
    SidesOfBox(const std::array<GridPoint, 3>& triangle, const GridBox& box) {
        std::size_t triple[3];
        GridPlane plane = plane_of(triangle, triple);
        for (int i = 0; i < 8; ++i) {
            GridPoint p{i & 1 ? box.max.x : box.min.x, i & 2 ? box.max.y : box.min.y, i & 4 ? box.max.z : box.min.z};
            Int128 value = plane.at(p);
            front |= value > 0;
            back |= value < 0;
        }
    }
};

} // namespace

void CellCounters::add(const CellCounters& other) {
    box_queries += other.box_queries;
    boxes_hidden += other.boxes_hidden;
    triangle_queries += other.triangle_queries;
    triangles_hidden += other.triangles_hidden;
    pairs += other.pairs;
    undecided += other.undecided;
    extended += other.extended;
    by_touch += other.by_touch;
    query.add(other.query);
}

struct CellSolver::State {
    const SceneTree& tree;
    const Tracer& tracer;
    Arbiter arbiter;
    CellOptions options;
    OccludersAlong occluders;
    Query query;
    GridBox cell;
    std::vector<std::uint64_t>* visible = nullptr;
    CellCounters* counters = nullptr;
    std::vector<std::uint32_t> unseen;      // per node of several objects: how many are not seen
    std::vector<std::uint8_t> holds_seen;   // per such node: does it hold one that is
    std::vector<std::uint8_t> hidden_alone; // per triangle
    std::vector<std::uint32_t> root_of_object;
    std::vector<std::uint32_t> hits;

    State(const SceneTree& t, const Tracer& r, const CellOptions& o)
        : tree(t), tracer(r), arbiter(r), options(o), occluders(t) {
        root_of_object.assign(tree.scene().objects().size(), UINT32_MAX);
        for (std::uint32_t n = 0; n < tree.nodes().size(); ++n) {
            const SceneTree::Node& node = tree.nodes()[n];
            if (node.object != SceneTree::kManyObjects && root_of_object[node.object] == UINT32_MAX)
                root_of_object[node.object] = n; // parents come before their children
        }
    }

    bool seen(std::uint32_t object) const { return is_set(*visible, object); }
    void begin(const GridBox& box, std::vector<std::uint64_t>& bits, CellCounters& count);
    void see(std::uint32_t object);
    Answer ask(std::span<const GridPoint> s, std::span<const GridPoint> t, std::uint64_t key, Witness* witness);
    Answer ask_box(std::uint32_t node);
    Answer ask_triangle(std::uint32_t triangle, Witness* witness);
    void extend(const Witness& witness);
    void decide_triangle(std::uint32_t triangle);
};

void CellSolver::State::begin(const GridBox& box, std::vector<std::uint64_t>& bits, CellCounters& count) {
    cell = box;
    visible = &bits;
    counters = &count;
    occluders.forget_hidden();
    hidden_alone.assign(tree.corners_count(), 0);
    std::size_t n = tree.nodes().size();
    unseen.assign(n, 0);
    holds_seen.assign(n, 0);
    for (std::uint32_t o = 0; o < root_of_object.size(); ++o) {
        if (tree.scene().objects()[o].has(kAlwaysVisible))
            bits[o / 64] |= std::uint64_t(1) << (o % 64);
        std::uint32_t at = root_of_object[o];
        if (at == UINT32_MAX)
            continue;
        bool is_seen = is_set(bits, o);
        while (at != 0) {
            at = tree.parents()[at];
            unseen[at] += !is_seen;
            holds_seen[at] |= is_seen;
        }
    }
}

void CellSolver::State::see(std::uint32_t object) {
    if (seen(object))
        return;
    (*visible)[object / 64] |= std::uint64_t(1) << (object % 64);
    for (std::uint32_t at = root_of_object[object]; at != 0;) {
        at = tree.parents()[at];
        --unseen[at];
        holds_seen[at] = 1;
    }
}

Answer CellSolver::State::ask(std::span<const GridPoint> s, std::span<const GridPoint> t, std::uint64_t key,
                              Witness* witness) {
    QueryOptions q;
    q.rays = options.rays;
    q.max_pieces = options.max_pieces;
    q.filtered = options.filtered;
    q.patches = options.patches;
    if (!options.filtered)
        q.start = Start::prism_or_hull;
    q.seed = mix_bits(options.seed + mix_bits(key));
    QueryResult result = query.run(s, t, occluders, q);
    ++counters->pairs;
    counters->query.add(result.counters);
    if (result.answer == Answer::visible && witness)
        *witness = result.witness;
    return result.answer;
}

/// Does any line from the cell reach the box? Over all pairs of faces that look at each other.
Answer CellSolver::State::ask_box(std::uint32_t n) {
    const GridBox& box = tree.nodes()[n].box;
    ++counters->box_queries;
    Answer answer = Answer::hidden;
    for (int from = 0; from < 6; ++from) {
        if (!reaches_beyond(box, cell, from / 2, from % 2))
            continue;
        std::array<GridPoint, 4> s = face_of(cell, from / 2, from % 2);
        for (int to = 0; to < 6; ++to) {
            if (!reaches_beyond(cell, box, to / 2, to % 2) || is_flat_across(box, to / 2))
                continue;
            Witness witness;
            switch (ask(s, face_of(box, to / 2, to % 2), std::uint64_t(n) * 64 + static_cast<unsigned>(6 * from + to),
                        &witness)) {
            case Answer::visible:
                extend(witness);
                return Answer::visible;
            case Answer::undecided:
                answer = Answer::undecided;
                break;
            case Answer::hidden:
                break;
            }
        }
    }
    return answer;
}

Answer CellSolver::State::ask_triangle(std::uint32_t triangle, Witness* witness) {
    ++counters->triangle_queries;
    const std::array<GridPoint, 3>& corners = tree.corners(triangle);
    GridBox box;
    for (const GridPoint& p : corners)
        box.extend(p);
    SidesOfBox sides(corners, cell);
    Answer answer = Answer::hidden;
    for (int turned = 0; turned < 2; ++turned) {
        if (turned ? !(sides.back && tree.both_sides(triangle)) : !sides.front)
            continue;
        std::array<GridPoint, 3> t = corners;
        if (turned)
            std::swap(t[1], t[2]);
        for (int from = 0; from < 6; ++from) {
            if (!reaches_beyond(box, cell, from / 2, from % 2))
                continue;
            std::uint64_t key = (std::uint64_t(triangle) << 32 | 0x80000000u) + static_cast<unsigned>(2 * from + turned);
            Answer one = ask(face_of(cell, from / 2, from % 2), t, key, witness);
            if (one == Answer::visible)
                return one;
            if (one == Answer::undecided)
                answer = one;
        }
    }
    return answer;
}

/// Follows the line that reached a box: what it sees is visible. The arbiter has the last word.
void CellSolver::State::extend(const Witness& witness) {
    Vec3d p = witness.near_p, d = witness.near_q - witness.near_p;
    for (int k = 0; k < 3; ++k) // rounding may have moved it out of the cell
        if (!(p[k] >= static_cast<double>(cell.min[k]) && p[k] <= static_cast<double>(cell.max[k])))
            return;
    Vec3d eye = tree.to_local(p), toward = tree.to_local(witness.near_q);
    hits.clear();
    tracer.seen({eye, tree.to_local(d)}, hits);
    for (std::uint32_t t : hits) {
        std::uint32_t object = tree.scene().triangle_objects()[t];
        if (!seen(object) && arbiter.sees(eye, toward, t) == Verdict::clear) {
            ++counters->extended;
            see(object);
        }
    }
}

void CellSolver::State::decide_triangle(std::uint32_t triangle) {
    std::uint32_t object = tree.scene().triangle_objects()[triangle];
    if (seen(object))
        return;
    if (touches(cell, tree.corners(triangle))) {
        SidesOfBox sides(tree.corners(triangle), cell);
        if (sides.front || (sides.back && tree.both_sides(triangle))) {
            ++counters->by_touch;
            see(object);
        }
        return;
    }
    switch (ask_triangle(triangle, nullptr)) {
    case Answer::visible:
        see(object);
        break;
    case Answer::undecided:
        ++counters->undecided;
        see(object);
        break;
    case Answer::hidden:
        ++counters->triangles_hidden;
        hidden_alone[triangle] = 1;
        break;
    }
}

CellSolver::CellSolver(const SceneTree& tree, const Tracer& tracer, const CellOptions& options)
    : state_(std::make_unique<State>(tree, tracer, options)) {}
CellSolver::~CellSolver() = default;

bool CellSolver::solve(const GridBox& cell, std::vector<std::uint64_t>& visible, CellCounters& counters,
                       const std::function<bool()>& cancelled) {
    State& s = *state_;
    const SceneTree& tree = s.tree;
    s.begin(cell, visible, counters);
    using Entry = std::pair<double, std::uint32_t>; // nearest first, then by number
    std::priority_queue<Entry, std::vector<Entry>, std::greater<>> queue;
    queue.push({0, 0});
    while (!queue.empty()) {
        if (cancelled && cancelled())
            return false;
        std::uint32_t n = queue.top().second;
        queue.pop();
        const SceneTree::Node& node = tree.nodes()[n];
        bool many = node.object == SceneTree::kManyObjects;
        auto settled = [&] { return many ? s.unseen[n] == 0 : s.seen(node.object); };
        if (settled())
            continue;
        bool known_reached = (many && s.holds_seen[n]) || cell.touches(node.box);
        if (!known_reached && node.count > 1) {
            if (s.ask_box(n) == Answer::hidden) {
                ++counters.boxes_hidden;
                if (s.options.virtual_occluders)
                    s.occluders.mark_hidden(n);
                else
                    for (std::uint32_t i = node.first; i < node.first + node.count; ++i)
                        s.hidden_alone[tree.order()[i]] = 1;
                continue;
            }
            if (settled())
                continue;
        }
        if (node.children == 0) {
            for (std::uint32_t i = node.first; i < node.first + node.count; ++i)
                s.decide_triangle(tree.order()[i]);
            continue;
        }
        for (std::uint32_t c = node.children; c < node.children + 2; ++c)
            queue.push({distance_squared(tree.nodes()[c].box, cell), c});
    }
    return true;
}

Answer CellSolver::ask_triangle(const GridBox& cell, std::uint32_t triangle, CellCounters& counters,
                                Witness* witness) {
    state_->cell = cell;
    state_->counters = &counters;
    return state_->ask_triangle(triangle, witness);
}

std::vector<std::uint32_t> CellSolver::hidden_triangles() const {
    std::vector<std::uint32_t> triangles;
    const SceneTree& tree = state_->tree;
    for (std::uint32_t n = 0; n < tree.nodes().size(); ++n)
        if (state_->occluders.is_hidden(n))
            for (std::uint32_t i = 0; i < tree.nodes()[n].count; ++i)
                triangles.push_back(tree.order()[tree.nodes()[n].first + i]);
    for (std::uint32_t t = 0; t < state_->hidden_alone.size(); ++t)
        if (state_->hidden_alone[t])
            triangles.push_back(t);
    std::sort(triangles.begin(), triangles.end());
    triangles.erase(std::unique(triangles.begin(), triangles.end()), triangles.end());
    return triangles;
}

} // namespace antumbra::exact
