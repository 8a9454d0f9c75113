#include "bake/exact/cell.hpp"

#include "bake/exact/frame.hpp"
#include "bake/exact/occluders_along.hpp"
#include "bake/keys.hpp"

#include <algorithm>
#include <ctime>
#include <queue>
#include <tuple>

namespace antumbra::exact {
namespace {

constexpr std::uint32_t kRaysAtTriangle = 4, kRaysAfterWitness = 64;
constexpr std::uint32_t kSmallBox = 8; ///< boxes of so few triangles are opened unasked: asking for these costs less
constexpr std::uint32_t kObjectTriangles = 64; ///< what stands for an object of the paper's two levels

double thread_seconds() {
    timespec now{};
    ::clock_gettime(CLOCK_THREAD_CPUTIME_ID, &now);
    return static_cast<double>(now.tv_sec) + static_cast<double>(now.tv_nsec) * 1e-9;
}

GridBox box_of(std::span<const GridPoint> corners) {
    GridBox box;
    for (const GridPoint& p : corners)
        box.extend(p);
    return box;
}

double distance_squared(const GridBox& a, const GridBox& b) {
    double sum = 0;
    for (int k = 0; k < 3; ++k) {
        auto gap = static_cast<double>(std::max({std::int64_t(0), a.min[k] - b.max[k], b.min[k] - a.max[k]}));
        sum += gap * gap;
    }
    return sum;
}

double extent(std::span<const GridPoint> corners) {
    GridBox box = box_of(corners);
    return distance_squared({box.min, box.min}, {box.max, box.max});
}

/// Does `box` reach beyond the plane of this face of `cell`?
bool reaches_beyond(const GridBox& box, const GridBox& cell, int axis, int side) {
    return side ? box.max[axis] > cell.max[axis] : box.min[axis] < cell.min[axis];
}

bool is_flat_across(const GridBox& box, int axis) {
    int b = (axis + 1) % 3, c = (axis + 2) % 3;
    return box.min[b] == box.max[b] || box.min[c] == box.max[c];
}

/// value * a / b for b > 0, rounded away from zero.
std::int64_t scaled_outward(std::int64_t value, std::int64_t a, std::int64_t b) {
    Int128 product = static_cast<Int128>(value) * a;
    return static_cast<std::int64_t>(product >= 0 ? (product + b - 1) / b : -((-product + b - 1) / b));
}

/// Two rectangles across an axis along which two boxes are apart, `leave` in the plane of the face of `a` that looks at
/// `b`, and `arrive` in that of the face of `b` that looks at `a`, both with their fronts between: every line from a to b
/// crosses both.
struct Windows {
    int axis = -1; ///< -1: the boxes touch or overlap
    std::array<GridPoint, 4> leave, arrive;

    Windows(const GridBox& a, const GridBox& b) {
        std::int64_t gap = 0;
        int side = 0;
        for (int k = 0; k < 3; ++k)
            for (int up = 0; up < 2; ++up)
                if (std::int64_t here = up ? b.min[k] - a.max[k] : a.min[k] - b.max[k]; here > gap) {
                    gap = here;
                    axis = k;
                    side = up;
                }
        if (axis < 0)
            return;
        leave = face_of(widened(a, b, gap), axis, side);
        arrive = face_of(widened(b, a, gap), axis, 1 - side);
    }

