#include "bake/exact/proof.hpp"
#include "base/random.hpp"
#include "evaluate/explain/sight_lines.hpp"
#include "rays/arbiter.hpp"

#include <antumbra/evaluate.hpp>
#include <antumbra/explain.hpp>

#include <algorithm>
#include <cmath>
#include <map>

namespace antumbra {

const char* to_string(Sight sight) {
    static constexpr const char* names[] = {"visible", "hidden", "undecided"};
    return names[std::size_t(sight)];
}

const char* to_string(CellState state) {
    static constexpr const char* names[] = {"baked", "solid", "not baked", "outside"};
    return names[std::size_t(state)];
}

struct Explainer::Parts {
    const Scene& scene;
    const Pvs& pvs;
    Tracer tracer;
    exact::SceneTree tree;

    exact::GridBox grid_box(const Box3d& world) const;
    Box3d world_box(const exact::GridBox& box) const;
    void find_cell(Explanation& explanation, Box3d& cell) const;
    void prove(const exact::GridBox& box, std::uint32_t object, const ExplainOptions& options, const Job& job,
               SightAnswer& answer) const;
    SightAnswer from_box(const Box3d& local, const exact::GridBox& box, std::uint32_t object,
                         const ExplainOptions& options, const Job& job) const;
};

namespace {

/// Beyond this the solver does not go: 2^24 grid steps from the scene's origin.
bool in_range(const exact::GridBox& box) {
    constexpr std::int64_t kLargest = 1 << 24;
    for (int k = 0; k < 3; ++k)
        if (box.min[k] <= -kLargest || box.max[k] >= kLargest)
            return false;
    return true;
}

/// The view box of a leaf: the way to it from the root.
ViewRegion region_of(const ViewTree& tree, std::uint32_t leaf) {
    ViewRegion region;
    for (std::uint32_t at = 0; at != leaf;) {
        const ViewNode& node = tree.nodes[at];
        if (leaf >= node.link) {
            region.low[node.axis] = node.split;
            at = node.link;
        } else {
            region.high[node.axis] = node.split;
            ++at;
        }
    }
    return region;
}

Vec3d to_double(const Vec3<certify::Rational>& p) {
    return {p.x.convert_to<double>(), p.y.convert_to<double>(), p.z.convert_to<double>()};
}

} // namespace

/// Rounded outward.
exact::GridBox Explainer::Parts::grid_box(const Box3d& local) const {
    exact::GridBox box;
    constexpr double kFar = 0x1p40; // whoever is so far away is told so by in_range()
    for (int k = 0; k < 3; ++k) {
        box.min[k] = std::int64_t(std::clamp(std::floor(local.min[k] / scene.step()), -kFar, kFar));
        box.max[k] = std::int64_t(std::clamp(std::ceil(local.max[k] / scene.step()), -kFar, kFar));
        if (box.max[k] == box.min[k])
            ++box.max[k]; // the solver wants a volume
    }
    return box;
}

Box3d Explainer::Parts::world_box(const exact::GridBox& box) const {
    auto corner = [&](const GridPoint& p) {
        return scene.to_world(tree.to_local({double(p.x), double(p.y), double(p.z)}));
    };
    return {corner(box.min), corner(box.max)};
}

void Explainer::Parts::find_cell(Explanation& explanation, Box3d& cell) const {
    std::uint32_t row = kCellNotBaked;
    if (pvs.tree().nodes.empty()) {
        explanation.cell = pvs.grid().find(explanation.eye);
        if (explanation.cell < 0)
            return;
        cell = pvs.grid().cell(std::uint64_t(explanation.cell));
        row = pvs.cell_row(std::uint64_t(explanation.cell));
    } else {
        std::vector<std::uint32_t> leaves;
        ViewRange around{{explanation.eye, explanation.eye}, true, {}};
        if (!pvs.tree().find_leaves(around, leaves) || leaves.empty())
            return;
        explanation.cell = leaves.front();
        cell = pvs.tree().spatial_box(region_of(pvs.tree(), leaves.front()));
        row = pvs.tree().nodes[leaves.front()].link;
    }
    explanation.state = row == kCellSolid      ? CellState::solid
                        : row == kCellNotBaked ? CellState::not_baked
                                               : CellState::baked;
}

/// Fills in what the exact method says of the box.
void Explainer::Parts::prove(const exact::GridBox& box, std::uint32_t object, const ExplainOptions& options,
                             const Job& job, SightAnswer& answer) const {
    exact::ProofLimits limits{options.most_queries, options.most_pieces, [&job] { return job.cancelled(); }};
    exact::Prover prover(tree, limits);
    exact::PairProof proof = prover.prove(box, object);
    switch (proof.answer) {
    case exact::Answer::visible:
        answer.sight = Sight::visible;
        answer.touches = proof.by_definition;
        if (!proof.by_definition)
            answer.witness = SightLine{scene.to_world(tree.to_local(to_double(proof.witness.p))),
                                       scene.to_world(tree.to_local(to_double(proof.witness.q))), proof.triangle};
        break;
    case exact::Answer::hidden:
        answer.sight = Sight::hidden;
        break;
    case exact::Answer::undecided:
        answer.sight = Sight::undecided;
        break;
    }
    std::map<std::uint32_t, std::map<std::uint32_t, std::uint64_t>> leaves; // object, triangle: leaves that it blocks
    std::uint64_t nodes = 0;
    answer.parts = proof.parts.size();
    for (const exact::HiddenPart& part : proof.parts) {
        nodes += part.tree.nodes.size();
        for (const certify::HiddenTree::Node& node : part.tree.nodes) {
            ++(node.kind == certify::HiddenTree::Kind::split ? answer.splits : answer.leaves);
            if (node.kind == certify::HiddenTree::Kind::blocked) {
                std::uint32_t triangle = part.blockers[node.occluder];
                ++leaves[scene.triangle_objects()[triangle]][triangle];
            }
        }
    }
    if (answer.sight != Sight::undecided && nodes <= options.verify_nodes)
        answer.verified = exact::verify_proof(tree, proof).ok();
    for (const auto& [hider, triangles] : leaves) {
        auto known = std::find_if(answer.hiders.begin(), answer.hiders.end(),
                                  [&, id = hider](const Hider& h) { return h.object == id; });
        if (known == answer.hiders.end())
            known = answer.hiders.insert(answer.hiders.end(), Hider{hider, 0, 0, {}});
        for (auto [triangle, count] : triangles) {
            known->leaves += count;
            known->triangles.push_back(triangle);
        }
    }
}

SightAnswer Explainer::Parts::from_box(const Box3d& local, const exact::GridBox& box, std::uint32_t object,
                                       const ExplainOptions& options, const Job& job) const {
    SightAnswer answer;
    answer.from = {scene.to_world(local.min), scene.to_world(local.max)};
    explain::aim(tracer, local, object, options.sight_lines, options.seed, answer);
    bool seen = answer.sight == Sight::visible;
    if (!seen && options.prove && in_range(box)) {
        answer.from = world_box(box);
        prove(box, object, options, job, answer);
    }
    if (answer.sight == Sight::visible)
        answer.hiders.clear();
    for (Hider& hider : answer.hiders) {
        std::sort(hider.triangles.begin(), hider.triangles.end());
        hider.triangles.erase(std::unique(hider.triangles.begin(), hider.triangles.end()), hider.triangles.end());
    }
    std::sort(answer.hiders.begin(), answer.hiders.end(), [](const Hider& a, const Hider& b) {
        if ((a.leaves > 0) != (b.leaves > 0))
            return a.leaves > 0;
        return a.share != b.share ? a.share > b.share : a.leaves != b.leaves ? a.leaves > b.leaves : a.object < b.object;
    });
    return answer;
}

Explainer::Explainer(std::unique_ptr<Parts> parts) : parts_(std::move(parts)) {}
Explainer::~Explainer() = default;
Explainer::Explainer(Explainer&&) noexcept = default;
Explainer& Explainer::operator=(Explainer&&) noexcept = default;
const Scene& Explainer::scene() const { return parts_->scene; }
const Pvs& Explainer::pvs() const { return parts_->pvs; }

Result<Explainer> Explainer::create(const Scene& scene, const Pvs& pvs, const Job& job) {
    if (Status status = check_belongs(scene, pvs); !status)
        return status;
    Tracer tracer = Tracer::build(scene, job);
    return Explainer(std::make_unique<Parts>(Parts{scene, pvs, std::move(tracer), exact::SceneTree::build(scene)}));
}

Result<Explanation> Explainer::explain(const Vec3d& eye, std::uint32_t object, const ExplainOptions& options,
                                       const Job& job) const {
    const Parts& parts = *parts_;
    if (object >= parts.scene.objects().size())
        return Status(ErrorCode::usage, "there is no object " + std::to_string(object) + "; the scene has " +
                                            std::to_string(parts.scene.objects().size()));
    if (!is_finite(eye))
        return Status(ErrorCode::usage, "the eye is not finite");
    Explanation explanation;
    explanation.object = object;
    explanation.eye = eye;
    explanation.always_visible = parts.scene.objects()[object].has(kAlwaysVisible);
    Box3d cell;
    parts.find_cell(explanation, cell);
    PvsCursor cursor;
    parts.pvs.query(eye, cursor);
    explanation.listed = cursor.everything || (cursor.visible[object / 64] >> (object % 64) & 1);
    for (std::uint32_t c = parts.pvs.first_cluster_of(object); c < parts.pvs.first_cluster_of(object + 1); ++c) {
        ++explanation.clusters;
        explanation.clusters_listed += explanation.listed && parts.pvs.is_cluster_visible(c, cursor);
    }
    explanation.guarantee = cursor.everything ? Guarantee::conservative : parts.pvs.guarantee();
    Vec3d local = parts.scene.to_local(eye);
    explanation.from_eye = parts.from_box({local, local}, parts.grid_box({local, local}), object, options, job);
    if (explanation.cell >= 0) {
        Box3d box{parts.scene.to_local(cell.min), parts.scene.to_local(cell.max)};
        explanation.from_cell = parts.from_box(box, parts.grid_box(box), object, options, job);
    }
    return explanation;
}

} // namespace antumbra
