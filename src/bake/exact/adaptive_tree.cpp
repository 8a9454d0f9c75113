#include "bake/exact/adaptive_tree.hpp"

#include <algorithm>
#include <bit>
#include <cmath>

namespace antumbra {
namespace {

bool share_volume(const Box3d& a, const Box3d& b) {
    for (int k = 0; k < 3; ++k)
        if (!(std::max(a.min[k], b.min[k]) < std::min(a.max[k], b.max[k])))
            return false;
    return true;
}

class Builder {
  public:
    Builder(const ExactCells& exact, const ViewTree& space, BuiltTree& tree, const std::atomic<bool>* cancel)
        : exact_(exact), space_(space), tree_(tree), cancel_(cancel) {}

    bool build(const ViewRegion& tile) {
        Solved root;
        if (!solve(tile, {}, root))
            return false;
        return grow(tile, std::move(root), 0);
    }

  private:
    struct Solved {
        bool wanted = true; ///< false: options.where does not touch it
        ExactCell cell;
        exact::HiddenParts hidden;
    };

    bool solve(const ViewRegion& region, const exact::HiddenParts& hidden, Solved& solved) {
        Box3d box = space_.spatial_box(region);
        const std::vector<Box3d>& where = exact_.options().where;
        solved.wanted = where.empty() || std::any_of(where.begin(), where.end(),
                                                     [&](const Box3d& wanted) { return share_volume(wanted, box); });
        if (!solved.wanted)
            return true;
        solved.cell = exact_.solve(box, cancel_, hidden, &solved.hidden);
        add(tree_.work, solved.cell.work);
        return solved.cell.finished;
    }

    /// Adds the node and all below it. False: cancelled.
    bool grow(const ViewRegion& region, Solved solved, std::uint32_t depth) {
        std::size_t index = tree_.nodes.size();
        tree_.nodes.push_back({ViewNode::kLeaf, 0, kCellNotBaked});
        if (!solved.wanted)
            return true;
        int axis = solved.cell.sample.solid || depth >= exact_.options().tree.max_depth || too_little(solved.cell.sample)
                       ? -1
                       : choose_axis(region);
        if (axis >= 0) {
            auto k = std::size_t(axis);
            std::uint32_t middle = (region.low[k] + region.high[k]) / 2;
            ViewRegion below = region, above = region;
            below.high[k] = above.low[k] = middle;
            Solved a, b;
            if (!solve(below, solved.hidden, a) || !solve(above, solved.hidden, b))
                return false;
            if (pays(a, b)) {
                solved = {};
                if (!grow(below, std::move(a), depth + 1))
                    return false;
                tree_.nodes[index] = {std::uint8_t(axis), std::uint16_t(middle), std::uint32_t(tree_.nodes.size())};
                return grow(above, std::move(b), depth + 1);
            }
        }
        tree_.nodes[index].link = std::uint32_t(tree_.leaves.size());
        tree_.leaves.push_back(std::move(solved.cell.sample));
        return true;
    }

    bool pays(const Solved& a, const Solved& b) const {
        if (!a.wanted || !b.wanted)
            return true;
        const RegionSample &x = a.cell.sample, &y = b.cell.sample;
        if (x.solid || y.solid)
            return !(x.solid && y.solid);
        std::uint64_t both = 0, seen = 0;
        for (std::size_t w = 0; w < x.visible.size(); ++w) {
            both += std::uint64_t(std::popcount(x.visible[w] & y.visible[w]));
            seen += std::uint64_t(std::popcount(x.visible[w] | y.visible[w]));
        }
        return seen > 0 && split_effectiveness(double(both), double(seen), 1, 1) > exact_.options().tree.effectiveness;
    }

    /// Too few triangles belong to visible objects.
    bool too_little(const RegionSample& sample) const {
        std::uint64_t triangles = 0;
        const auto& objects = exact_.scene().objects();
        for (std::size_t o = 0; o < objects.size(); ++o)
            if (sample.visible[o / 64] >> (o % 64) & 1)
                triangles += objects[o].source_triangles;
        return triangles < exact_.options().tree.min_visible;
    }

    /// The longest axis (world) that may be halved; -1: none.
    int choose_axis(const ViewRegion& region) const {
        Vec3d size = space_.spatial_box(region).size();
        int best = -1;
        for (int axis = 0; axis < 3; ++axis) {
            auto k = std::size_t(axis);
            std::uint32_t length = region.high[k] - region.low[k];
            if (double(length) < 2 * exact_.options().tree.min_extent * kViewSteps || length < 2 ||
                !is_on_grid(exact_.scene(), space_, axis, (region.low[k] + region.high[k]) / 2))
                continue;
            if (best < 0 || size[axis] > size[best])
                best = axis;
        }
        return best;
    }

    const ExactCells& exact_;
    const ViewTree& space_;
    BuiltTree& tree_;
    const std::atomic<bool>* cancel_;
};

} // namespace

bool is_on_grid(const Scene& scene, const ViewTree& space, int axis, std::uint32_t step) {
    double steps = (space.bounds.max[axis] - space.bounds.min[axis]) / scene.step(); // whole, below 2^53
    return std::fmod(std::floor(steps + 0.5) * step, double(kViewSteps)) == 0;
}

bool build_exact_tree(const ExactCells& exact, const ViewTree& space, const ViewRegion& tile, BuiltTree& tree,
                      const std::atomic<bool>* cancel) {
    return Builder(exact, space, tree, cancel).build(tile);
}

} // namespace antumbra
