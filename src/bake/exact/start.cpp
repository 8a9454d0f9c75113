#include "bake/exact/start.hpp"

#include <algorithm>
#include <cmath>

namespace antumbra::exact {
namespace {

using Doubles6 = std::array<double, 6>;

double dot6(const Doubles6& a, const Doubles6& b) {
    double sum = 0;
    for (std::size_t k = 0; k < 6; ++k)
        sum += a[k] * b[k];
    return sum;
}

/// x + f * y.
Doubles6 add6(const Doubles6& x, double f, const Doubles6& y) {
    Doubles6 out;
    for (std::size_t k = 0; k < 6; ++k)
        out[k] = x[k] + f * y[k];
    return out;
}

Vec3d unit(const Vec3<std::int64_t>& n) {
    Vec3d d{static_cast<double>(n.x), static_cast<double>(n.y), static_cast<double>(n.z)};
    return d / std::sqrt(dot(d, d));
}

/// Solves the symmetric system m x = b by elimination with pivots; m is made regular by the caller.
Doubles6 solve6(std::array<std::array<double, 7>, 6> m) {
    for (std::size_t a = 0; a < 6; ++a) {
        std::size_t pivot = a;
        for (std::size_t b = a + 1; b < 6; ++b)
            if (std::abs(m[b][a]) > std::abs(m[pivot][a]))
                pivot = b;
        std::swap(m[a], m[pivot]);
        for (std::size_t b = 0; b < 6; ++b)
            if (b != a) {
                double f = m[b][a] / m[a][a];
                for (std::size_t k = a; k < 7; ++k)
                    m[b][k] -= f * m[a][k];
            }
    }
    Doubles6 x;
    for (std::size_t a = 0; a < 6; ++a)
        x[a] = m[a][6] / m[a][a];
    return x;
}

/// A functional w with w(L0) = |L0|^2 = 1 whose spread over the lines is small: least squares over what may be
/// added to L0 without changing its value there. Any functional would be right; a good one cuts fewer pieces.
Doubles6 flat_functional(const std::vector<Doubles6>& lines, const Doubles6& l0) {
    std::array<std::array<double, 7>, 6> m{};
    for (const Doubles6& x : lines) {
        double value = dot6(l0, x);
        Doubles6 y = add6(x, -value, l0);
        for (std::size_t a = 0; a < 6; ++a) {
            for (std::size_t b = 0; b < 6; ++b)
                m[a][b] += y[a] * y[b];
            m[a][6] -= value * y[a];
        }
    }
    double trace = 0;
    for (std::size_t a = 0; a < 6; ++a)
        trace += m[a][a];
    for (std::size_t a = 0; a < 6; ++a)
        m[a][a] += 1e-9 * trace + 1e-300;
    Doubles6 g = solve6(m);
    return add6(l0, 1, add6(g, -dot6(g, l0), l0));
}

/// A ray of the cone of lines modulo L0, and the facets (edges of S, then of T) that it lies on.
template <int W>
struct BaseRay {
    VertexId line;
    FacetSet<W> facets;
};

/// Corners in the other plane: all their lines coincide modulo L0 and lie on every edge hyperplane of the other
/// polygon. (Lines of two such corners are L0 itself: no ray.)
template <int W>
std::vector<BaseRay<W>> base_rays(const Frame& frame) {
    std::size_t ns = frame.s.clipped.size(), nt = frame.t.clipped.size();
    auto bits_of_corner = [](std::size_t i, std::size_t n, std::size_t offset) {
        FacetSet<W> set;
        set.add(offset + i);
        set.add(offset + (i + n - 1) % n);
        return set;
    };
    FacetSet<W> all_s, all_t;
    for (std::size_t i = 0; i < ns; ++i)
        all_s.add(i);
    for (std::size_t j = 0; j < nt; ++j)
        all_t.add(ns + j);
    auto free_corner = [](const Face& face) {
        return static_cast<std::size_t>(std::find(face.touches.begin(), face.touches.end(), false) -
                                        face.touches.begin());
    };
    std::vector<BaseRay<W>> rays;
    for (std::size_t i = 0; i < ns; ++i) {
        if (frame.s.touches[i]) {
            rays.push_back({frame.line(i, free_corner(frame.t)), bits_of_corner(i, ns, 0) | all_t});
            continue;
        }
        for (std::size_t j = 0; j < nt; ++j)
            if (!frame.t.touches[j])
                rays.push_back({frame.line(i, j), bits_of_corner(i, ns, 0) | bits_of_corner(j, nt, ns)});
    }
    for (std::size_t j = 0; j < nt; ++j)
        if (frame.t.touches[j])
            rays.push_back({frame.line(free_corner(frame.s), j), bits_of_corner(j, nt, ns) | all_s});
    return rays;
}

/// A cap: low * g <= w or w <= high * g, rounded to integers and moved outward until exact signs confirm that it
/// cuts no line off and meets L0 from the right side. -1: none found.
template <bool F>
HyperplaneId make_cap(LineStore<F>& store, const Frame& frame, const Doubles6& w, const Doubles6& g, double bound,
                      double margin, bool high, VertexId plus_l0) {
    for (int attempt = 0; attempt < 8; ++attempt, margin *= 4) {
        double limit = high ? bound + margin : bound - margin;
        Doubles6 cap;
        double largest = 0;
        for (std::size_t k = 0; k < 6; ++k) {
            cap[k] = high ? limit * g[k] - w[k] : w[k] - limit * g[k];
            largest = std::max(largest, std::abs(cap[k]));
        }
        if (!(largest > 0) || !std::isfinite(largest))
            return -1;
        Six six;
        for (std::size_t k = 0; k < 6; ++k) {
            six[k] = static_cast<std::int64_t>(std::floor(cap[k] / largest * 0x1p30 + 0.5));
            if (k < 3) // multiplies directions, which the doubles scale by one power less
                six[k] <<= static_cast<unsigned>(frame.scale_bits);
        }
        HyperplaneId h = store.hyperplane(six);
        bool valid = store.sign(h, plus_l0) == (high ? -1 : 1);
        for (std::size_t k = 0; k < frame.lines.size() && valid; ++k)
            valid = store.sign(h, frame.lines[k]) >= 0;
        if (valid)
            return h;
    }
    return -1;
}

} // namespace

template <bool F, int W>
StartResult prism_start(LineStore<F>& store, const Frame& frame, Polytope<W>& out) {
    if (frame.s_touches() && frame.t_touches())
        return StartResult::not_applicable;
    std::size_t ns = frame.s.clipped.size(), nt = frame.t.clipped.size();
    if (ns + nt + 2 > 64 * W)
        return StartResult::overflow;
    Six minus = frame.common_line;
    for (Integer& c : minus)
        c = -c;
    VertexId l0[2] = {store.line(minus, -1, -1), store.line(frame.common_line, -1, -1)};

    // In the chart g = n . d = 1, n = nS - nT: positive on every corner line, zero on L0.
    Vec3d n = unit(frame.s.plane.n) - unit(frame.t.plane.n);
    Doubles6 g = {n.x, n.y, n.z, 0, 0, 0};
    Doubles6 direction = store.approximate(l0[1]);
    double length = std::sqrt(dot6(direction, direction));
    for (double& c : direction)
        c /= length;
    std::vector<Doubles6> charted;
    for (VertexId v : frame.lines) {
        const Doubles6& x = store.approximate(v);
        double scale = dot6(g, x);
        if (!(scale > 1e-12))
            return StartResult::not_applicable;
        charted.push_back(add6({}, 1 / scale, x));
    }
    Doubles6 w = flat_functional(charted, direction);
    double low = dot6(w, charted[0]), high = low;
    for (const Doubles6& x : charted) {
        low = std::min(low, dot6(w, x));
        high = std::max(high, dot6(w, x));
    }
    double margin = 0.02 * (high - low) + 1e-6;
    HyperplaneId caps[2] = {make_cap(store, frame, w, g, low, margin, false, l0[1]),
                            make_cap(store, frame, w, g, high, margin, true, l0[1])};
    if (caps[0] < 0 || caps[1] < 0)
        return StartResult::not_applicable;

    out.clear();
    for (const Face* face : {&frame.s, &frame.t})
        for (const HalfSpace& half : face->half_spaces)
            out.codes.push_back(facet_code(half.hyperplane, half.sign));
    for (HyperplaneId cap : caps)
        out.codes.push_back(facet_code(cap, 1));
    std::vector<BaseRay<W>> rays = base_rays<W>(frame);
    for (std::size_t c = 0; c < 2; ++c)
        for (const BaseRay<W>& ray : rays) {
            // Along L0 to the cap: down to the low one, up to the high one.
            VertexId v = store.sign(caps[c], ray.line) == 0 ? ray.line : store.cut(ray.line, l0[c], caps[c]);
            out.vertices.push_back(v);
            out.facets.push_back(ray.facets | FacetSet<W>::one(ns + nt + c));
        }
    auto size = static_cast<std::uint16_t>(rays.size());
    for (std::uint16_t i = 0; i < size; ++i) {
        out.edges.push_back({i, static_cast<std::uint16_t>(size + i)});
        for (auto j = static_cast<std::uint16_t>(i + 1); j < size; ++j) {
            FacetSet<W> common = rays[i].facets & rays[j].facets;
            if (!common.has_at_least(3))
                continue;
            bool adjacent = true;
            for (std::uint16_t k = 0; k < size && adjacent; ++k)
                adjacent = k == i || k == j || !rays[k].facets.holds(common);
            if (adjacent) {
                out.edges.push_back({i, j});
                out.edges.push_back({static_cast<std::uint16_t>(size + i), static_cast<std::uint16_t>(size + j)});
            }
        }
    }
    drop_spent_facets(out);
    return StartResult::ready;
}

namespace {

/// Six independent lines among the corner lines, and the inverse of their matrix, scaled row by row to integers:
/// the rays of the simplicial cone dual to them.
struct DualRay {
    Six h;
    std::vector<bool> on; ///< which corner lines lie on it
};

bool pick_basis(const std::vector<Six>& lines, std::vector<std::size_t>& basis) {
    using Rational = boost::multiprecision::cpp_rational;
    std::vector<std::array<Rational, 6>> rows;
    std::vector<std::size_t> pivots;
    for (std::size_t k = 0; k < lines.size() && basis.size() < 6; ++k) {
        std::array<Rational, 6> row;
        for (std::size_t c = 0; c < 6; ++c)
            row[c] = boost::multiprecision::cpp_int(lines[k][c]);
        for (std::size_t r = 0; r < rows.size(); ++r)
            if (row[pivots[r]] != 0) {
                Rational f = row[pivots[r]] / rows[r][pivots[r]];
                for (std::size_t c = 0; c < 6; ++c)
                    row[c] -= f * rows[r][c];
            }
        for (std::size_t c = 0; c < 6; ++c)
            if (row[c] != 0) {
                rows.push_back(row);
                pivots.push_back(c);
                basis.push_back(k);
                break;
            }
    }
    return basis.size() == 6;
}

/// Determinant by fraction-free elimination (Bareiss).
Integer determinant(std::vector<std::vector<Integer>> m) {
    std::size_t n = m.size();
    Integer previous = 1;
    int sign = 1;
    for (std::size_t k = 0; k + 1 < n; ++k) {
        std::size_t pivot = k;
        while (pivot < n && m[pivot][k].is_zero())
            ++pivot;
        if (pivot == n)
            return 0;
        if (pivot != k) {
            std::swap(m[pivot], m[k]);
            sign = -sign;
        }
        for (std::size_t i = k + 1; i < n; ++i)
            for (std::size_t j = k + 1; j < n; ++j)
                m[i][j] = (m[i][j] * m[k][k] - m[i][k] * m[k][j]) / previous;
        previous = m[k][k];
    }
    return sign < 0 ? Integer(-m[n - 1][n - 1]) : m[n - 1][n - 1];
}

/// The hyperplane through five lines.
Six through_five(const std::vector<Six>& lines, const std::vector<std::size_t>& five) {
    Six h;
    for (std::size_t skip = 0; skip < 6; ++skip) {
        std::vector<std::vector<Integer>> minor(5);
        for (std::size_t r = 0; r < 5; ++r)
            for (std::size_t c = 0; c < 6; ++c)
                if (c != skip)
                    minor[r].push_back(lines[five[r]][c]);
        Integer value = determinant(std::move(minor));
        h[skip] = skip % 2 == 0 ? value : Integer(-value);
    }
    make_primitive(h);
    return h;
}

Integer dot_six(const Six& h, const Six& x) {
    Integer sum = 0;
    for (std::size_t k = 0; k < 6; ++k)
        sum += h[k] * x[k];
    return sum;
}

std::size_t count_common(const DualRay& a, const DualRay& b, std::vector<bool>& common) {
    common.assign(a.on.size(), false);
    std::size_t count = 0;
    for (std::size_t k = 0; k < a.on.size(); ++k)
        if (a.on[k] && b.on[k]) {
            common[k] = true;
            ++count;
        }
    return count;
}

bool holds(const std::vector<bool>& set, const std::vector<bool>& part) {
    for (std::size_t k = 0; k < set.size(); ++k)
        if (part[k] && !set[k])
            return false;
    return true;
}

/// The extreme rays h of the cone of all h with h . line >= 0, that is, the facets of the cone of `lines`: start with six
/// independent ones and insert the rest (double description). Lines and hyperplanes may change places.
std::vector<DualRay> hull_facets(const std::vector<Six>& lines) {
    std::vector<std::size_t> basis;
    std::vector<DualRay> facets;
    if (!pick_basis(lines, basis))
        return facets;
    std::vector<bool> inserted(lines.size(), false);
    for (std::size_t b : basis)
        inserted[b] = true;
    for (std::size_t skip = 0; skip < 6; ++skip) {
        std::vector<std::size_t> five;
        for (std::size_t k = 0; k < 6; ++k)
            if (k != skip)
                five.push_back(basis[k]);
        DualRay ray{through_five(lines, five), std::vector<bool>(lines.size(), false)};
        if (sign_of(dot_six(ray.h, lines[basis[skip]])) < 0)
            for (Integer& c : ray.h)
                c = -c;
        for (std::size_t k : five)
            ray.on[k] = true;
        facets.push_back(std::move(ray));
    }
    std::vector<bool> common;
    for (std::size_t k = 0; k < lines.size(); ++k) {
        if (inserted[k])
            continue;
        std::vector<Integer> value;
        for (DualRay& ray : facets) {
            value.push_back(dot_six(ray.h, lines[k]));
            if (value.back().is_zero())
                ray.on[k] = true;
        }
        std::vector<DualRay> next;
        for (std::size_t i = 0; i < facets.size(); ++i)
            if (value[i].sign() >= 0)
                next.push_back(facets[i]);
        for (std::size_t i = 0; i < facets.size(); ++i)
            for (std::size_t j = 0; j < facets.size(); ++j) {
                if (!(value[i].sign() > 0 && value[j].sign() < 0))
                    continue;
                if (count_common(facets[i], facets[j], common) < 4)
                    continue;
                bool adjacent = true;
                for (std::size_t q = 0; q < facets.size() && adjacent; ++q)
                    adjacent = q == i || q == j || !holds(facets[q].on, common);
                if (!adjacent)
                    continue;
                DualRay ray{{}, common};
                ray.on[k] = true;
                for (std::size_t c = 0; c < 6; ++c)
                    ray.h[c] = value[i] * facets[j].h[c] - value[j] * facets[i].h[c];
                make_primitive(ray.h);
                next.push_back(std::move(ray));
            }
        facets.swap(next);
    }
    return facets;
}

} // namespace

template <bool F, int W>
StartResult hull_start(LineStore<F>& store, const Frame& frame, Polytope<W>& out) {
    std::vector<Six> lines;
    for (VertexId v : frame.lines)
        lines.push_back(store.exact(v));
    std::vector<DualRay> facets = hull_facets(lines);
    if (facets.empty())
        return StartResult::not_applicable;
    if (facets.size() > 64 * W)
        return StartResult::overflow;
    store.start_from_lines();
    out.clear();
    out.codes.assign(facets.size(), kStartFacet);
    std::vector<FacetSet<W>> on(lines.size());
    for (std::size_t k = 0; k < lines.size(); ++k)
        for (std::size_t f = 0; f < facets.size(); ++f)
            if (facets[f].on[k])
                on[k].add(f);
    for (std::size_t k = 0; k < lines.size(); ++k) {
        // A line is a vertex iff no other one lies on all its facets (of equal ones the first).
        bool extreme = true;
        for (std::size_t q = 0; q < lines.size() && extreme; ++q)
            extreme = q == k || !on[q].holds(on[k]) || (on[k].holds(on[q]) && q > k);
        if (!extreme)
            continue;
        out.vertices.push_back(frame.lines[k]);
        out.facets.push_back(on[k]);
    }
    std::vector<std::uint16_t> all;
    for (std::size_t k = 0; k < out.vertices.size(); ++k)
        all.push_back(static_cast<std::uint16_t>(k));
    connect(out.facets, all, out.edges);
    return StartResult::ready;
}

template <bool F, int W>
StartResult published_start(LineStore<F>& store, const Frame& frame, Polytope<W>& out) {
    StartResult prism = prism_start(store, frame, out); // for its half-spaces
    if (prism != StartResult::ready)
        return prism == StartResult::overflow ? prism : hull_start(store, frame, out);
    std::vector<Six> half_spaces;
    std::vector<std::int32_t> codes;
    for (std::int32_t code : out.codes) {
        if (code == kFreeFacet)
            continue;
        Six h = store.exact_hyperplane(code / 2);
        if (code % 2)
            for (Integer& c : h)
                c = -c;
        half_spaces.push_back(h);
        codes.push_back(code);
    }
    std::vector<DualRay> rays = hull_facets(half_spaces);
    if (rays.empty())
        return hull_start(store, frame, out);
    out.clear();
    out.codes = codes;
    for (const DualRay& ray : rays) {
        out.vertices.push_back(store.line(ray.h, -1, -1));
        FacetSet<W> on;
        for (std::size_t k = 0; k < codes.size(); ++k)
            if (ray.on[k])
                on.add(k);
        out.facets.push_back(on);
    }
    std::vector<std::uint16_t> all;
    for (std::size_t k = 0; k < out.vertices.size(); ++k)
        all.push_back(static_cast<std::uint16_t>(k));
    connect(out.facets, all, out.edges);
    drop_spent_facets(out);
    return StartResult::ready;
}

#define ANTUMBRA_INSTANTIATE(F, W)                                                                                   \
    template StartResult prism_start(LineStore<F>&, const Frame&, Polytope<W>&);                                     \
    template StartResult hull_start(LineStore<F>&, const Frame&, Polytope<W>&);                                      \
    template StartResult published_start(LineStore<F>&, const Frame&, Polytope<W>&);
ANTUMBRA_INSTANTIATE(true, 2)
ANTUMBRA_INSTANTIATE(false, 2)
ANTUMBRA_INSTANTIATE(false, 16)
#undef ANTUMBRA_INSTANTIATE

} // namespace antumbra::exact
