#include "evaluate/spatial_cells.hpp"

#include <algorithm>
#include <numeric>

namespace antumbra {
namespace {

std::vector<SpatialCell> cells_of_grid(const Pvs& pvs) {
    std::vector<SpatialCell> cells;
    for (std::uint64_t c = 0; c < pvs.grid().cells(); ++c) {
        std::uint32_t row = pvs.cell_row(c);
        if (row >= kCellSolid)
            continue;
        Box3d box = pvs.grid().cell(c);
        cells.push_back({box, box, box, c, {row}});
    }
    return cells;
}

/// Cuts space by all spatial splits of the nodes that cover a box.
class TreeCutter {
  public:
    TreeCutter(const Pvs& pvs, std::vector<SpatialCell>& cells) : tree_(pvs.tree()), cells_(cells) {}
    void cut() { cut(ViewRegion(), {{0, ViewRegion()}}); }

  private:
    struct Cover {
        std::uint32_t node;
        ViewRegion region; ///< of the node
    };

    void cut(const ViewRegion& space, std::vector<Cover> covers) {
        std::vector<Cover> leaves;
        while (!covers.empty()) {
            auto [at, region] = covers.back();
            covers.pop_back();
            const ViewNode& node = tree_.nodes[at];
            if (node.axis == ViewNode::kLeaf) {
                leaves.push_back({at, region});
                continue;
            }
            ViewRegion below = region, above = region;
            below.high[node.axis] = node.split;
            above.low[node.axis] = node.split;
            bool cuts_space = node.axis < 3 && space.low[node.axis] < node.split && node.split < space.high[node.axis];
            if (cuts_space) {
                covers.push_back({at, region});
                covers.insert(covers.end(), leaves.begin(), leaves.end());
                ViewRegion low = space, high = space;
                low.high[node.axis] = node.split;
                high.low[node.axis] = node.split;
                cut(low, covers);
                cut(high, std::move(covers));
                return;
            }
            bool all = node.axis >= 3; // directions: both halves belong to the same space
            if (all || space.low[node.axis] >= node.split)
                covers.push_back({node.link, above});
            if (all || space.high[node.axis] <= node.split)
                covers.push_back({at + 1, below});
        }
        add(space, leaves);
    }

    void add(const ViewRegion& space, const std::vector<Cover>& leaves) {
        SpatialCell cell;
        cell.box = tree_.spatial_box(space);
        cell.cell = UINT64_MAX;
        for (const Cover& leaf : leaves) {
            std::uint32_t row = tree_.nodes[leaf.node].link;
            if (row >= kCellSolid)
                return;
            Box3d box = tree_.spatial_box(leaf.region);
            cell.outer.extend(box);
            cell.inner = cell.rows.empty() ? box : intersection(cell.inner, box);
            cell.rows.push_back(row);
            cell.cell = std::min<std::uint64_t>(cell.cell, leaf.node);
        }
        std::sort(cell.rows.begin(), cell.rows.end());
        cell.rows.erase(std::unique(cell.rows.begin(), cell.rows.end()), cell.rows.end());
        cells_.push_back(std::move(cell));
    }

    const ViewTree& tree_;
    std::vector<SpatialCell>& cells_;
};

} // namespace

std::vector<SpatialCell> spatial_cells(const Pvs& pvs) {
    if (pvs.tree().nodes.empty())
        return cells_of_grid(pvs);
    std::vector<SpatialCell> cells;
    TreeCutter(pvs, cells).cut();
    return cells;
}

void unite_rows(const Pvs& pvs, const SpatialCell& cell, std::vector<std::uint64_t>& bits) {
    bits.assign(pvs.words_per_row(), 0);
    pvs.decode_row(cell.rows[0], bits);
    std::vector<std::uint64_t> more(cell.rows.size() > 1 ? bits.size() : 0);
    for (std::size_t k = 1; k < cell.rows.size(); ++k) {
        pvs.decode_row(cell.rows[k], more);
        for (std::size_t w = 0; w < bits.size(); ++w)
            bits[w] |= more[w];
    }
}

double volume(const Box3d& box) {
    if (box.empty())
        return 0;
    Vec3d size = box.size();
    return size.x * size.y * size.z;
}

Box3d intersection(const Box3d& a, const Box3d& b) {
    Box3d box;
    for (int k = 0; k < 3; ++k) {
        box.min[k] = std::max(a.min[k], b.min[k]);
        box.max[k] = std::min(a.max[k], b.max[k]);
    }
    return box;
}

void for_each_common_piece(const std::vector<SpatialCell>& a, const std::vector<SpatialCell>& b,
                           const std::function<void(std::size_t, std::size_t, const Box3d&)>& visit) {
    // Cells of b by their lower end along the axis on which b is cut the most.
    int axis = 0;
    std::size_t most = 0;
    double widest = 0;
    for (int k = 0; k < 3; ++k) {
        std::vector<double> ends;
        for (const SpatialCell& cell : b)
            ends.push_back(cell.box.min[k]);
        std::sort(ends.begin(), ends.end());
        auto distinct = std::size_t(std::unique(ends.begin(), ends.end()) - ends.begin());
        if (distinct > most) {
            most = distinct;
            axis = k;
        }
    }
    std::vector<std::size_t> order(b.size());
    std::iota(order.begin(), order.end(), std::size_t(0));
    std::stable_sort(order.begin(), order.end(),
                     [&](std::size_t i, std::size_t j) { return b[i].box.min[axis] < b[j].box.min[axis]; });
    for (const SpatialCell& cell : b)
        widest = std::max(widest, cell.box.size()[axis]);
    std::vector<std::size_t> met;
    for (std::size_t i = 0; i < a.size(); ++i) {
        const Box3d& box = a[i].box;
        auto from = std::lower_bound(order.begin(), order.end(), box.min[axis] - widest * 1.0001,
                                     [&](std::size_t j, double low) { return b[j].box.min[axis] < low; });
        met.clear();
        for (; from != order.end() && b[*from].box.min[axis] < box.max[axis]; ++from)
            if (volume(intersection(box, b[*from].box)) > 0)
                met.push_back(*from);
        std::sort(met.begin(), met.end());
        for (std::size_t j : met)
            visit(i, j, intersection(box, b[j].box));
    }
}

} // namespace antumbra
