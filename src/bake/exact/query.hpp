// The exact visibility query between two convex polygons (Nirenstein, Blake, Gain 2002, section 3, in the lazy,
// witness-guided form): is there an unblocked line, and with it an open set of them?
//
// Every sign is exact; there is no tolerance. Method and proofs: docs/methods/exact.md.
#pragma once

#include "bake/exact/frame.hpp"
#include "certify/certificate.hpp"

#include <antumbra/bake.hpp>

#include <atomic>
#include <memory>
#include <span>
#include <vector>

namespace antumbra::exact {

using OccluderId = std::uint32_t;

/// What may block. Called back during a query with the segments it is curious about.
class OccluderSource {
  public:
    virtual ~OccluderSource() = default;
    /// Appends at least every occluder that the segment p..q (grid coordinates, rounded to double) touches; more do
    /// no harm. May stop once `limit` are found; returns whether it did. Deterministic.
    virtual bool near_segment(const Vec3d& p, const Vec3d& q, std::size_t limit,
                              std::vector<OccluderId>& found) = 0;
    /// Appends at least every occluder that reaches strictly in front of all these planes (grid coordinates), whose fronts
    /// meet in the hull of the two polygons of a query. The published form asks for all occluders at once. False:
    /// not supported.
    virtual bool in_hull(std::span<const GridPlane>, std::vector<OccluderId>&) { return false; }
    /// The polygon behind an id: convex, planar unless is_flat() says no, with an area. Valid until the next call.
    virtual const certify::Polygon& polygon(OccluderId id) = 0;
    /// Do all corners of the polygon lie in one plane? If not, it is the rim of an oriented disc of triangles without an inner
    /// corner, which blocks the lines that pass all edges of the rim on one side.
    virtual bool is_flat(OccluderId) { return true; }
    /// A larger occluder that this one is part of, or itself. near_segment() names the larger one first.
    virtual OccluderId whole_of(OccluderId id) { return id; }
    /// Is this occluder part of a surface whose neighbours are known?
    virtual bool has_neighbours(OccluderId) { return false; }
    /// Appends all other occluders that share edge k (from corner k to the next) of `id`, same two ends exactly. Returns
    /// whether there is one only and it runs along the edge the other way, as in an oriented surface.
    virtual bool neighbours(OccluderId, std::size_t, std::vector<OccluderId>&) { return false; }
};

/// A plain list, for few occluders and for tests: ids are indices.
class OccluderList final : public OccluderSource {
  public:
    explicit OccluderList(std::span<const certify::Polygon> polygons) : polygons_(polygons) {}
    bool near_segment(const Vec3d& p, const Vec3d& q, std::size_t limit, std::vector<OccluderId>& found) override;
    bool in_hull(std::span<const GridPlane> around, std::vector<OccluderId>& found) override;
    const certify::Polygon& polygon(OccluderId id) override { return polygons_[id]; }

