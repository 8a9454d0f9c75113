#include "cull/set_cells.hpp"

#include "tree/kd_tree.hpp"

#include <bit>
#include <memory>

namespace antumbra {
namespace {

std::uint32_t depth_for(std::uint32_t leaves) { return static_cast<std::uint32_t>(std::bit_width(std::max(leaves, 1u) - 1)); }

/// The grid, halved along its longest side until it has no more than so many cells.
SpaceCells of_grid(const CellGrid& grid, const Vec3d& origin, std::uint32_t leaves) {
    std::array<std::uint32_t, 3> count = grid.count;
    while (std::uint64_t(count[0]) * count[1] * count[2] > std::max(leaves, 1u))
        for (std::size_t axis = 0, most = std::max({count[0], count[1], count[2]}); axis < 3; ++axis)
            if (count[axis] == most) {
                count[axis] = (count[axis] + 1) / 2;
                break;
            }
    return SpaceCells::of_grid({grid.bounds.min - origin, grid.bounds.max - origin}, count);
}

/// The tree's cuts of space, as deep as leaves allow; what it cuts by direction stays together.
class ViewTreeCells {
  public:
    ViewTreeCells(const ViewTree& tree, const Vec3d& origin, std::uint32_t depth) : tree_(tree), origin_(origin), depth_(depth) {}

    SpaceCells run() {
        cells_.bounds = {tree_.bounds.min - origin_, tree_.bounds.max - origin_};
        copy(0, 0);
        return std::move(cells_);
    }

  private:
    void copy(std::uint32_t index, std::uint32_t depth) {
        const ViewNode& node = tree_.nodes[index];
        std::size_t made = cells_.nodes.size();
        cells_.nodes.emplace_back();
        if (node.axis > 2 || depth == depth_) {
            cells_.nodes[made].leaf = cells_.leaves++;
            return;
        }
        cells_.nodes[made].axis = node.axis;
        cells_.nodes[made].at = static_cast<float>(tree_.position(node.axis, node.split) - origin_[node.axis]);
        copy(index + 1, depth + 1);
        cells_.nodes[made].right = static_cast<std::uint32_t>(cells_.nodes.size());
        copy(node.link, depth + 1);
    }

    const ViewTree& tree_;
    Vec3d origin_;
    std::uint32_t depth_;
    SpaceCells cells_;
};

/// What each cell sees: bits over the objects.
std::vector<std::vector<std::uint64_t>> rows_of(const SpaceCells& cells, const Pvs& pvs, const Vec3d& origin) {
    std::vector<std::vector<std::uint64_t>> rows;
    PvsCursor cursor;
    for (const Box3d& box : cells.boxes()) {
        // A little smaller: what only touches a neighbour does not count.
        Vec3d inset = box.size() * 1e-3;
        ViewRange range;
        range.eyes = {box.min + inset + origin, box.max - inset + origin};
        (void)pvs.query_range(range, cursor);
        rows.emplace_back(cursor.visible.begin(), cursor.visible.end());
        if (cursor.everything)
            rows.back().assign((std::size_t(pvs.object_count()) + 63) / 64, ~std::uint64_t(0));
    }
    return rows;
}

} // namespace

SpaceCells cells_of_objects(const CullScene::Data& scene, std::uint32_t leaves) {
    KdTreeOptions options;
    options.rule = KdRule::balanced_counts;
    options.most_depth = depth_for(leaves);
    return SpaceCells::of_tree(build_kd_tree(scene.bounds, scene.order, options), options.most_depth);
}

SetCells choose_set_cells(const CullScene::Data& scene, const Pvs* pvs, std::uint32_t leaves) {
    SetCells result;
    if (pvs && !pvs->tree().nodes.empty())
        result.cells = ViewTreeCells(pvs->tree(), scene.origin, depth_for(leaves)).run();
    else if (pvs && pvs->grid().cells() > 0)
        result.cells = of_grid(pvs->grid(), scene.origin, leaves);
    if (result.cells.nodes.empty()) {
        result.cells = cells_of_objects(scene, leaves);
        return result;
    }
    auto rows = std::make_shared<std::vector<std::vector<std::uint64_t>>>(rows_of(result.cells, *pvs, scene.origin));
    result.is_seen = [rows](std::uint32_t leaf, std::uint32_t object) {
        const std::vector<std::uint64_t>& row = (*rows)[leaf];
        return object / 64 >= row.size() || (row[object / 64] >> (object % 64) & 1) != 0;
    };
    return result;
}

} // namespace antumbra