  private:
    /// Across the axis, `from` grown to what lines to `to` can cross in the plane of the face of `from` towards it:
    /// p + (q - p) t for t at most depth / (depth + gap).
    GridBox widened(const GridBox& from, const GridBox& to, std::int64_t gap) const {
        GridBox out = from;
        std::int64_t depth = from.max[axis] - from.min[axis];
        for (int k = 0; k < 3; ++k) {
            if (k == axis)
                continue;
            if (to.max[k] > from.max[k])
                out.max[k] += scaled_outward(to.max[k] - from.max[k], depth, depth + gap);
            if (to.min[k] < from.min[k])
                out.min[k] += scaled_outward(to.min[k] - from.min[k], depth, depth + gap);
            if (out.min[k] == out.max[k])
                ++out.max[k]; // a rectangle has an area
        }
        return out;
    }
};

/// Signs of the plane of a polygon over the corners of a box: is some corner in front, is some behind?
struct SidesOfBox {
    bool front = false, back = false;
    SidesOfBox(std::span<const GridPoint> polygon, const GridBox& box) {
        std::size_t triple[3];
        GridPlane plane = plane_of(polygon, triple);
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
    boxes_by_ray += other.boxes_by_ray;
    triangle_queries += other.triangle_queries;
    triangles_hidden += other.triangles_hidden;
    pairs += other.pairs;
    windows += other.windows;
    windows_hidden += other.windows_hidden;
    pairs_handed_down += other.pairs_handed_down;
    reused += other.reused;
    boxes_given_up += other.boxes_given_up;
    undecided += other.undecided;
    unasked += other.unasked;
    extended += other.extended;
    by_touch += other.by_touch;
    effective += other.effective;
    with_effective += other.with_effective;
    most_effective = std::max(most_effective, other.most_effective);
    sampler.add(other.sampler);
    query.add(other.query);
}

struct CellSolver::State {
    const SceneTree& tree;
    const Tracer& tracer;
    Arbiter arbiter;
    CellOptions options;
    OccludersAlong occluders;
    Query query;
    SeenUnits seen;
    CellSampler sampler;
    GridBox cell;
    CellCounters* counters = nullptr;
    std::uint64_t work_before = 0; // of earlier cells that the counters hold
    std::uint32_t windows_asked = 0, windows_proved = 0, boxes_apart = 0; // of this cell
    const std::atomic<bool>* cancel = nullptr;
    std::vector<std::uint8_t> hidden_alone; // per triangle
    std::vector<std::uint8_t> asked_patch;  // per patch
    std::vector<std::uint32_t> hidden_triangles, hidden_nodes, asked_patches;
    std::vector<std::uint32_t> hits;
    /// Published form: all unobstructed lines from the cell to a box around what is asked for; null: not known.
    using Spaces = std::shared_ptr<std::vector<std::shared_ptr<LineSpace>>>;
    Spaces around;   // of the node at hand
    Spaces complete; // what its own query found

    State(const SceneTree& t, const Tracer& r, const CellOptions& o)
        : tree(t), tracer(r), arbiter(r), options(o), occluders(t, o.joined && o.form == ExactForm::fast), seen(t), sampler(t, r, seen),
          hidden_alone(t.corners_count(), 0), asked_patch(t.patches().count(), 0) {}

