// What a CullScene holds: boxes, a binary tree (for frustum-scalar alone) and the wide tree that all other
// methods walk.
#pragma once

#include <antumbra/cull.hpp>

#include "occluders/choose.hpp"
#include "occluders/occluder_sets.hpp"
#include "raster/patch.hpp"
#include "tree/object_tree.hpp"

#include <array>
#include <vector>

namespace antumbra {

/// kAlwaysVisible of scene.hpp, which the run time does not include; a test compares them.
inline constexpr std::uint32_t kAlwaysVisibleFlag = 1u << 2;

/// Occluder patches laid out for drawing; patch p of the store is OccluderSet::patches[p].
struct ScenePatches {
    PatchStore store;
    std::vector<Box3f> boxes;
    std::vector<float> area;          ///< all three sides of the box, for each polygon of the patch
    std::vector<std::uint32_t> solid; ///< kNoPolygon, or the solid that the patch belongs to
    /// Trees over objects and patches together: item i is an object if i < object_count, else the patch
    /// i - object_count.
    std::vector<std::uint32_t> order;
    std::vector<BinaryNode> binary;
    std::vector<CullNode> tree;
};

struct CullScene::Data {
    std::vector<Box3f> bounds;
    std::vector<std::uint32_t> flags;
    std::vector<std::uint32_t> triangles; ///< per object, or empty
    Vec3d origin;
    std::vector<std::uint64_t> always_visible; ///< bit set; these objects are in no tree
    std::vector<std::uint32_t> order;          ///< the other objects, in the order of the trees
    std::vector<BinaryNode> binary;            ///< empty if `order` is
    std::vector<CullNode> wide;                ///< node 0 is the root
    OccluderSet occluders;
    ScenePatches patches;
    ConvexGroups groups;         ///< of the occluders, for the object-space methods
    OccluderTree occluder_tree;  ///< over the groups
    /// Minimum occluder sets by grid point and direction, from a prepared file; else empty.
    OccluderDatabase minimum_sets;
    /// Polygons per place and direction, from a prepared file; else empty.
    OccluderSets front_sets, back_sets;
    OccluderSets first_hit_sets; ///< groups, most visible first
    Box3f tree_box;                            ///< around all objects of the trees
    std::uint32_t stack_bound = 0;             ///< entries that a depth-first walk of either tree can need

    std::uint32_t object_count() const { return static_cast<std::uint32_t>(bounds.size()); }
};

/// All but the trees; `order` lists the items that go into one.
ScenePatches lay_out_patches(const CullScene::Data& scene);
/// Boxes of the objects, then of the patches.
std::vector<Box3f> items_of(const CullScene::Data& scene);

/// The tree's shape and order as bytes, and back: `order` lists the items that must be in it (its own order replaces
/// theirs). ErrorCode::corrupt if it is no tree over exactly these, or deeper than kTreeDepth. O(bytes).
void encode_tree(const std::vector<BinaryNode>& binary, std::span<const std::uint32_t> order, ByteWriter& out);
Result<std::vector<BinaryNode>> decode_tree(std::span<const std::byte> bytes, std::size_t& at,
                                            std::span<const Box3f> bounds, std::vector<std::uint32_t>& order);

/// The steps in which a CullScene is made, whether from a scene or from a file.
inline constexpr std::uint32_t kMostGroups = 32768; ///< the largest; smaller ones hide next to nothing
void take_objects(const CullSceneInput& input, CullScene::Data& data);
void build_trees(CullScene::Data& data); ///< after objects and occluders
void finish(CullScene::Data& data);      ///< what follows from the rest

} // namespace antumbra
