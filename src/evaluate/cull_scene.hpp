// From a scene to what the cullers see of it.
#pragma once

#include <antumbra/cull.hpp>
#include <antumbra/occluder_finding.hpp>
#include <antumbra/scene.hpp>

namespace antumbra {

/// What a CullSceneInput of the scene refers to; must outlive it.
struct CullSceneObjects {
    std::vector<Box3f> bounds;
    std::vector<std::uint32_t> flags, triangles;
    Vec3d origin;

    explicit CullSceneObjects(const Scene& scene) : origin(scene.origin()) {
        for (const Object& object : scene.objects()) {
            bounds.push_back(object.bounds);
            flags.push_back(object.flags);
            triangles.push_back(object.triangle_count);
        }
    }
    CullSceneInput input(const OccluderSet* occluders) const {
        CullSceneInput result;
        result.bounds = bounds;
        result.flags = flags;
        result.triangles = triangles;
        result.origin = origin;
        result.occluders = occluders;
        return result;
    }
};

/// Reads `occluders` only during the call.
inline CullScene cull_scene_of(const Scene& scene, const OccluderSet& occluders) {
    return CullScene::create(CullSceneObjects(scene).input(&occluders));
}

/// From the chunks of a prepared file, or, where it has none or there is none, from occluders found now.
inline Result<CullScene> cull_scene_for(const Scene& scene, const Pvs* pvs) {
    if (pvs && pvs->has_chunk("OCCL"))
        return CullScene::open(*pvs);
    return cull_scene_of(scene, find_occluders(scene));
}

} // namespace antumbra
