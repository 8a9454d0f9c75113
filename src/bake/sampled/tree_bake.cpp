#include "bake/sampled/tree_bake.hpp"

#include "bake/assemble.hpp"
#include "bake/exact/adaptive_tree.hpp"
#include "bake/parts.hpp"
#include "bake/sampled/sample_payload.hpp"

#include <bit>
#include <cmath>

namespace antumbra {
namespace {

/// The halvings above the tiles, in preorder; a tile is a leaf whose link is its index.
class Tiling {
  public:
    Tiling(const ViewTree& space, std::uint32_t depth) : space_(space) { halve(ViewRegion(), depth); }
    const std::vector<ViewRegion>& tiles() const { return tiles_; }

    /// The whole tree: the halvings with each tile's own tree in its place.
    BuiltTree join(std::vector<BuiltTree> trees) const {
        BuiltTree joined;
        std::size_t next = 0;
        append(joined, trees, next);
        return joined;
    }

  private:
    void halve(const ViewRegion& box, std::uint32_t depth) {
        std::size_t index = halvings_.size(), axis = 0;
        halvings_.emplace_back();
        Vec3d size = space_.spatial_box(box).size();
        for (std::size_t k = 1; k < 3; ++k)
            if (size[int(k)] > size[int(axis)])
                axis = k;
        if (depth == 0) {
            halvings_[index].link = std::uint32_t(tiles_.size());
            tiles_.push_back(box);
            return;
        }
        std::uint32_t middle = (box.low[axis] + box.high[axis]) / 2;
        ViewRegion below = box, above = box;
        below.high[axis] = above.low[axis] = middle;
        halve(below, depth - 1);
        halvings_[index] = {std::uint8_t(axis), std::uint16_t(middle), 0};
        halve(above, depth - 1);
    }

    void append(BuiltTree& joined, std::vector<BuiltTree>& trees, std::size_t& next) const {
        ViewNode halving = halvings_[next++];
        auto index = std::uint32_t(joined.nodes.size());
        if (halving.axis == ViewNode::kLeaf) {
            BuiltTree& tree = trees[halving.link];
            if (tree.nodes.empty()) { // of another shard
                joined.nodes.push_back({ViewNode::kLeaf, 0, kCellNotBaked});
                return;
            }
            auto first_leaf = std::uint32_t(joined.leaves.size());
            for (ViewNode node : tree.nodes) {
                if (node.axis != ViewNode::kLeaf || node.link != kCellNotBaked)
                    node.link += node.axis == ViewNode::kLeaf ? first_leaf : index;
                joined.nodes.push_back(node);
            }
            for (RegionSample& leaf : tree.leaves)
                joined.leaves.push_back(std::move(leaf));
            joined.rays_reused += tree.rays_reused;
            add(joined.work, tree.work);
            return;
        }
        joined.nodes.push_back(halving);
        append(joined, trees, next);
        joined.nodes[index].link = std::uint32_t(joined.nodes.size());
        append(joined, trees, next);
    }

