#include "import/gltf_nodes.hpp"

#include <algorithm>

namespace antumbra::gltf {
namespace {

/// Every node has at most one parent (read_document saw to it), so a node that no root reaches is on or below a
/// circle.
Status check_circles(const Document& document) {
    std::vector<std::int32_t> todo;
    std::vector<bool> reached(document.nodes.size());
    for (std::size_t n = 0; n < document.nodes.size(); ++n)
        if (document.nodes[n].parent < 0)
            todo.push_back(static_cast<std::int32_t>(n));
    while (!todo.empty()) {
        std::size_t n = static_cast<std::size_t>(todo.back());
        todo.pop_back();
        reached[n] = true;
        todo.insert(todo.end(), document.nodes[n].children.begin(), document.nodes[n].children.end());
    }
    auto lost = std::find(reached.begin(), reached.end(), false);
    if (lost == reached.end())
        return {};
    return {ErrorCode::corrupt,
            "nodes[" + std::to_string(lost - reached.begin()) + "]: is its own ancestor; repair the hierarchy"};
}

} // namespace

Result<std::vector<PlacedNode>> place_nodes(const Document& document, const Transform& root, std::uint32_t depth) {
    if (Status status = check_circles(document); !status)
        return status;
    struct Pending {
        PlacedNode placed; ///< what is inherited; the node's own share comes when it is taken up
        std::uint32_t level;
    };
    std::vector<Pending> todo;
    for (std::int32_t node : document.roots)
        todo.push_back({{node, root, false, false, {}}, 1});
    std::vector<PlacedNode> placed;
    while (!todo.empty()) {
        auto [place, level] = todo.back();
        todo.pop_back();
        const Node& node = document.nodes[static_cast<std::size_t>(place.node)];
        if (level > depth)
            return Status(ErrorCode::limit, "nodes[" + std::to_string(place.node) + "]: hangs deeper than " +
                                                std::to_string(depth) + " levels");
        place.world = place.world * node.local();
        place.moves = place.moves || node.animated;
        place.hidden = place.hidden || node.hidden;
        place.flags = place.flags | node.flags;
        placed.push_back(place);
        for (std::int32_t child : node.children) {
            Pending next{place, level + 1};
            next.placed.node = child;
            todo.push_back(next);
        }
    }
    std::sort(placed.begin(), placed.end(),
              [](const PlacedNode& a, const PlacedNode& b) { return a.node < b.node; });
    return placed;
}

} // namespace antumbra::gltf
