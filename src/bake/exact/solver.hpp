// The subtraction: from the polytope of all lines between S and T, the lines that occluders block are taken away
// piece by piece, each piece steered by a real line inside it.
#pragma once

#include "bake/exact/face_lattice.hpp"
#include "base/random.hpp"
#include "bake/exact/quadric.hpp"
#include "bake/exact/query.hpp"
#include "bake/exact/start.hpp"

#include <map>
#include <unordered_map>

namespace antumbra::exact {

enum class RunStatus : std::uint8_t { done, overflow };

template <bool F, int W>
class Solver {
  public:
    /// `overflow`: a polytope needed more than 64 W facets; ask a wider solver.
    RunStatus run(std::span<const GridPoint> s, std::span<const GridPoint> t, OccluderSource& source,
                  const QueryOptions& options, QueryResult& result);

  private:
    /// An occluder, clipped to the fronts of S and T: the hyperplanes of its edges, each positive for lines that
    /// cross it along its normal.
    struct Prepared {
        OccluderId id = 0;
        std::vector<HalfSpace> edges;
        bool both_sides = true;
        bool empty = false; ///< nothing of it lies in front of both
    };
    /// A line that leaves S and meets T, given by its ends.
    struct Candidate {
        VertexId line = -1;
        Homogeneous p, q; ///< in the frame
        Vec3d near_p, near_q; ///< in grid coordinates
    };
    using Piece = Polytope<W>;

    const Prepared& prepare(OccluderId id);
    bool outside_fronts(const std::vector<GridPoint>& corners) const;
    int blocks(const Prepared& occluder, VertexId line);
    int cover_all(const Prepared& occluder);
    const Prepared* find_blocker(const Candidate& line, const Piece* piece, int& crossing);
    double score(const Prepared& occluder, int crossing, const Piece& piece, VertexId line) const;

    bool crosses_faces(VertexId line);
    bool inside(const Piece& piece, VertexId line);
    bool ends_of(const std::array<double, 6>& x, Candidate& out);
    bool round_to(const Face& face, const Vec3d& point, Vec3<std::int64_t>& out) const;
    bool make_candidate(const Vec3d& p, const Vec3d& q, Candidate& out);
    bool random_line(Candidate& out);
    bool rounded_witness(const Piece& piece, int attempt, Candidate& out);
    bool exact_witness(const Piece& piece, Candidate& out);
    void exact_sum(const std::vector<VertexId>& vertices, Six& out);
    bool exact_point(const QuadricPoint& point, int wanted, Six& out);
    bool candidate_from(const Six& x, Candidate& out);

    bool random_stage(Answer& answer);
    RunStatus first_piece(Piece& out);
    RunStatus search(Answer& answer);
    RunStatus subtract(Piece& piece, const Prepared& occluder, int crossing);
    bool keeps_lines(Piece& piece);

    // The published form (solver_published.cpp).
    /// Its shell carries the vertices, the cuts and the points that show both signs of the quadric, for the tests and
    /// witnesses that both forms share.
    struct Whole {
        Piece shell;
        FaceLattice lattice;
    };
    RunStatus search_published(Answer& answer);
    std::vector<OccluderId> order_by_rays(Answer& answer);
    std::vector<OccluderId> order_by_rays_left(std::vector<Whole>& complex, Answer& answer);
    std::vector<OccluderId> greedy_order(const std::map<OccluderId, std::vector<std::uint32_t>>& rays_of, std::size_t rays) const;
    std::vector<OccluderId> blockers_of(const Candidate& line);
    std::vector<OccluderId> rest_of_hull();
    RunStatus subtract_next(OccluderId id, std::vector<Whole>& complex);
    bool clip_to_hull(const std::vector<GridPoint>& corners, std::vector<bool>& left) const;
    bool over_budget() const;
    RunStatus subtract_everywhere(const Prepared& occluder, int crossing, std::vector<Whole>& complex);
    bool keeps_lines(Whole& whole);
    RunStatus find_witness(const Whole& whole);
    void keep_complex(std::vector<Whole>& complex);
    void accept(const Candidate& line);

    std::int32_t new_node();
    void record_split(Piece& in, Piece& out, HyperplaneId h, int sign);
    void record_blocked(std::int32_t node, OccluderId id, int crossing);
    std::uint32_t blocker_index(OccluderId id);

    std::array<double, 6> chart_{}; // of the published form
    LineStore<F> store_;
    Frame frame_;
    Random random_{0};
    OccluderSource* source_ = nullptr;
    const QueryOptions* options_ = nullptr;
    QueryResult* result_ = nullptr;
    std::unordered_map<OccluderId, std::size_t> prepared_index_;
    std::vector<Prepared> prepared_;
    std::size_t prepared_used_ = 0;
    std::unordered_map<OccluderId, std::uint32_t> blocker_index_;
    std::vector<OccluderId> found_;
    std::vector<Piece> stack_;
    Piece in_, out_;
    std::vector<GridPlane> around_; ///< of the published form: the hull of S and T lies behind all of them
};

extern template class Solver<true, 2>;
extern template class Solver<false, 2>;
extern template class Solver<false, 16>;

} // namespace antumbra::exact
