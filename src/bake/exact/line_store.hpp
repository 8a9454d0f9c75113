// The vertices and hyperplanes of one query, and the signs between them, all exact.
//
// A vertex is a point of Pluecker space (up to a positive factor): a given line, or the cut of an edge between two
// earlier vertices with a hyperplane. The filtered store keeps six doubles and one error bound per vertex, and
// integers only where a sign asks for them; the plain store (the test oracle) computes every vertex in integers at
// once. Bounds and their proofs: docs/methods/exact.md, "Arithmetic".
#pragma once

#include "bake/exact/residues.hpp"

#include <deque>
#include <span>
#include <unordered_map>
#include <vector>

namespace antumbra::exact {

class Wedge;
using VertexId = std::int32_t;
using HyperplaneId = std::int32_t;
inline constexpr double kUnit = 0x1p-53; ///< unit roundoff of double

/// What the arithmetic of a query cost.
struct ArithmeticCounters {
    std::uint64_t signs = 0, signs_small = 0, signs_residue = 0, signs_exact = 0;
    std::uint64_t quadric_signs = 0, side_signs = 0, quadric_undecided = 0, side_undecided = 0;
    std::uint64_t exact_vertices = 0, forced_vertices = 0;
    std::uint32_t largest_bits = 0;
    void add(const ArithmeticCounters& other);
};

/// A hyperplane and the side of it that is meant: sign * (h . x) >= 0.
struct HalfSpace {
    HyperplaneId hyperplane = -1;
    int sign = 1;
};

template <bool kFiltered>
class LineStore {
  public:
    /// Forgets everything. `scale_bits`: coordinates of the query's points are below 2^scale_bits in magnitude.
    void reset(int scale_bits);

    /// The hyperplane of lines that meet the directed edge a -> b (a != b). Collinear edges share one id, whatever
    /// their ends and direction; the sign tells which way this one runs.
    HalfSpace edge(const GridPoint& a, const GridPoint& b);
    HyperplaneId hyperplane(const Six& coefficients);
    /// `source` and `target`: the line passes through this corner of S, of T (-1: not known to).
    VertexId line(const SmallSix& coordinates, int source, int target);
    VertexId line(const Six& coordinates, int source, int target);
    /// The line through p / 2^shift and q / 2^shift, |p|, |q| below 2^52: on the quadric by construction.
    VertexId line_through(const Vec3<std::int64_t>& p, const Vec3<std::int64_t>& q, int shift);
    /// The point of the edge between `a` and `b`, strictly on opposite sides of `h`, on `h`. `common`: hyperplanes that
    /// hold both, if known, by which its integers are found without those of earlier vertices.
    VertexId cut(VertexId a, VertexId b, HyperplaneId h, std::span<const HyperplaneId> common = {});

    /// Sign of h . x.
    int sign(HyperplaneId h, VertexId v);
    /// Sign of quadric(x); remembered.
    int quadric_sign(VertexId v);
    int side_sign(VertexId v, VertexId w);
    /// side(v, w)^2 > 4 quadric(v) quadric(w), for two vertices whose quadric() has the same sign, not zero.
    bool discriminant_positive(VertexId v, VertexId w);

    /// h . x in doubles, for choices that decide nothing.
    double approximate(HyperplaneId h, VertexId v) const { return dot(hyperplanes_[index(h)], vertices_[index(v)]); }
    /// Largest coordinate in [0.25, 1]; coordinates are scaled by 2^-scale_bits per length.
    const std::array<double, 6>& approximate(VertexId v) const { return vertices_[index(v)].x; }
    double error(VertexId v) const { return vertices_[index(v)].error; } ///< of each coordinate of approximate(v)
    double norm(HyperplaneId h) const { return hyperplanes_[index(h)].norm; }
    const std::array<double, 6>& coefficients(HyperplaneId h) const { return hyperplanes_[index(h)].h; }
    const Six& exact(VertexId v);
    Six exact_hyperplane(HyperplaneId h) const;

