#include "bake/exact/line_store.hpp"

#include "bake/exact/wedge.hpp"

#include <algorithm>
#include <numeric>

namespace antumbra::exact {
namespace {

/// Errors above this are not worth carrying on: the vertex is computed in integers and rounded.
constexpr double kLargestError = 0x1p-20;
/// Exact vertices longer than this are made primitive.
constexpr int kLongBits = 256;
/// Absorbs the roundings made while an error bound itself is computed.
constexpr double kInflate = 1 + 0x1p-40;

int bits_of_small(std::int64_t value) {
    auto magnitude = static_cast<std::uint64_t>(value < 0 ? -value : value);
    return 64 - (magnitude == 0 ? 64 : __builtin_clzll(magnitude));
}

bool fits(const Integer& value) { return bits_of(value) <= 61; }

Integer quadric_of(const Six& x) { return quadric(x); }

} // namespace

void ArithmeticCounters::add(const ArithmeticCounters& other) {
    signs += other.signs;
    signs_small += other.signs_small;
    signs_residue += other.signs_residue;
    signs_exact += other.signs_exact;
    quadric_signs += other.quadric_signs;
    side_signs += other.side_signs;
    quadric_undecided += other.quadric_undecided;
    side_undecided += other.side_undecided;
    exact_vertices += other.exact_vertices;
    forced_vertices += other.forced_vertices;
    largest_bits = std::max(largest_bits, other.largest_bits);
}

template <bool F>
void LineStore<F>::reset(int scale_bits) {
    scale_bits_ = scale_bits;
    from_lines_ = false;
    moment_bits_ = direction_bits_ = line_bits_ = 0;
    hyperplanes_.clear();
    vertices_.clear();
    small_.clear();
    wide_.clear();
    edges_.clear();
    exact_used_ = residues_used_ = 0;
    counters = {};
}

template <bool F>
std::int32_t LineStore<F>::keep(const Six& values) {
    if (exact_used_ == exact_.size())
        exact_.emplace_back();
    exact_[exact_used_] = values;
    return static_cast<std::int32_t>(exact_used_++);
}

template <bool F>
void LineStore<F>::to_doubles(const Six& values, bool hyperplane, std::array<double, 6>& x, double& error) const {
    int exponent[6];
    for (std::size_t k = 0; k < 6; ++k)
        x[k] = to_double(values[k], exponent[k]);
    scale(x, exponent, hyperplane);
    error = 2 * kUnit;
}

/// x[k] * 2^exponent[k], scaled so that the largest lies in [0.5, 1).
template <bool F>
void LineStore<F>::scale(std::array<double, 6>& x, int (&exponent)[6], bool hyperplane) const {
    int largest = INT32_MIN;
    for (std::size_t k = 0; k < 6; ++k) {
        // Lengths are scaled by 2^-scale_bits: once in a direction, twice in a moment.
        bool moment = (k >= 3) != hyperplane;
        exponent[k] -= (moment ? 2 : 1) * scale_bits_;
        if (x[k] != 0)
            largest = std::max(largest, exponent[k]);
    }
    for (std::size_t k = 0; k < 6; ++k)
        x[k] = x[k] == 0 ? 0 : std::ldexp(x[k], exponent[k] - largest);
}

template <bool F>
void LineStore<F>::finish(Vertex& v) const {
    v.norm = 0;
    for (double c : v.x)
        v.norm += std::abs(c);
}

template <bool F>
void LineStore<F>::note_bits(const Hyperplane& h, int moment, int direction) {
    (void)h;
    moment_bits_ = std::max(moment_bits_, moment);
    direction_bits_ = std::max(direction_bits_, direction);
}

template <bool F>
int LineStore<F>::vertex_bits() const {
    int large = std::max(moment_bits_, direction_bits_), small = std::min(moment_bits_, direction_bits_);
    if (!from_lines_) // Cramer: a 5 x 5 minor has at most three factors of the large kind
        return 3 * large + 2 * small + 7;
    return 5 * (large + line_bits_ + 3) + line_bits_ + 10; // weights of six given lines: minors of their products
}

template <bool F>
HalfSpace LineStore<F>::edge(const GridPoint& a, const GridPoint& b) {
    GridPoint d = b - a;
    std::int64_t divisor = std::gcd(std::gcd(d.x, d.y), d.z);
    int sign = d.x != 0 ? (d.x < 0 ? -1 : 1) : d.y != 0 ? (d.y < 0 ? -1 : 1) : d.z < 0 ? -1 : 1;
    divisor *= sign;
    d = {d.x / divisor, d.y / divisor, d.z / divisor};
    GridPoint m = cross(a, d);
    SmallSix key = {m.x, m.y, m.z, d.x, d.y, d.z};
    auto [found, fresh] = edges_.emplace(key, static_cast<HyperplaneId>(hyperplanes_.size()));
    if (!fresh)
        return {found->second, sign};
    Hyperplane h;
    h.small = key;
    double largest = 0;
    for (std::size_t k = 0; k < 6; ++k) { // exact: at most 53 bits, and the scaling is a power of two
        h.h[k] = std::ldexp(static_cast<double>(key[k]), -(k < 3 ? 2 : 1) * scale_bits_);
        largest = std::max(largest, std::abs(h.h[k]));
        h.bits = std::max(h.bits, bits_of_small(key[k]));
    }
    int exponent = 0;
    std::frexp(largest, &exponent);
    h.norm = 0;
    for (double& c : h.h) {
        c = std::ldexp(c, -exponent);
        h.norm += std::abs(c);
    }
    h.error = 0;
    int moment = 0, direction = 0;
    for (std::size_t k = 0; k < 3; ++k) {
        moment = std::max(moment, bits_of_small(key[k]));
        direction = std::max(direction, bits_of_small(key[k + 3]));
    }
    note_bits(h, moment, direction);
    hyperplanes_.push_back(h);
    return {found->second, sign};
}

template <bool F>
HyperplaneId LineStore<F>::hyperplane(const Six& coefficients) {
    Hyperplane h;
    h.small = {};
    to_doubles(coefficients, true, h.h, h.error);
    h.norm = 0;
    for (double c : h.h)
        h.norm += std::abs(c);
    bool small = true;
    int bits[2] = {0, 0};
    for (std::size_t k = 0; k < 6; ++k) {
        small = small && fits(coefficients[k]);
        bits[k < 3 ? 0 : 1] = std::max(bits[k < 3 ? 0 : 1], bits_of(coefficients[k]));
    }
    h.bits = std::max(bits[0], bits[1]);
    if (small)
        for (std::size_t k = 0; k < 6; ++k)
            h.small[k] = static_cast<std::int64_t>(coefficients[k]);
    else
        h.exact = keep(coefficients);
    note_bits(h, bits[0], bits[1]);
    hyperplanes_.push_back(h);
    return static_cast<HyperplaneId>(hyperplanes_.size() - 1);
}

template <bool F>
VertexId LineStore<F>::line(const SmallSix& coordinates, int source, int target) {
    WideSix wide;
    for (std::size_t k = 0; k < 6; ++k)
        wide[k] = coordinates[k];
    return given_line(wide, source, target);
}

/// Coordinates below 2^126. Their integers are made when they are asked for.
template <bool F>
VertexId LineStore<F>::given_line(const WideSix& coordinates, int source, int target) {
    Vertex v;
    v.label[0] = static_cast<std::int16_t>(source);
    v.label[1] = static_cast<std::int16_t>(target);
    double largest = 0;
    v.bits = 0;
    for (std::size_t k = 0; k < 6; ++k) { // rounded once, if longer than 53 bits; the scalings are powers of two
        auto magnitude = static_cast<Unsigned128>(coordinates[k] < 0 ? -coordinates[k] : coordinates[k]);
        auto high = static_cast<std::uint64_t>(magnitude >> 64);
        auto bits = static_cast<std::int32_t>(high != 0 ? 64 + std::bit_width(high)
                                                        : std::bit_width(static_cast<std::uint64_t>(magnitude)));
        v.bits = std::max(v.bits, bits);
        v.x[k] = std::ldexp(static_cast<double>(coordinates[k]), -(k < 3 ? 1 : 2) * scale_bits_);
        largest = std::max(largest, std::abs(v.x[k]));
    }
    int exponent = 0;
    std::frexp(largest, &exponent);
    for (double& c : v.x)
        c = std::ldexp(c, -exponent);
    v.error = v.bits <= 53 ? 0 : 2 * kUnit;
    finish(v);
    line_bits_ = std::max(line_bits_, v.bits);
    if (v.bits <= 61) {
        SmallSix values;
        for (std::size_t k = 0; k < 6; ++k)
            values[k] = static_cast<std::int64_t>(coordinates[k]);
        v.small = static_cast<std::int32_t>(small_.size());
        small_.push_back(values);
    }
    v.wide = static_cast<std::int32_t>(wide_.size());
    wide_.push_back(coordinates);
    vertices_.push_back(v);
    return static_cast<VertexId>(vertices_.size() - 1);
}

template <bool F>
VertexId LineStore<F>::line(const Six& coordinates, int source, int target) {
    Vertex v;
    v.label[0] = static_cast<std::int16_t>(source);
    v.label[1] = static_cast<std::int16_t>(target);
    to_doubles(coordinates, false, v.x, v.error);
    finish(v);
    v.bits = 0;
    bool small = true, representable = true;
    for (const Integer& c : coordinates) {
        v.bits = std::max(v.bits, bits_of(c));
        small = small && fits(c);
        representable = representable && bits_of(c) <= 53;
    }
    if (representable)
        v.error = 0;
    line_bits_ = std::max(line_bits_, v.bits);
    v.exact = keep(coordinates);
    if (small) {
        SmallSix values;
        for (std::size_t k = 0; k < 6; ++k)
            values[k] = static_cast<std::int64_t>(coordinates[k]);
        v.small = static_cast<std::int32_t>(small_.size());
        small_.push_back(values);
    }
    vertices_.push_back(v);
    return static_cast<VertexId>(vertices_.size() - 1);
}

template <bool F>
VertexId LineStore<F>::line_through(const Vec3<std::int64_t>& p, const Vec3<std::int64_t>& q, int shift) {
    WideSix six;
    for (int k = 0; k < 3; ++k) {
        int i = (k + 1) % 3, j = (k + 2) % 3;
        six[static_cast<std::size_t>(k)] = static_cast<Int128>(q[k] - p[k]) << shift;
        six[static_cast<std::size_t>(k) + 3] = static_cast<Int128>(p[i]) * q[j] - static_cast<Int128>(p[j]) * q[i];
    }
    int keep_line_bits = line_bits_; // a witness is no start line
    VertexId v = given_line(six, -1, -1);
    line_bits_ = keep_line_bits;
    vertices_[index(v)].quadric = 0;
    return v;
}

template <bool F>
VertexId LineStore<F>::cut(VertexId ia, VertexId ib, HyperplaneId ih, std::span<const HyperplaneId> common) {
    Vertex v;
    for (HyperplaneId on : common.subspan(0, std::min(common.size(), v.on.size())))
        v.on[static_cast<std::size_t>(v.on_count++)] = on;
    const Vertex &a = vertices_[index(ia)], &b = vertices_[index(ib)];
    const Hyperplane& h = hyperplanes_[index(ih)];
    v.parent[0] = ia;
    v.parent[1] = ib;
    v.by = ih;
    for (int side = 0; side < 2; ++side)
        v.label[side] = a.label[side] == b.label[side] ? a.label[side] : std::int16_t(-1);
    bool force = !F;
    if constexpr (F) {
        // docs/methods/exact.md, lemma 2: the convex form keeps errors small on short edges too.
        double va = std::abs(dot(h, a)), vb = std::abs(dot(h, b));
        double ba = bound(h, a), bb = bound(h, b);
        double gap = va + vb, ratio = (ba + bb) / gap;
        if (!(va > ba && vb > bb && ratio < 0.1))
            force = true;
        else {
            double t = va / gap, t1 = 1 - t;
            double shift = (t1 * ba + t * bb) / gap / (1 - ratio) + 4 * kUnit;
            double apart = 0, largest = 0;
            for (std::size_t k = 0; k < 6; ++k) {
                apart = std::max(apart, std::abs(b.x[k] - a.x[k]));
                v.x[k] = t1 * a.x[k] + t * b.x[k];
                largest = std::max(largest, std::abs(v.x[k]));
            }
            v.error = (t1 * a.error + t * b.error + shift * (apart + a.error + b.error) + 4 * kUnit) * kInflate;
            if ((largest < 0.25 && largest > 0) || largest > 1) {
                int exponent = 0;
                std::frexp(largest, &exponent);
                double factor = std::ldexp(1.0, -exponent);
                for (double& c : v.x)
                    c *= factor;
                v.error *= factor;
            }
            finish(v);
            force = !(v.error < kLargestError);
        }
    }
    vertices_.push_back(v);
    auto id = static_cast<VertexId>(vertices_.size() - 1);
    if (force) {
        ++counters.forced_vertices;
        if (!F || !round_by_hyperplanes(id))
            make_exact(id);
    }
    return id;
}

template <bool F>
Integer LineStore<F>::dot_exact(const Hyperplane& h, const Six& x) const {
    Integer sum = 0;
    if (h.exact < 0) {
        for (std::size_t k = 0; k < 6; ++k)
            if (h.small[k] != 0)
                sum += x[k] * h.small[k];
    } else {
        const Six& c = exact_[index(h.exact)];
        for (std::size_t k = 0; k < 6; ++k)
            sum += x[k] * c[k];
    }
    return sum;
}

template <bool F>
void LineStore<F>::make_exact(VertexId id) {
    if (vertices_[index(id)].exact >= 0)
        return;
    if (std::int32_t wide = vertices_[index(id)].wide; wide >= 0) { // its doubles and sizes are known
        Six x;
        for (std::size_t k = 0; k < 6; ++k)
            x[k] = wide_[index(wide)][k];
        vertices_[index(id)].exact = keep(x);
        return;
    }
    if (F && exact_by_hyperplanes(id))
        return;
    VertexId ia = vertices_[index(id)].parent[0], ib = vertices_[index(id)].parent[1];
    make_exact(ia);
    make_exact(ib);
    const Hyperplane& h = hyperplanes_[index(vertices_[index(id)].by)];
    const Six &xa = exact_[index(vertices_[index(ia)].exact)], &xb = exact_[index(vertices_[index(ib)].exact)];
    Integer wa = abs(dot_exact(h, xb)), wb = abs(dot_exact(h, xa));
    Six x;
    for (std::size_t k = 0; k < 6; ++k)
        x[k] = wa * xa[k] + wb * xb[k];
    int size = 0;
    for (const Integer& c : x)
        size = std::max(size, bits_of(c));
    if (size > kLongBits) // dividing costs more than carrying a few words
        make_primitive(x);
    set_exact(id, x);
}

/// The common point of five of the hyperplanes that hold the vertex; the ray of the two opposite ones on which the
/// vertex lies is told by a coordinate in which both ends of the cut edge certainly have one sign.
template <bool F>
bool LineStore<F>::common_point(VertexId id, Wedge& wedge, bool& negate) const {
    const Vertex& v = vertices_[index(id)];
    if (v.on_count < 4 || v.by < 0)
        return false;
    const Vertex &a = vertices_[index(v.parent[0])], &b = vertices_[index(v.parent[1])];
    unsigned best = 6;
    double clearest = 0;
    for (unsigned k = 0; k < 6; ++k) {
        double at_a = a.x[k], at_b = b.x[k];
        if (at_a * at_b <= 0)
            continue;
        double clear = std::min(std::abs(at_a) - a.error, std::abs(at_b) - b.error);
        if (clear > clearest) {
            clearest = clear;
            best = k;
        }
    }
    if (best == 6)
        return false;
    auto add = [&](HyperplaneId on) {
        const Hyperplane& h = hyperplanes_[index(on)];
        if (h.exact < 0)
            wedge.add(h.small);
    };
    add(v.by);
    for (std::int8_t k = 0; k < v.on_count && !wedge.complete(); ++k)
        add(v.on[static_cast<std::size_t>(k)]);
    if (!wedge.complete())
        return false;
    negate = (wedge.sign(best) > 0) != (a.x[best] > 0);
    return true;
}

template <bool F>
bool LineStore<F>::exact_by_hyperplanes(VertexId id) {
    Wedge wedge;
    bool negate = false;
    if (!common_point(id, wedge, negate))
        return false;
    Six x;
    for (unsigned k = 0; k < 6; ++k)
        x[k] = wedge.coordinate(k, negate);
    set_exact(id, x);
    return true;
}

/// Doubles rounded from the integers, which are not kept: hardly any sign will ask for them.
template <bool F>
bool LineStore<F>::round_by_hyperplanes(VertexId id) {
    Wedge wedge;
    bool negate = false;
    if (!common_point(id, wedge, negate))
        return false;
    ++counters.exact_vertices;
    Vertex& v = vertices_[index(id)];
    int exponent[6];
    for (unsigned k = 0; k < 6; ++k)
        v.x[k] = wedge.coordinate(k, negate, exponent[k]);
    scale(v.x, exponent, false);
    v.error = 2 * kUnit;
    finish(v);
    return true;
}

template <bool F>
void LineStore<F>::set_exact(VertexId id, const Six& x) {
    ++counters.exact_vertices;
    std::int32_t kept = keep(x);
    Vertex& v = vertices_[index(id)];
    v.exact = kept;
    int bits = 0;
    bool small = true;
    for (const Integer& c : x) {
        bits = std::max(bits, bits_of(c));
        small = small && fits(c);
    }
    counters.largest_bits = std::max(counters.largest_bits, static_cast<std::uint32_t>(bits));
    v.bits = bits;
    if (small) {
        SmallSix values;
        for (std::size_t k = 0; k < 6; ++k)
            values[k] = static_cast<std::int64_t>(x[k]);
        v.small = static_cast<std::int32_t>(small_.size());
        small_.push_back(values);
    }
    // The rounded doubles may have another scale than the old ones: nothing else may be remembered of them.
    to_doubles(x, false, v.x, v.error);
    finish(v);
}

template <bool F>
const Six& LineStore<F>::exact(VertexId v) {
    make_exact(v);
    return exact_[index(vertices_[index(v)].exact)];
}

template <bool F>
Six LineStore<F>::exact_hyperplane(HyperplaneId id) const {
    const Hyperplane& h = hyperplanes_[index(id)];
    if (h.exact >= 0)
        return exact_[index(h.exact)];
    Six six;
    for (std::size_t k = 0; k < 6; ++k)
        six[k] = h.small[k];
    return six;
}

template <bool F>
const ResidueSix& LineStore<F>::hyperplane_residues(HyperplaneId id) {
    if (hyperplanes_[index(id)].residues < 0) {
        if (residues_used_ == residues_.size())
            residues_.emplace_back();
        Hyperplane& h = hyperplanes_[index(id)];
        h.residues = static_cast<std::int32_t>(residues_used_++);
        ResidueSix& out = residues_[index(h.residues)];
        for (std::size_t k = 0; k < 6; ++k)
            if (h.exact < 0)
                reduce(h.small[k], out[k]);
            else
                reduce(exact_[index(h.exact)][k], out[k]);
    }
    return residues_[index(hyperplanes_[index(id)].residues)];
}

/// Null if the residue vector vanishes modulo some prime, so that it would prove nothing.
template <bool F>
const ResidueSix* LineStore<F>::residues(VertexId id) {
    constexpr std::int32_t kUseless = -2;
    if (vertices_[index(id)].residues == kUseless)
        return nullptr;
    if (vertices_[index(id)].residues < 0) {
        ResidueSix out;
        if (is_given(vertices_[index(id)])) {
            const Six& x = exact(id);
            for (std::size_t k = 0; k < 6; ++k)
                reduce(x[k], out[k]);
        } else {
            const ResidueSix* a = residues(vertices_[index(id)].parent[0]);
            const ResidueSix* b = a ? residues(vertices_[index(id)].parent[1]) : nullptr;
            if (!b) {
                vertices_[index(id)].residues = kUseless;
                return nullptr;
            }
            const ResidueSix& h = hyperplane_residues(vertices_[index(id)].by);
            Residue at_a, at_b;
            residue_dot(h, *a, at_a);
            residue_dot(h, *b, at_b);
            residue_combine(at_a, *b, at_b, *a, out);
        }
        if (!nonzero_everywhere(out)) {
            vertices_[index(id)].residues = kUseless;
            return nullptr;
        }
        if (residues_used_ == residues_.size())
            residues_.emplace_back();
        residues_[residues_used_] = out;
        vertices_[index(id)].residues = static_cast<std::int32_t>(residues_used_++);
    }
    return &residues_[index(vertices_[index(id)].residues)];
}

template <bool F>
bool LineStore<F>::residue_sign_zero(HyperplaneId h, VertexId v) {
    if (hyperplanes_[index(h)].bits + bits_of_vertex(vertices_[index(v)]) + 3 > kProvenBits)
        return false;
    const ResidueSix* x = residues(v);
    if (!x)
        return false;
    Residue value;
    residue_dot(hyperplane_residues(h), *x, value);
    return all_zero(value);
}

template <bool F>
bool LineStore<F>::residue_side_zero(VertexId v, VertexId w) {
    if (bits_of_vertex(vertices_[index(v)]) + bits_of_vertex(vertices_[index(w)]) + 3 > kProvenBits)
        return false;
    const ResidueSix *x = residues(v), *y = x ? residues(w) : nullptr;
    if (!y)
        return false;
    Residue value;
    residue_dot(exchanged(*x), *y, value);
    return all_zero(value);
}

template <bool F>
int LineStore<F>::sign(HyperplaneId ih, VertexId iv) {
    const Hyperplane& h = hyperplanes_[index(ih)];
    const Vertex& v = vertices_[index(iv)];
    ++counters.signs;
    if constexpr (F) {
        double value = dot(h, v);
        if (std::abs(value) > bound(h, v))
            return value > 0 ? 1 : -1;
    }
    if (h.exact < 0 && v.small >= 0) {
        ++counters.signs_small;
        const SmallSix& x = small_[index(v.small)];
        Int128 sum = 0;
        for (std::size_t k = 0; k < 6; ++k)
            sum += static_cast<Int128>(h.small[k]) * x[k];
        return sign_of(sum);
    }
    if constexpr (F)
        if (!is_given(v) && residue_sign_zero(ih, iv)) {
            ++counters.signs_residue;
            return 0;
        }
    ++counters.signs_exact;
    const Six& x = exact(iv);
    return sign_of(dot_exact(hyperplanes_[index(ih)], x));
}

template <bool F>
int LineStore<F>::quadric_sign(VertexId iv) {
    Vertex& v = vertices_[index(iv)];
    if (v.quadric != kUnknown)
        return v.quadric;
    if (F && (v.label[0] >= 0 || v.label[1] >= 0)) // lines through one point of a polygon: a plane in the quadric
        return v.quadric = 0;
    ++counters.quadric_signs;
    if constexpr (F) {
        double value = 0, size = 0;
        for (std::size_t k = 0; k < 3; ++k) {
            double term = v.x[k] * v.x[k + 3];
            value += term;
            size += std::abs(term);
        }
        if (std::abs(value) > (v.norm * v.error + 3 * v.error * v.error + 8 * kUnit * size) * kInflate + 0x1p-900)
            return v.quadric = value > 0 ? 1 : -1;
        ++counters.quadric_undecided;
        if (!is_given(v) && residue_side_zero(iv, iv))
            return vertices_[index(iv)].quadric = 0;
    }
    int result = sign_of(quadric_of(exact(iv)));
    return vertices_[index(iv)].quadric = static_cast<std::int8_t>(result);
}

template <bool F>
Integer LineStore<F>::side_exact(VertexId v, VertexId w) {
    make_exact(v);
    make_exact(w);
    return side(exact(v), exact(w));
}

template <bool F>
int LineStore<F>::side_sign(VertexId iv, VertexId iw) {
    const Vertex &a = vertices_[index(iv)], &b = vertices_[index(iw)];
    if constexpr (F) {
        if ((a.label[0] >= 0 && a.label[0] == b.label[0]) || (a.label[1] >= 0 && a.label[1] == b.label[1]))
            return 0;
        ++counters.side_signs;
        double value = 0, size = 0;
        for (std::size_t k = 0; k < 6; ++k) {
            double term = a.x[k] * b.x[(k + 3) % 6];
            value += term;
            size += std::abs(term);
        }
        double limit = a.norm * b.error + b.norm * a.error + 6 * a.error * b.error + 10 * kUnit * size;
        if (std::abs(value) > limit * kInflate + 0x1p-900)
            return value > 0 ? 1 : -1;
        ++counters.side_undecided;
        if ((!is_given(a) || !is_given(b)) && residue_side_zero(iv, iw))
            return 0;
    }
    return sign_of(side_exact(iv, iw));
}

template <bool F>
bool LineStore<F>::discriminant_positive(VertexId iv, VertexId iw) {
    if constexpr (F) {
        const Vertex &a = vertices_[index(iv)], &b = vertices_[index(iw)];
        double s = 0;
        for (std::size_t k = 0; k < 6; ++k)
            s += a.x[k] * b.x[(k + 3) % 6];
        double qa = 0, qb = 0;
        for (std::size_t k = 0; k < 3; ++k) {
            qa += a.x[k] * a.x[k + 3];
            qb += b.x[k] * b.x[k + 3];
        }
        // All |x| <= 1: generous absolute bounds, then intervals (docs/methods/exact.md, lemma 3).
        double es = 12 * (a.error + b.error) + 64 * kUnit;
        double ea = 12 * a.error + 32 * kUnit, eb = 12 * b.error + 32 * kUnit;
        s = std::abs(s);
        qa = std::abs(qa);
        qb = std::abs(qb);
        double low = std::max(0.0, s - es), high = s + es;
        double product_low = 4 * std::max(0.0, qa - ea) * std::max(0.0, qb - eb);
        double product_high = 4 * (qa + ea) * (qb + eb);
        if (low * low > product_high * kInflate + 0x1p-900)
            return true;
        if (high * high * kInflate + 0x1p-900 < product_low)
            return false;
    }
    Integer s = side_exact(iv, iw);
    return s * s > 4 * quadric_of(exact(iv)) * quadric_of(exact(iw));
}

template class LineStore<true>;
template class LineStore<false>;

} // namespace antumbra::exact
