// The only writers of results.
#pragma once

#include "cull/scene_data.hpp"
#include "pvs/count_bits.hpp"

#include <bit>

namespace antumbra {

inline void mark_visible(CullResult& result, std::uint32_t object) {
    result.visible[object / 64] |= std::uint64_t(1) << (object % 64);
}

/// Empty but for the objects that are always reported. Allocates when the result is new.
inline void begin_result(const CullScene::Data& scene, CullResult& result) {
    result.visible.assign(scene.always_visible.begin(), scene.always_visible.end());
    result.visible_count = 0;
    result.everything = false;
    result.reason = "";
    result.counters = {};
}

inline void mark_everything(const CullScene::Data& scene, CullResult& result, const char* reason) {
    result.visible.assign(scene.always_visible.size(), ~std::uint64_t(0));
    if (scene.object_count() % 64)
        result.visible.back() = (std::uint64_t(1) << (scene.object_count() % 64)) - 1;
    result.visible_count = scene.object_count();
    result.everything = true;
    result.reason = reason;
}

inline void finish_result(CullResult& result) {
    result.visible_count = count_bits(std::span<const std::uint64_t>(result.visible));
}

} // namespace antumbra
