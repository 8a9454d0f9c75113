// What writing and checking certificates share: cells and triangles as polygons.
#pragma once

#include "bake/exact/baked_cells.hpp"
#include "bake/exact/certificate_bytes.hpp"
#include "bake/exact/certificate_file.hpp"

namespace antumbra::certificates {

using certify::Polygon;
using exact::GridBox;

/// Face 0 to 5: -x, +x, -y, ..
inline Polygon cell_face(const GridBox& cell, int face) {
    auto corners = exact::face_of(cell, face / 2, face % 2);
    return {{corners.begin(), corners.end()}, true};
}

inline Polygon triangle_polygon(const exact::SceneTree& tree, std::uint32_t t, bool turned) {
    const auto& c = tree.corners(t);
    return {turned ? std::vector<GridPoint>{c[0], c[2], c[1]} : std::vector<GridPoint>{c[0], c[1], c[2]},
            tree.both_sides(t)};
}

inline GridBox grid_cell(const exact::SceneTree& tree, const exact::BakedCell& cell) {
    return {tree.to_grid(tree.scene().to_local(cell.box.min)), tree.to_grid(tree.scene().to_local(cell.box.max))};
}

inline Status check_belongs(const Scene& scene, const Pvs& pvs) {
    if (pvs.scene_fingerprint() != scene.fingerprint() || pvs.object_count() != scene.objects().size())
        return {ErrorCode::mismatch, "the file was baked from another scene, or from this one read otherwise"};
    return {};
}

inline void add(CertificateFileResult& total, const CertificateFileResult& one) {
    total.pairs += one.pairs;
    total.visible += one.visible;
    total.by_definition += one.by_definition;
    total.hidden += one.hidden;
    total.undecided += one.undecided;
    total.trees += one.trees;
    total.nodes += one.nodes;
    total.rejected += one.rejected;
    total.disagree += one.disagree;
}

} // namespace antumbra::certificates
