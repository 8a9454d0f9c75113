// The front-to-back walk that the image-space methods share: over the wide tree of objects and occluder patches.
#pragma once

#include "cull/box_kernels.hpp"
#include "cull/result_bits.hpp"
#include "raster/pixel_rect.hpp"

#include <algorithm>

namespace antumbra {

/// What a box touches on the screen, packed; an empty rectangle if it may be anywhere.
struct PackedPlace {
    std::uint16_t x0 = 1, y0 = 1, x1 = 0, y1 = 0;
    float nearness = 0;

    PixelRect rect() const { return {x0, y0, x1, y1}; }
};

inline PackedPlace packed_place(const EightOnScreen& boxes, std::uint32_t slot) {
    if (!(boxes.testable >> slot & 1))
        return {};
    auto pixel = [](int value) { return static_cast<std::uint16_t>(value); };
    return {pixel(boxes.x0[slot]), pixel(boxes.y0[slot]), pixel(boxes.x1[slot]), pixel(boxes.y1[slot]),
            boxes.nearness[slot]};
}

struct WalkEntry {
    std::uint32_t child, planes;
    PackedPlace place;
};

struct WalkKernels {
    BoxKernel boxes = nullptr;
    ProjectEight project = nullptr;
};

/// Squared distances from the eye (orthographic: depths) of eight boxes. Only an order: it needs no care.
inline void find_distances(const CullNode& node, const Camera& camera, float (&distances)[kWidth]) {
    for (float& distance : distances)
        distance = 0;
    for (int axis = 0; axis < 3; ++axis) {
        const auto eye = static_cast<float>(camera.eye[axis]), forward = static_cast<float>(camera.forward[axis]);
        const float *low = node.min[axis], *high = node.max[axis];
        if (camera.orthographic)
            for (int slot = 0; slot < kWidth; ++slot)
                distances[slot] += forward * (forward > 0 ? low[slot] : high[slot]);
        else
            for (int slot = 0; slot < kWidth; ++slot) {
                float before = low[slot] - eye, behind = eye - high[slot];
                float gap = before > behind ? before : behind;
                gap = gap > 0 ? gap : 0;
                distances[slot] += gap * gap;
            }
    }
}

/// Visits what is inside the view volume, nearest first (by the distance of boxes, depth first, so nearly). `Visitor`
/// has
///   bool hidden(const PackedPlace&)  is everything in a box there certainly invisible?
///   void object(std::uint32_t, const PackedPlace&)  an object that is not
///   void patch(std::uint32_t, const PackedPlace&)   an occluder patch that is not
///   bool wants_patch(std::uint32_t, float)    is it worth a look, at that squared distance (orthographic: at depth)?
template <class Visitor>
void walk_front_to_back(const CullScene::Data& scene, const Screen& screen, const WalkKernels& kernels,
                        std::vector<WalkEntry>& stack, CullCounters& counters, Visitor&& visitor) {
    const std::vector<CullNode>& tree = scene.patches.tree;
    if (tree.empty())
        return;
    const Camera& camera = screen.camera;
    FrustumPlanes planes = frustum_planes(camera, scene.patches.binary[0].box);
    BoxVerdicts verdicts;
    EightOnScreen places;
    float distances[kWidth];
    std::uint32_t slots[kWidth];

    auto open = [&](std::uint32_t index, std::uint32_t active) {
        const CullNode& node = tree[index];
        kernels.boxes({node.min, node.max}, planes, active, verdicts);
        std::uint32_t inside = node.mask() & ~verdicts.outside;
        ++counters.nodes_visited;
        counters.boxes_tested += node.used;
        counters.outside_frustum += static_cast<std::uint32_t>(std::popcount(node.mask() & ~inside));
        if (inside == 0)
            return;
        find_distances(node, camera, distances);
        int count = 0;
        for (std::uint32_t rest = inside; rest; rest &= rest - 1) {
            auto slot = static_cast<std::uint32_t>(std::countr_zero(rest));
            std::uint32_t child = node.child[slot];
            if ((child & kObjectChild) && (child & ~kObjectChild) >= scene.object_count() &&
                !visitor.wants_patch((child & ~kObjectChild) - scene.object_count(), distances[slot]))
                continue;
            int at = count++;
            for (; at > 0 && distances[slots[at - 1]] < distances[slot]; --at) // farthest first: the stack turns it round
                slots[at] = slots[at - 1];
            slots[at] = slot;
        }
        if (count == 0)
            return;
        kernels.project(screen, node.min, node.max, places);
        for (int i = 0; i < count; ++i)
            stack.push_back({node.child[slots[i]], verdicts.crossing[slots[i]], packed_place(places, slots[i])});
    };

    stack.clear();
    stack.reserve(scene.stack_bound);
    open(0, planes.mask());
    while (!stack.empty()) {
        WalkEntry entry = stack.back();
        stack.pop_back();
        if (visitor.hidden(entry.place)) {
            ++counters.hidden_by_raster;
            continue;
        }
        if (!(entry.child & kObjectChild))
            open(entry.child, entry.planes);
        else if (std::uint32_t item = entry.child & ~kObjectChild; item < scene.object_count())
            visitor.object(item, entry.place);
        else
            visitor.patch(item - scene.object_count(), entry.place);
    }
}

/// True if a line of sight may start within the shell of the solid that the patch belongs to.
inline bool is_unusable_solid(const CullScene::Data& scene, std::uint32_t patch, const Box3d& start) {
    std::uint32_t solid = scene.patches.solid[patch];
    return solid != kNoPolygon && !scene.occluders.solids[solid].serves(start);
}

} // namespace antumbra
