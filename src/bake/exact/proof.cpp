#include "bake/exact/proof.hpp"

#include "bake/exact/baked_cells.hpp"
#include "bake/exact/frame.hpp"
#include "base/collect.hpp"
#include "base/random.hpp"

#include <algorithm>

namespace antumbra::exact {
namespace {

certify::Polygon polygon_of(std::span<const GridPoint> corners, bool both_sides = true) {
    return {{corners.begin(), corners.end()}, both_sides};
}

certify::Polygon triangle_of(const SceneTree& tree, std::uint32_t t) {
    return polygon_of(tree.corners(t), tree.both_sides(t));
}

bool reaches_beyond(const GridBox& box, const GridBox& cell, int axis, int side) {
    return side ? box.max[axis] > cell.max[axis] : box.min[axis] < cell.min[axis];
}

GridBox box_of(std::span<const GridPoint> corners) {
    GridBox box;
    for (const GridPoint& p : corners)
        box.extend(p);
    return box;
}

} // namespace

Prover::Prover(const SceneTree& tree, ProofLimits limits)
    : tree_(tree), limits_(std::move(limits)), occluders_(tree) {}

/// True if the pair is hidden, with a certificate; else `result` says visible or undecided.
bool Prover::ask(const certify::Polygon& from, const certify::Polygon& to, PairProof& proof, QueryResult& result) {
    QueryOptions options;
    options.certificate = true;
    options.rays = 4;
    options.max_pieces = limits_.pieces;
    if (queries_ >= limits_.queries || (limits_.cancelled && limits_.cancelled())) {
        result.answer = Answer::undecided;
        return false;
    }
    ++queries_;
    result = query_.run(from.corners, to.corners, occluders_, options);
    if (result.answer != Answer::hidden)
        return false;
    if (!result.tree.nodes.empty()) // else nothing of them faces each other
        proof.parts.push_back({from, to, result.blockers, std::move(result.tree)});
    return true;
}

bool Prover::hide_box(const GridBox& cell, const GridBox& box, PairProof& proof) {
    std::size_t before = proof.parts.size();
    QueryResult result;
    for (int from = 0; from < 6; ++from)
        for (int to = 0; to < 6; ++to) {
            int b = (to / 2 + 1) % 3, c = (to / 2 + 2) % 3;
            if (!reaches_beyond(box, cell, from / 2, from % 2) || !reaches_beyond(cell, box, to / 2, to % 2) ||
                box.min[b] == box.max[b] || box.min[c] == box.max[c])
                continue;
            if (!ask(polygon_of(face_of(cell, from / 2, from % 2)), polygon_of(face_of(box, to / 2, to % 2)), proof,
                     result)) {
                proof.parts.resize(before);
                return false;
            }
        }
    proof.boxes.push_back(box);
    return true;
}

/// False: it is visible (or undecided), and the proof is finished.
bool Prover::hide_triangle(const GridBox& cell, std::uint32_t t, PairProof& proof) {
    certify::Polygon triangle = triangle_of(tree_, t);
    std::size_t triple[3];
    GridPlane plane = plane_of(triangle.corners, triple);
    bool side[2] = {false, false}; // some of the cell in front of it, behind it
    for (int i = 0; i < 8; ++i) {
        GridPoint p{i & 1 ? cell.max.x : cell.min.x, i & 2 ? cell.max.y : cell.min.y, i & 4 ? cell.max.z : cell.min.z};
        Int128 at = plane.at(p);
        side[0] |= at > 0;
        side[1] |= at < 0;
    }
    side[1] &= triangle.both_sides;
    if (touches(cell, tree_.corners(t))) {
        if (!side[0] && !side[1])
            return true;
        proof.answer = Answer::visible;
        proof.by_definition = true;
        proof.triangle = t;
        return false;
    }
    GridBox box = box_of(triangle.corners);
    for (int turned = 0; turned < 2; ++turned) {
        if (side[turned])
            for (int from = 0; from < 6; ++from) {
                if (!reaches_beyond(box, cell, from / 2, from % 2))
                    continue;
                certify::Polygon face = polygon_of(face_of(cell, from / 2, from % 2));
                QueryResult result;
                if (ask(face, triangle, proof, result))
                    continue;
                proof.answer = result.answer;
                if (result.answer == Answer::visible) {
                    proof.from = face;
                    proof.to = triangle;
                    proof.triangle = t;
                    proof.witness = to_rational(result.witness);
                }
                return false;
            }
        std::swap(triangle.corners[1], triangle.corners[2]);
    }
    return true;
}

PairProof Prover::prove(const GridBox& cell, std::uint32_t unit) {
    PairProof proof;
    queries_ = 0;
    const auto& nodes = tree_.nodes();
    std::uint32_t root = tree_.root_of(unit);
    std::vector<std::uint32_t> open;
    if (root < nodes.size())
        open.push_back(root);
    while (!open.empty()) {
        const SceneTree::Node& node = nodes[open.back()];
        open.pop_back();
        if (node.count > 2 && !cell.touches(node.box) && hide_box(cell, node.box, proof))
            continue;
        if (node.children != 0) {
            open.push_back(node.children + 1);
            open.push_back(node.children);
            continue;
        }
        for (std::uint32_t i = node.first; i < node.first + node.count; ++i)
            if (!hide_triangle(cell, tree_.order()[i], proof)) {
                proof.parts.clear();
                proof.boxes.clear();
                return proof;
            }
    }
    proof.answer = Answer::hidden;
    return proof;
}

Status verify_proof(const SceneTree& tree, const PairProof& proof) {
    if (proof.answer == Answer::visible && !proof.by_definition) {
        // The box of the segment, rounded outward: all that can be in its way touches it.
        GridBox around;
        for (const auto& end : {proof.witness.p, proof.witness.q}) {
            GridPoint low;
            for (int k = 0; k < 3; ++k)
                low[k] = static_cast<std::int64_t>(certify::Integer(numerator(end[k]) / denominator(end[k]))) - 1;
            around.extend(low);
            around.extend(low + GridPoint{2, 2, 2});
        }
        std::vector<certify::Polygon> occluders;
        for (std::uint32_t t = 0; t < tree.corners_count(); ++t)
            if (tree.occludes(t) && box_of(tree.corners(t)).touches(around))
                occluders.push_back(triangle_of(tree, t));
        return certify::verify_witness(proof.from, proof.to, occluders, proof.witness);
    }
    for (const HiddenPart& part : proof.parts) {
        std::vector<certify::Polygon> blockers;
        for (std::uint32_t t : part.blockers)
            blockers.push_back(triangle_of(tree, t));
        if (Status status = certify::verify_hidden(part.from, part.part, blockers, part.tree); !status)
            return status;
    }
    return {};
}

} // namespace antumbra::exact

