#include "occluders/choose.hpp"

#include <algorithm>
#include <numeric>

namespace antumbra {
namespace {

/// Halves by the median of the centres along the longest side.
void build(const ConvexGroups& groups, std::vector<std::uint32_t>& order, std::uint32_t first, std::uint32_t count,
           OccluderTree& tree) {
    auto index = tree.nodes.size();
    tree.nodes.emplace_back();
    OccluderTree::Node node;
    Box3d centres;
    for (std::uint32_t i = first; i < first + count; ++i) {
        const ConvexGroups::Group& group = groups.groups[order[i]];
        node.box.extend(group.box);
        node.area = std::max(node.area, static_cast<float>(group.area));
        centres.extend(group.centre);
    }
    node.group = order[first];
    if (count > 1) {
        Vec3d size = centres.size();
        int axis = size.x >= size.y && size.x >= size.z ? 0 : size.y >= size.z ? 1 : 2;
        auto begin = order.begin() + first;
        std::nth_element(begin, begin + count / 2, begin + count, [&](std::uint32_t a, std::uint32_t b) {
            double left = groups.groups[a].centre[axis], right = groups.groups[b].centre[axis];
            return left != right ? left < right : a < b;
        });
        build(groups, order, first, count / 2, tree);
        node.right = static_cast<std::uint32_t>(tree.nodes.size());
        build(groups, order, first + count / 2, count - count / 2, tree);
    }
    tree.nodes[index] = node;
}

} // namespace

OccluderTree build_occluder_tree(const ConvexGroups& groups) {
    OccluderTree tree;
    std::vector<std::uint32_t> order(groups.groups.size());
    std::iota(order.begin(), order.end(), 0u);
    tree.nodes.reserve(2 * order.size());
    if (!order.empty())
        build(groups, order, 0, static_cast<std::uint32_t>(order.size()), tree);
    return tree;
}

void OccluderSearch::begin(const OccluderTree& tree, const Vec3d& eye, std::uint32_t wanted) {
    heap_.clear();
    finding_.clear();
    eye_ = {static_cast<float>(eye.x), static_cast<float>(eye.y), static_cast<float>(eye.z)};
    wanted_ = wanted;
    running_ = true;
    if (!tree.nodes.empty())
        heap_.push_back({area_angle_bound(tree.nodes[0].area, tree.nodes[0].box, eye_), 0});
}

} // namespace antumbra
