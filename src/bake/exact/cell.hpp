// What is visible from one view cell, exactly (Nirenstein, Blake, Gain 2002, section 4).
//
// Units that rays find are taken as seen. The rest of the scene is walked from front to back: a box of the tree that no
// line from the cell reaches hides all that it holds, and from then on occludes as a solid itself (virtual occluder); a
// box that is reached is opened, and the line that reached it is followed to what it hits.
#pragma once

#include "bake/exact/cell_sampler.hpp"
#include "bake/exact/query.hpp"
#include "bake/exact/scene_tree.hpp"

#include <functional>
#include <span>

namespace antumbra::exact {

/// One query of a pair of faces, for studies.
struct QueryRecord {
    bool box = false;             ///< of a box; else of a triangle
    Answer answer = Answer::undecided;
    std::uint32_t effective = 0;  ///< occluders (QueryResult::effective)
    std::uint32_t pieces = 0;     ///< of line space
    double distance = 0;          ///< from the cell to the target's box, in grid units
    double seconds = 0;           ///< of this thread
};

struct CellOptions {
    std::uint32_t rays = 1;             ///< random lines per pair of faces, before any polytope (published form: 200)
    std::uint32_t max_pieces = 20000;   ///< budget of one query; beyond it the answer is visible and counted
    std::uint32_t box_pieces = 20000;   ///< the same for boxes; beyond it the box is opened
    std::uint32_t window_pieces = 100;   ///< the same for the windows of a box; beyond it the pairs of faces are asked for
    /// Budget of the cell: pieces of line space and pairs of faces asked for, summed; 0: none. Of its last quarter boxes are
    /// asked for first and triangles with what they leave. What is not decided when it is spent is visible and counted.
    std::uint64_t work = 0;
    std::uint32_t rays_at_box = 16;     ///< of sample_between
    bool virtual_occluders = true;      ///< false only to measure what they are worth
    bool windows = true;                ///< one query through two windows before the pairs of faces of a box
    bool joined = true;                 ///< flat neighbouring triangles as one occluder (fast form); false only to measure
    bool patches = true;                ///< connected surfaces as single occluders; false only to measure
    bool filtered = true;               ///< false: the oracle
    ExactForm form = ExactForm::fast;
    std::uint32_t look_around = 0;      ///< rays in all directions before any query
    std::uint32_t follow = 0;           ///< rays that follow the edges of what was found, at the most
    bool sample_between = false;        ///< aim a few rays before each query, and follow each witness
    std::uint64_t seed = 1;
    std::function<void(const QueryRecord&)> observer; ///< called after each query, from the solving thread
};

/// What no line from a cell reaches, ascending. Hidden nodes are boxes that hide all that they hold; hidden triangles say
/// nothing of the boxes around them (one that is turned away may stand in plain sight).
struct HiddenParts {
    std::vector<std::uint32_t> nodes, triangles;
};

struct CellCounters {
    std::uint64_t box_queries = 0, boxes_hidden = 0, triangle_queries = 0, triangles_hidden = 0;
    std::uint64_t boxes_by_ray = 0;      ///< opened because a ray came in
    std::uint64_t pairs = 0;             ///< pairs of faces asked for
    std::uint64_t windows = 0, windows_hidden = 0; ///< boxes asked for through two windows
    std::uint64_t pairs_handed_down = 0; ///< answered by the hidden face of a parent box that holds the target's
    std::uint64_t reused = 0;            ///< published form: targets that lie outside all open lines of their parent box
    std::uint64_t boxes_given_up = 0;    ///< opened because a budget ran out
    std::uint64_t undecided = 0;         ///< triangles reported visible because a budget ran out
    std::uint64_t extended = 0;          ///< units found by following the witness of a box
    std::uint64_t by_touch = 0;          ///< units visible because they touch the cell
    std::uint64_t unasked = 0;           ///< of these, those that came up after the cell's budget was spent
    std::uint64_t effective = 0;         ///< occluders, summed over the pairs that needed any
    std::uint64_t with_effective = 0;    ///< those pairs
    std::uint32_t most_effective = 0;
    SamplerCounters sampler;
    QueryCounters query;
    void add(const CellCounters& other);
};

/// Solves one cell after the other. Not thread-safe; one per thread. Refers to the tree and the tracer.
class CellSolver {
  public:
    CellSolver(const SceneTree& tree, const Tracer& tracer, const CellOptions& options = {});
    ~CellSolver();

    /// `cell`: closed box on the grid, with a volume. `visible`: bit set over the tree's units, holding what is known
    /// to be visible; on return every unit that is visible from some point of the cell, and no other. A unit that
    /// touches the closed cell with a side that is drawn towards it is visible by definition. A pure function of
    /// scene, cell, options and the given bits (of which the result does not depend, but the time does).
    /// `hidden`: what no line from a cell around this one reaches; as hidden_parts() gives it.
    /// `cancel`, asked now and then, also within queries, may stop the work: then false is returned.
    bool solve(const GridBox& cell, std::vector<std::uint64_t>& visible, CellCounters& counters,
               const HiddenParts& hidden = {}, const std::atomic<bool>* cancel = nullptr);

    /// One triangle on its own, with no virtual occluders but those of the last solve(): is it visible?
    Answer ask_triangle(const GridBox& cell, std::uint32_t triangle, CellCounters& counters,
                        Witness* witness = nullptr);
    /// After solve(): the highest nodes proved hidden, and the triangles outside of these proved hidden one by one; what was
    /// handed to solve() among them.
    HiddenParts hidden_parts() const;
    /// After solve(): triangles proved hidden (at least one box or query each). For tests.
    std::vector<std::uint32_t> hidden_triangles() const;

  private:
    struct State;
    std::unique_ptr<State> state_;
};

} // namespace antumbra::exact
