#include "bake/exact/query.hpp"

#include "bake/exact/solver.hpp"

#include <algorithm>

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
    sphere_tests += o.sphere_tests;
    sphere_rejected += o.sphere_rejected;
    faces += o.faces;
    edges_clipped += o.edges_clipped;
    later_rays += o.later_rays;
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

bool LineSpace::may_cross(std::span<const GridPoint> polygon) {
    std::vector<HalfSpace> edges;
    for (std::size_t i = 0; i < polygon.size(); ++i)
        if (const GridPoint &a = polygon[i], &b = polygon[(i + 1) % polygon.size()]; a != b)
            edges.push_back(store_.edge(a - origin_, b - origin_));
    return std::any_of(cones_.begin(), cones_.end(), [&](const Cone& cone) {
        return std::none_of(edges.begin(), edges.end(), [&](const HalfSpace& edge) {
            return std::all_of(cone.vertices.begin(), cone.vertices.end(),
                               [&](VertexId v) { return store_.sign(edge.hyperplane, v) * edge.sign >= 0; });
        });
    });
}

std::vector<Six> LineSpace::cone(std::size_t k) {
    std::vector<Six> out;
    for (VertexId v : cones_[k].vertices) {
        Six x = store_.exact(v);
        for (std::size_t c = 0; c < 3; ++c) { // the moment about the grid's origin: m + origin x d
            std::size_t i = (c + 1) % 3, j = (c + 2) % 3;
            x[3 + c] += x[j] * origin_[static_cast<int>(i)] - x[i] * origin_[static_cast<int>(j)];
        }
        out.push_back(x);
    }
    return out;
}

std::vector<std::vector<std::uint32_t>> LineSpace::facets(std::size_t k) const {
    const auto& faces = cones_[k].faces;
    std::vector<std::vector<std::uint32_t>> below(faces[0].size()); // vertices of each face of one dimension
    for (std::uint32_t v = 0; v < below.size(); ++v)
        below[v] = {v};
    for (std::size_t dimension = 1; dimension < 5; ++dimension) {
        std::vector<std::vector<std::uint32_t>> level;
        for (const std::vector<std::uint32_t>& parts : faces[dimension]) {
            std::vector<std::uint32_t> vertices;
            for (std::uint32_t part : parts)
                vertices.insert(vertices.end(), below[part].begin(), below[part].end());
            std::sort(vertices.begin(), vertices.end());
            vertices.erase(std::unique(vertices.begin(), vertices.end()), vertices.end());
            level.push_back(std::move(vertices));
        }
        below = std::move(level);
    }
    return below;
}

std::array<std::uint64_t, 5> LineSpace::face_counts(std::size_t k) const {
    std::array<std::uint64_t, 5> counts;
    for (std::size_t dimension = 0; dimension < 5; ++dimension)
        counts[dimension] = cones_[k].faces[dimension].size();
    return counts;
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
