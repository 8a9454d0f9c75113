#include "tree/kd_tree.hpp"

#include <algorithm>

namespace antumbra {
namespace {

struct Cut {
    int axis = -1; ///< none
    float at = 0;
};

/// Boundaries of a cell's items along one axis, sorted, to count what lies where.
struct Boundaries {
    std::vector<float> low, high, flat; ///< flat: items of no extent, which go to the low side

    void collect(std::span<const Box3f> boxes, std::span<const std::uint32_t> items, int axis) {
        low.clear();
        high.clear();
        flat.clear();
        for (std::uint32_t item : items) {
            low.push_back(boxes[item].min[axis]);
            high.push_back(boxes[item].max[axis]);
            if (low.back() == high.back())
                flat.push_back(low.back());
        }
        for (std::vector<float>* list : {&low, &high, &flat})
            std::sort(list->begin(), list->end());
    }
    std::size_t left_of(float at) const {
        auto [first, last] = std::equal_range(flat.begin(), flat.end(), at);
        return static_cast<std::size_t>(std::lower_bound(low.begin(), low.end(), at) - low.begin() + (last - first));
    }
    std::size_t right_of(float at) const {
        return high.size() - static_cast<std::size_t>(std::upper_bound(high.begin(), high.end(), at) - high.begin());
    }
};

class Builder {
  public:
    Builder(std::span<const Box3f> boxes, const KdTreeOptions& options) : boxes_(boxes), options_(options) {}

    KdTree run(std::span<const std::uint32_t> items) {
        Box3f cell;
        for (std::uint32_t item : items)
            cell.extend(boxes_[item]);
        if (!items.empty())
            build(cell, {items.begin(), items.end()}, 0, double(items.size()) * std::max(1.0, options_.most_copies));
        return std::move(tree_);
    }

  private:
    /// `allowance`: what the leaves below may list together; children share it by what they hold.
    void build(const Box3f& cell, std::vector<std::uint32_t> items, std::uint32_t depth, double allowance) {
        std::size_t index = tree_.nodes.size();
        tree_.nodes.push_back({cell, 0, 0, 0});
        Cut cut;
        if (items.size() > std::max(1u, options_.leaf_items) && depth < std::min(options_.most_depth, kMaxKdDepth))
            cut = options_.rule == KdRule::balanced_counts ? balanced(cell, items, depth) : fewest_splits(cell, items);
        std::vector<std::uint32_t> left, right;
        if (cut.axis >= 0)
            for (std::uint32_t item : items) {
                bool beyond = boxes_[item].max[cut.axis] > cut.at;
                if (boxes_[item].min[cut.axis] < cut.at || !beyond)
                    left.push_back(item);
                if (beyond)
                    right.push_back(item);
            }
        double listed = double(left.size() + right.size());
        if (cut.axis < 0 || listed > allowance) {
            tree_.nodes[index].first = static_cast<std::uint32_t>(tree_.items.size());
            tree_.nodes[index].count = static_cast<std::uint32_t>(items.size());
            std::sort(items.begin(), items.end());
            tree_.items.insert(tree_.items.end(), items.begin(), items.end());
            return;
        }
        items = {};
        double left_allowance = allowance * (double(left.size()) / listed);
        Box3f low = cell, high = cell;
        low.max[cut.axis] = high.min[cut.axis] = cut.at;
        build(low, std::move(left), depth + 1, left_allowance);
        tree_.nodes[index].right = static_cast<std::uint32_t>(tree_.nodes.size());
        build(high, std::move(right), depth + 1, allowance - left_allowance);
    }

    /// Calls use(at) for every boundary inside of the cell, ascending, each once.
    template <class Use>
    void for_boundaries(const Box3f& cell, int axis, Use&& use) const {
        std::size_t i = 0, j = 0;
        float last = cell.min[axis];
        while (i < sorted_.low.size() || j < sorted_.high.size()) {
            float at = j == sorted_.high.size() || (i < sorted_.low.size() && sorted_.low[i] <= sorted_.high[j])
                           ? sorted_.low[i++]
                           : sorted_.high[j++];
            if (at > last && at < cell.max[axis])
                use(last = at);
        }
    }

    /// Only cuts that leave fewer items on both sides are worth anything.
    bool helps(std::size_t left, std::size_t right, std::size_t all) const { return left < all && right < all; }

    Cut balanced(const Box3f& cell, std::span<const std::uint32_t> items, std::uint32_t depth) {
        for (std::uint32_t turn = 0; turn < 3; ++turn) {
            int axis = static_cast<int>((depth + turn) % 3);
            sorted_.collect(boxes_, items, axis);
            Cut best;
            std::size_t best_gap = ~std::size_t(0), best_sum = 0;
            for_boundaries(cell, axis, [&](float at) {
                std::size_t left = sorted_.left_of(at), right = sorted_.right_of(at);
                std::size_t gap = left > right ? left - right : right - left, sum = left + right;
                if (helps(left, right, items.size()) && (gap < best_gap || (gap == best_gap && sum < best_sum))) {
                    best = {axis, at};
                    best_gap = gap;
                    best_sum = sum;
                }
            });
            if (best.axis >= 0)
                return best;
        }
        return {};
    }

    Cut fewest_splits(const Box3f& cell, std::span<const std::uint32_t> items) {
        Vec3f size = cell.size();
        int order[3] = {0, 1, 2};
        std::stable_sort(order, order + 3, [&](int a, int b) { return size[a] > size[b]; });
        for (int axis : order) {
            sorted_.collect(boxes_, items, axis);
            double middle = (double(cell.min[axis]) + cell.max[axis]) / 2, reach = options_.window * double(size[axis]);
            Cut best, nearest;
            std::size_t best_splits = ~std::size_t(0);
            double best_distance = 0, nearest_distance = std::numeric_limits<double>::infinity();
            for_boundaries(cell, axis, [&](float at) {
                std::size_t left = sorted_.left_of(at), right = sorted_.right_of(at);
                if (!helps(left, right, items.size()))
                    return;
                std::size_t splits = left + right - items.size();
                double distance = std::abs(double(at) - middle);
                if (distance < nearest_distance) {
                    nearest_distance = distance;
                    nearest = {axis, at};
                }
                if (distance <= reach &&
                    (splits < best_splits || (splits == best_splits && distance < best_distance))) {
                    best_splits = splits;
                    best_distance = distance;
                    best = {axis, at};
                }
            });
            if (best.axis >= 0)
                return best;
            if (nearest.axis >= 0)
                return nearest;
        }
        return {};
    }

    std::span<const Box3f> boxes_;
    const KdTreeOptions& options_;
    KdTree tree_;
    Boundaries sorted_;
};

} // namespace

KdTree build_kd_tree(std::span<const Box3f> boxes, std::span<const std::uint32_t> items, const KdTreeOptions& options) {
    return Builder(boxes, options).run(items);
}

} // namespace antumbra
