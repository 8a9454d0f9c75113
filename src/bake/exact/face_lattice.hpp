// Polytopes of Pluecker space with all their faces, and how a hyperplane splits one: the representation of the published
// algorithm (Nirenstein, Blake, Gain 2002, section 3.2.1, after Bajaj and Pascucci). The fast form does without the
// faces between edges and facets (polytope.hpp).
#pragma once

#include "bake/exact/polytope.hpp"

#include <algorithm>
#include <map>

namespace antumbra::exact {

/// A convex polytope of dimension 5 (a cone of R^6). Immutable once made.
struct FaceLattice {
    /// Vertices are the faces of dimension 0, the polytope itself the one of dimension 5. A face is the list of those
    /// of one dimension less that bound it.
    std::array<std::vector<std::vector<std::uint32_t>>, 6> faces; ///< [0]: empty lists, one per vertex
    std::vector<VertexId> vertices;

    // The sphere around the vertices in the chart where a functional that is positive on them is 1. radius < 0: none.
    std::array<double, 6> centre{};
    double radius = -1;

    std::size_t count() const {
        std::size_t sum = 0;
        for (const auto& level : faces)
            sum += level.size();
        return sum;
    }
};

/// All faces of a polytope from the facets that each of its vertices lies on: the faces below a face are its maximal
/// intersections with facets (Fukuda, Rosta 1994).
template <int W>
FaceLattice enumerate_faces(const Polytope<W>& p) {
    using Set = std::vector<std::uint64_t>; // of vertices
    std::size_t n = p.vertices.size(), words = (n + 63) / 64;
    std::vector<Set> facets;
    for (std::size_t bit = 0; bit < p.codes.size(); ++bit) {
        if (p.codes[bit] == kFreeFacet)
            continue;
        Set set(words, 0);
        for (std::size_t v = 0; v < n; ++v)
            if (p.facets[v].has(bit))
                set[v / 64] |= std::uint64_t(1) << (v % 64);
        facets.push_back(std::move(set));
    }
    auto holds = [](const Set& a, const Set& b) {
        for (std::size_t w = 0; w < a.size(); ++w)
            if (b[w] & ~a[w])
                return false;
        return true;
    };
    FaceLattice lattice;
    lattice.vertices = p.vertices;
    Set all(words, 0);
    for (std::size_t v = 0; v < n; ++v)
        all[v / 64] |= std::uint64_t(1) << (v % 64);
    std::vector<Set> level = {all};
    lattice.faces[5].resize(1);
    lattice.faces[0].resize(n);
    for (std::size_t dimension = 5; dimension > 0; --dimension) {
        std::map<Set, std::uint32_t> below;
        std::vector<Set> next;
        for (std::size_t f = 0; f < level.size(); ++f) {
            std::vector<Set> parts;
            for (const Set& facet : facets) {
                Set part(words);
                bool any = false, whole = true;
                for (std::size_t w = 0; w < words; ++w) {
                    part[w] = level[f][w] & facet[w];
                    any |= part[w] != 0;
                    whole &= part[w] == level[f][w];
                }
                if (any && !whole)
                    parts.push_back(std::move(part));
            }
            std::sort(parts.begin(), parts.end());
            parts.erase(std::unique(parts.begin(), parts.end()), parts.end());
            for (const Set& part : parts) {
                bool maximal = std::none_of(parts.begin(), parts.end(),
                                            [&](const Set& other) { return other != part && holds(other, part); });
                if (!maximal)
                    continue;
                std::uint32_t id;
                if (dimension == 1) { // a vertex: under its own number
                    id = 0;
                    for (std::size_t w = 0; w < words; ++w)
                        if (part[w] != 0)
                            id = static_cast<std::uint32_t>(64 * w) + static_cast<std::uint32_t>(std::countr_zero(part[w]));
                } else {
                    auto [found, fresh] = below.emplace(part, static_cast<std::uint32_t>(next.size()));
                    if (fresh)
                        next.push_back(part);
                    id = found->second;
                }
                lattice.faces[dimension][f].push_back(id);
            }
        }
        if (dimension > 1)
            lattice.faces[dimension - 1].resize(next.size());
        level = std::move(next);
    }
    return lattice;
}

/// Is every face well-formed? Edges have two ends, and the numbers of faces below the top obey Euler's formula.
inline bool is_broken(const FaceLattice& lattice) {
    long euler = 0;
    for (std::size_t dimension = 0; dimension < 5; ++dimension)
        euler += (dimension % 2 == 0 ? 1 : -1) * static_cast<long>(lattice.faces[dimension].size());
    return euler != 2 || std::any_of(lattice.faces[1].begin(), lattice.faces[1].end(),
                                     [](const auto& edge) { return edge.size() != 2; });
}

/// Sphere in the chart dot(chart, x) = 1; none if the chart is not clearly positive on all vertices.
template <bool F>
void set_sphere(LineStore<F>& store, const std::array<double, 6>& chart, FaceLattice& lattice) {
    lattice.radius = -1;
    std::vector<std::array<double, 6>> points;
    double error = 0;
    for (VertexId v : lattice.vertices) {
        std::array<double, 6> x = store.approximate(v);
        double scale = 0;
        for (std::size_t k = 0; k < 6; ++k)
            scale += chart[k] * x[k];
        if (!(scale > 1e-9))
            return;
        for (double& c : x)
            c /= scale;
        error = std::max(error, store.error(v) / scale);
        points.push_back(x);
    }
    lattice.centre.fill(0);
    for (const auto& x : points)
        for (std::size_t k = 0; k < 6; ++k)
            lattice.centre[k] += x[k] / static_cast<double>(points.size());
    double largest = 0;
    for (const auto& x : points) {
        double square = 0;
        for (std::size_t k = 0; k < 6; ++k)
            square += (x[k] - lattice.centre[k]) * (x[k] - lattice.centre[k]);
        largest = std::max(largest, square);
    }
    // The true points lie within sqrt(6) errors of these, and a few roundings of coordinates up to |centre| + radius.
    double size = 0;
    for (double c : lattice.centre)
        size += std::abs(c);
    double radius = std::sqrt(largest);
    lattice.radius = radius * (1 + 1e-12) + 3 * error + 1e-14 * (size + radius);
}

/// On which side of the hyperplane is the whole sphere? 0: it may cross, or there is none.
template <bool F>
int side_of_sphere(const LineStore<F>& store, const FaceLattice& lattice, HyperplaneId h) {
    if (!(lattice.radius >= 0))
        return 0;
    double value = 0, size = 0, square = 0;
    const std::array<double, 6>& c = store.coefficients(h);
    for (std::size_t k = 0; k < 6; ++k) {
        value += c[k] * lattice.centre[k];
        size += std::abs(c[k] * lattice.centre[k]);
        square += c[k] * c[k];
    }
    // Rounding of the product, and of the coefficients (each within 2^-52 of its true value, in the same scaling).
    double doubt = std::sqrt(square) * lattice.radius * (1 + 1e-12) + 1e-14 * size +
                   6 * 0x1p-52 * (lattice.radius + std::abs(lattice.centre[0]) + std::abs(lattice.centre[1]) +
                                  std::abs(lattice.centre[2]) + std::abs(lattice.centre[3]) + std::abs(lattice.centre[4]) +
                                  std::abs(lattice.centre[5]));
    return value > doubt ? 1 : value < -doubt ? -1 : 0;
}

/// Sides of the vertices with respect to sign * h: is one strictly positive, one strictly negative?
struct Crossing {
    std::vector<std::int8_t> of;
    bool positive = false, negative = false;
};
template <bool F>
Crossing classify(LineStore<F>& store, const FaceLattice& lattice, HyperplaneId h, int sign) {
    Crossing crossing;
    for (VertexId v : lattice.vertices) {
        int c = store.sign(h, v) * sign;
        crossing.of.push_back(static_cast<std::int8_t>(c));
        crossing.positive |= c > 0;
        crossing.negative |= c < 0;
    }
    return crossing;
}

/// Splits the polytope in two, level by level; a face that is crossed leaves a part on either side and a new face of one
/// dimension less in the hyperplane. Vertices in the hyperplane need no special place.
template <bool F>
void split(LineStore<F>& store, const FaceLattice& p, HyperplaneId h, const Crossing& crossing, FaceLattice& in,
           FaceLattice& out) {
    constexpr std::uint32_t kNone = UINT32_MAX;
    struct Parts {
        bool positive = false, negative = false;
        std::uint32_t in = kNone, out = kNone;         // the face, or its part, on either side
        std::uint32_t cut_in = kNone, cut_out = kNone; // the new face, if it is crossed
    };
    FaceLattice* side[2] = {&in, &out};
    for (FaceLattice* half : side) {
        half->vertices.clear();
        for (auto& level : half->faces)
            level.clear();
    }
    auto add = [](FaceLattice& half, std::size_t dimension, std::vector<std::uint32_t> below) {
        half.faces[dimension].push_back(std::move(below));
        return static_cast<std::uint32_t>(half.faces[dimension].size() - 1);
    };
    auto add_vertex = [&](FaceLattice& half, VertexId v) {
        half.vertices.push_back(v);
        return add(half, 0, {});
    };
    std::array<std::vector<Parts>, 6> parts;
    for (std::size_t v = 0; v < p.vertices.size(); ++v) {
        Parts one;
        one.positive = crossing.of[v] > 0;
        one.negative = crossing.of[v] < 0;
        if (!one.negative)
            one.in = add_vertex(in, p.vertices[v]);
        if (!one.positive)
            one.out = add_vertex(out, p.vertices[v]);
        parts[0].push_back(one);
    }
    std::vector<std::uint32_t> cut_in, cut_out, below_in, below_out;
    for (std::size_t d = 1; d <= 5; ++d)
        for (const std::vector<std::uint32_t>& face : p.faces[d]) {
            Parts one;
            for (std::uint32_t g : face) {
                one.positive |= parts[d - 1][g].positive;
                one.negative |= parts[d - 1][g].negative;
            }
            below_in.clear();
            below_out.clear();
            for (std::uint32_t g : face) {
                // (Where a face is crossed, none of those that bound it lies in the hyperplane.)
                const Parts& part = parts[d - 1][g];
                if (part.in != kNone)
                    below_in.push_back(part.in);
                if (part.out != kNone)
                    below_out.push_back(part.out);
            }
            if (one.positive && one.negative) {
                if (d == 1) {
                    VertexId v = store.cut(p.vertices[face[0]], p.vertices[face[1]], h);
                    one.cut_in = add_vertex(in, v);
                    one.cut_out = add_vertex(out, v);
                } else {
                    cut_in.clear();
                    cut_out.clear();
                    for (std::uint32_t g : face) {
                        const Parts& part = parts[d - 1][g];
                        if (part.cut_in != kNone) {
                            cut_in.push_back(part.cut_in);
                            cut_out.push_back(part.cut_out);
                        }
                        for (std::uint32_t e : p.faces[d - 1][g])
                            if (const Parts& ridge = parts[d - 2][e]; !ridge.positive && !ridge.negative) {
                                cut_in.push_back(ridge.in);
                                cut_out.push_back(ridge.out);
                            }
                    }
                    for (std::vector<std::uint32_t>* list : {&cut_in, &cut_out}) {
                        std::sort(list->begin(), list->end());
                        list->erase(std::unique(list->begin(), list->end()), list->end());
                    }
                    one.cut_in = add(in, d - 1, cut_in);
                    one.cut_out = add(out, d - 1, cut_out);
                }
                below_in.push_back(one.cut_in);
                below_out.push_back(one.cut_out);
            }
            if (one.positive || !one.negative)
                one.in = add(in, d, below_in);
            if (one.negative || !one.positive)
                one.out = add(out, d, below_out);
            parts[d].push_back(one);
        }
}

} // namespace antumbra::exact