    static std::uint64_t work_of(const CellCounters& c) { return c.query.pieces + c.pairs; }
    /// What is left of the cell's budget. A pure function of the work done: never of time.
    std::uint64_t work_left() const {
        if (options.work == 0)
            return UINT64_MAX;
        std::uint64_t done = work_of(*counters) - work_before;
        return options.work - std::min(done, options.work);
    }
    bool spent() const { return work_left() == 0; }
    bool is_scarce() const { return work_left() < options.work / 4; }
    /// Where windows seldom prove anything, only some boxes are asked for through them, to see whether that has changed.
    bool windows_pay() {
        constexpr std::uint32_t kTrial = 32, kOneIn = 6, kRetry = 16;
        ++boxes_apart;
        return windows_asked < kTrial || windows_proved * kOneIn >= windows_asked || boxes_apart % kRetry == 0;
    }
    bool cancelled() const { return cancel && cancel->load(std::memory_order_relaxed); }
    void begin(const GridBox& box, std::vector<std::uint64_t>& bits, CellCounters& count);
    QueryResult ask(std::span<const GridPoint> s, int from, std::span<const GridPoint> t, std::uint64_t key, bool box);
    QueryResult ask(int from, std::span<const GridPoint> t, std::uint64_t key, bool box) {
        return ask(face_of(cell, from / 2, from % 2), from, t, key, box);
    }
    QueryResult ask_windows(const Windows& windows, std::uint64_t key);
    bool box_meets_spaces(const GridBox& box);
    bool meets_spaces(std::span<const GridPoint> polygon);
    Answer ask_box(std::uint32_t node);
    Answer ask_polygon(std::span<const GridPoint> corners, bool both_sides, std::uint64_t key, Witness* witness);
    Answer ask_triangle(std::uint32_t triangle, Witness* witness);
    bool hide_patch(std::uint32_t triangle);
    void extend(const Witness& witness);
    void decide_triangle(std::uint32_t triangle);
    void hide_node(std::uint32_t node);
    void hide_triangle(std::uint32_t triangle);
    void decide_leaf(std::uint32_t node);
    bool open(std::uint32_t node);
};

void CellSolver::State::begin(const GridBox& box, std::vector<std::uint64_t>& bits, CellCounters& count) {
    cell = box;
    counters = &count;
    work_before = work_of(count);
    windows_asked = windows_proved = boxes_apart = 0;
    occluders.forget_hidden();
    for (std::uint32_t t : hidden_triangles)
        hidden_alone[t] = 0;
    hidden_triangles.clear();
    for (std::uint32_t p : asked_patches)
        asked_patch[p] = 0;
    asked_patches.clear();
    hidden_nodes.clear();
    const Scene& scene = tree.scene();
    for (std::uint32_t o = 0; o < scene.objects().size(); ++o) {
        const Object& object = scene.objects()[o];
        if (!object.has(kAlwaysVisible))
            continue;
        std::uint32_t first = o, last = o;
        if (object.triangle_count > 0) { // units of an object follow each other
            std::tie(first, last) = tree.units().range_of(object);
        } else if (tree.units().count() != scene.objects().size()) {
            continue; // only where objects are the units does it have one
        }
        for (std::uint32_t u = first; u <= last; ++u)
            bits[u / 64] |= std::uint64_t(1) << (u % 64);
    }
    seen.begin(bits);
    sampler.begin(box, mix_bits(options.seed), count.sampler);
}

/// `from`: the face of the cell that s is; -1: none.
QueryResult CellSolver::State::ask(std::span<const GridPoint> s, int from, std::span<const GridPoint> t,
                                   std::uint64_t key, bool box) {
    QueryOptions q;
    q.rays = options.rays;
    q.max_pieces = !box ? options.max_pieces : from < 0 ? options.window_pieces : options.box_pieces;
    q.max_pieces = static_cast<std::uint32_t>(std::min<std::uint64_t>(q.max_pieces, work_left()));
    q.filtered = options.filtered;
    q.patches = options.patches;
    q.form = options.form;
    q.cancel = cancel;
    q.complete = box && options.form == ExactForm::published;
    if (!options.filtered)
        q.start = Start::prism_or_hull;
    q.seed = mix_bits(options.seed + mix_bits(key));
    double start = options.observer ? thread_seconds() : 0;
    occluders.start_from(options.virtual_occluders ? from : -1);
    occluders.look_from_end(extent(t) < extent(s));
    QueryResult result = query.run(s, t, occluders, q);
    ++counters->pairs;
    counters->query.add(result.counters);
    counters->effective += result.effective;
    counters->with_effective += result.effective > 0;
    counters->most_effective = std::max(counters->most_effective, result.effective);
    if (options.observer)
        options.observer({box, result.answer, result.effective, static_cast<std::uint32_t>(result.counters.pieces),
                          std::sqrt(distance_squared(cell, box_of(t))), thread_seconds() - start});
    return result;
}

/// One query instead of up to nine: if all lines between the two windows are blocked, then so are all from the cell to
/// the box. If not, nothing is proved: some lines between the windows do not come from the cell, or miss the box.
QueryResult CellSolver::State::ask_windows(const Windows& windows, std::uint64_t key) {
    ++counters->windows;
    QueryResult result = ask(windows.leave, -1, windows.arrive, key, true);
    counters->windows_hidden += result.answer == Answer::hidden;
    ++windows_asked;
    windows_proved += result.answer == Answer::hidden;
    return result;
}

/// Does any unobstructed line to the box around go on through this one? (Section 4.2; conservative.)
bool CellSolver::State::box_meets_spaces(const GridBox& box) {
    for (int to = 0; to < 6; ++to)
        if (reaches_beyond(cell, box, to / 2, to % 2) && !is_flat_across(box, to / 2) &&
            meets_spaces(face_of(box, to / 2, to % 2)))
            return true;
    return false;
}

bool CellSolver::State::meets_spaces(std::span<const GridPoint> polygon) {
    return std::any_of(around->begin(), around->end(), [&](const auto& space) { return space->may_cross(polygon); });
}

/// Does any line from the cell reach the box? Over all pairs of faces that look at each other.
Answer CellSolver::State::ask_box(std::uint32_t n) {
    const GridBox& box = tree.nodes()[n].box;
    std::uint32_t parent = tree.parents()[n];
    ++counters->box_queries;
    bool published = options.form == ExactForm::published;
    if (published && around && !box_meets_spaces(box)) {
        ++counters->reused;
        return Answer::hidden;
    }
    complete = published ? std::make_shared<std::vector<std::shared_ptr<LineSpace>>>() : nullptr;
    if (Windows windows(cell, box); options.windows && !published && windows.axis >= 0 && windows_pay()) {
        QueryResult result = ask_windows(windows, std::uint64_t(n) * 64 + 63);
        if (result.answer == Answer::hidden)
            return Answer::hidden;
        if (result.answer == Answer::visible && options.sample_between && sampler.try_line(result.witness.near_p, result.witness.near_q, n))
            return Answer::visible;
    }
    Answer answer = Answer::hidden;
    for (int from = 0; from < 6; ++from) {
        if (!reaches_beyond(box, cell, from / 2, from % 2))
            continue;
        for (int to = 0; to < 6; ++to) {
            if (!reaches_beyond(cell, box, to / 2, to % 2) || is_flat_across(box, to / 2))
                continue;
            if (spent())
                return Answer::undecided;
            bool same_plane = to % 2 ? box.max[to / 2] == tree.nodes()[parent].box.max[to / 2]
                                     : box.min[to / 2] == tree.nodes()[parent].box.min[to / 2];
            if (n != 0 && same_plane && occluders.is_pair_hidden(parent, from, to)) {
                ++counters->pairs_handed_down;
                occluders.mark_pair(n, from, to);
                continue;
            }
            QueryResult result = ask(from, face_of(box, to / 2, to % 2),
                                     std::uint64_t(n) * 64 + static_cast<unsigned>(6 * from + to), true);
            switch (result.answer) {
            case Answer::visible:
                extend(result.witness);
                if (!published)
                    return Answer::visible;
                if (answer == Answer::hidden)
                    answer = Answer::visible;
                if (result.unobstructed && complete)
                    complete->push_back(result.unobstructed);
                else
                    complete = nullptr;
                break;
            case Answer::undecided:
                answer = Answer::undecided;
                complete = nullptr;
                break;
            case Answer::hidden:
                if (options.virtual_occluders)
                    occluders.mark_pair(n, from, to);
                break;
            }
            if (answer == Answer::undecided && options.box_pieces < options.max_pieces)
                return answer; // it will be opened anyway
        }
    }
    return answer;
}

Answer CellSolver::State::ask_triangle(std::uint32_t triangle, Witness* witness) {
    return ask_polygon(tree.corners(triangle), tree.both_sides(triangle), std::uint64_t(triangle) << 32 | 0x80000000u, witness);
}

/// Neighbouring triangles that make a flat polygon are asked for at once, the first time that one of them comes up. True: they
/// are all hidden.
bool CellSolver::State::hide_patch(std::uint32_t triangle) {
    const ConvexPatches& patches = tree.patches();
    std::uint32_t patch = patches.of(triangle);
    if (!options.joined || around || patch == ConvexPatches::kNone || !patches.is_flat(patch) || asked_patch[patch])
        return false;
    asked_patch[patch] = 1;
    asked_patches.push_back(patch);
    for (std::uint32_t t : patches.members(patch))
        if (hidden_alone[t] || seen.seen(tree.units().of[t]) || touches(cell, tree.corners(t)))
            return false;
    Witness witness;
    switch (ask_polygon(patches.rim(patch), patches.both_sides(patch), std::uint64_t(triangle) << 32 | 0x90000000u, &witness)) {
    case Answer::visible:
        extend(witness);
        return false;
    case Answer::undecided:
        return false;
    case Answer::hidden:
        for (std::uint32_t t : patches.members(patch))
            hide_triangle(t);
        return true;
    }
    return false;
}

/// Is a polygon of the scene visible?
Answer CellSolver::State::ask_polygon(std::span<const GridPoint> corners, bool both_sides, std::uint64_t key, Witness* witness) {
    ++counters->triangle_queries;
    GridBox box = box_of(corners);
    SidesOfBox sides(corners, cell);
    Answer answer = Answer::hidden;
    for (int turned = 0; turned < 2; ++turned) {
        if (turned ? !(sides.back && both_sides) : !sides.front)
            continue;
        std::vector<GridPoint> t(corners.begin(), corners.end());
        if (turned)
            std::reverse(t.begin(), t.end());
        if (around && !meets_spaces(t)) {
            ++counters->reused;
            continue;
        }
        for (int from = 0; from < 6; ++from) {
            if (!reaches_beyond(box, cell, from / 2, from % 2))
                continue;
            if (spent())
                return Answer::undecided;
            QueryResult result = ask(from, t, key + static_cast<unsigned>(2 * from + turned), false);
            if (result.answer == Answer::visible) {
                if (witness)
                    *witness = result.witness;
                return result.answer;
            }
            if (result.answer == Answer::undecided)
                answer = result.answer;
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
    if (options.sample_between)
        sampler.mark_line(p, witness.near_q);
    Vec3d eye = tree.to_local(p), toward = tree.to_local(witness.near_q);
    hits.clear();
    tracer.seen({eye, tree.to_local(d)}, hits);
    for (std::uint32_t t : hits) {
        std::uint32_t unit = tree.units().of[t];
        if (seen.seen(unit) || arbiter.sees(eye, toward, t) != Verdict::clear)
            continue;
        ++counters->extended;
        seen.see(unit);
        if (options.sample_between) {
            sampler.mutate(witness.near_p, witness.near_q, t);
            sampler.follow(kRaysAfterWitness);
        }
    }
}

void CellSolver::State::hide_triangle(std::uint32_t triangle) {
    ++counters->triangles_hidden;
    hidden_alone[triangle] = 1;
    hidden_triangles.push_back(triangle);
}

void CellSolver::State::hide_node(std::uint32_t n) {
    const SceneTree::Node& node = tree.nodes()[n];
    hidden_nodes.push_back(n);
    if (options.virtual_occluders) {
        occluders.mark_hidden(n);
        return;
    }
    for (std::uint32_t i = node.first; i < node.first + node.count; ++i) {
        hidden_alone[tree.order()[i]] = 1;
        hidden_triangles.push_back(tree.order()[i]);
    }
}

void CellSolver::State::decide_triangle(std::uint32_t triangle) {
    std::uint32_t unit = tree.units().of[triangle];
    if (seen.seen(unit))
        return;
    if (touches(cell, tree.corners(triangle))) {
        SidesOfBox sides(tree.corners(triangle), cell);
        if (sides.front || (sides.back && tree.both_sides(triangle))) {
            ++counters->by_touch;
            seen.see(unit);
        }
        return;
    }
    if (SidesOfBox sides(tree.corners(triangle), cell); !sides.front && !(sides.back && tree.both_sides(triangle))) {
        hide_triangle(triangle); // turned away from the whole cell
        return;
    }
    if (options.sample_between && sampler.aim_at_triangle(triangle, kRaysAtTriangle))
        return;
    if (hide_patch(triangle) || seen.seen(unit))
        return;
    Witness witness;
    switch (ask_triangle(triangle, &witness)) {
    case Answer::visible:
        seen.see(unit);
        if (options.sample_between) {
            sampler.mutate(witness.near_p, witness.near_q, triangle);
            sampler.follow(kRaysAfterWitness);
        }
        break;
    case Answer::undecided:
        if (cancelled())
            break;
        ++counters->undecided;
        counters->unasked += spent();
        seen.see(unit);
        break;
    case Answer::hidden:
        hide_triangle(triangle);
        break;
    }
}

void CellSolver::State::decide_leaf(std::uint32_t n) {
    const SceneTree::Node& node = tree.nodes()[n];
    for (std::uint32_t i = node.first; i < node.first + node.count && !cancelled(); ++i)
        if (!hidden_alone[tree.order()[i]])
            decide_triangle(tree.order()[i]);
}

/// Is there more to do below this node? Asks for its box unless it is known to be reached.
bool CellSolver::State::open(std::uint32_t n) {
    const SceneTree::Node& node = tree.nodes()[n];
    if (occluders.is_hidden(n) || seen.all_seen(n))
        return false;
    if (seen.holds_seen(n) || cell.touches(node.box) || (node.count <= kSmallBox && !is_scarce()) || spent())
        return true;
    // In the published form small boxes are asked for even where a ray came in, for the sake of their line spaces.
    bool complete_space = options.form == ExactForm::published && node.count <= kObjectTriangles;
    if (options.sample_between && !complete_space && (sampler.reached(n) || sampler.aim_at_box(n, options.rays_at_box))) {
        ++counters->boxes_by_ray;
        return !seen.all_seen(n);
    }
    Answer answer = ask_box(n);
    if (answer == Answer::hidden) {
        ++counters->boxes_hidden;
        hide_node(n);
        return false;
    }
    counters->boxes_given_up += answer == Answer::undecided;
    return !seen.all_seen(n);
}

CellSolver::CellSolver(const SceneTree& tree, const Tracer& tracer, const CellOptions& options)
    : state_(std::make_unique<State>(tree, tracer, options)) {}
CellSolver::~CellSolver() = default;

bool CellSolver::solve(const GridBox& cell, std::vector<std::uint64_t>& visible, CellCounters& counters,
                       const HiddenParts& hidden, const std::atomic<bool>* cancel) {
    State& s = *state_;
    const SceneTree& tree = s.tree;
    s.cancel = cancel;
    s.begin(cell, visible, counters);
    for (std::uint32_t n : hidden.nodes)
        s.hide_node(n);
    for (std::uint32_t t : hidden.triangles)
        s.hide_triangle(t);
    counters.triangles_hidden -= hidden.triangles.size(); // nobody asked
    s.sampler.look_around(s.options.look_around);
    s.sampler.explore(s.options.follow);
    struct Entry {
        double distance;
        std::uint32_t node;
        State::Spaces spaces; // around it
        bool operator<(const Entry& o) const { // nearest first, then by number
            return distance != o.distance ? distance > o.distance : node > o.node;
        }
    };
    std::priority_queue<Entry> queue;
    std::vector<Entry> put_off; // leaves that came up when the budget was scarce
    queue.push({0, 0, nullptr});
    while (!queue.empty()) {
        if (s.cancelled())
            return false;
        std::uint32_t n = queue.top().node;
        s.around = queue.top().spaces;
        s.complete = nullptr;
        queue.pop();
        if (!s.open(n))
            continue;
        State::Spaces spaces = s.complete ? s.complete : s.around;
        const SceneTree::Node& node = tree.nodes()[n];
        if (node.children == 0) {
            s.around = spaces;
            if (s.is_scarce())
                put_off.push_back({0, n, spaces});
            else
                s.decide_leaf(n);
            continue;
        }
        for (std::uint32_t c = node.children; c < node.children + 2; ++c)
            queue.push({distance_squared(tree.nodes()[c].box, cell), c, spaces});
    }
    for (const Entry& leaf : put_off) {
        s.around = leaf.spaces;
        s.decide_leaf(leaf.node);
    }
    s.around = s.complete = nullptr;
    return !s.cancelled();
}

Answer CellSolver::ask_triangle(const GridBox& cell, std::uint32_t triangle, CellCounters& counters,
                                Witness* witness) {
    state_->cell = cell;
    state_->counters = &counters;
    state_->cancel = nullptr;
    state_->around = nullptr;
    return state_->ask_triangle(triangle, witness);
}

HiddenParts CellSolver::hidden_parts() const {
    HiddenParts parts{state_->hidden_nodes, state_->hidden_triangles};
    for (auto* list : {&parts.nodes, &parts.triangles}) {
        std::sort(list->begin(), list->end());
        list->erase(std::unique(list->begin(), list->end()), list->end());
    }
    return parts;
}

std::vector<std::uint32_t> CellSolver::hidden_triangles() const {
    const SceneTree& tree = state_->tree;
    std::vector<std::uint32_t> triangles = state_->hidden_triangles;
    for (std::uint32_t n : state_->hidden_nodes)
        for (std::uint32_t i = 0; i < tree.nodes()[n].count; ++i)
            triangles.push_back(tree.order()[tree.nodes()[n].first + i]);
    std::sort(triangles.begin(), triangles.end());
    triangles.erase(std::unique(triangles.begin(), triangles.end()), triangles.end());
    return triangles;
}

} // namespace antumbra::exact
