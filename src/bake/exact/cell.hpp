// What is visible from one view cell, exactly (Nirenstein, Blake, Gain 2002, section 4).
//
// Objects that rays have found are taken as seen. The rest of the scene is walked from front to back: a box of the
// tree that no line from the cell reaches hides all that it holds, and from then on occludes as a solid itself
// (virtual occluder); a box that is reached is opened, and the line that reached it is followed to what it hits.
#pragma once

#include "bake/exact/query.hpp"
#include "bake/exact/scene_tree.hpp"
#include "rays/arbiter.hpp"

#include <functional>

namespace antumbra::exact {

struct CellOptions {
    std::uint32_t rays = 6;             ///< random lines per pair of faces, before any polytope
    std::uint32_t max_pieces = 20000;   ///< budget of one query; beyond it the answer is visible and counted
    bool virtual_occluders = true;      ///< false only to measure what they are worth
    bool patches = true;                ///< connected surfaces as single occluders; false only to measure
    bool filtered = true;               ///< false: the oracle
    std::uint64_t seed = 1;
};

struct CellCounters {
    std::uint64_t box_queries = 0, boxes_hidden = 0, triangle_queries = 0, triangles_hidden = 0;
    std::uint64_t pairs = 0;             ///< pairs of faces asked for
    std::uint64_t undecided = 0;         ///< triangles reported visible because a budget ran out
    std::uint64_t extended = 0;          ///< objects found by following the witness of a box
    std::uint64_t by_touch = 0;          ///< objects visible because they touch the cell
    QueryCounters query;
    void add(const CellCounters& other);
};

/// Why an object is visible. `p` lies in the closed cell, `q` on the triangle; in grid coordinates.
struct CellWitness {
    std::uint32_t triangle;
    Witness line;
};

/// Solves one cell after the other. Not thread-safe; one per thread. Refers to the tree and the tracer.
class CellSolver {
  public:
    CellSolver(const SceneTree& tree, const Tracer& tracer, const CellOptions& options = {});
    ~CellSolver();

    /// `cell`: closed box on the grid, with a volume. `visible`: bit set over objects, holding what is known to be
    /// visible; on return every object that is visible from some point of the cell, and no other. An object that
    /// touches the closed cell with a side that is drawn towards it is visible by definition. A pure function of
    /// scene, cell, options and the given bits (of which the result does not depend, but the time does).
    /// `cancelled`, asked now and then, may stop the work: then the rest is left visible and false returned.
    bool solve(const GridBox& cell, std::vector<std::uint64_t>& visible, CellCounters& counters,
               const std::function<bool()>& cancelled = {});

    /// One triangle on its own, with no virtual occluders but those of the last solve(): is it visible?
    Answer ask_triangle(const GridBox& cell, std::uint32_t triangle, CellCounters& counters,
                        Witness* witness = nullptr);
    /// After solve(): triangles proved hidden (at least one box or query each). For tests.
    std::vector<std::uint32_t> hidden_triangles() const;

  private:
    struct State;
    std::unique_ptr<State> state_;
};

} // namespace antumbra::exact
