// Other people's cullers behind our interface, so that bench_cull puts the same frames to them. None of their code is here:
// see README.md.
#pragma once

#include <antumbra/cull.hpp>
#include <antumbra/scene.hpp>

#include <memory>
#include <vector>

namespace antumbra::bench {

#if defined(ANTUMBRA_HAS_MOC)
/// Intel's Masked Occlusion Culling, with all triangles and as it works best: drawn and asked in turn on one
/// front-to-back walk. `scene` must outlive them.
std::vector<std::unique_ptr<Culler>> make_moc(const Scene& scene, const CullSceneInput& input);
#endif

/// Those that were compiled in.
inline std::vector<std::unique_ptr<Culler>> make_peers([[maybe_unused]] const Scene& scene,
                                                       [[maybe_unused]] const CullSceneInput& input) {
    std::vector<std::unique_ptr<Culler>> peers;
#if defined(ANTUMBRA_HAS_MOC)
    for (std::unique_ptr<Culler>& culler : make_moc(scene, input))
        peers.push_back(std::move(culler));
#endif
    return peers;
}

} // namespace antumbra::bench
