// Trivial acceptance by rays (Nirenstein, Blake, Gain 2002, section 3.3), before and between exact queries: rays in
// all directions, then rays past the edges of what was just seen (in the manner of guided visibility sampling, Wonka et
// al. 2006), and the same around the witnesses of queries. Each new unit is proved by the arbiter of rays/.
#pragma once

#include "base/random.hpp"
#include "bake/exact/seen_units.hpp"
#include "rays/arbiter.hpp"

namespace antumbra::exact {

struct SamplerCounters {
    std::uint64_t rays = 0;
    std::uint64_t uniform = 0, guided = 0, mutated = 0, aimed = 0; ///< units found by each kind
    void add(const SamplerCounters& o) {
        rays += o.rays;
        uniform += o.uniform;
        guided += o.guided;
        mutated += o.mutated;
        aimed += o.aimed;
    }
};

/// One cell at a time. Not thread-safe. What it finds depends on the seed; what an exact cell lists does not.
class CellSampler {
  public:
    CellSampler(const SceneTree& tree, const Tracer& tracer, SeenUnits& seen);

    void begin(const GridBox& cell, std::uint64_t seed, SamplerCounters& counters);
    /// Rays in all directions from anywhere in the cell.
    void look_around(std::uint32_t rays);
    /// Follows the edges of what was found, until nothing more is or the rays are spent.
    void follow(std::uint32_t rays);
    /// Looks around and follows the edges of all that was found, again and again, from other eyes; until so few rays find
    /// something that exact queries cost less, or `rays` are spent.
    void explore(std::uint64_t rays);
    /// A triangle was found to be visible along the line from `eye` to `at` (grid coordinates): follow from there.
    void mutate(const Vec3d& eye, const Vec3d& at, std::uint32_t triangle);
    /// Rays from the cell at a triangle that is not seen. True: its unit is seen now.
    bool aim_at_triangle(std::uint32_t triangle, std::uint32_t rays);
    /// Rays from the cell at a box. True: one came in, as far as doubles can tell (no proof).
    bool aim_at_box(std::uint32_t node, std::uint32_t rays);
    /// Did some ray come into this node's box, as far as doubles can tell? To open a box needs no proof.
    bool reached(std::uint32_t node) const { return reached_[node] != 0; }
    /// Does the line through two points (grid coordinates) come from the cell and reach the node's box? No proof.
    bool try_line(const Vec3d& p, const Vec3d& q, std::uint32_t node);
    /// An unblocked line from `eye` to `at` (grid coordinates), and as far beyond as a ray gets: marks what it reaches.
    void mark_line(const Vec3d& eye, const Vec3d& at);

  private:
    enum class Kind : std::uint8_t { uniform, guided, mutated, aimed };
    /// A line that ended on a triangle: its edges are to be followed.
    struct Lead {
        Vec3d eye; ///< local
        std::uint32_t triangle;
        Kind kind;
    };
    Vec3d random_eye();
    double cast(const Vec3d& eye, const Vec3d& direction, Kind kind);
    void mark(const Vec3d& eye, const Vec3d& direction, double end);
    void follow_edges(const Lead& lead);

    const SceneTree& tree_;
    const Tracer& tracer_;
    const Scene& scene_;
    Arbiter arbiter_;
    SeenUnits& seen_;
    SamplerCounters* counters_ = nullptr;
    Box3d cell_; ///< local
    Random random_{0};
    std::vector<Lead> leads_;
    std::vector<Lead> found_; ///< by looking around and following, to be followed again
    std::size_t next_lead_ = 0;
    std::vector<std::uint32_t> hits_;
    std::vector<std::uint8_t> reached_; ///< per node
    std::vector<Vec3f> eye_;            ///< per node reached: from where, local
    std::vector<std::uint32_t> touched_, stack_;
};

} // namespace antumbra::exact