    const ViewTree& space_;
    std::vector<ViewNode> halvings_;
    std::vector<ViewRegion> tiles_;
};

Payload pack(const BuiltTree& tree) {
    PayloadWriter payload;
    put(payload, tree.work);
    payload.put(tree.rays_reused);
    payload.put(tree.nodes.size());
    payload.put(tree.leaves.size());
    for (const ViewNode& node : tree.nodes)
        payload.put(std::uint64_t(node.axis) | std::uint64_t(node.split) << 8 | std::uint64_t(node.link) << 32);
    for (const RegionSample& leaf : tree.leaves)
        payload.put(leaf);
    return payload.take();
}

/// False if the bytes hold no tree of so many leaves.
bool unpack(std::span<const std::byte> bytes, std::size_t words, BuiltTree& tree) {
    PayloadReader payload(bytes);
    tree.work = get_exact_statistics(payload);
    tree.rays_reused = payload.get();
    std::uint64_t nodes = payload.get(), leaves = payload.get();
    if (!payload.ok() || nodes == 0 || nodes > bytes.size() / 8 || leaves > nodes)
        return false;
    for (std::uint64_t n = 0; n < nodes; ++n) {
        std::uint64_t word = payload.get();
        tree.nodes.push_back({std::uint8_t(word), std::uint16_t(word >> 8), std::uint32_t(word >> 32)});
    }
    for (std::uint64_t leaf = 0; leaf < leaves; ++leaf)
        tree.leaves.push_back(payload.get_sample(words));
    ViewTree shape{{{0, 0, 0}, {1, 1, 1}}, tree.nodes};
    return payload.at_end() && shape.check(std::uint32_t(leaves)).ok();
}

/// FNV-1a over the corners of boxes.
std::uint64_t name_of(const std::vector<Box3d>& boxes) {
    std::vector<std::uint64_t> words;
    for (const Box3d& box : boxes)
        for (int k = 0; k < 3; ++k) {
            words.push_back(std::bit_cast<std::uint64_t>(box.min[k]));
            words.push_back(std::bit_cast<std::uint64_t>(box.max[k]));
        }
    return plan_of(words);
}

/// Exact cells are halved at most so often along each axis, so that their corners stay on the scene's grid.
constexpr double kHalvable = 4096;

/// The scene's box times options.tree.view_space about its centre, or the box around options.where, on the scene's grid, in
/// world coordinates.
Box3d view_space(const Scene& scene, const BakeOptions& options) {
    Box3d bounds = to_double(scene.local_bounds());
    double step = scene.step();
    Box3d space;
    for (const Box3d& box : options.where)
        space.extend(Box3d{scene.to_local(box.min), scene.to_local(box.max)});
    if (!options.where.empty())
        bounds = space;
    for (int k = 0; k < 3; ++k) {
        double times = options.where.empty() ? options.tree.view_space : 1;
        double half = bounds.size()[k] / 2 * times, centre = bounds.centre()[k];
        space.min[k] = std::floor((centre - half) / step) * step;
        space.max[k] = std::ceil((centre + half) / step) * step;
        if (!(space.max[k] > space.min[k]))
            space.max[k] = space.min[k] + step;
        if (options.method == "exact")
            space.max[k] = space.min[k] + std::ceil((space.max[k] - space.min[k]) / (kHalvable * step)) * kHalvable * step;
    }
    return {scene.to_world(space.min), scene.to_world(space.max)};
}

} // namespace

Result<TreeBake> bake_view_tree(const SamplingScene& shared, const ExactCells* exact, const Job& job) {
    const BakeOptions& options = shared.options();
    std::size_t words = exact ? exact->words() : shared.words();
    for (const Box3d& box : options.where)
        if (!is_finite(box.min) || !is_finite(box.max) || box.empty())
            return Status(ErrorCode::usage, "a box of viewpoints is empty or not finite; min must not exceed max");
    TreeBake result;
    result.tree.bounds = view_space(shared.scene(), options);
    if (exact)
        if (Status status = exact->check(result.tree.bounds); !status)
            return status;
    Tiling tiling(result.tree, options.tree.tile_depth);
    std::string key = checkpoint_key(shared.scene(), options, CellGrid(), exact ? std::to_string(name_of(options.where)) : "");
    Units units;
    units.stage = "bake";
    units.unit_name = "tiles";
    for (std::size_t tile = 0; tile < tiling.tiles().size(); ++tile)
        units.ids.push_back(tile);
    result.plan = exact ? name_of(options.where) : 0;
    keep_shard(units.ids, options.shard);
    units.compute = [&](std::size_t unit) {
        const ViewRegion& tile = tiling.tiles()[units.ids[unit]];
        if (!exact)
            return pack(build_view_tree(shared, result.tree, tile));
        BuiltTree tree;
        return build_exact_tree(*exact, result.tree, tile, tree, job.cancel) ? pack(tree) : Payload();
    };
    units.acceptable = [&](std::size_t, std::span<const std::byte> payload) {
        BuiltTree tree;
        return unpack(payload, words, tree);
    };
    Result<UnitResults> results = run_units(units, key, options, job);
    if (!results)
        return results.status();
    std::vector<BuiltTree> trees(tiling.tiles().size());
    for (std::size_t unit = 0; unit < units.ids.size(); ++unit)
        if (!unpack(results->payloads[unit], words, trees[units.ids[unit]]))
            return Status(ErrorCode::internal, "a tile of the view tree cannot be read back; please report");
    BuiltTree joined = tiling.join(std::move(trees));
    result.tree.nodes = std::move(joined.nodes);
    result.leaves = std::move(joined.leaves);
    result.rays_reused = joined.rays_reused;
    result.work = joined.work;
    result.tiles = units.ids.size();
    result.tiles_resumed = results->resumed;
    return result;
}

} // namespace antumbra
