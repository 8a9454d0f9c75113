#include "cull/methods.hpp"

#include <array>
#include <atomic>
#include <string>

namespace antumbra {
namespace {

struct Method {
    std::string_view name, summary;
    Result<CullerPointer> (*make)(const CullScene&, const CullerOptions&);
};

constexpr std::array kMethods{
    Method{"none", "reports every object",
           [](const CullScene& scene, const CullerOptions&) { return Result<CullerPointer>(make_none(scene)); }},
#ifndef ANTUMBRA_SHIPPED_METHODS_ONLY // where bytes count, what is there to be compared with stays away
    Method{"frustum-scalar", "view frustum, one box at a time over a binary tree: the denominator of all ratios",
           [](const CullScene& scene, const CullerOptions&) {
               return Result<CullerPointer>(make_frustum_scalar(scene));
           }},
#endif
    Method{"frustum", "view frustum, eight boxes at a time over a wide tree", make_frustum},
#ifndef ANTUMBRA_SHIPPED_METHODS_ONLY
    Method{"hzb", "hierarchical z-buffer of conservatively drawn occluders, scalar", make_hzb},
#endif
    Method{"masked", "masked depth buffer, occluders drawn as a front-to-back walk meets them", make_masked},
    Method{"planes", "shadows of the largest convex occluders (Coorg, Teller 1997)", make_planes},
#ifndef ANTUMBRA_SHIPPED_METHODS_ONLY
    Method{"planes-published", "the same as published: a kd-tree, cached relations of occluders and nodes",
           make_published_planes},
    Method{"tree-f", "view frustum alone over the kd-tree of the tree- methods: what they are compared with", make_tree_f},
    Method{"tree-fse", "occlusion tree, faces of nodes split exactly (Bittner, Havran, Slavik 1998)", make_tree_fse},
    Method{"tree-fme", "modified occlusion tree without splitting, pyramid test at leaves", make_tree_fme},
    Method{"tree-fmc", "modified occlusion tree without splitting or test at leaves", make_tree_fmc},
    Method{"tree", "planes, then an occlusion tree of many occluders for what they hide together", make_tree},
    Method{"opacity", "opacity map of chosen occluders (Poon, Wang 1999)", make_opacity},
    Method{"opacity-published", "the same as published: summed-area table and sparse depth map, 128 x 128",
           [](const CullScene& scene, const CullerOptions& options) {
               CullerOptions published = options;
               if (published.opacity.form == OpacityForm::modern)
                   published.opacity.form = OpacityForm::published;
               return make_opacity(scene, published);
           }},
#endif
    Method{"pvs", "the baked set of the cell of the eye, within the view frustum", make_pvs},
};

} // namespace

std::span<const std::string_view> culler_names() {
    static const auto names = [] {
        std::array<std::string_view, kMethods.size()> list;
        for (std::size_t i = 0; i < kMethods.size(); ++i)
            list[i] = kMethods[i].name;
        return list;
    }();
    return names;
}

std::string_view culler_summary(std::string_view name) {
    for (const Method& method : kMethods)
        if (method.name == name)
            return method.summary;
    return "";
}

Result<CullerPointer> make_culler(std::string_view name, const CullScene& scene, const CullerOptions& options) {
    std::string known;
    for (const Method& method : kMethods) {
        if (method.name == name && options.pvs && options.pvs->object_count() != scene.object_count())
            return Status(ErrorCode::mismatch, "the .pvs knows " + std::to_string(options.pvs->object_count()) +
                                                   " objects, the scene has " + std::to_string(scene.object_count()) +
                                                   "; bake this scene again");
        if (method.name == name)
            return method.make(scene, options);
        known += (known.empty() ? "" : ", ") + std::string(method.name);
    }
    return Status(ErrorCode::usage, "unknown culling method '" + std::string(name) + "'; known are: " + known);
}

std::uint64_t new_culler_serial() {
    static std::atomic<std::uint64_t> next{1};
    return next.fetch_add(1, std::memory_order_relaxed);
}

} // namespace antumbra