    HyperplaneId hyperplane_count() const { return static_cast<HyperplaneId>(hyperplanes_.size()); }
    std::size_t vertex_count() const { return vertices_.size(); }
    /// Tells the store that cuts start from the hull of given lines (else: from grid and clip hyperplanes alone),
    /// which changes the bound on their size.
    void start_from_lines() { from_lines_ = true; }
    /// Bound on the bits of the primitive coordinates of every cut.
    int vertex_bits() const;

    ArithmeticCounters counters;

  private:
    struct Hyperplane {
        std::array<double, 6> h;
        double norm, error; // sum of |h|; |h - true| <= error per coefficient, for some positive scaling
        SmallSix small;
        std::int32_t exact = -1, residues = -1; // exact < 0: the coefficients are in `small`
        std::int32_t bits = 0;
    };
    struct Vertex {
        std::array<double, 6> x;
        double norm, error;
        VertexId parent[2] = {-1, -1};
        HyperplaneId by = -1;
        std::int32_t exact = -1, residues = -1, small = -1, wide = -1;
        std::array<HyperplaneId, 6> on; // some that hold it besides `by`
        std::int8_t on_count = 0;
        std::int32_t bits = -1;         // of a given line; -1: bounded by vertex_bits()
        std::int16_t label[2] = {-1, -1};
        std::int8_t quadric = kUnknown;
    };
    static constexpr std::int8_t kUnknown = 2;
    struct SmallHash {
        std::size_t operator()(const SmallSix& key) const {
            std::uint64_t hash = 0;
            for (std::int64_t value : key) {
                hash = (hash ^ static_cast<std::uint64_t>(value)) * 0x9E3779B97F4A7C15u;
                hash ^= hash >> 29;
            }
            return hash;
        }
    };

    static std::size_t index(std::int32_t id) { return static_cast<std::size_t>(id); }
    static double dot(const Hyperplane& h, const Vertex& v) {
        double sum = 0;
        for (std::size_t k = 0; k < 6; ++k)
            sum += h.h[k] * v.x[k];
        return sum;
    }
    /// |dot - true value| <= this (docs/methods/exact.md, lemma 1).
    static double bound(const Hyperplane& h, const Vertex& v) {
        return h.norm * (v.error + 8 * kUnit) + 7 * h.error;
    }
    std::int32_t keep(const Six& values);
    void to_doubles(const Six& values, bool hyperplane, std::array<double, 6>& x, double& error) const;
    void scale(std::array<double, 6>& x, int (&exponent)[6], bool hyperplane) const;
    void finish(Vertex& v) const;
    void note_bits(const Hyperplane& h, int moment, int direction);
    Integer dot_exact(const Hyperplane& h, const Six& x) const;
    Integer side_exact(VertexId v, VertexId w);
    void make_exact(VertexId v);
    void set_exact(VertexId v, const Six& x);
    bool common_point(VertexId v, Wedge& wedge, bool& negate) const;
    bool exact_by_hyperplanes(VertexId v);
    bool round_by_hyperplanes(VertexId v);
    /// Has integers, or can have them at once?
    static bool is_given(const Vertex& v) { return v.exact >= 0 || v.wide >= 0; }
    using WideSix = std::array<Int128, 6>;
    VertexId given_line(const WideSix& coordinates, int source, int target);
    const ResidueSix* residues(VertexId v);
    const ResidueSix& hyperplane_residues(HyperplaneId h);
    bool residue_sign_zero(HyperplaneId h, VertexId v);
    bool residue_side_zero(VertexId v, VertexId w);
    int bits_of_vertex(const Vertex& v) const { return v.bits >= 0 ? v.bits : vertex_bits(); }

    int scale_bits_ = 0;
    bool from_lines_ = false;
    int moment_bits_ = 0, direction_bits_ = 0; // of the largest hyperplane
    int line_bits_ = 0;                        // of the largest given start line
    std::vector<Hyperplane> hyperplanes_;
    std::vector<Vertex> vertices_;
    std::deque<Six> exact_;
    std::size_t exact_used_ = 0;
    std::vector<SmallSix> small_;
    std::vector<WideSix> wide_; // given lines
    std::deque<ResidueSix> residues_;
    std::size_t residues_used_ = 0;
    std::unordered_map<SmallSix, HyperplaneId, SmallHash> edges_;
};

extern template class LineStore<true>;
extern template class LineStore<false>;

} // namespace antumbra::exact
