// The unobstructed lines from a cell to an object, all of them, as a document.
#include "bake/exact/complex.hpp"
#include "bake/exact/occluders_along.hpp"

#include <antumbra/explain.hpp>

#include <cmath>
#include <nlohmann/json.hpp>

namespace antumbra {
namespace {

using Json = nlohmann::ordered_json;
using exact::GridBox;

constexpr std::uint32_t kRays = 200, kShareSamples = 2000;

Json point_json(const GridPoint& p) { return {p.x, p.y, p.z}; }

Json polygon_json(std::span<const GridPoint> polygon) {
    Json corners = Json::array();
    for (const GridPoint& p : polygon)
        corners.push_back(point_json(p));
    return corners;
}

Json six_json(const exact::Six& x) {
    Json numbers = Json::array();
    for (const auto& value : x)
        numbers.push_back(value.str());
    return numbers;
}

Json pieces_json(std::span<const exact::ComplexPiece> pieces) {
    Json list = Json::array();
    for (const exact::ComplexPiece& piece : pieces) {
        Json one{{"faces", piece.faces}, {"vertices", Json::array()}, {"facets", Json::array()}};
        for (const exact::Six& vertex : piece.vertices)
            one["vertices"].push_back(six_json(vertex));
        for (const exact::ComplexFacet& facet : piece.facets)
            one["facets"].push_back({{"hyperplane", six_json(facet.hyperplane)}, {"vertices", facet.vertices}});
        list.push_back(std::move(one));
    }
    return list;
}

class Writer {
  public:
    Writer(const Scene& scene, const exact::SceneTree& tree, const LineSpaceOptions& options)
        : scene_(scene), tree_(tree), occluders_(tree), options_(options) {}

    Json write(const GridBox& cell, std::uint32_t object, const Job& job) {
        std::vector<std::pair<std::string, std::vector<GridPoint>>> targets;
        const Object& asked = scene_.objects()[object];
        GridBox box;
        for (std::uint32_t t = asked.first_triangle; t < asked.first_triangle + asked.triangle_count; ++t)
            for (const GridPoint& p : tree_.corners(t))
                box.extend(p);
        if (asked.triangle_count <= options_.most_triangles) {
            for (std::uint32_t t = asked.first_triangle; t < asked.first_triangle + asked.triangle_count; ++t) {
                const auto& c = tree_.corners(t);
                targets.push_back({"triangle " + std::to_string(t - asked.first_triangle), {c[0], c[1], c[2]}});
                if (tree_.both_sides(t))
                    targets.push_back({"triangle " + std::to_string(t - asked.first_triangle) + ", back", {c[0], c[2], c[1]}});
            }
        } else {
            for (int face = 0; face < 6; ++face) {
                auto corners = exact::face_of(box, face / 2, face % 2);
                targets.push_back({"box face " + std::to_string(face), {corners.begin(), corners.end()}});
            }
        }
        Json pairs = Json::array();
        for (int face = 0; face < 6; ++face) {
            auto from = exact::face_of(cell, face / 2, face % 2);
            bool reaches = face % 2 ? box.max[face / 2] > cell.max[face / 2] : box.min[face / 2] < cell.min[face / 2];
            for (const auto& [name, target] : targets)
                if (reaches && !job.cancelled())
                    if (Json pair = ask(from, target); !pair.is_null())
                        pairs.push_back(Json{{"cell_face", face}, {"target", name}}), pairs.back().update(pair);
        }
        return pairs;
    }

  private:
    /// null: nothing of the two faces each other.
    Json ask(std::span<const GridPoint> from, const std::vector<GridPoint>& target) {
        if (target[0] == target[1] || target[1] == target[2]) // a face of a box without depth
            return nullptr;
        exact::QueryOptions query;
        query.form = ExactForm::published;
        query.complete = true;
        query.rays = kRays;
        query.max_pieces = options_.most_pieces;
        query.seed = options_.seed;
        exact::QueryResult result = query_.run(from, target, occluders_, query);
        static constexpr const char* answers[] = {"hidden", "visible", "undecided"};
        if (result.answer == exact::Answer::hidden && result.counters.prisms + result.counters.hulls == 0 && result.effective == 0)
            return nullptr;
        Json pair{{"answer", answers[std::size_t(result.answer)]},
                  {"effective_occluders", result.effective},
                  {"from", polygon_json(from)},
                  {"to", polygon_json(target)}};
        Json blockers = Json::array();
        for (exact::OccluderId id : result.blockers)
            blockers.push_back({{"object", scene_.triangle_objects()[id]},
                                {"triangle", id - scene_.object_of(id).first_triangle}});
        pair["subtracted"] = std::move(blockers);
        pair["complete"] = result.answer == exact::Answer::hidden || result.unobstructed != nullptr;
        std::vector<exact::ComplexPiece> pieces;
        if (result.unobstructed)
            pieces = exact::complete_complex(*result.unobstructed);
        pair["visible_share"] = exact::visible_share(pieces, from, target, kShareSamples, options_.seed);
        pair["pieces"] = pieces_json(pieces);
        return pair;
    }

    const Scene& scene_;
    const exact::SceneTree& tree_;
    exact::OccludersAlong occluders_;
    exact::Query query_;
    const LineSpaceOptions& options_;
};

} // namespace

Result<std::string> line_space_in_json(const Scene& scene, const Box3d& cell, std::uint32_t object,
                                       const LineSpaceOptions& options, const Job& job) {
    if (object >= scene.objects().size() || scene.objects()[object].triangle_count == 0)
        return Status(ErrorCode::usage, "the object has no triangles that anything could see");
    exact::SceneTree tree = exact::SceneTree::build(scene);
    GridBox box{tree.to_grid(scene.to_local(cell.min)), tree.to_grid(scene.to_local(cell.max))};
    for (int k = 0; k < 3; ++k) {
        if (box.max[k] == box.min[k])
            ++box.max[k];
        if (box.min[k] <= -(1 << 24) || box.max[k] >= 1 << 24)
            return Status(ErrorCode::usage, "the cell lies beyond twice the scene's own size around it");
    }
    Json document{{"coordinates", "grid steps from the origin: world = origin + step * grid; lines (d, m), d = q - p, m = p x q"},
                  {"origin", {scene.origin().x, scene.origin().y, scene.origin().z}},
                  {"step", scene.step()},
                  {"object", object},
                  {"name", std::string(scene.name(object))},
                  {"cell", {point_json(box.min), point_json(box.max)}}};
    document["pairs"] = Writer(scene, tree, options).write(box, object, job);
    if (job.cancelled())
        return Status(ErrorCode::cancelled, "stopped");
    return document.dump(1, ' ', false, Json::error_handler_t::replace) + "\n";
}

} // namespace antumbra
