#include "tree/object_tree.hpp"

#include <algorithm>
#include <array>
#include <limits>

namespace antumbra {
namespace {

constexpr int kBins = 16;

double area_of(const Box3f& box) {
    if (box.empty())
        return 0;
    Vec3d s = to_double(box.max) - to_double(box.min);
    return s.x * s.y + s.y * s.z + s.z * s.x;
}

struct Bin {
    Box3f box;
    std::uint32_t count = 0;
};

struct Split {
    int axis = -1;
    int bin = 0; ///< bins 0..bin go left
    double cost = std::numeric_limits<double>::infinity();
};

class Builder {
  public:
    Builder(std::span<const Box3f> bounds, std::vector<std::uint32_t>& order) : bounds_(bounds), order_(order) {
        nodes_.reserve(2 * order.size());
    }

    std::vector<BinaryNode> run() {
        if (!order_.empty())
            build(0, static_cast<std::uint32_t>(order_.size()), 0);
        return std::move(nodes_);
    }

  private:
    /// Depth is bounded: below half of the allowed depth ranges are halved by count, which ends after 32 more.
    void build(std::uint32_t first, std::uint32_t count, int depth) {
        auto index = static_cast<std::uint32_t>(nodes_.size());
        nodes_.push_back({});
        nodes_[index].first = first;
        nodes_[index].count = count;
        Box3d centroids;
        for (std::uint32_t i = first; i < first + count; ++i) {
            nodes_[index].box.extend(bounds_[order_[i]]);
            centroids.extend(to_double(bounds_[order_[i]]).centre());
        }
        if (count == 1)
            return;
        std::uint32_t left = 0;
        if (count > 2 && depth < kTreeDepth / 2)
            left = partition(first, count, centroids);
        if (left == 0 || left == count)
            left = halve(first, count, centroids);
        build(first, left, depth + 1);
        nodes_[index].right = static_cast<std::uint32_t>(nodes_.size());
        build(first + left, count - left, depth + 1);
    }

    int bin_of(std::uint32_t object, int axis, const Box3d& centroids) const {
        double low = centroids.min[axis], size = centroids.max[axis] - low;
        double centre = (double(bounds_[object].min[axis]) + bounds_[object].max[axis]) * 0.5;
        return std::clamp(static_cast<int>((centre - low) / size * kBins), 0, kBins - 1);
    }

    Split best_split(std::uint32_t first, std::uint32_t count, const Box3d& centroids) const {
        Split best;
        for (int axis = 0; axis < 3; ++axis) {
            if (!(centroids.max[axis] > centroids.min[axis]))
                continue;
            std::array<Bin, kBins> bins{};
            for (std::uint32_t i = first; i < first + count; ++i) {
                Bin& bin = bins[static_cast<std::size_t>(bin_of(order_[i], axis, centroids))];
                bin.box.extend(bounds_[order_[i]]);
                ++bin.count;
            }
            std::array<double, kBins> right_cost{};
            Bin sum;
            for (std::size_t b = kBins - 1; b > 0; --b) {
                sum.box.extend(bins[b].box);
                sum.count += bins[b].count;
                right_cost[b] = area_of(sum.box) * sum.count;
            }
            sum = {};
            for (std::size_t b = 0; b + 1 < kBins; ++b) {
                sum.box.extend(bins[b].box);
                sum.count += bins[b].count;
                double cost = area_of(sum.box) * sum.count + right_cost[b + 1];
                if (sum.count > 0 && sum.count < count && cost < best.cost)
                    best = {axis, static_cast<int>(b), cost};
            }
        }
        return best;
    }

    std::uint32_t partition(std::uint32_t first, std::uint32_t count, const Box3d& centroids) {
        Split split = best_split(first, count, centroids);
        if (split.axis < 0)
            return 0;
        auto begin = order_.begin() + first;
        auto middle = std::stable_partition(begin, begin + count, [&](std::uint32_t object) {
            return bin_of(object, split.axis, centroids) <= split.bin;
        });
        return static_cast<std::uint32_t>(middle - begin);
    }

    std::uint32_t halve(std::uint32_t first, std::uint32_t count, const Box3d& centroids) {
        Vec3d size = centroids.size();
        int axis = size.x >= size.y && size.x >= size.z ? 0 : size.y >= size.z ? 1 : 2;
        auto begin = order_.begin() + first;
        std::sort(begin, begin + count, [&](std::uint32_t a, std::uint32_t b) {
            double left = double(bounds_[a].min[axis]) + bounds_[a].max[axis];
            double right = double(bounds_[b].min[axis]) + bounds_[b].max[axis];
            return left != right ? left < right : a < b;
        });
        return count / 2;
    }

    std::span<const Box3f> bounds_;
    std::vector<std::uint32_t>& order_;
    std::vector<BinaryNode> nodes_;
};

/// Indices of the up to eight binary nodes that become the children of one wide node.
std::array<std::uint32_t, kWidth> open_largest(const std::vector<BinaryNode>& binary, std::uint32_t root,
                                               std::uint32_t& used) {
    std::array<std::uint32_t, kWidth> children{root};
    used = 1;
    while (used < kWidth) {
        std::uint32_t largest = kWidth;
        double area = -1;
        for (std::uint32_t c = 0; c < used; ++c)
            if (binary[children[c]].count > 1 && area_of(binary[children[c]].box) > area) {
                largest = c;
                area = area_of(binary[children[c]].box);
            }
        if (largest == kWidth)
            break;
        std::uint32_t opened = children[largest];
        // The right child goes next to the left one: slots stay in the order of `order`.
        std::copy_backward(children.begin() + largest + 1, children.begin() + used, children.begin() + used + 1);
        children[largest] = opened + 1;
        children[largest + 1] = binary[opened].right;
        ++used;
    }
    return children;
}

} // namespace

std::vector<BinaryNode> build_binary_tree(std::span<const Box3f> bounds, std::vector<std::uint32_t>& order) {
    return Builder(bounds, order).run();
}

std::vector<CullNode> collapse(const std::vector<BinaryNode>& binary, const std::vector<std::uint32_t>& order) {
    std::vector<CullNode> wide;
    if (binary.empty())
        return wide;
    std::vector<std::uint32_t> sources{0}; // sources[w]: the binary node that wide node w stands for
    for (std::size_t w = 0; w < sources.size(); ++w) {
        CullNode node;
        std::array<std::uint32_t, kWidth> children = open_largest(binary, sources[w], node.used);
        for (std::uint32_t slot = 0; slot < kWidth; ++slot) {
            const BinaryNode& child = binary[children[slot < node.used ? slot : 0]];
            for (int axis = 0; axis < 3; ++axis) {
                node.min[axis][slot] = child.box.min[axis];
                node.max[axis][slot] = child.box.max[axis];
            }
            node.first[slot] = child.first;
            node.count[slot] = child.count;
            if (child.count == 1) {
                node.child[slot] = order[child.first] | kObjectChild;
            } else if (slot < node.used) {
                node.child[slot] = static_cast<std::uint32_t>(sources.size());
                sources.push_back(children[slot]);
            } else {
                node.child[slot] = node.child[0];
            }
        }
        wide.push_back(node);
    }
    return wide;
}

} // namespace antumbra
