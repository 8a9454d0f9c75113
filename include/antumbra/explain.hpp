// Why an object is visible or hidden: from one viewpoint and from the whole view cell around it, each with a proof, beside
// what a baked file says.
#pragma once

#include <antumbra/job.hpp>
#include <antumbra/pvs.hpp>
#include <antumbra/scene.hpp>

#include <memory>
#include <optional>

namespace antumbra {

struct ExplainOptions {
    std::uint32_t sight_lines = 2048; ///< aimed at the object, from the eye and from the cell each
    bool prove = true;                ///< false: sight lines alone; what they do not see stays `undecided`
    /// Budgets of the proof: pairs of polygons asked for, and pieces of line space in each of these. Beyond them the
    /// answer is `undecided`.
    std::uint64_t most_queries = 20000;
    std::uint32_t most_pieces = 20000;
    /// A certificate of at most so many nodes is handed to the independent verifier, too (0.1 to 10 ms a node).
    std::uint64_t verify_nodes = 1000;
    std::uint64_t seed = 1;
};

enum class Sight : std::uint8_t {
    visible,   ///< proved: by a witness, or because it touches
    hidden,    ///< proved by a certificate: no open set of lines gets through
    undecided, ///< no sight line got through, and no proof was asked for or its budget ran out
};
const char* to_string(Sight sight);

/// One line of sight, world coordinates.
struct SightLine {
    Vec3d from, to;
    std::uint32_t triangle = 0; ///< of the scene: what it ends on
};

/// An object that hides.
struct Hider {
    std::uint32_t object = 0;
    double share = 0;             ///< of the sight lines aimed at the object: those that met this one first
    std::uint64_t leaves = 0;     ///< leaves of the certificate that it blocks
    std::vector<std::uint32_t> triangles; ///< of the scene, ascending: those that took part
};

/// The answer from one box of viewpoints.
struct SightAnswer {
    Sight sight = Sight::undecided;
    Box3d from;                       ///< the box of viewpoints that the answer speaks of (world)
    bool touches = false;             ///< visible by definition: the object touches the closed box
    std::optional<SightLine> witness; ///< visible and not by touching
    std::uint32_t sight_lines = 0, lines_through = 0; ///< aimed at the object, and those that nothing blocked
    double undrawn = 0;               ///< share of them that arrive only at a side that is not drawn, or graze an edge
    /// Only if not visible. First those that block leaves of the certificate, which together are enough to hide it; then
    /// those that are in the way of sight lines, too. Within each most share first, then most leaves, then lowest id.
    std::vector<Hider> hiders;
    std::uint64_t parts = 0;          ///< hidden: boxes and triangles that the certificate hides, each from one face
    std::uint64_t splits = 0, leaves = 0; ///< of line space, over all parts
    bool verified = false;            ///< the independent verifier accepted the certificate or the witness
};

enum class CellState : std::uint8_t { baked, solid, not_baked, outside };
const char* to_string(CellState state);

struct Explanation {
    std::uint32_t object = 0;
    Vec3d eye;                   ///< world
    std::int64_t cell = -1;      ///< grid: the cell; view tree: the node of the first leaf around the eye; -1: outside
    CellState state = CellState::outside;
    bool listed = true;          ///< what the file says: visible from there
    /// Of a file that lists clusters: those of the object, and how many of them it lists there.
    std::uint32_t clusters = 0, clusters_listed = 0;
    bool always_visible = false; ///< the object is never culled, whatever is in the way
    Guarantee guarantee = Guarantee::approximate; ///< of that: conservative where no cell answers
    SightAnswer from_eye;
    std::optional<SightAnswer> from_cell; ///< if there is a cell
};

/// Answers one question after the other about one scene and one file. Immutable; safe from any number of threads; refers
/// to both, which must outlive it.
class Explainer {
  public:
    /// ErrorCode::mismatch if the file was baked from another scene. O(n log n) for n triangles, about 300 bytes each.
    static Result<Explainer> create(const Scene& scene, const Pvs& pvs, const Job& job = {});
    ~Explainer();
    Explainer(Explainer&&) noexcept;
    Explainer& operator=(Explainer&&) noexcept;

    const Scene& scene() const;
    const Pvs& pvs() const;

    /// First sight lines, of which the exact arbiter decides each; one that gets through is the witness. If none does, the
    /// exact method asks for the object from the cell (docs/methods/exact.md), and from the box of one grid step around
    /// the eye: hidden from there is hidden from the eye. ErrorCode::usage if there is no such object or the eye is not
    /// finite. A pure function of its arguments. Milliseconds for what is seen; for what is hidden as long as the proof
    /// takes, within the budgets (mostly below a second). `cancel` leaves the rest undecided.
    Result<Explanation> explain(const Vec3d& eye, std::uint32_t object, const ExplainOptions& options = {},
                                const Job& job = {}) const;

  private:
    struct Parts;
    explicit Explainer(std::unique_ptr<Parts> parts);
    std::unique_ptr<Parts> parts_;
};

/// The object that a user means: a number is an index, else the one object of that name. ErrorCode::usage if there is none
/// or several (the message lists some).
Result<std::uint32_t> find_object(const Scene& scene, const std::string& name_or_index);

/// In words, several lines.
std::string explain_in_words(const Scene& scene, const Explanation& explanation);

/// One JSON object. Its keys, which stay: object {id, name, node, primitive, instance}, eye, cell {index, state, min, max},
/// pvs {listed, guarantee, always_visible, clusters, clusters_listed}, words, and `from_eye` and `from_cell` (null without a cell) {answer (visible,
/// hidden, undecided), from {min, max}, touches, witness {from, to, triangle, object} or null, sight_lines,
/// lines_through, undrawn, hiders [{id, name, share, leaves, triangles}], certificate {parts, splits, leaves, verified}}.
std::string explain_in_json(const Scene& scene, const Explanation& explanation);

/// As GLB, to be looked at together with the scene, in its coordinates: the object (green: visible; red: hidden; grey:
/// undecided), what hides it (blue; the triangles that took part in a lighter blue), witness lines (orange from the eye,
/// yellow from the cell), the cell's box (yellow) and a cross at the eye (white).
Result<std::vector<std::byte>> explain_as_glb(const Scene& scene, const Explanation& explanation);

/// The whole cell around an eye (world) as a drawing, as in figure 5 of Nirenstein, Blake and Gain 2002: the cell in yellow,
/// what the file lists in green, what it does not in red. Of a view tree, the leaves around the eye, all directions
/// together. ErrorCode::usage where no baked cell is, mismatch if the file belongs to another scene.
Result<std::vector<std::byte>> cell_as_glb(const Scene& scene, const Pvs& pvs, const Vec3d& eye);

struct LineSpaceOptions {
    std::uint32_t most_triangles = 64; ///< objects of more are asked for by the faces of their box
    std::uint32_t most_pieces = 2000;  ///< of one pair; beyond it the pair is "undecided"
    std::uint64_t seed = 1;
};

/// The complete set of unobstructed lines from the faces of a cell (world) to an object, as convex pieces of line space with
/// vertices and facets in whole numbers (docs/methods/exact.md, "The unobstructed complex"); method: the published form
/// (Nirenstein, Blake, Gain 2002). A JSON document. ErrorCode::usage for an object without triangles or a cell far away.
/// Cost: milliseconds to minutes a pair. A pure function of its arguments.
Result<std::string> line_space_in_json(const Scene& scene, const Box3d& cell, std::uint32_t object,
                                       const LineSpaceOptions& options = {}, const Job& job = {});

} // namespace antumbra
