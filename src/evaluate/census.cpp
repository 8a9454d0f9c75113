#include "evaluate/census.hpp"

#include <algorithm>
#include <bit>
#include <span>

namespace antumbra {
namespace {

/// Leaves of the tree with their parts of view space, in preorder.
void collect_leaves(const ViewTree& tree, std::vector<CensusCell>& cells) {
    struct Open {
        std::size_t node;
        ViewRegion region;
    };
    std::vector<Open> stack{{0, {}}};
    while (!stack.empty()) {
        Open open = stack.back();
        stack.pop_back();
        const ViewNode& node = tree.nodes[open.node];
        if (node.axis == ViewNode::kLeaf) {
            cells.push_back({open.node, tree.spatial_box(open.region), open.region, node.link, 0});
            continue;
        }
        ViewRegion below = open.region, above = open.region;
        below.high[node.axis] = above.low[node.axis] = node.split;
        stack.push_back({node.link, above});
        stack.push_back({open.node + 1, below});
    }
}

/// Calls visit(row, words) for every row.
template <class Visit>
void each_row(const Pvs& pvs, const Visit& visit) {
    std::vector<std::uint64_t> words(pvs.words_per_row());
    for (std::uint32_t row = 0; row < pvs.row_count(); ++row) {
        pvs.decode_row(row, words);
        visit(row, std::span<const std::uint64_t>(words));
    }
}

/// Calls visit(object) for every object of a row; occludee volumes are none.
template <class Visit>
void each_object(const Pvs& pvs, std::span<const std::uint64_t> words, const Visit& visit) {
    for (std::size_t w = 0; w < words.size(); ++w)
        for (std::uint64_t rest = words[w]; rest; rest &= rest - 1) {
            std::size_t object = w * 64 + std::size_t(std::countr_zero(rest));
            if (object < pvs.object_count())
                visit(std::uint32_t(object));
        }
}

template <class T, class Less>
std::vector<T> first_of(std::vector<T> all, std::size_t count, const Less& less) {
    std::size_t shown = std::min(count, all.size());
    std::partial_sort(all.begin(), all.begin() + std::ptrdiff_t(shown), all.end(), less);
    all.resize(shown);
    return all;
}

} // namespace

Census take_census(const Pvs& pvs) {
    Census census;
    if (!pvs.tree().nodes.empty())
        collect_leaves(pvs.tree(), census.cells);
    else
        for (std::uint64_t cell = 0; cell < pvs.grid().cells(); ++cell)
            census.cells.push_back({cell, pvs.grid().cell(cell), {}, pvs.cell_row(cell), 0});
    std::vector<std::uint32_t> objects(pvs.row_count());
    std::vector<std::uint64_t> triangles(pvs.row_count());
    std::vector<std::uint32_t> triangles_of(pvs.object_count());
    for (std::uint32_t o = 0; o < pvs.object_count(); ++o)
        triangles_of[o] = pvs.object(o).triangle_count;
    each_row(pvs, [&](std::uint32_t row, std::span<const std::uint64_t> words) {
        each_object(pvs, words, [&](std::uint32_t object) {
            ++objects[row];
            triangles[row] += triangles_of[object];
        });
    });
    double sum = 0, triangle_sum = 0;
    for (CensusCell& cell : census.cells) {
        census.solid += cell.row == kCellSolid;
        census.not_baked += cell.row == kCellNotBaked;
        if (!cell.baked())
            continue;
        ++census.baked;
        cell.visible = objects[cell.row];
        sum += cell.visible;
        triangle_sum += double(triangles[cell.row]);
    }
    if (census.baked) {
        census.mean_visible = sum / double(census.baked);
        census.mean_visible_triangles = triangle_sum / double(census.baked);
    }
    return census;
}

std::vector<CensusCell> Census::worst(std::size_t count) const {
    std::vector<CensusCell> baked_cells;
    std::copy_if(cells.begin(), cells.end(), std::back_inserter(baked_cells),
                 [](const CensusCell& cell) { return cell.baked(); });
    return first_of(std::move(baked_cells), count, [](const CensusCell& a, const CensusCell& b) {
        return a.visible != b.visible ? a.visible > b.visible : a.index < b.index;
    });
}

std::vector<CensusObject> costliest_objects(const Pvs& pvs, const Census& census, std::size_t count) {
    std::vector<std::uint64_t> cells_of_row(pvs.row_count());
    for (const CensusCell& cell : census.cells)
        if (cell.baked())
            ++cells_of_row[cell.row];
    std::vector<CensusObject> all(pvs.object_count());
    each_row(pvs, [&](std::uint32_t row, std::span<const std::uint64_t> words) {
        each_object(pvs, words, [&](std::uint32_t object) { all[object].cells += cells_of_row[row]; });
    });
    for (std::uint32_t o = 0; o < all.size(); ++o) {
        all[o].object = o;
        all[o].cost = all[o].cells * pvs.object(o).triangle_count;
    }
    return first_of(std::move(all), count, [](const CensusObject& a, const CensusObject& b) {
        return a.cost != b.cost ? a.cost > b.cost : a.object < b.object;
    });
}

} // namespace antumbra
