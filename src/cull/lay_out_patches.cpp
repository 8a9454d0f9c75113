// Occluder patches from the shared set to flat arrays.
#include "cull/patch_layout.hpp"
#include "cull/scene_data.hpp"

#include <algorithm>

namespace antumbra {

std::vector<Box3f> items_of(const CullScene::Data& scene) {
    std::vector<Box3f> items = scene.bounds;
    for (const OccluderPatch& patch : scene.occluders.patches)
        items.push_back(patch.box);
    return items;
}

ScenePatches lay_out_patches(const CullScene::Data& scene) {
    ScenePatches patches;
    const OccluderSet& set = scene.occluders;
    PatchLayout layout(set);
    patches.order = scene.order;
    std::uint32_t item = scene.object_count();
    for (const OccluderPatch& patch : set.patches) {
        std::span<const std::uint32_t> polygons(set.patch_polygons.data() + patch.first, patch.count);
        layout.add(set, polygons, patches.store);
        patches.boxes.push_back(patch.box);
        Vec3d size = patch.box.empty() ? Vec3d{} : to_double(patch.box.max) - to_double(patch.box.min);
        double area = size.x * size.y + size.y * size.z + size.z * size.x;
        patches.area.push_back(static_cast<float>(area / std::max(patch.count, 1u)));
        patches.solid.push_back(patch.count ? set.polygons[polygons[0]].solid : kNoPolygon);
        if (patch.count && !patch.box.empty())
            patches.order.push_back(item);
        ++item;
    }
    return patches;
}

} // namespace antumbra
