// Convex polytopes of Pluecker space (cones of R^6) as vertices, incidences and edges, and how a hyperplane splits
// one. No face lattice: vertices, the facets each lies on, and the 1-skeleton say everything a split needs.
#pragma once

#include "bake/exact/line_store.hpp"

#include <bit>
#include <utility>

namespace antumbra::exact {

/// A set of facets of a polytope.
template <int W>
struct FacetSet {
    std::array<std::uint64_t, W> words{};

    static FacetSet one(std::size_t bit) {
        FacetSet set;
        set.add(bit);
        return set;
    }
    void add(std::size_t bit) { words[bit / 64] |= std::uint64_t(1) << (bit % 64); }
    bool has(std::size_t bit) const { return words[bit / 64] >> (bit % 64) & 1; }
    FacetSet operator&(const FacetSet& other) const {
        FacetSet out;
        for (std::size_t w = 0; w < W; ++w)
            out.words[w] = words[w] & other.words[w];
        return out;
    }
    FacetSet operator|(const FacetSet& other) const {
        FacetSet out;
        for (std::size_t w = 0; w < W; ++w)
            out.words[w] = words[w] | other.words[w];
        return out;
    }
    void remove(const FacetSet& other) {
        for (std::size_t w = 0; w < W; ++w)
            words[w] &= ~other.words[w];
    }
    bool holds(const FacetSet& other) const {
        std::uint64_t missing = 0;
        for (std::size_t w = 0; w < W; ++w)
            missing |= other.words[w] & ~words[w];
        return missing == 0;
    }
    /// Drops one member after the other: on machines without a counting instruction cheaper than counting all.
    bool has_at_least(int members) const {
        for (std::uint64_t word : words)
            for (; word != 0; word &= word - 1)
                if (--members == 0)
                    return true;
        return false;
    }
};

inline constexpr std::int32_t kFreeFacet = -1;  ///< no facet of the polytope uses this bit
inline constexpr std::int32_t kStartFacet = -2; ///< a facet of the first polytope that no hyperplane id names

/// Facet code of the half-space sign * h >= 0.
constexpr std::int32_t facet_code(HyperplaneId h, int sign) { return 2 * h + (sign < 0 ? 1 : 0); }

/// Points that show both signs of the quadric on a polytope: weighted sums of at most three vertices each.
struct QuadricPoint {
    int count = 0;
    VertexId vertex[3] = {-1, -1, -1};
    double weight[3] = {0, 0, 0}; ///< for doubles; exact weights are derived again where they are needed
};
struct QuadricCrossing {
    QuadricPoint negative, positive;
};

template <int W>
struct Polytope {
    std::vector<VertexId> vertices;
    std::vector<FacetSet<W>> facets; ///< of each vertex
    std::vector<std::pair<std::uint16_t, std::uint16_t>> edges;
    std::vector<std::int32_t> codes; ///< per bit: facet_code, kFreeFacet or kStartFacet
    QuadricCrossing crossing;
    std::int32_t node = -1; ///< of the certificate

