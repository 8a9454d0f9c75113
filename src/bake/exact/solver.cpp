#include "bake/exact/solver.hpp"

#include "bake/exact/patch.hpp"

#include <algorithm>
#include <cmath>

namespace antumbra::exact {
namespace {

constexpr int kRoundingBits = 26;      ///< ends of a rounded witness: multiples of 2^-26 along two edges
constexpr std::size_t kFirstLook = 24; ///< candidates asked for before all are
constexpr int kRoundedAttempts = 6;

Vec3d to_vector(const GridPoint& p) {
    return {static_cast<double>(p.x), static_cast<double>(p.y), static_cast<double>(p.z)};
}

Vec3d to_vector(const Homogeneous& p) {
    int e[4];
    double c[4];
    for (std::size_t k = 0; k < 4; ++k)
        c[k] = to_double(p[k], e[k]);
    Vec3d out;
    for (int k = 0; k < 3; ++k) {
        auto i = static_cast<std::size_t>(k);
        out[k] = c[i] == 0 ? 0 : std::ldexp(c[i] / c[3], e[i] - e[3]);
    }
    return out;
}

Homogeneous shifted(const Vec3<std::int64_t>& p, int shift) {
    return {p.x, p.y, p.z, Integer(1) << static_cast<unsigned>(shift)};
}

/// Moves by a grid vector.
Homogeneous moved(const Homogeneous& p, const GridPoint& by) {
    return {p[0] + p[3] * by.x, p[1] + p[3] * by.y, p[2] + p[3] * by.z, p[3]};
}

/// Weight of an exponential distribution: sums of such weights are uniform over a simplex. Any positive numbers
/// would do; -log is avoided because no libm function may decide a result.
double random_weight(Random& random) {
    double u = random.uniform();
    return (u + 0x1p-20) / (1 - u + 0x1p-20);
}

/// The point where the line x (perhaps a little off the quadric) meets a plane.
Homogeneous meet(const GridPlane& plane, const Six& x) {
    Homogeneous p;
    Integer c = Integer(plane.c);
    for (int k = 0; k < 3; ++k) {
        auto a = static_cast<std::size_t>((k + 1) % 3), b = static_cast<std::size_t>((k + 2) % 3);
        auto d = static_cast<std::size_t>(k);
        p[d] = x[3 + b] * plane.n[(k + 1) % 3] - x[3 + a] * plane.n[(k + 2) % 3] + c * x[d];
    }
    p[3] = x[0] * plane.n.x + x[1] * plane.n.y + x[2] * plane.n.z;
    if (p[3].sign() < 0)
        for (Integer& v : p)
            v = -v;
    return p;
}

/// Where a + t (b - a), t in [0, 1], crosses the quadric, given values of opposite sign at the ends.
double crossing_parameter(double qa, double s, double qb) {
    double a = qa - s + qb, b = s - 2 * qa, discriminant = std::max(0.0, b * b - 4 * a * qa);
    double root = std::sqrt(discriminant), half = -0.5 * (b + (b > 0 ? root : -root));
    double t1 = half / a, t2 = qa / half;
    auto distance = [](double t) { return std::isnan(t) ? 1e300 : t < 0 ? -t : t > 1 ? t - 1 : 0; };
    double t = distance(t1) <= distance(t2) ? t1 : t2;
    return std::isnan(t) ? 0.5 : std::clamp(t, 0.0, 1.0);
}

} // namespace

// ------------------------------------------------------------------------------------------------- occluders

/// True if no point of the polygon lies strictly in front of both S and T (exact clipping; rare).
template <bool F, int W>
bool Solver<F, W>::outside_fronts(const std::vector<GridPoint>& corners) const {
    std::vector<Homogeneous> polygon;
    for (const GridPoint& p : corners)
        polygon.push_back({p.x, p.y, p.z, 1});
    for (const GridPlane* plane : {&frame_.s.plane, &frame_.t.plane}) {
        std::vector<Homogeneous> kept;
        std::size_t n = polygon.size();
        bool positive = false;
        for (std::size_t i = 0; i < n; ++i) {
            const Homogeneous &a = polygon[i], &b = polygon[(i + 1) % n];
            Integer va = plane->at(a), vb = plane->at(b);
            positive |= va.sign() > 0;
            if (va.sign() >= 0)
                kept.push_back(a);
            if (va.sign() * vb.sign() < 0) {
                Homogeneous p;
                for (std::size_t k = 0; k < 4; ++k)
                    p[k] = abs(vb) * a[k] + abs(va) * b[k];
                kept.push_back(p);
            }
        }
        if (!positive || kept.size() < 3)
            return true;
        polygon.swap(kept);
    }
    return false;
}

template <bool F, int W>
auto Solver<F, W>::prepare(OccluderId id) -> const Prepared& {
    auto [found, fresh] = prepared_index_.emplace(id, prepared_used_);
    if (!fresh)
        return prepared_[found->second];
    if (prepared_used_ == prepared_.size())
        prepared_.emplace_back();
    Prepared& occluder = prepared_[prepared_used_++];
    const certify::Polygon& polygon = source_->polygon(id);
    occluder.id = id;
    occluder.both_sides = polygon.both_sides;
    occluder.edges.clear();
    occluder.empty = true;
    std::vector<GridPoint> corners;
    for (const GridPoint& p : polygon.corners)
        corners.push_back(p - frame_.origin);
    std::size_t n = corners.size();
    std::vector<int> at_s(n), at_t(n);
    bool some_s = false, some_t = false, some_both = false, behind_s = false, behind_t = false;
    for (std::size_t i = 0; i < n; ++i) {
        at_s[i] = sign_of(frame_.s.plane.at(corners[i]));
        at_t[i] = sign_of(frame_.t.plane.at(corners[i]));
        some_s |= at_s[i] > 0;
        some_t |= at_t[i] > 0;
        some_both |= at_s[i] > 0 && at_t[i] > 0;
        behind_s |= at_s[i] < 0;
        behind_t |= at_t[i] < 0;
    }
    if (!some_s || !some_t)
        return occluder;
    if (!source_->is_flat(id)) { // nothing to clip: wholly in the closed fronts, and no triangle of it in one of the planes
        if (behind_s || behind_t || std::count(at_s.begin(), at_s.end(), 0) > 2 || std::count(at_t.begin(), at_t.end(), 0) > 2)
            return occluder;
        for (std::size_t i = 0; i < n; ++i)
            occluder.edges.push_back(store_.edge(corners[i], corners[(i + 1) % n]));
        occluder.empty = false;
        return occluder;
    }
    if (!some_both && outside_fronts(corners))
        return occluder;
    std::size_t triple[3];
    GridPlane plane = plane_of(corners, triple);
    if (plane.n.x == 0 && plane.n.y == 0 && plane.n.z == 0)
        return occluder;
    // The published form clips to the hull of S and T. Edges outside it bound nothing, and its sides no line from S to T; but
    // without all its edges the polygon ends where its plane leaves the fronts of S and T.
    std::vector<bool> in_hull(n, true);
    if (options_->form == ExactForm::published) {
        if (!clip_to_hull(corners, in_hull))
            return occluder;
        auto dropped = static_cast<std::uint64_t>(std::count(in_hull.begin(), in_hull.end(), false));
        result_->counters.edges_clipped += dropped;
        behind_s |= dropped > 0;
        behind_t |= dropped > 0;
    }
    for (std::size_t i = 0; i < n; ++i) {
        std::size_t j = (i + 1) % n;
        // An edge behind a plane bounds nothing of the part in front. One that lies in the plane does: beyond it
        // lines cross the occluder's plane behind S, or behind T, where it blocks nothing.
        auto is_behind = [&](const std::vector<int>& at) { return at[i] <= 0 && at[j] <= 0 && at[i] + at[j] < 0; };
        if (!in_hull[i] || corners[i] == corners[j] || is_behind(at_s) || is_behind(at_t))
            continue;
        occluder.edges.push_back(store_.edge(corners[i], corners[j]));
    }
    if (behind_s)
        occluder.edges.push_back({store_.hyperplane(dual(exact::meet(frame_.s.plane, plane))), 1});
    if (behind_t)
        occluder.edges.push_back({store_.hyperplane(dual(exact::meet(frame_.t.plane, plane))), 1});
    occluder.empty = false;
    return occluder;
}

/// +1 or -1: the line lies in the closed cone of lines that the occluder blocks, crossing it along its normal or
/// against. 0: it does not.
template <bool F, int W>
int Solver<F, W>::blocks(const Prepared& occluder, VertexId line) {
    if (occluder.empty)
        return 0;
    int crossing = occluder.both_sides ? 0 : -1; // its front is where lines against the normal come from
    for (const HalfSpace& edge : occluder.edges) {
        int sign = store_.sign(edge.hyperplane, line) * edge.sign;
        if (sign * crossing < 0)
            return 0;
        if (sign != 0)
            crossing = sign;
    }
    return crossing != 0 ? crossing : 1;
}

/// As blocks(), for all lines from S to T at once.
template <bool F, int W>
int Solver<F, W>::cover_all(const Prepared& occluder) {
    if (occluder.empty)
        return 0;
    int crossing = occluder.both_sides ? 0 : -1;
    for (const HalfSpace& edge : occluder.edges)
        for (VertexId line : frame_.lines) {
            int sign = store_.sign(edge.hyperplane, line) * edge.sign;
            if (sign * crossing < 0)
                return 0;
            if (sign != 0)
                crossing = sign;
        }
    return crossing != 0 ? crossing : 1;
}

/// How well an occluder suits a piece: few of its edges cross the piece (none: the piece is gone), and the line
/// runs deep inside it. Decides nothing but the order of work.
template <bool F, int W>
double Solver<F, W>::score(const Prepared& occluder, int crossing, const Piece& piece, VertexId line) const {
    int cuts = 0;
    double depth = 1e300;
    for (const HalfSpace& edge : occluder.edges) {
        double sign = crossing * edge.sign, limit = -1e-13 * store_.norm(edge.hyperplane);
        depth = std::min(depth, store_.approximate(edge.hyperplane, line) * sign);
        for (VertexId v : piece.vertices)
            if (store_.approximate(edge.hyperplane, v) * sign < limit) {
                ++cuts;
                break;
            }
    }
    return -cuts + 0.5 * depth;
}

/// The best of the occluders that block a line, or null if none does, which is only said after all were asked.
template <bool F, int W>
auto Solver<F, W>::find_blocker(const Candidate& line, const Piece* piece, int& crossing) -> const Prepared* {
    for (std::size_t limit : {kFirstLook, SIZE_MAX}) {
        found_.clear();
        bool more = source_->near_segment(line.near_p, line.near_q, limit, found_);
        std::size_t best = SIZE_MAX; // an index: prepare() may move what it keeps
        double best_score = 0;
        OccluderId whole = 0; // the last larger occluder that blocks
        bool have_whole = false;
        for (OccluderId id : found_) {
            OccluderId larger = source_->whole_of(id);
            if (have_whole && larger == whole && larger != id)
                continue;
            const Prepared& occluder = prepare(id);
            int sign = blocks(occluder, line.line);
            if (sign == 0)
                continue;
            if (larger == id) {
                whole = id;
                have_whole = true;
            }
            double value = piece ? score(occluder, sign, *piece, line.line) : 0;
            if (best == SIZE_MAX || value > best_score) {
                best = static_cast<std::size_t>(&occluder - prepared_.data());
                best_score = value;
                crossing = sign;
            }
            if (value > -0.5)
                break; // covers the piece alone, or any will do
        }
        if (best != SIZE_MAX)
            return &prepared_[best];
        if (!more)
            break;
    }
    return nullptr;
}

// ------------------------------------------------------------------------------------------------- witnesses

/// Strictly inside S and T?
template <bool F, int W>
bool Solver<F, W>::crosses_faces(VertexId line) {
    for (const Face* face : {&frame_.s, &frame_.t})
        for (const HalfSpace& half : face->half_spaces)
            if (store_.sign(half.hyperplane, line) * half.sign <= 0)
                return false;
    return true;
}

/// Strictly inside every facet that a cut has made? (The facets of the first polytope hold all lines from S to T.)
template <bool F, int W>
bool Solver<F, W>::inside(const Piece& piece, VertexId line) {
    for (std::int32_t code : piece.codes)
        if (code >= 0 && store_.sign(code / 2, line) * (code % 2 ? -1 : 1) <= 0)
            return false;
    return true;
}

/// Rounds a point near a face to p0 + a e1 + b e2 with a and b multiples of 2^-26: exactly in its plane, and, once
/// scaled by 2^26, an integer of 51 bits.
template <bool F, int W>
bool Solver<F, W>::round_to(const Face& face, const Vec3d& point, Vec3<std::int64_t>& out) const {
    const GridPoint &p0 = face.corners[face.triple[0]], &p1 = face.corners[face.triple[1]],
                    &p2 = face.corners[face.triple[2]];
    Vec3d e1 = to_vector(p1 - p0), e2 = to_vector(p2 - p0), r = point - to_vector(p0);
    double a11 = dot(e1, e1), a12 = dot(e1, e2), a22 = dot(e2, e2), b1 = dot(r, e1), b2 = dot(r, e2);
    double d = a11 * a22 - a12 * a12, a = (b1 * a22 - b2 * a12) / d, b = (b2 * a11 - b1 * a12) / d;
    if (!(std::abs(a) < 8 && std::abs(b) < 8))
        return false;
    auto ia = static_cast<std::int64_t>(std::floor(std::ldexp(a, kRoundingBits) + 0.5));
    auto ib = static_cast<std::int64_t>(std::floor(std::ldexp(b, kRoundingBits) + 0.5));
    for (int k = 0; k < 3; ++k)
        out[k] = (p0[k] << kRoundingBits) + ia * (p1[k] - p0[k]) + ib * (p2[k] - p0[k]);
    return true;
}

/// `p` and `q` in the frame. False if the rounded line misses S or T.
template <bool F, int W>
bool Solver<F, W>::make_candidate(const Vec3d& p, const Vec3d& q, Candidate& out) {
    Vec3<std::int64_t> ip, iq;
    if (!round_to(frame_.s, p, ip) || !round_to(frame_.t, q, iq))
        return false;
    out.line = store_.line_through(ip, iq, kRoundingBits);
    if (!crosses_faces(out.line))
        return false;
    out.p = shifted(ip, kRoundingBits);
    out.q = shifted(iq, kRoundingBits);
    Vec3d origin = to_vector(frame_.origin);
    out.near_p = to_vector(ip) * std::ldexp(1.0, -kRoundingBits) + origin;
    out.near_q = to_vector(iq) * std::ldexp(1.0, -kRoundingBits) + origin;
    return true;
}

template <bool F, int W>
bool Solver<F, W>::random_line(Candidate& out) {
    Vec3d ends[2];
    for (int k = 0; k < 2; ++k) {
        const Face& face = k == 0 ? frame_.s : frame_.t;
        double total = 0;
        for (const Homogeneous& corner : face.clipped) {
            double weight = random_weight(random_);
            ends[k] += to_vector(corner) * weight;
            total += weight;
        }
        ends[k] = ends[k] / total;
    }
    return make_candidate(ends[0], ends[1], out);
}

/// Meets a point of Pluecker space near the quadric, in scaled doubles, with the planes of S and T.
template <bool F, int W>
bool Solver<F, W>::ends_of(const std::array<double, 6>& x, Candidate& out) {
    Vec3d d{x[0], x[1], x[2]}, m{x[3], x[4], x[5]}, ends[2];
    for (int k = 0; k < 2; ++k) {
        const GridPlane& plane = (k == 0 ? frame_.s : frame_.t).plane;
        Vec3d n = to_vector(plane.n);
        double c = std::ldexp(static_cast<double>(plane.c), -frame_.scale_bits);
        ends[k] = (cross(n, m) + d * c) / dot(n, d);
        ends[k] = ends[k] * std::ldexp(1.0, frame_.scale_bits);
        if (!is_finite(ends[k]))
            return false;
    }
    return make_candidate(ends[0], ends[1], out);
}

template <bool F, int W>
bool Solver<F, W>::rounded_witness(const Piece& piece, int attempt, Candidate& out) {
    std::array<double, 6> c{}, o{};
    double largest = 0;
    for (VertexId v : piece.vertices) {
        double weight = attempt > 0 ? random_weight(random_) : 1;
        for (std::size_t k = 0; k < 6; ++k)
            c[k] += weight * store_.approximate(v)[k];
    }
    for (double value : c)
        largest = std::max(largest, std::abs(value));
    if (!(largest > 0))
        return false;
    for (double& value : c)
        value /= largest;
    double qc = quadric<double>(c);
    const QuadricPoint& opposite = qc > 0 ? piece.crossing.negative : piece.crossing.positive;
    for (int i = 0; i < opposite.count; ++i)
        for (std::size_t k = 0; k < 6; ++k)
            o[k] += opposite.weight[i] * store_.approximate(opposite.vertex[i])[k];
    double t = crossing_parameter(qc, side<double>(c, o), quadric<double>(o));
    std::array<double, 6> x;
    for (std::size_t k = 0; k < 6; ++k)
        x[k] = (1 - t) * c[k] + t * o[k];
    return ends_of(x, out);
}

/// A sum of the vertices with positive weights that balance their sizes.
template <bool F, int W>
void Solver<F, W>::exact_sum(const std::vector<VertexId>& vertices, Six& out) {
    int most = 0;
    std::vector<int> bits;
    for (VertexId v : vertices) {
        int b = 0;
        const Six& x = store_.exact(v);
        for (std::size_t k = 0; k < 6; ++k) // moments weigh as much as directions
            b = std::max(b, bits_of(x[k]) - (k < 3 ? 0 : frame_.scale_bits));
        bits.push_back(b);
        most = std::max(most, b);
    }
    out = {0, 0, 0, 0, 0, 0};
    for (std::size_t i = 0; i < vertices.size(); ++i) {
        const Six& x = store_.exact(vertices[i]);
        for (std::size_t k = 0; k < 6; ++k)
            out[k] += x[k] << static_cast<unsigned>(most - bits[i]);
    }
}

/// A point of the segment or triangle behind `point` where the quadric has the sign `wanted`.
template <bool F, int W>
bool Solver<F, W>::exact_point(const QuadricPoint& point, int wanted, Six& out) {
    std::array<Integer, 3> weight = {1, 0, 0};
    if (point.count == 2) {
        const Six &a = store_.exact(point.vertex[0]), &b = store_.exact(point.vertex[1]);
        // In absolute values Q(wa a + wb b) = wa wb s - wa^2 qa - wb^2 qb, largest where wb : wa = s : 2 qb; a zero
        // at one end asks only for a large enough weight there.
        Integer qa = abs(quadric(a)), qb = abs(quadric(b)), s = abs(side(a, b));
        if (qa.is_zero() && qb.is_zero())
            weight = {1, 1, 0};
        else if (qa.is_zero())
            weight = {qb / s + 1, 1, 0};
        else if (qb.is_zero())
            weight = {1, qa / s + 1, 0};
        else
            weight = {2 * qb, s, 0};
    } else if (point.count == 3) {
        Matrix3 m;
        for (std::size_t i = 0; i < 3; ++i)
            for (std::size_t j = 0; j < 3; ++j)
                m[i][j] = side(store_.exact(point.vertex[i]), store_.exact(point.vertex[j])) * -wanted;
        Matrix3 a = adjugate(m);
        for (std::size_t i = 0; i < 3; ++i)
            weight[i] = a[i][0] + a[i][1] + a[i][2];
    }
    out = {0, 0, 0, 0, 0, 0};
    for (int i = 0; i < point.count; ++i)
        for (std::size_t k = 0; k < 6; ++k)
            out[k] += weight[static_cast<std::size_t>(i)] * store_.exact(point.vertex[i])[k];
    return sign_of(Integer(quadric(out))) == wanted;
}

/// The line through the points where x, near the quadric, meets the planes; false if it misses S or T.
template <bool F, int W>
bool Solver<F, W>::candidate_from(const Six& x, Candidate& out) {
    out.p = meet(frame_.s.plane, x);
    out.q = meet(frame_.t.plane, x);
    if (out.p[3].is_zero() || out.q[3].is_zero())
        return false;
    make_primitive(out.p);
    make_primitive(out.q);
    Six six = exact::line_through(out.p, out.q);
    make_primitive(six);
    out.line = store_.line(six, -1, -1);
    if (!crosses_faces(out.line))
        return false;
    Vec3d origin = to_vector(frame_.origin);
    out.near_p = to_vector(out.p) + origin;
    out.near_q = to_vector(out.q) + origin;
    return true;
}

/// Bisection between two interior points of opposite sign, in integers. Converges: the crossing lies inside.
template <bool F, int W>
bool Solver<F, W>::exact_witness(const Piece& piece, Candidate& out) {
    ++result_->counters.exact_witnesses;
    Six c, o;
    exact_sum(piece.vertices, c);
    int at_c = sign_of(Integer(quadric(c)));
    if (at_c == 0)
        return candidate_from(c, out) && inside(piece, out.line);
    if (!exact_point(at_c > 0 ? piece.crossing.negative : piece.crossing.positive, -at_c, o))
        return false;
    make_primitive(c);
    make_primitive(o);
    // x = (2^n - k) c + k o
    Integer low = 0, high = 1;
    for (unsigned n = 1; n <= 4096; ++n) {
        low <<= 1;
        high <<= 1;
        Integer middle = (low + high) / 2, rest = (Integer(1) << n) - middle;
        Six x;
        for (std::size_t k = 0; k < 6; ++k)
            x[k] = rest * c[k] + middle * o[k];
        int at_x = sign_of(Integer(quadric(x)));
        (at_x == -at_c ? high : low) = middle;
        if ((n % 24 == 0 || at_x == 0) && candidate_from(x, out) && inside(piece, out.line))
            return true;
    }
    return false;
}

// ------------------------------------------------------------------------------------------------- the search

template <bool F, int W>
void Solver<F, W>::accept(const Candidate& line) {
    Witness& witness = result_->witness;
    witness.p = moved(line.p, frame_.origin);
    witness.q = moved(line.q, frame_.origin);
    witness.near_p = line.near_p;
    witness.near_q = line.near_q;
}

/// Random lines: an unblocked one ends the query, and so does a blocker that hides everything alone.
template <bool F, int W>
bool Solver<F, W>::random_stage(Answer& answer) {
    Candidate line;
    bool have_line = false;
    for (std::uint32_t r = 0; r < options_->rays; ++r) {
        if (!random_line(line))
            continue;
        have_line = true;
        int crossing = 0;
        const Prepared* blocker = find_blocker(line, nullptr, crossing);
        if (!blocker) {
            ++result_->counters.random_witness;
            accept(line);
            answer = Answer::visible;
            return true;
        }
        if (int all = cover_all(*blocker); all != 0) {
            ++result_->counters.single_cover;
            answer = Answer::hidden;
            if (options_->certificate)
                record_blocked(new_node(), blocker->id, all);
            else
                blocker_index(blocker->id);
            return true;
        }
    }
    if (!have_line || !options_->patches || options_->certificate)
        return false;
    std::vector<OccluderId> starts; // what blocks the last line
    for (OccluderId id : found_)
        if (source_->has_neighbours(id) && blocks(prepare(id), line.line) != 0)
            starts.push_back(id);
    std::size_t triangles =
        starts.empty() ? 0 : patch_hides(store_, frame_, *source_, starts, line.line, result_->counters);
    if (triangles == 0)
        return false;
    result_->effective = static_cast<std::uint32_t>(triangles);
    answer = Answer::hidden;
    return true;
}

template <bool F, int W>
RunStatus Solver<F, W>::first_piece(Piece& out) {
    bool touches = frame_.s_touches() || frame_.t_touches();
    bool try_prism = options_->start == Start::automatic || (options_->start == Start::prism_or_hull && !touches);
    if (try_prism) {
        StartResult prism = prism_start(store_, frame_, out);
        if (prism == StartResult::ready) {
            ++result_->counters.prisms;
            return RunStatus::done;
        }
        if (prism == StartResult::overflow)
            return RunStatus::overflow;
    }
    ++result_->counters.hulls;
    return hull_start(store_, frame_, out) == StartResult::ready ? RunStatus::done : RunStatus::overflow;
}

/// Does the piece hold real lines? If not, it is a leaf of the certificate (nodes are born as empty leaves).
template <bool F, int W>
bool Solver<F, W>::keeps_lines(Piece& piece) {
    return crosses_quadric(store_, piece, result_->counters.pairs, result_->counters.triples);
}

/// Takes from `piece` the lines that cross the occluder in this direction; pushes what is left.
template <bool F, int W>
RunStatus Solver<F, W>::subtract(Piece& piece, const Prepared& occluder, int crossing) {
    QueryCounters& counters = result_->counters;
    ++counters.subtractions;
    for (const HalfSpace& edge : occluder.edges) {
        int sign = edge.sign * crossing;
        Split result = split(store_, piece, edge.hyperplane, sign, in_, out_, counters.known);
        ++counters.crossing_tests;
        if (result == Split::overflow)
            return RunStatus::overflow;
        if (result == Split::inside)
            continue;
        if (result == Split::outside) { // cannot be: the witness is inside both
            stack_.push_back(std::move(piece));
            return RunStatus::done;
        }
        ++counters.splits;
        counters.most_vertices =
            std::max(counters.most_vertices, static_cast<std::uint32_t>(in_.vertices.size()));
        if (is_broken(in_) || is_broken(out_)) {
            ++counters.broken;
            return RunStatus::overflow; // a defect: never answered from, redone by another solver
        }
        record_split(in_, out_, edge.hyperplane, sign);
        if (keeps_lines(out_))
            stack_.push_back(out_);
        if (!keeps_lines(in_))
            return RunStatus::done;
        std::swap(piece, in_);
    }
    record_blocked(piece.node, occluder.id, crossing);
    return RunStatus::done;
}

template <bool F, int W>
RunStatus Solver<F, W>::search(Answer& answer) {
    QueryCounters& counters = result_->counters;
    Piece piece;
    if (first_piece(piece) == RunStatus::overflow)
        return RunStatus::overflow;
    if (is_broken(piece)) {
        ++counters.broken;
        return RunStatus::overflow;
    }
    piece.node = new_node();
    stack_.clear();
    if (keeps_lines(piece))
        stack_.push_back(std::move(piece));
    while (!stack_.empty()) {
        piece = std::move(stack_.back());
        stack_.pop_back();
        if (++counters.pieces > options_->max_pieces ||
            (options_->cancel && options_->cancel->load(std::memory_order_relaxed))) {
            answer = Answer::undecided;
            return RunStatus::done;
        }
        Candidate line;
        const Prepared* blocker = nullptr;
        int crossing = 0;
        for (int attempt = 0; attempt <= kRoundedAttempts && !blocker; ++attempt) {
            if (attempt == kRoundedAttempts) {
                if (!exact_witness(piece, line)) {
                    ++counters.broken;
                    return RunStatus::overflow;
                }
            } else if (!rounded_witness(piece, attempt, line)) {
                continue;
            }
            bool is_inside = attempt == kRoundedAttempts || inside(piece, line.line);
            blocker = find_blocker(line, is_inside ? &piece : nullptr, crossing);
            if (!blocker) { // unblocked: proof enough, inside the piece or not
                accept(line);
                answer = Answer::visible;
                return RunStatus::done;
            }
            if (!is_inside) {
                ++counters.witness_retries;
                blocker = nullptr;
            }
        }
        Prepared chosen = *blocker;
        if (subtract(piece, chosen, crossing) == RunStatus::overflow)
            return RunStatus::overflow;
    }
    answer = Answer::hidden;
    return RunStatus::done;
}

template <bool F, int W>
RunStatus Solver<F, W>::run(std::span<const GridPoint> s, std::span<const GridPoint> t, OccluderSource& source,
                            const QueryOptions& options, QueryResult& result) {
    source_ = &source;
    options_ = &options;
    result_ = &result;
    prepared_index_.clear();
    prepared_used_ = 0;
    blocker_index_.clear();
    result.blockers.clear();
    result.effective = 0;
    result.tree.nodes.clear();
    random_ = Random(options.seed);
    if (!frame_.set(s, t)) {
        result.answer = Answer::hidden; // nothing faces nothing: not even a root
        return RunStatus::done;
    }
    store_.reset(frame_.scale_bits);
    frame_.fill(store_);
    around_ = options.form == ExactForm::published ? frame_.planes_around() : std::vector<GridPlane>();
    RunStatus status = RunStatus::done;
    result.unobstructed.reset();
    if (options.form == ExactForm::published)
        status = search_published(result.answer);
    else if (!random_stage(result.answer))
        status = search(result.answer);
    if (result.effective == 0)
        result.effective = static_cast<std::uint32_t>(result.blockers.size());
    result.counters.arithmetic.add(store_.counters);
    return status;
}

// ------------------------------------------------------------------------------------------------- certificate

template <bool F, int W>
std::int32_t Solver<F, W>::new_node() {
    if (!options_->certificate)
        return -1;
    result_->tree.nodes.emplace_back();
    return static_cast<std::int32_t>(result_->tree.nodes.size() - 1);
}

template <bool F, int W>
std::uint32_t Solver<F, W>::blocker_index(OccluderId id) {
    auto [found, fresh] = blocker_index_.emplace(id, static_cast<std::uint32_t>(result_->blockers.size()));
    if (fresh)
        result_->blockers.push_back(id);
    return found->second;
}

template <bool F, int W>
void Solver<F, W>::record_split(Piece& in, Piece& out, HyperplaneId h, int sign) {
    if (!options_->certificate)
        return;
    auto parent = static_cast<std::size_t>(in.node);
    std::int32_t a = new_node(), b = new_node();
    certify::HiddenTree::Node& node = result_->tree.nodes[parent];
    node.kind = certify::HiddenTree::Kind::split;
    Six six = store_.exact_hyperplane(h);
    // From the frame, whose lines have moments m - origin x d, to the grid.
    for (int k = 0; k < 3; ++k) {
        auto i = static_cast<std::size_t>((k + 1) % 3), j = static_cast<std::size_t>((k + 2) % 3);
        six[static_cast<std::size_t>(k)] -=
            six[3 + i] * frame_.origin[(k + 2) % 3] - six[3 + j] * frame_.origin[(k + 1) % 3];
    }
    for (std::size_t k = 0; k < 6; ++k)
        node.hyperplane[k] = certify::Integer(six[k]) * sign;
    node.child[0] = in.node = a;
    node.child[1] = out.node = b;
}

template <bool F, int W>
void Solver<F, W>::record_blocked(std::int32_t at, OccluderId id, int crossing) {
    std::uint32_t index = blocker_index(id);
    if (!options_->certificate)
        return;
    certify::HiddenTree::Node& node = result_->tree.nodes[static_cast<std::size_t>(at)];
    node.kind = certify::HiddenTree::Kind::blocked;
    node.occluder = index;
    node.crossing = static_cast<std::int8_t>(crossing);
}

template class Solver<true, 2>;
template class Solver<false, 2>;
template class Solver<false, 16>;

} // namespace antumbra::exact
