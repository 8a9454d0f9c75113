#include "cull/seen_patches.hpp"

#include <algorithm>

namespace antumbra {

void SeenPatches::look(const CullScene::Data& scene) {
    const OccluderSet& set = scene.occluders;
    auto is_seen = [&](std::uint32_t index) {
        const OccluderPolygon& polygon = set.polygons[index];
        return cell_.everything || polygon.synthetic || polygon.object >= scene.object_count() ||
               (cell_.visible[polygon.object / 64] >> (polygon.object % 64) & 1) != 0;
    };
    seen_.assign(set.patches.size(), 0);
    for (std::size_t p = 0; p < set.patches.size(); ++p) {
        const std::uint32_t* owned = set.patch_polygons.data() + set.patches[p].first;
        seen_[p] = std::any_of(owned, owned + set.patches[p].core, is_seen);
    }
}

} // namespace antumbra