  private:
    std::span<const certify::Polygon> polygons_;
};

enum class Answer : std::uint8_t {
    hidden,    ///< no open set of unblocked lines
    visible,   ///< an open set of unblocked lines, one of which is the witness
    undecided, ///< the budget ran out: to be reported as visible, and counted
};

enum class Start : std::uint8_t {
    automatic, ///< prism, or hull where a corner of S lies in T's plane and one of T in that of S
    prism_or_hull, ///< prism, or hull where any corner touches the other plane (the oracle's choice)
    hull,      ///< always the hull of the corner lines
};

struct QueryOptions {
    Start start = Start::automatic;
    bool filtered = true;          ///< doubles with proven bounds first; false: the oracle, integers throughout
    std::uint32_t rays = 8;        ///< random lines tried before any polytope is built
    bool certificate = false;      ///< record the subdivision behind "hidden" (and use no patches)
    bool patches = true;           ///< try connected surfaces as single occluders where neighbours are known
    std::uint32_t max_pieces = 100000; ///< budget; beyond it the answer is `undecided`
    std::uint64_t seed = 1;
    ExactForm form = ExactForm::fast;
    bool complete = false; ///< published form: go on after the first unblocked line, and keep all of them
    const std::atomic<bool>* cancel = nullptr; ///< once true: `undecided`, soon
};

struct QueryCounters {
    std::uint64_t pieces = 0, subtractions = 0, splits = 0, crossing_tests = 0, known = 0;
    std::uint64_t pairs = 0, triples = 0, hulls = 0, prisms = 0;
    std::uint64_t exact_witnesses = 0, witness_retries = 0, widened = 0, broken = 0;
    std::uint64_t single_cover = 0, random_witness = 0;
    std::uint64_t sphere_tests = 0, sphere_rejected = 0, faces = 0; ///< published form
    std::uint64_t edges_clipped = 0, later_rays = 0;              ///< published form: edges outside the hull; rays into what is left
    std::uint64_t patches_tried = 0, patches_proved = 0;
    std::uint32_t most_vertices = 0;
    ArithmeticCounters arithmetic;
    void add(const QueryCounters& other);
};

/// An unblocked line: where it leaves S and where it meets T, in grid coordinates.
struct Witness {
    Homogeneous p, q;
    Vec3d near_p, near_q; ///< rounded
};

/// The unobstructed lines between two polygons, completely: convex pieces of line space whose lines are unblocked
/// (Nirenstein, Blake, Gain 2002, section 4.2). Published form only.
class LineSpace {
  public:
    struct Cone {
        std::vector<VertexId> vertices;
        std::array<std::vector<std::vector<std::uint32_t>>, 6> faces; ///< FaceLattice::faces
    };
    LineSpace(LineStore<true> store, const GridPoint& origin, std::vector<Cone> cones)
        : store_(std::move(store)), origin_(origin), cones_(std::move(cones)) {}

    std::size_t size() const { return cones_.size(); }
    /// False only if no line of any cone crosses the polygon against its normal: every cone lies outside one of its
    /// edges. Exact signs, but conservative: true says little.
    bool may_cross(std::span<const GridPoint> polygon);
    /// The vertices of cone k: points of Pluecker space, in grid coordinates, up to positive factors; most are no lines.
    std::vector<Six> cone(std::size_t k);
    /// Which vertices each facet of cone k has, ascending; faces of cone k by dimension, 0 to 4 (of a cross-section).
    std::vector<std::vector<std::uint32_t>> facets(std::size_t k) const;
    std::array<std::uint64_t, 5> face_counts(std::size_t k) const;

  private:
    LineStore<true> store_; // its signs are found when asked for
    GridPoint origin_;
    std::vector<Cone> cones_;
};

struct QueryResult {
    Answer answer = Answer::undecided;
    Witness witness;                           ///< if visible
    certify::HiddenTree tree;                  ///< if hidden and asked for; occluders are indices into `blockers`
    std::vector<OccluderId> blockers;          ///< the occluders subtracted, in the order of their first use
    /// Effective occluders: those that the ray stage chose (published form), that were subtracted (fast form), or the
    /// triangles of the connected surface that hides all.
    std::uint32_t effective = 0;
    std::shared_ptr<LineSpace> unobstructed; ///< if visible and `complete`; null if it was widened
    QueryCounters counters;
};

/// Keeps its memory between queries. One per thread.
class Query {
  public:
    Query();
    ~Query();
    Query(Query&&) noexcept;
    Query& operator=(Query&&) noexcept;

    /// Lines that leave the front of `s` and arrive at the front of `t`; both convex, planar, with an area, and
    /// disjoint. Parts of either behind the other's plane do not count. Coordinates below 2^24 in magnitude.
    /// Deterministic. Cost: microseconds to milliseconds, about the effective occluders to the power 1.5.
    QueryResult run(std::span<const GridPoint> s, std::span<const GridPoint> t, OccluderSource& occluders,
                    const QueryOptions& options = {});

  private:
    struct Solvers;
    std::unique_ptr<Solvers> solvers_;
};

/// The witness as exact rationals, for the verifier.
certify::WitnessSegment to_rational(const Witness& witness);

} // namespace antumbra::exact
