#include "cull/scene_data.hpp"

#include <utility>

namespace antumbra {
namespace {

constexpr float kLargest = 1e17f;
bool is_usable(const Box3f& box) {
    for (int axis = 0; axis < 3; ++axis)
        if (!(std::abs(box.min[axis]) <= kLargest && std::abs(box.max[axis]) <= kLargest)) // also NaN
            return false;
    return !box.empty();
}

} // namespace

void take_objects(const CullSceneInput& input, CullScene::Data& data) {
    data.bounds.assign(input.bounds.begin(), input.bounds.end());
    data.flags.assign(input.flags.begin(), input.flags.end());
    data.flags.resize(data.bounds.size(), 0);
    if (input.triangles.size() == data.bounds.size())
        data.triangles.assign(input.triangles.begin(), input.triangles.end());
    data.origin = input.origin;
    data.always_visible.resize((data.bounds.size() + 63) / 64);
    for (std::uint32_t o = 0; o < data.object_count(); ++o) {
        if ((data.flags[o] & kAlwaysVisibleFlag) || !is_usable(data.bounds[o])) {
            data.always_visible[o / 64] |= std::uint64_t(1) << (o % 64);
        } else {
            data.order.push_back(o);
            data.tree_box.extend(data.bounds[o]);
        }
    }
}

void build_trees(CullScene::Data& data) {
    data.binary = build_binary_tree(data.bounds, data.order);
    data.patches = lay_out_patches(data);
    data.patches.binary = build_binary_tree(items_of(data), data.patches.order);
}

void finish(CullScene::Data& data) {
    data.wide = collapse(data.binary, data.order);
    data.patches.tree = collapse(data.patches.binary, data.patches.order);
    data.occluder_tree = build_occluder_tree(data.groups);
    data.stack_bound = kTreeDepth * kWidth;
}

CullScene CullScene::create(const CullSceneInput& input) {
    auto data = std::make_shared<Data>();
    take_objects(input, *data);
    // A set that contradicts itself hides nothing.
    if (input.occluders && check_occluders(*input.occluders).ok())
        data->occluders = *input.occluders;
    build_trees(*data);
    data->groups = find_convex_groups(data->occluders, kMostGroups);
    finish(*data);
    CullScene scene;
    scene.data_ = std::move(data);
    return scene;
}

std::uint32_t CullScene::object_count() const { return data_->object_count(); }
std::span<const Box3f> CullScene::bounds() const { return data_->bounds; }

} // namespace antumbra
