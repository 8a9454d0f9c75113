#include "bake/exact/baked_cells.hpp"

#include <algorithm>

namespace antumbra::exact {

Result<std::vector<BakedCell>> baked_cells(const Pvs& pvs) {
    std::vector<BakedCell> cells;
    for (std::uint64_t c = 0; c < pvs.grid().cells(); ++c)
        if (std::uint32_t row = pvs.cell_row(c); row < kCellSolid)
            cells.push_back({c, pvs.grid().cell(c), row});
    std::vector<std::pair<std::uint32_t, ViewRegion>> open;
    const ViewTree& tree = pvs.tree();
    if (!tree.nodes.empty())
        open.push_back({0, ViewRegion()});
    while (!open.empty()) {
        auto [at, region] = open.back();
        open.pop_back();
        const ViewNode& node = tree.nodes[at];
        if (node.axis == ViewNode::kLeaf) {
            if (node.link < kCellSolid)
                cells.push_back({at, tree.spatial_box(region), node.link});
            continue;
        }
        if (node.axis >= 3)
            return Status(ErrorCode::usage, "the cells of the file are split by direction; certificates speak of boxes in space");
        ViewRegion below = region, above = region;
        below.high[node.axis] = above.low[node.axis] = node.split;
        open.push_back({node.link, above});
        open.push_back({at + 1, below});
    }
    std::sort(cells.begin(), cells.end(), [](const BakedCell& a, const BakedCell& b) { return a.number < b.number; });
    if (cells.empty())
        return Status(ErrorCode::usage, "the file holds no baked cells to prove");
    return cells;
}

Result<Units> units_of(const Scene& scene, const Pvs& pvs) {
    if (pvs.cluster_count() == 0)
        return Units::objects(scene);
    Status other(ErrorCode::mismatch, "the clusters of the file are not made of this scene's triangles; bake it again");
    std::vector<std::uint32_t> of(scene.triangles().size());
    if (pvs.object_count() != scene.objects().size())
        return other;
    for (std::uint32_t o = 0; o < pvs.object_count(); ++o) {
        const Object& object = scene.objects()[o];
        PvsTriangles triangles = pvs.triangles_of(o, object.source_triangles + object.triangle_count);
        std::uint32_t listed = 0;
        for (std::uint32_t t = 0; t < object.triangle_count; ++t) {
            std::uint32_t at = pvs.tells_triangles() ? scene.triangle_sources()[object.first_triangle + t] : t;
            std::uint32_t cluster = at < triangles.cluster.size() ? triangles.cluster[at] : PvsTriangles::kNone;
            if (cluster == PvsTriangles::kNone)
                return other;
            of[object.first_triangle + t] = cluster;
            ++listed;
        }
        if (pvs.object(o).triangle_count != listed)
            return other;
    }
    return Units::from_numbers(std::move(of));
}

std::size_t bit_of(const Pvs& pvs, std::uint32_t unit) {
    return pvs.cluster_count() == 0 ? unit : std::size_t(pvs.object_count()) + std::size_t(pvs.volumes().cells()) + unit;
}

bool is_always_visible(const Scene& scene, const Pvs& pvs, const Units& units, std::uint32_t unit) {
    std::uint32_t object = pvs.cluster_count() == 0 ? unit : scene.triangle_objects()[units.triangles_of(unit)[0]];
    return scene.objects()[object].has(kAlwaysVisible);
}

std::string name_of_unit(const Pvs& pvs, std::uint32_t unit) {
    return (pvs.cluster_count() == 0 ? "object " : "cluster ") + std::to_string(unit);
}

} // namespace antumbra::exact
