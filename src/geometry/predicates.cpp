#include "geometry/predicates.hpp"

#include "geometry/expansion.hpp"

#include <vector>

namespace antumbra {

namespace exact {

std::size_t sum(std::span<const double> e, std::span<const double> f, double* h) {
    // Merge by magnitude, then carry the running sum upwards (Shewchuk, FAST-EXPANSION-SUM with zero
    // elimination).
    std::size_t i = 0, j = 0, count = 0;
    auto next = [&] {
        bool from_e = j == f.size() || (i < e.size() && std::abs(e[i]) < std::abs(f[j]));
        return from_e ? e[i++] : f[j++];
    };
    std::size_t total = e.size() + f.size();
    if (total == 0)
        return 0;
    double carry = next();
    for (std::size_t k = 1; k < total; ++k) {
        double high, low;
        two_sum(carry, next(), high, low);
        if (low != 0)
            h[count++] = low;
        carry = high;
    }
    if (carry != 0)
        h[count++] = carry;
    return count;
}

std::size_t scale(std::span<const double> e, double b, double* h) {
    // Shewchuk, SCALE-EXPANSION with zero elimination.
    std::size_t count = 0;
    if (e.empty() || b == 0)
        return 0;
    double carry, low;
    two_product(e[0], b, carry, low);
    if (low != 0)
        h[count++] = low;
    for (std::size_t i = 1; i < e.size(); ++i) {
        double product, error, middle;
        two_product(e[i], b, product, error);
        two_sum(carry, error, middle, low);
        if (low != 0)
            h[count++] = low;
        fast_two_sum(product, middle, carry, low);
        if (low != 0)
            h[count++] = low;
    }
    if (carry != 0)
        h[count++] = carry;
    return count;
}

} // namespace exact

namespace {

/// Half an ulp of 1: the largest relative error of one operation.
constexpr double kUnit = 0x1p-53;

struct Approximation {
    double value; ///< rounded
    double error; ///< the true value is at most this far away
};

/// Proof of the bound, after Shewchuk section 4.3. Each difference has relative error u. A 2x2 minor such as
/// bx*cy - by*cx is off by at most (3u + 3u^2 + ..) (|bx cy| + |by cx|) of computed magnitudes for its
/// products and differences, plus u of the result for its subtraction; times dz (2 more roundings), and two
/// more sums: altogether 7u to first order, and Shewchuk shows that (7 + 56u) u times the *rounded* permanent
/// covers all higher orders. 8u is used here, so that the roundings of the bound itself are covered with room
/// to spare. Products that underflow lose at most 2^-1074 each: not covered, but out of the range that the
/// header states.
Approximation approximate(const Vec3d& a, const Vec3d& b, const Vec3d& c, const Vec3d& d) {
    Vec3d u = b - a, v = c - a, w = d - a;
    double yz = u.y * v.z, zy = u.z * v.y, zx = u.z * v.x, xz = u.x * v.z, xy = u.x * v.y, yx = u.y * v.x;
    double value = (yz - zy) * w.x + (zx - xz) * w.y + (xy - yx) * w.z;
    double permanent = (std::abs(yz) + std::abs(zy)) * std::abs(w.x) +
                       (std::abs(zx) + std::abs(xz)) * std::abs(w.y) +
                       (std::abs(xy) + std::abs(yx)) * std::abs(w.z);
    return {value, 8 * kUnit * permanent};
}

/// Two differences, two products, one sum: 3u to first order, times a permanent of products.
Approximation approximate(const Vec3d& a, const Vec3d& b, const Vec3d& c, int i, int j) {
    double left = (b[i] - a[i]) * (c[j] - a[j]);
    double right = (b[j] - a[j]) * (c[i] - a[i]);
    return {left - right, 4 * kUnit * (std::abs(left) + std::abs(right))};
}

/// a.value * b.value - c.value * d.value with the errors of all four carried along.
Approximation cross_difference(const Approximation& a, const Approximation& b, const Approximation& c,
                               const Approximation& d) {
    double left = a.value * b.value, right = c.value * d.value;
    double carried = std::abs(a.value) * b.error + a.error * (std::abs(b.value) + b.error) +
                     std::abs(c.value) * d.error + c.error * (std::abs(d.value) + d.error);
    // Two products and a difference round by at most 3u (|left| + |right|) to first order; `carried` sums
    // nonnegative numbers in at most 6 roundings, which the factor 1 + 2^-48 outweighs.
    return {left - right, (carried + 4 * kUnit * (std::abs(left) + std::abs(right))) * (1 + 0x1p-48)};
}

int sign_of(double value) {
    return value > 0 ? 1 : value < 0 ? -1 : 0;
}

/// A sign that the bound proves; 2: undecided. A bound of zero means that all products are zero: so is the
/// value.
int proven_sign(const Approximation& value) {
    if (value.error == 0)
        return sign_of(value.value);
    if (value.value > value.error)
        return 1;
    if (value.value < -value.error)
        return -1;
    return 2;
}

using Difference = Expansion<2>;

auto minor(const Difference& a, const Difference& b, const Difference& c, const Difference& d) {
    return a * b - c * d;
}

Expansion<192> orient3d_expansion(const Vec3d& a, const Vec3d& b, const Vec3d& c, const Vec3d& d) {
    Difference u[3], v[3], w[3];
    for (int k = 0; k < 3; ++k) {
        u[k] = Difference::difference(b[k], a[k]);
        v[k] = Difference::difference(c[k], a[k]);
        w[k] = Difference::difference(d[k], a[k]);
    }
    auto x = minor(u[1], v[2], u[2], v[1]) * w[0];
    auto y = minor(u[2], v[0], u[0], v[2]) * w[1];
    auto z = minor(u[0], v[1], u[1], v[0]) * w[2];
    return x + y + z;
}

Expansion<16> orient2d_expansion(const Vec3d& a, const Vec3d& b, const Vec3d& c, int i, int j) {
    return minor(Difference::difference(b[i], a[i]), Difference::difference(c[j], a[j]),
                 Difference::difference(b[j], a[j]), Difference::difference(c[i], a[i]));
}

/// Products of long expansions, on the heap: rare.
using Terms = std::vector<double>;

template <std::size_t N>
Terms compressed(const Expansion<N>& e) {
    // One pass of exact carries from the top packs the value into few components (Shewchuk, COMPRESS).
    std::span<const double> terms = e.terms();
    if (terms.empty())
        return {};
    Terms down;
    double carry = terms.back();
    for (std::size_t i = terms.size() - 1; i-- > 0;) {
        double high, low;
        exact::fast_two_sum(carry, terms[i], high, low);
        if (low != 0) {
            down.push_back(high);
            high = low;
        }
        carry = high;
    }
    down.push_back(carry);
    Terms packed;
    carry = down.back();
    for (std::size_t i = down.size() - 1; i-- > 0;) {
        double high, low;
        exact::fast_two_sum(down[i], carry, high, low);
        if (low != 0)
            packed.push_back(low);
        carry = high;
    }
    packed.push_back(carry);
    return packed;
}

Terms product(const Terms& e, const Terms& f) {
    Terms result, part(2 * e.size());
    for (double factor : f) {
        std::size_t parts = exact::scale(e, factor, part.data());
        Terms next(result.size() + parts);
        next.resize(exact::sum(result, {part.data(), parts}, next.data()));
        result.swap(next);
    }
    return result;
}

/// Sign of a * b - c * d.
template <std::size_t N, std::size_t M>
int cross_sign(const Expansion<N>& a, const Expansion<M>& b, const Expansion<N>& c, const Expansion<M>& d) {
    Terms left = product(compressed(a), compressed(b));
    Terms right = product(compressed(-c), compressed(d));
    Terms difference(left.size() + right.size());
    difference.resize(exact::sum(left, right, difference.data()));
    return difference.empty() ? 0 : sign_of(difference.back());
}

int counted(int sign, bool exactly, PredicateTally* tally) {
    if (tally)
        ++(exactly ? tally->exact : tally->filtered);
    return sign;
}

/// xp / (xp - xq) - yp / (yp - yq) = (yp xq - xp yq) / ((xp - xq) (yp - yq)): its sign from those of the
/// cross difference on top and of the two factors below.
int compare_ratios(int cross, int x_denominator, int y_denominator) {
    return cross * x_denominator * y_denominator;
}

} // namespace

bool in_exact_range(const Vec3d& p) {
    for (int k = 0; k < 3; ++k) {
        double magnitude = std::abs(p[k]);
        if (magnitude != 0 && !(magnitude >= 0x1p-97 && magnitude <= 0x1p150))
            return false;
    }
    return true;
}

namespace exact {

int orient3d(const Vec3d& a, const Vec3d& b, const Vec3d& c, const Vec3d& d) {
    return orient3d_expansion(a, b, c, d).sign();
}

int orient2d(const Vec3d& a, const Vec3d& b, const Vec3d& c, int axis) {
    return orient2d_expansion(a, b, c, (axis + 1) % 3, (axis + 2) % 3).sign();
}

int compare_crossings(const Vec3d& p, const Vec3d& q, const TrianglePoints& first,
                      const TrianglePoints& second) {
    auto fp = orient3d_expansion(first.a, first.b, first.c, p),
         fq = orient3d_expansion(first.a, first.b, first.c, q);
    auto sp = orient3d_expansion(second.a, second.b, second.c, p),
         sq = orient3d_expansion(second.a, second.b, second.c, q);
    return compare_ratios(cross_sign(sp, fq, fp, sq), (fp - fq).sign(), (sp - sq).sign());
}

} // namespace exact

int orient3d(const Vec3d& a, const Vec3d& b, const Vec3d& c, const Vec3d& d, PredicateTally* tally) {
    int sign = proven_sign(approximate(a, b, c, d));
    if (sign != 2)
        return counted(sign, false, tally);
    return counted(exact::orient3d(a, b, c, d), true, tally);
}

int orient2d(const Vec3d& a, const Vec3d& b, const Vec3d& c, int axis, PredicateTally* tally) {
    int i = (axis + 1) % 3, j = (axis + 2) % 3;
    int sign = proven_sign(approximate(a, b, c, i, j));
    if (sign != 2)
        return counted(sign, false, tally);
    return counted(exact::orient2d(a, b, c, axis), true, tally);
}

int compare_crossings(const Vec3d& p, const Vec3d& q, const TrianglePoints& first,
                      const TrianglePoints& second, PredicateTally* tally) {
    // Heights over the planes at p and q; the line meets a plane at t = at p / (at p - at q).
    Approximation fp = approximate(first.a, first.b, first.c, p),
                  fq = approximate(first.a, first.b, first.c, q);
    Approximation sp = approximate(second.a, second.b, second.c, p),
                  sq = approximate(second.a, second.b, second.c, q);
    Approximation f_fall{fp.value - fq.value,
                         (fp.error + fq.error + kUnit * (std::abs(fp.value) + std::abs(fq.value))) * 1.001};
    Approximation s_fall{sp.value - sq.value,
                         (sp.error + sq.error + kUnit * (std::abs(sp.value) + std::abs(sq.value))) * 1.001};
    int f_sign = proven_sign(f_fall), s_sign = proven_sign(s_fall),
        cross = proven_sign(cross_difference(sp, fq, fp, sq));
    if (f_sign != 2 && s_sign != 2 && cross != 2)
        return counted(compare_ratios(cross, f_sign, s_sign), false, tally);
    return counted(exact::compare_crossings(p, q, first, second), true, tally);
}

int compare_edge_crossing(const Vec3d& p, const Vec3d& q, const Vec3d& a, const Vec3d& b, int axis,
                          const TrianglePoints& triangle, PredicateTally* tally) {
    // Rare (the line lies in a triangle's plane): exact at once.
    int i = (axis + 1) % 3, j = (axis + 2) % 3;
    auto ep = orient2d_expansion(a, b, p, i, j), eq = orient2d_expansion(a, b, q, i, j);
    auto tp = orient3d_expansion(triangle.a, triangle.b, triangle.c, p),
         tq = orient3d_expansion(triangle.a, triangle.b, triangle.c, q);
    int cross = cross_sign(tp, eq, tq, ep); // (tp eq - ep tq), as in compare_ratios
    return counted(compare_ratios(cross, (ep - eq).sign(), (tp - tq).sign()), true, tally);
}

} // namespace antumbra
