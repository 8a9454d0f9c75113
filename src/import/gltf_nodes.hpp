// Where the nodes of the shown scene stand in the world, and what they inherit.
#pragma once

#include "import/gltf_document.hpp"

namespace antumbra::gltf {

struct PlacedNode {
    std::int32_t node = -1;
    Transform world;
    bool moves = false;  ///< the node or an ancestor is animated
    bool hidden = false; ///< KHR_node_visibility of the node or an ancestor
    Flags flags;         ///< the node's and its ancestors'
};

/// Every node of the shown scene, in the order of their indices. Transforms are multiplied in double from the root
/// down, `root` first. ErrorCode::corrupt for circles anywhere in the file, limit beyond `depth` levels.
Result<std::vector<PlacedNode>> place_nodes(const Document& document, const Transform& root, std::uint32_t depth);

} // namespace antumbra::gltf
