#include <antumbra/bake.hpp>

namespace antumbra {

PvsData describe_scene(const Scene& scene) {
    PvsData pvs;
    pvs.guarantee = Guarantee::conservative; // no cell: everything is visible
    pvs.method = "none";
    pvs.tool_version = ANTUMBRA_VERSION;
    pvs.scene_fingerprint = scene.fingerprint();
    pvs.structure_fingerprint = scene.structure_fingerprint();
    pvs.sides = std::uint8_t(scene.sides());
    pvs.origin = scene.origin();
    for (std::uint32_t o = 0; o < scene.objects().size(); ++o) {
        const Object& object = scene.objects()[o];
        pvs.objects.push_back({object.id.node, object.id.primitive, object.id.instance, object.flags,
                               object.triangle_count, object.bounds, std::string(scene.name(o))});
    }
    return pvs;
}

} // namespace antumbra