namespace antumbra {
namespace {

struct Pair {
    exact::BakedCell cell;
    std::uint32_t unit = 0;
    bool listed = false;
};

/// Random pairs, listed and not in turn, among cells that were baked and what is not always listed.
std::vector<Pair> choose_pairs(const exact::SceneTree& tree, const Pvs& pvs, const std::vector<exact::BakedCell>& cells,
                               const CertificateOptions& options) {
    std::vector<Pair> pairs;
    std::vector<std::uint64_t> row(pvs.words_per_row());
    Random random(options.seed, 0x63657274);
    for (std::uint64_t tries = 0; pvs.object_count() > 0 && pairs.size() < options.pairs &&
                                  tries < 64 * std::uint64_t(options.pairs);
         ++tries) {
        Pair pair;
        pair.cell = cells[random.below(static_cast<std::uint32_t>(cells.size()))];
        pair.unit = random.below(tree.units().count());
        pvs.decode_row(pair.cell.row, row);
        std::size_t bit = exact::bit_of(pvs, pair.unit);
        pair.listed = row[bit / 64] >> (bit % 64) & 1;
        bool wanted = pairs.size() % 2 == 0;
        // After half the tries any pair will do: the file may list everything, or nothing.
        if ((pair.listed == wanted || tries >= 32 * std::uint64_t(options.pairs)) &&
            !exact::is_always_visible(tree.scene(), pvs, tree.units(), pair.unit))
            pairs.push_back(pair);
    }
    return pairs;
}

/// Adds one proof; what is wrong with it in words, or "".
std::string count(const exact::PairProof& proof, const Status& verified, bool listed, CertificateResult& result) {
    ++result.pairs;
    for (const exact::HiddenPart& part : proof.parts) {
        ++result.trees;
        result.nodes += part.tree.nodes.size();
    }
    if (!verified) {
        ++result.rejected;
        return verified.message();
    }
    if (proof.answer == exact::Answer::undecided) {
        ++result.undecided;
        return {};
    }
    if (proof.answer == exact::Answer::visible) {
        ++(proof.by_definition ? result.by_definition : result.visible);
        result.visible_but_unlisted += !listed;
        return listed ? "" : "proved visible, but not listed";
    }
    ++result.hidden;
    result.listed_but_hidden += listed;
    return listed ? "proved hidden, but listed" : "";
}

} // namespace

Result<CertificateResult> check_certificates(const Scene& scene, const Pvs& pvs, const CertificateOptions& options,
                                             const Job& job) {
    if (pvs.scene_fingerprint() != scene.fingerprint() || pvs.object_count() != scene.objects().size())
        return Status(ErrorCode::mismatch, "the file was baked from another scene; bake it again");
    Result<std::vector<exact::BakedCell>> cells = exact::baked_cells(pvs);
    if (!cells)
        return cells.status();
    Result<exact::Units> units = exact::units_of(scene, pvs);
    if (!units)
        return units.status();
    exact::SceneTree tree = exact::SceneTree::build(scene, std::move(*units));
    std::vector<Pair> pairs = choose_pairs(tree, pvs, *cells, options);
    if (pairs.empty())
        return Status(ErrorCode::usage, "every object of the file is always visible: there is nothing to prove");
    CertificateResult result;
    std::vector<std::string> problems(pairs.size());
    struct Part {
        exact::PairProof proof;
        Status verified;
    };
    auto prove = [&](std::size_t index, unsigned) {
        const Box3d& cell = pairs[index].cell.box;
        exact::GridBox box{tree.to_grid(scene.to_local(cell.min)), tree.to_grid(scene.to_local(cell.max))};
        exact::Prover prover(tree);
        Part part{prover.prove(box, pairs[index].unit), {}};
        part.verified = exact::verify_proof(tree, part.proof);
        return part;
    };
    auto take = [&](std::size_t index, const Part& part) {
        const Pair& pair = pairs[index];
        std::string problem = count(part.proof, part.verified, pair.listed, result);
        if (!problem.empty())
            problems[index] = "cell " + std::to_string(pair.cell.number) + ", " + exact::name_of_unit(pvs, pair.unit) + ": " + problem;
    };
    if (Status status = collect(pairs.size(), job, "certify", "pairs", prove, take); !status)
        return status;
    result.first_problem = first_problem(problems);
    return result;
}

} // namespace antumbra
