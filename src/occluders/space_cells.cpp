#include "occluders/space_cells.hpp"

#include <algorithm>
#include <cmath>

namespace antumbra {
namespace {

constexpr std::uint8_t kLeaf = 3;

struct GridCutter {
    SpaceCells& cells;
    std::array<std::uint32_t, 3> count;

    /// Cells low .. high (excluded) of the grid: cut in the middle of the longest row.
    void cut(const std::array<std::uint32_t, 3>& low, const std::array<std::uint32_t, 3>& high) {
        std::size_t axis = 0, node = cells.nodes.size();
        for (std::size_t k = 1; k < 3; ++k)
            if (high[k] - low[k] > high[axis] - low[axis])
                axis = k;
        cells.nodes.emplace_back();
        if (high[axis] - low[axis] < 2) {
            cells.nodes[node].leaf = low[0] + count[0] * (low[1] + count[1] * low[2]);
            return;
        }
        std::uint32_t middle = low[axis] + (high[axis] - low[axis]) / 2;
        double from = cells.bounds.min[int(axis)], size = cells.bounds.max[int(axis)] - from;
        cells.nodes[node].axis = static_cast<std::uint8_t>(axis);
        cells.nodes[node].at = static_cast<float>(from + size * middle / count[axis]);
        std::array<std::uint32_t, 3> below = high, above = low;
        below[axis] = above[axis] = middle;
        cut(low, below);
        cells.nodes[node].right = static_cast<std::uint32_t>(cells.nodes.size());
        cut(above, high);
    }
};

void copy(const KdTree& tree, std::uint32_t index, std::uint32_t depth, SpaceCells& cells) {
    const KdNode& node = tree.nodes[index];
    std::size_t made = cells.nodes.size();
    cells.nodes.emplace_back();
    if (node.leaf() || depth == 0) {
        cells.nodes[made].leaf = cells.leaves++;
        return;
    }
    const Box3f &whole = node.cell, &below = tree.nodes[index + 1].cell;
    int axis = whole.max.x != below.max.x ? 0 : whole.max.y != below.max.y ? 1 : 2;
    cells.nodes[made].axis = static_cast<std::uint8_t>(axis);
    cells.nodes[made].at = below.max[axis];
    copy(tree, index + 1, depth - 1, cells);
    cells.nodes[made].right = static_cast<std::uint32_t>(cells.nodes.size());
    copy(tree, node.right, depth - 1, cells);
}

} // namespace

std::uint32_t SpaceCells::find(const Vec3d& place) const {
    std::uint32_t index = 0;
    while (nodes[index].right != 0)
        index = place[nodes[index].axis] >= double(nodes[index].at) ? nodes[index].right : index + 1;
    return nodes[index].leaf;
}

std::vector<Box3d> SpaceCells::boxes() const {
    std::vector<Box3d> result(leaves), of_node(nodes.size());
    for (std::size_t n = 0; n < nodes.size(); ++n) {
        if (n == 0)
            of_node[n] = bounds;
        const Node& node = nodes[n];
        if (node.right == 0) {
            result[node.leaf] = of_node[n];
            continue;
        }
        of_node[n + 1] = of_node[node.right] = of_node[n];
        double at = std::clamp(double(node.at), of_node[n].min[node.axis], of_node[n].max[node.axis]);
        of_node[n + 1].max[node.axis] = of_node[node.right].min[node.axis] = at;
    }
    return result;
}

SpaceCells SpaceCells::of_grid(const Box3d& bounds, const std::array<std::uint32_t, 3>& count) {
    SpaceCells cells;
    cells.bounds = bounds;
    cells.leaves = count[0] * count[1] * count[2];
    cells.nodes.reserve(2 * std::size_t(cells.leaves));
    GridCutter{cells, count}.cut({0, 0, 0}, count);
    return cells;
}

SpaceCells SpaceCells::of_tree(const KdTree& tree, std::uint32_t depth) {
    SpaceCells cells;
    if (tree.nodes.empty())
        return cells;
    cells.bounds = to_double(tree.nodes[0].cell);
    copy(tree, 0, depth, cells);
    return cells;
}

void SpaceCells::encode(ByteWriter& out) const {
    for (const Node& node : nodes) {
        out.u8(node.right == 0 ? kLeaf : node.axis);
        if (node.right != 0)
            out.f32(node.at);
    }
}

SpaceCells SpaceCells::decode(std::span<const std::byte> bytes, std::size_t& at, const Box3d& bounds) {
    SpaceCells cells;
    cells.bounds = bounds;
    std::vector<std::uint32_t> open; ///< inner nodes whose upper child is still to come
    while (true) {
        auto index = static_cast<std::uint32_t>(cells.nodes.size());
        if (at >= bytes.size() || open.size() > kMostDepth)
            return {};
        Node node;
        node.axis = std::to_integer<std::uint8_t>(bytes[at++]);
        if (node.axis < kLeaf) {
            if (bytes.size() - at < 4 || !std::isfinite(node.at = load_f32(bytes, at)))
                return {};
            at += 4;
            open.push_back(index);
            cells.nodes.push_back(node);
            continue;
        }
        if (node.axis != kLeaf)
            return {};
        node.axis = 0;
        node.leaf = cells.leaves++;
        cells.nodes.push_back(node);
        if (open.empty())
            return cells;
        cells.nodes[open.back()].right = index + 1; // the next node is its upper child
        open.pop_back();
    }
}

} // namespace antumbra
