#include "rays/triangle_tree.hpp"

#include "rays/caster.hpp"

#include <utility>

namespace antumbra::rays {
namespace {

bool before(const Vec3f& a, const Vec3f& b) {
    return a.x != b.x ? a.x < b.x : a.y != b.y ? a.y < b.y : a.z < b.z;
}

/// Puts a triangle into a lane, corners in order of position.
void set_lane(Block& block, int lane, const Scene& scene, std::uint32_t triangle) {
    const TriangleIndices& indices = scene.triangles()[triangle];
    Vec3f corners[3];
    for (std::size_t c = 0; c < 3; ++c)
        corners[c] = scene.positions()[indices[c]];
    bool flipped = false;
    auto order = [&](int i, int j) {
        if (before(corners[j], corners[i])) {
            std::swap(corners[i], corners[j]);
            flipped = !flipped;
        }
    };
    order(0, 1);
    order(1, 2);
    order(0, 1);
    for (int c = 0; c < 3; ++c)
        for (int k = 0; k < 3; ++k)
            block.corner[c][k][lane] = corners[c][k];
    block.triangle[lane] = triangle;
    const Object& object = scene.object_of(triangle);
    auto bit = [&](bool set) { return static_cast<std::uint8_t>(set ? 1 << lane : 0); };
    block.flipped |= bit(flipped);
    block.double_sided |= bit(object.has(kDoubleSided));
}

void clear_lanes(Block& block, int from) {
    for (int lane = from; lane < kLanes; ++lane) {
        for (int c = 0; c < 3; ++c)
            for (int k = 0; k < 3; ++k)
                block.corner[c][k][lane] = block.corner[0][k][0];
        block.triangle[lane] = kNoTriangle;
    }
}

} // namespace

TriangleTree build_triangle_tree(const Scene& scene, std::span<const std::uint32_t> triangles,
                                 BvhOptions options, const Job& job) {
    std::vector<Box3f> boxes(triangles.size());
    for (std::size_t i = 0; i < triangles.size(); ++i)
        for (std::uint32_t v : scene.triangles()[triangles[i]])
            boxes[i].extend(scene.positions()[v]);
    options.block_size = kLanes;
    WideBvh<kWidth> wide = widen<kWidth>(build_bvh(boxes, options, job), options);
    TriangleTree tree; // leaves get ranges of blocks for ranges of items
    for (Node& node : wide.nodes)
        for (int i = 0; i < kWidth; ++i) {
            std::uint32_t first = node.first[i], count = node.count[i];
            if (count == 0)
                continue;
            node.first[i] = static_cast<std::uint32_t>(tree.blocks.size());
            for (std::uint32_t item = 0; item < count; ++item) {
                int lane = static_cast<int>(item % kLanes);
                if (lane == 0)
                    tree.blocks.emplace_back();
                set_lane(tree.blocks.back(), lane, scene, triangles[wide.order[first + item]]);
            }
            clear_lanes(tree.blocks.back(), static_cast<int>((count - 1) % kLanes) + 1);
            node.count[i] = static_cast<std::uint32_t>(tree.blocks.size()) - node.first[i];
        }
    tree.nodes = std::move(wide.nodes);
    tree.blocks.shrink_to_fit();
    return tree;
}

} // namespace antumbra::rays
