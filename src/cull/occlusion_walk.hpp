// The front-to-back walk that the image-space methods share: over the wide tree of objects and occluder patches.
#pragma once

#include "cull/box_kernels.hpp"
#include "cull/result_bits.hpp"

#include <algorithm>

namespace antumbra {

struct WalkEntry {
    std::uint32_t node, slot, planes;
    float distance;
};

/// Visits what is inside the view volume, nearest first (by the distance of boxes, depth first, so nearly). `Visitor`
/// has
///   bool hidden(const Box3f&)        is everything in that box certainly invisible?
///   void object(std::uint32_t, const Box3f&)  an object that is not
///   void patch(std::uint32_t)        an occluder patch that is not
///   bool wants_patch(std::uint32_t, float)    is it worth a look, at that squared distance (orthographic: at depth)?
template <class Visitor>
void walk_front_to_back(const CullScene::Data& scene, const Camera& camera, BoxKernel kernel,
                        std::vector<WalkEntry>& stack, CullCounters& counters, Visitor&& visitor) {
    const std::vector<CullNode>& tree = scene.patches.tree;
    if (tree.empty())
        return;
    Box3f domain = scene.tree_box;
    for (const Box3f& box : scene.patches.boxes)
        if (!box.empty())
            domain.extend(box);
    FrustumPlanes planes = frustum_planes(camera, domain);
    const float eye[3] = {static_cast<float>(camera.eye.x), static_cast<float>(camera.eye.y),
                          static_cast<float>(camera.eye.z)};
    const float forward[3] = {static_cast<float>(camera.forward.x), static_cast<float>(camera.forward.y),
                              static_cast<float>(camera.forward.z)};
    BoxVerdicts verdicts;
    WalkEntry children[kWidth];

    auto open = [&](std::uint32_t index, std::uint32_t active) {
        const CullNode& node = tree[index];
        kernel({node.min, node.max}, planes, active, verdicts);
        std::uint32_t inside = node.mask() & ~verdicts.outside;
        ++counters.nodes_visited;
        counters.boxes_tested += node.used;
        counters.outside_frustum += static_cast<std::uint32_t>(std::popcount(node.mask() & ~inside));
        int count = 0;
        for (std::uint32_t rest = inside; rest; rest &= rest - 1) {
            auto slot = static_cast<std::uint32_t>(std::countr_zero(rest));
            float distance = 0; // only an order: it needs no care
            for (int axis = 0; axis < 3; ++axis) {
                if (camera.orthographic) {
                    distance += forward[axis] * (forward[axis] > 0 ? node.min[axis][slot] : node.max[axis][slot]);
                } else {
                    float gap = std::max({node.min[axis][slot] - eye[axis], eye[axis] - node.max[axis][slot], 0.0f});
                    distance += gap * gap;
                }
            }
            std::uint32_t child = node.child[slot];
            if ((child & kObjectChild) && (child & ~kObjectChild) >= scene.object_count() &&
                !visitor.wants_patch((child & ~kObjectChild) - scene.object_count(), distance))
                continue;
            int at = count++;
            for (; at > 0 && children[at - 1].distance < distance; --at) // farthest first: the stack turns it round
                children[at] = children[at - 1];
            children[at] = {index, slot, verdicts.crossing[slot], distance};
        }
        stack.insert(stack.end(), children, children + count);
    };

    stack.clear();
    stack.reserve(scene.stack_bound);
    open(0, planes.mask());
    while (!stack.empty()) {
        WalkEntry entry = stack.back();
        stack.pop_back();
        const CullNode& node = tree[entry.node];
        Box3f box = node.box(int(entry.slot));
        if (visitor.hidden(box)) {
            ++counters.hidden_by_raster;
            continue;
        }
        std::uint32_t child = node.child[entry.slot];
        if (!(child & kObjectChild))
            open(child, entry.planes);
        else if (std::uint32_t item = child & ~kObjectChild; item < scene.object_count())
            visitor.object(item, box);
        else
            visitor.patch(item - scene.object_count());
    }
}

/// True if a line of sight may start within the shell of the solid that the patch belongs to.
inline bool is_unusable_solid(const CullScene::Data& scene, std::uint32_t patch, const Box3d& start) {
    std::uint32_t solid = scene.patches.solid[patch];
    return solid != kNoPolygon && to_double(scene.occluders.solids[solid].shell).overlaps(start);
}

} // namespace antumbra