    void clear() {
        vertices.clear();
        facets.clear();
        edges.clear();
        codes.clear();
        node = -1;
    }
    /// A bit for a new facet; -1 if all 64 W are in use.
    int new_bit(std::int32_t code) {
        for (std::size_t bit = 0; bit < codes.size(); ++bit)
            if (codes[bit] == kFreeFacet) {
                codes[bit] = code;
                return static_cast<int>(bit);
            }
        if (codes.size() == 64 * W)
            return -1;
        codes.push_back(code);
        return static_cast<int>(codes.size() - 1);
    }
};

enum class Split : std::uint8_t { inside, outside, both, overflow };

/// Adds the edges among `candidates` (vertices of one facet): two vertices are adjacent iff they share at least
/// four facets and no third one lies on all of those.
template <int W>
void connect(const std::vector<FacetSet<W>>& facets, const std::vector<std::uint16_t>& candidates,
             std::vector<std::pair<std::uint16_t, std::uint16_t>>& edges) {
    std::size_t n = candidates.size();
    for (std::size_t i = 0; i < n; ++i)
        for (std::size_t j = i + 1; j < n; ++j) {
            FacetSet<W> common = facets[candidates[i]] & facets[candidates[j]];
            if (!common.has_at_least(4))
                continue;
            bool adjacent = true;
            for (std::size_t k = 0; k < n && adjacent; ++k)
                adjacent = k == i || k == j || !facets[candidates[k]].holds(common);
            if (adjacent)
                edges.push_back({candidates[i], candidates[j]});
        }
}

/// Frees the bits of facets that fewer than five vertices touch: no facets any more.
template <int W>
void drop_spent_facets(Polytope<W>& p) {
    std::array<std::uint16_t, 64 * W> uses{};
    for (const FacetSet<W>& set : p.facets)
        for (std::size_t w = 0; w < W; ++w)
            for (std::uint64_t word = set.words[w]; word != 0; word &= word - 1)
                ++uses[64 * w + static_cast<std::size_t>(std::countr_zero(word))];
    FacetSet<W> spent;
    bool any = false;
    for (std::size_t bit = 0; bit < p.codes.size(); ++bit)
        if (p.codes[bit] != kFreeFacet && uses[bit] < 5) {
            spent.add(bit);
            p.codes[bit] = kFreeFacet;
            any = true;
        }
    if (any)
        for (FacetSet<W>& set : p.facets)
            set.remove(spent);
    while (!p.codes.empty() && p.codes.back() == kFreeFacet)
        p.codes.pop_back();
}

/// Splits `p` by sign * h: `in` gets the part >= 0, `out` the part <= 0. `inside` or `outside`: the hyperplane does
/// not meet the interior of p, and in and out stay untouched. `known` counts answers read off the facets of p.
/// `overflow`: more facets than bits.
template <bool F, int W>
Split split(LineStore<F>& store, const Polytope<W>& p, HyperplaneId h, int sign, Polytope<W>& in,
            Polytope<W>& out, std::uint64_t& known) {
    for (std::int32_t code : p.codes)
        if (code >= 0 && code / 2 == h) {
            ++known;
            return code == facet_code(h, sign) ? Split::inside : Split::outside;
        }
    std::size_t n = p.vertices.size();
    static thread_local std::vector<std::int8_t> classes;
    static thread_local std::vector<std::uint16_t> to_in, to_out, cut_in, cut_out;
    classes.resize(n);
    bool positive = false, negative = false;
    for (std::size_t i = 0; i < n; ++i) {
        int c = store.sign(h, p.vertices[i]) * sign;
        classes[i] = static_cast<std::int8_t>(c);
        positive |= c > 0;
        negative |= c < 0;
    }
    if (!negative)
        return Split::inside;
    if (!positive)
        return Split::outside;

    in.clear();
    out.clear();
    in.codes = p.codes;
    out.node = in.node = p.node;
    int bit = in.new_bit(facet_code(h, sign));
    if (bit < 0)
        return Split::overflow;
    out.codes = in.codes;
    out.codes[static_cast<std::size_t>(bit)] = facet_code(h, -sign);
    auto cut = FacetSet<W>::one(static_cast<std::size_t>(bit));
    to_in.assign(n, 0);
    to_out.assign(n, 0);
    cut_in.clear();
    cut_out.clear();
    auto place = [](Polytope<W>& part, VertexId v, const FacetSet<W>& facets) {
        part.vertices.push_back(v);
        part.facets.push_back(facets);
        return static_cast<std::uint16_t>(part.vertices.size() - 1);
    };
    for (std::size_t i = 0; i < n; ++i) {
        FacetSet<W> facets = classes[i] == 0 ? p.facets[i] | cut : p.facets[i];
        if (classes[i] >= 0)
            to_in[i] = place(in, p.vertices[i], facets);
        if (classes[i] <= 0)
            to_out[i] = place(out, p.vertices[i], facets);
        if (classes[i] == 0) {
            cut_in.push_back(to_in[i]);
            cut_out.push_back(to_out[i]);
        }
    }
    for (auto [i, j] : p.edges) {
        if (classes[i] * classes[j] < 0) {
            if (classes[i] < 0)
                std::swap(i, j);
            FacetSet<W> facets = p.facets[i] & p.facets[j];
            HyperplaneId common[8];
            std::size_t known_common = 0;
            for (std::size_t w = 0; w < W; ++w)
                for (std::uint64_t word = facets.words[w]; word != 0 && known_common < std::size(common); word &= word - 1)
                    if (std::int32_t code = p.codes[64 * w + static_cast<std::size_t>(std::countr_zero(word))]; code >= 0)
                        common[known_common++] = code / 2;
            VertexId v = store.cut(p.vertices[i], p.vertices[j], h, std::span(common, known_common));
            facets = facets | cut;
            cut_in.push_back(place(in, v, facets));
            cut_out.push_back(place(out, v, facets));
            in.edges.push_back({to_in[i], cut_in.back()});
            out.edges.push_back({to_out[j], cut_out.back()});
        } else if (classes[i] == 0 && classes[j] == 0) {
            continue; // found again by connect()
        } else if (classes[i] >= 0 && classes[j] >= 0) {
            in.edges.push_back({to_in[i], to_in[j]});
        } else {
            out.edges.push_back({to_out[i], to_out[j]});
        }
    }
    // Both parts share the cut facet; its vertices correspond one to one.
    std::size_t old_edges = in.edges.size();
    connect(in.facets, cut_in, in.edges);
    static thread_local std::vector<std::uint16_t> in_to_out;
    in_to_out.assign(in.vertices.size(), 0);
    for (std::size_t k = 0; k < cut_in.size(); ++k)
        in_to_out[cut_in[k]] = cut_out[k];
    for (std::size_t e = old_edges; e < in.edges.size(); ++e)
        out.edges.push_back({in_to_out[in.edges[e].first], in_to_out[in.edges[e].second]});
    drop_spent_facets(in);
    drop_spent_facets(out);
    return Split::both;
}

/// A polytope of full dimension has at least five edges at every vertex.
template <int W>
bool is_broken(const Polytope<W>& p) {
    std::vector<std::uint16_t> degree(p.vertices.size(), 0);
    for (auto [i, j] : p.edges) {
        ++degree[i];
        ++degree[j];
    }
    for (std::uint16_t d : degree)
        if (d < 5)
            return true;
    return false;
}

} // namespace antumbra::exact
