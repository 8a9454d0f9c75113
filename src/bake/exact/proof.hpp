// Proofs of single (cell, object) pairs, and files checked by them: every answer is derived again without sampling and
// without virtual occluders, and its certificate goes through the independent verifier.
#pragma once

#include "bake/exact/occluders_along.hpp"
#include "certify/verifier.hpp"

#include <antumbra/job.hpp>
#include <antumbra/pvs.hpp>

#include <functional>

namespace antumbra::exact {

/// A box (of the scene's tree) or a triangle that no line from a face of the cell reaches.
struct HiddenPart {
    certify::Polygon from, part; ///< a face of the cell; a face of the box, or the triangle
    std::vector<std::uint32_t> blockers; ///< triangles, in the numbering of `tree`
    certify::HiddenTree tree;
};

struct PairProof {
    Answer answer = Answer::undecided;
    bool by_definition = false; ///< visible because it touches the cell
    // visible: the segment from the face `from` of the cell to `triangle`
    certify::Polygon from, to;
    std::uint32_t triangle = 0;
    certify::WitnessSegment witness;
    // hidden: every part of the object, as boxes or triangles
    std::vector<HiddenPart> parts;
    std::vector<GridBox> boxes; ///< that hold them; triangles outside of all boxes are parts themselves
};

/// Budgets of one proof; beyond them the answer is `undecided`.
struct ProofLimits {
    std::uint64_t queries = UINT64_MAX; ///< pairs of polygons
    std::uint32_t pieces = 100000;      ///< of line space, in each
    std::function<bool()> cancelled;    ///< asked before each query, if there
};

/// Derives a proof. Not thread-safe; one per thread. Refers to the tree.
class Prover {
  public:
    explicit Prover(const SceneTree& tree, ProofLimits limits = {});
    /// `cell` on the grid, with a volume. `unit`: of the tree; an object, if it was built without units.
    PairProof prove(const GridBox& cell, std::uint32_t unit);

  private:
    bool hide_box(const GridBox& cell, const GridBox& box, PairProof& proof);
    bool hide_triangle(const GridBox& cell, std::uint32_t triangle, PairProof& proof);
    bool ask(const certify::Polygon& from, const certify::Polygon& to, PairProof& proof, QueryResult& result);

    const SceneTree& tree_;
    ProofLimits limits_;
    std::uint64_t queries_ = 0; ///< of the proof under way
    OccludersAlong occluders_;
    Query query_;
};

/// Hands the proof to the verifier. A witness is tested against every triangle whose box its own box touches.
Status verify_proof(const SceneTree& tree, const PairProof& proof);

} // namespace antumbra::exact

namespace antumbra {

struct CertificateOptions {
    std::uint32_t pairs = 32; ///< (cell, object) pairs to prove, half of them listed, half not
    std::uint64_t seed = 1;
};

struct CertificateResult {
    std::uint64_t pairs = 0, visible = 0, hidden = 0, by_definition = 0, undecided = 0;
    std::uint64_t trees = 0, nodes = 0;   ///< of the hidden certificates
    std::uint64_t rejected = 0;           ///< proofs that the verifier refused: defects of the solver
    std::uint64_t listed_but_hidden = 0;  ///< false visible
    std::uint64_t visible_but_unlisted = 0; ///< false invisible
    std::string first_problem;            ///< in words, "" if there is none
};

/// Proves random pairs of cell and object (where the file lists clusters: cell and cluster) and compares them with the file.
/// ErrorCode::mismatch if the file belongs to another scene, usage if its cells are no boxes on the scene's own grid.
Result<CertificateResult> check_certificates(const Scene& scene, const Pvs& pvs, const CertificateOptions& options,
                                             const Job& job = {});

} // namespace antumbra
