// Does the interior of a polytope hold real lines? Exactly iff the quadric takes both signs on it, and since the
// extrema of the quadric lie on faces of dimension at most two, vertices, pairs and triples of vertices decide
// (docs/methods/exact.md, "The quadric test").
#pragma once

#include "bake/exact/polytope.hpp"

#include <optional>

namespace antumbra::exact {

/// sides[i][j] = side(x_i, x_j), i.e. the matrix of the quadratic form 2 Q on the cone of three vertices.
using Matrix3 = std::array<std::array<Integer, 3>, 3>;

inline Matrix3 adjugate(const Matrix3& m) {
    Matrix3 a;
    for (std::size_t i = 0; i < 3; ++i)
        for (std::size_t j = 0; j < 3; ++j) {
            std::size_t i1 = (i + 1) % 3, i2 = (i + 2) % 3, j1 = (j + 1) % 3, j2 = (j + 2) % 3;
            a[i][j] = m[i1][j1] * m[i2][j2] - m[i1][j2] * m[i2][j1];
        }
    return a;
}

/// Does sign * Q become negative strictly inside the cone of the three vertices, given that it does not on its
/// boundary? Hadeler 1983: iff det M < 0 and no entry of the adjugate is negative. (The row sums of the adjugate are
/// then the weights of a point where it does.)
template <bool F>
bool triple_dips(LineStore<F>& store, const VertexId (&v)[3], int sign) {
    Matrix3 m;
    for (std::size_t i = 0; i < 3; ++i)
        for (std::size_t j = i; j < 3; ++j) {
            m[i][j] = side(store.exact(v[i]), store.exact(v[j]));
            if (sign < 0)
                m[i][j] = -m[i][j];
            m[j][i] = m[i][j];
        }
    Matrix3 a = adjugate(m);
    if (sign_of(Integer(m[0][0] * a[0][0] + m[0][1] * a[1][0] + m[0][2] * a[2][0])) >= 0)
        return false;
    for (const auto& row : a)
        for (const Integer& entry : row)
            if (sign_of(entry) < 0)
                return false;
    return true;
}

/// A point inside three vertices where triple_dips() found the sign, weighted in doubles: good enough to start
/// from, and derived again exactly where it is not.
template <bool F>
QuadricPoint triple_point(LineStore<F>& store, const VertexId (&v)[3]) {
    double m[3][3];
    for (int i = 0; i < 3; ++i)
        for (int j = 0; j < 3; ++j)
            m[i][j] = side<double>(store.approximate(v[i]), store.approximate(v[j]));
    QuadricPoint point{3, {v[0], v[1], v[2]}, {0, 0, 0}};
    double total = 0;
    for (int i = 0; i < 3; ++i) {
        for (int j = 0; j < 3; ++j) {
            int i1 = (i + 1) % 3, i2 = (i + 2) % 3, j1 = (j + 1) % 3, j2 = (j + 2) % 3;
            point.weight[i] += m[i1][j1] * m[i2][j2] - m[i1][j2] * m[i2][j1];
        }
        point.weight[i] = std::abs(point.weight[i]);
        total += point.weight[i];
    }
    for (double& weight : point.weight)
        weight = total > 0 ? weight / total : 1.0 / 3;
    return point;
}

/// The point of the segment v..w where Q is most of its sign, given that it takes a sign there that the ends lack.
template <bool F>
QuadricPoint pair_point(LineStore<F>& store, VertexId v, VertexId w) {
    const std::array<double, 6>&a = store.approximate(v), &b = store.approximate(w);
    double qa = store.quadric_sign(v) == 0 ? 0 : std::abs(quadric<double>(a));
    double qb = store.quadric_sign(w) == 0 ? 0 : std::abs(quadric<double>(b));
    double s = std::abs(side<double>(a, b)), total = qa + s + qb;
    double t = total > 0 ? (qa + 0.5 * s) / total : 0.5;
    return {2, {v, w, -1}, {1 - t, t, 0}};
}

/// Fills p.crossing and returns true iff Q < 0 < Q somewhere on p, i.e. iff real lines cross its interior.
template <bool F, int W>
bool crosses_quadric(LineStore<F>& store, Polytope<W>& p, std::uint64_t& pairs, std::uint64_t& triples) {
    std::size_t n = p.vertices.size();
    QuadricPoint point[2]; // [0] negative, [1] positive
    double best[2] = {-1, -1};
    bool found[2] = {false, false};
    for (VertexId v : p.vertices) {
        int sign = store.quadric_sign(v);
        if (sign == 0)
            continue;
        auto k = static_cast<std::size_t>(sign > 0);
        double size = std::abs(quadric<double>(store.approximate(v)));
        if (!found[k] || size > best[k]) {
            found[k] = true;
            best[k] = size;
            point[k] = {1, {v, -1, -1}, {1, 0, 0}};
        }
    }
    if (found[0] && found[1]) {
        p.crossing = {point[0], point[1]};
        return true;
    }
    ++pairs;
    // A sign that no vertex has may be taken on a segment between two: where side has it and outweighs the ends.
    bool at_vertex[2] = {found[0], found[1]};
    static thread_local std::vector<std::pair<std::uint16_t, std::uint16_t>> dips[2];
    dips[0].clear();
    dips[1].clear();
    for (std::size_t i = 0; i < n && !(found[0] && found[1]); ++i)
        for (std::size_t j = i + 1; j < n && !(found[0] && found[1]); ++j) {
            VertexId v = p.vertices[i], w = p.vertices[j];
            int sign = store.side_sign(v, w);
            if (sign == 0)
                continue;
            auto k = static_cast<std::size_t>(sign > 0);
            if (at_vertex[k])
                continue;
            if (!found[k] && (store.quadric_sign(v) == 0 || store.quadric_sign(w) == 0 ||
                              store.discriminant_positive(v, w))) {
                found[k] = true;
                point[k] = pair_point(store, v, w);
            } else {
                dips[k].push_back({static_cast<std::uint16_t>(i), static_cast<std::uint16_t>(j)});
            }
        }
    if (found[0] && found[1]) {
        p.crossing = {point[0], point[1]};
        return true;
    }
    if (!found[0] && !found[1])
        return false; // Q is zero throughout: not even full-dimensional
    // One sign is missing; only a 2-face between three vertices, at least two of whose pairs dip, can hold it.
    std::size_t missing = found[0] ? 1 : 0;
    const auto& list = dips[missing];
    if (list.size() < 2)
        return false;
    ++triples;
    for (std::size_t a = 0; a < list.size(); ++a)
        for (std::size_t b = a + 1; b < list.size(); ++b) {
            auto [i, j] = list[a];
            auto [k, l] = list[b];
            std::uint16_t third;
            if (k == i || k == j)
                third = l;
            else if (l == i || l == j)
                third = k;
            else
                continue;
            VertexId v[3] = {p.vertices[i], p.vertices[j], p.vertices[third]};
            if (!triple_dips(store, v, missing == 0 ? 1 : -1))
                continue;
            point[missing] = triple_point(store, v);
            p.crossing = {point[0], point[1]};
            return true;
        }
    return false;
}

} // namespace antumbra::exact
