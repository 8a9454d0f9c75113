#include "bake/exact/query.hpp"

#include "bake/exact/solver.hpp"

namespace antumbra::exact {

bool OccluderList::near_segment(const Vec3d&, const Vec3d&, std::size_t, std::vector<OccluderId>& found) {
    for (std::size_t k = 0; k < polygons_.size(); ++k)
        found.push_back(static_cast<OccluderId>(k));
    return false;
}

bool OccluderList::in_hull(std::span<const GridPlane>, std::vector<OccluderId>& found) {
    for (std::size_t k = 0; k < polygons_.size(); ++k)
        found.push_back(static_cast<OccluderId>(k));
    return true;
}

void QueryCounters::add(const QueryCounters& o) {
    pieces += o.pieces;
    subtractions += o.subtractions;
    splits += o.splits;
    crossing_tests += o.crossing_tests;
    known += o.known;
    pairs += o.pairs;
    triples += o.triples;
    hulls += o.hulls;
    prisms += o.prisms;
    exact_witnesses += o.exact_witnesses;
    witness_retries += o.witness_retries;
    widened += o.widened;
    broken += o.broken;
    single_cover += o.single_cover;
    random_witness += o.random_witness;
    patches_tried += o.patches_tried;
    patches_proved += o.patches_proved;
    most_vertices = std::max(most_vertices, o.most_vertices);
    arithmetic.add(o.arithmetic);
}

struct Query::Solvers {
    Solver<true, 2> filtered;
    Solver<false, 2> plain;
    std::unique_ptr<Solver<false, 16>> wide; // hardly ever needed
};

Query::Query() : solvers_(std::make_unique<Solvers>()) {}
Query::~Query() = default;
Query::Query(Query&&) noexcept = default;
Query& Query::operator=(Query&&) noexcept = default;

QueryResult Query::run(std::span<const GridPoint> s, std::span<const GridPoint> t, OccluderSource& occluders,
                       const QueryOptions& options) {
    QueryResult result;
    RunStatus status = options.filtered ? solvers_->filtered.run(s, t, occluders, options, result)
                                        : solvers_->plain.run(s, t, occluders, options, result);
    if (status == RunStatus::done)
        return result;
    // Too many facets for the small sets, or a broken invariant: once more, in integers and with room.
    ++result.counters.widened;
    if (!solvers_->wide)
        solvers_->wide = std::make_unique<Solver<false, 16>>();
    QueryOptions slow = options;
    slow.filtered = false;
    slow.start = Start::prism_or_hull;
    if (solvers_->wide->run(s, t, occluders, slow, result) == RunStatus::overflow)
        result.answer = Answer::undecided;
    return result;
}

certify::WitnessSegment to_rational(const Witness& witness) {
    auto point = [](const Homogeneous& p) {
        certify::Integer weight(p[3]);
        return Vec3<certify::Rational>{certify::Rational(certify::Integer(p[0]), weight),
                                       certify::Rational(certify::Integer(p[1]), weight),
                                       certify::Rational(certify::Integer(p[2]), weight)};
    };
    return {point(witness.p), point(witness.q)};
}

} // namespace antumbra::exact
