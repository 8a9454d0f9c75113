#include "bake/sampled/tree_bake.hpp"

#include "bake/sampled/sample_payload.hpp"

#include <bit>
#include <cmath>

namespace antumbra {
namespace {

/// The halvings above the tiles: a complete binary tree, in depth-first order.
class Tiling {
  public:
    Tiling(const ViewRegion& space, std::uint32_t depth, double step) : step_(step) { halve(space, depth); }
    const std::vector<ViewRegion>& tiles() const { return tiles_; }

    /// The whole tree: the halvings with each tile's own tree in its place.
    BuiltTree join(std::vector<BuiltTree> trees) const {
        BuiltTree joined;
        std::size_t next_split = 0, next_tile = 0;
        append(joined, trees, next_split, next_tile);
        return joined;
    }

  private:
    struct Halving {
        int axis; ///< -1: a tile
        double plane;
    };

    void halve(const ViewRegion& box, std::uint32_t depth) {
        std::size_t axis = 0;
        for (std::size_t k = 1; k < 3; ++k)
            if (box.max[k] - box.min[k] > box.max[axis] - box.min[axis])
                axis = k;
        double plane = std::floor((box.min[axis] + box.max[axis]) / 2 / step_) * step_;
        if (depth == 0 || !(plane > box.min[axis])) {
            halvings_.push_back({-1, 0});
            tiles_.push_back(box);
            return;
        }
        halvings_.push_back({int(axis), plane});
        ViewRegion below = box, above = box;
        below.max[axis] = above.min[axis] = plane;
        halve(below, depth - 1);
        halve(above, depth - 1);
    }

    std::uint32_t append(BuiltTree& joined, std::vector<BuiltTree>& trees, std::size_t& next_split,
                         std::size_t& next_tile) const {
        Halving halving = halvings_[next_split++];
        auto index = std::uint32_t(joined.nodes.size());
        if (halving.axis < 0) {
            BuiltTree& tree = trees[next_tile++];
            auto first_leaf = std::uint32_t(joined.leaves.size());
            for (BuiltNode node : tree.nodes) {
                node.children[0] += index;
                node.children[1] += index;
                node.leaf += first_leaf;
                joined.nodes.push_back(node);
            }
            for (RegionSample& leaf : tree.leaves)
                joined.leaves.push_back(std::move(leaf));
            joined.rays_reused += tree.rays_reused;
            return index;
        }
        joined.nodes.push_back({halving.axis, halving.plane, {0, 0}, 0});
        std::uint32_t below = append(joined, trees, next_split, next_tile);
        std::uint32_t above = append(joined, trees, next_split, next_tile);
        joined.nodes[index].children[0] = below;
        joined.nodes[index].children[1] = above;
        return index;
    }

    double step_;
    std::vector<Halving> halvings_;
    std::vector<ViewRegion> tiles_;
};

Payload pack(const BuiltTree& tree) {
    PayloadWriter payload;
    payload.put(tree.rays_reused);
    payload.put(tree.nodes.size());
    payload.put(tree.leaves.size());
    for (const BuiltNode& node : tree.nodes) {
        payload.put(std::uint64_t(std::int64_t(node.axis)));
        payload.put(std::bit_cast<std::uint64_t>(node.split));
        payload.put(node.children[0]);
        payload.put(node.children[1]);
        payload.put(node.leaf);
    }
    for (const RegionSample& leaf : tree.leaves)
        payload.put(leaf);
    return payload.take();
}

/// False if the bytes are no tree: indices out of range, or children that do not follow their parent.
bool unpack(std::span<const std::byte> bytes, std::size_t words, BuiltTree& tree) {
    PayloadReader payload(bytes);
    tree.rays_reused = payload.get();
    std::uint64_t nodes = payload.get(), leaves = payload.get();
    if (!payload.ok() || nodes == 0 || nodes > bytes.size() / 40 || leaves > nodes)
        return false;
    for (std::uint64_t n = 0; n < nodes; ++n) {
        BuiltNode node;
        node.axis = int(std::int64_t(payload.get()));
        node.split = std::bit_cast<double>(payload.get());
        std::uint64_t numbers[3] = {payload.get(), payload.get(), payload.get()};
        bool inner = node.axis >= 0;
        if (node.axis < -1 || node.axis >= kViewAxes ||
            (inner ? !(numbers[0] > n && numbers[1] > numbers[0] && numbers[1] < nodes) : numbers[2] >= leaves))
            return false;
        node.children[0] = std::uint32_t(numbers[0]);
        node.children[1] = std::uint32_t(numbers[1]);
        node.leaf = std::uint32_t(numbers[2]);
        tree.nodes.push_back(node);
    }
    for (std::uint64_t leaf = 0; leaf < leaves; ++leaf)
        tree.leaves.push_back(payload.get_sample(words));
    return payload.at_end();
}

} // namespace

ViewRegion view_space_of(const Scene& scene, const BakeOptions& options) {
    Box3d bounds = to_double(scene.local_bounds());
    double step = scene.step();
    Box3d space;
    for (int k = 0; k < 3; ++k) {
        double half = bounds.size()[k] / 2 * options.tree.view_space, centre = bounds.centre()[k];
        space.min[k] = std::floor((centre - half) / step) * step;
        space.max[k] = std::ceil((centre + half) / step) * step;
        if (!(space.max[k] > space.min[k]))
            space.max[k] = space.min[k] + step;
    }
    return ViewRegion::all_directions(space);
}

Result<TreeBake> bake_view_tree(const SamplingScene& shared, const std::string& key, const Job& job) {
    const BakeOptions& options = shared.options();
    std::size_t words = (shared.scene().objects().size() + 63) / 64;
    TreeBake result;
    result.view_space = view_space_of(shared.scene(), options);
    Tiling tiling(result.view_space, options.tree.tile_depth, shared.scene().step());
    Units units;
    units.stage = "bake";
    units.unit_name = "tiles";
    for (std::size_t tile = 0; tile < tiling.tiles().size(); ++tile)
        units.ids.push_back(tile);
    units.compute = [&](std::size_t tile) { return pack(build_view_tree(shared, tiling.tiles()[tile])); };
    units.acceptable = [&](std::size_t, std::span<const std::byte> payload) {
        BuiltTree tree;
        return unpack(payload, words, tree);
    };
    Result<UnitResults> results = run_units(units, key, options, job);
    if (!results)
        return results.status();
    std::vector<BuiltTree> trees(results->payloads.size());
    for (std::size_t tile = 0; tile < trees.size(); ++tile)
        if (!unpack(results->payloads[tile], words, trees[tile]))
            return Status(ErrorCode::internal, "a tile of the view tree cannot be read back; please report");
    result.tree = tiling.join(std::move(trees));
    result.tiles = units.ids.size();
    result.tiles_resumed = results->resumed;
    return result;
}

} // namespace antumbra
