#include "tree/bvh.hpp"

#include "base/parallel.hpp"

#include <array>

namespace antumbra {
namespace {

constexpr int kBins = 16;
/// Below this depth nodes are cut in halves by count, which ends after at most 32 more levels.
constexpr int kMedianDepth = 40;
/// Subtrees of at most this share of all items are built as units of parallel work. A constant, so that the tree
/// does not depend on the number of threads.
constexpr std::size_t kUnits = 64;
constexpr std::size_t kSmallestUnit = 2048;

struct Item {
    Box3f box;
    std::uint32_t index;
};

float half_area(const Box3f& box) {
    Vec3f size = box.size();
    return size.x * size.y + size.y * size.z + size.z * size.x;
}

/// Twice the centre: saves a multiplication and keeps the order.
float key_of(const Box3f& box, int axis) { return box.min[axis] + box.max[axis]; }

struct Bin {
    Box3f box;
    std::uint32_t count = 0;
};

/// Where to cut a range of items; axis -1: nowhere.
struct Split {
    int axis = -1;
    int bin = 0; ///< items of bins below go to the left
    float cost = std::numeric_limits<float>::infinity();
};

/// Maps centres to bins; the same for counting and for partitioning.
struct Binning {
    Vec3f low, scale;
    int bin(const Box3f& box, int axis) const {
        int b = static_cast<int>((key_of(box, axis) - low[axis]) * scale[axis]);
        return std::clamp(b, 0, kBins - 1);
    }
};

class Builder {
  public:
    Builder(std::span<Item> items, const BvhOptions& options) : items_(items), options_(options) {}

    /// Range of items that still has to become a subtree below `node`.
    struct Task {
        std::uint32_t node;
        std::size_t begin, end;
        int depth;
    };

    /// Builds the nodes of `task` into `nodes`; ranges of at most `defer` items are left to `deferred`.
    void build(Task task, std::vector<BvhNode>& nodes, std::size_t defer, std::vector<Task>& deferred) const {
        std::vector<Task> todo{task};
        while (!todo.empty()) {
            Task now = todo.back();
            todo.pop_back();
            if (now.end - now.begin <= defer) {
                deferred.push_back(now);
                continue;
            }
            Box3f box, centres;
            for (std::size_t i = now.begin; i < now.end; ++i) {
                box.extend(items_[i].box);
                centres.extend(items_[i].box.min + items_[i].box.max);
            }
            nodes[now.node].box = box;
            std::size_t middle = cut(now, box, centres);
            if (middle == now.begin) {
                nodes[now.node].first = static_cast<std::uint32_t>(now.begin);
                nodes[now.node].count = static_cast<std::uint32_t>(now.end - now.begin);
                continue;
            }
            auto child = static_cast<std::uint32_t>(nodes.size());
            nodes.resize(nodes.size() + 2);
            nodes[now.node].first = child;
            todo.push_back({child + 1, middle, now.end, now.depth + 1});
            todo.push_back({child, now.begin, middle, now.depth + 1});
        }
    }

  private:
    float blocks(std::size_t count) const {
        return static_cast<float>((count + options_.block_size - 1) / options_.block_size);
    }

    /// Partitions the items and returns the first of the right half; begin: better a leaf.
    std::size_t cut(const Task& task, const Box3f& box, const Box3f& centres) const {
        std::size_t count = task.end - task.begin;
        if (count == 1)
            return task.begin;
        Split split;
        Binning binning = binning_of(centres);
        if (task.depth < kMedianDepth)
            split = best_split(task, binning, centres);
        float whole = half_area(box);
        bool fits = count <= options_.leaf_size;
        if (fits && !(split.axis >= 0 && options_.node_cost * whole + split.cost < blocks(count) * whole))
            return task.begin;
        if (split.axis < 0) // all centres equal, or too deep: any halves will do
            return task.begin + count / 2;
        auto middle = std::partition(items_.begin() + static_cast<std::ptrdiff_t>(task.begin),
                                     items_.begin() + static_cast<std::ptrdiff_t>(task.end), [&](const Item& item) {
                                         return binning.bin(item.box, split.axis) < split.bin;
                                     });
        return static_cast<std::size_t>(middle - items_.begin());
    }

    static Binning binning_of(const Box3f& centres) {
        Binning binning;
        binning.low = centres.min;
        for (int k = 0; k < 3; ++k) {
            float extent = centres.max[k] - centres.min[k];
            binning.scale[k] = extent > 0 ? static_cast<float>(kBins) * 0.9999f / extent : 0.0f;
        }
        return binning;
    }

    Split best_split(const Task& task, const Binning& binning, const Box3f& centres) const {
        std::array<std::array<Bin, kBins>, 3> bins;
        for (std::size_t i = task.begin; i < task.end; ++i)
            for (int k = 0; k < 3; ++k) {
                Bin& bin = bins[static_cast<std::size_t>(k)][static_cast<std::size_t>(binning.bin(items_[i].box, k))];
                bin.box.extend(items_[i].box);
                ++bin.count;
            }
        Split best;
        for (int k = 0; k < 3; ++k)
            if (centres.max[k] > centres.min[k])
                sweep(bins[static_cast<std::size_t>(k)], k, best);
        return best;
    }

    /// Prices every plane between two bins of one axis.
    void sweep(const std::array<Bin, kBins>& bins, int axis, Split& best) const {
        std::array<float, kBins> right{};
        Box3f box;
        std::size_t count = 0;
        for (std::size_t b = kBins - 1; b > 0; --b) {
            box.extend(bins[b].box);
            count += bins[b].count;
            right[b] = count ? half_area(box) * blocks(count) : std::numeric_limits<float>::infinity();
        }
        box = {};
        count = 0;
        for (std::size_t b = 1; b < kBins; ++b) {
            box.extend(bins[b - 1].box);
            count += bins[b - 1].count;
            float cost = count ? half_area(box) * blocks(count) + right[b] : std::numeric_limits<float>::infinity();
            if (cost < best.cost)
                best = {axis, static_cast<int>(b), cost};
        }
    }

    std::span<Item> items_;
    BvhOptions options_;
};

/// Appends a subtree whose root replaces nodes[root].
void graft(std::vector<BvhNode>& nodes, std::uint32_t root, const std::vector<BvhNode>& subtree) {
    auto shift = static_cast<std::uint32_t>(nodes.size()) - 1;
    for (std::size_t i = 0; i < subtree.size(); ++i) {
        BvhNode node = subtree[i];
        if (!node.leaf())
            node.first += shift;
        if (i == 0)
            nodes[root] = node;
        else
            nodes.push_back(node);
    }
}

} // namespace

Bvh build_bvh(std::span<const Box3f> boxes, const BvhOptions& options, const Job& job) {
    Bvh bvh;
    if (boxes.empty())
        return bvh;
    std::vector<Item> items(boxes.size());
    for (std::size_t i = 0; i < boxes.size(); ++i)
        items[i] = {boxes[i], static_cast<std::uint32_t>(i)};
    Builder builder(items, options);
    bvh.nodes.resize(1);
    std::vector<Builder::Task> units;
    builder.build({0, 0, items.size(), 0}, bvh.nodes, std::max(items.size() / kUnits, kSmallestUnit), units);
    std::vector<std::vector<BvhNode>> subtrees(units.size());
    Job uncancelled;
    uncancelled.threads = job.threads;
    parallel_for(units.size(), uncancelled, [&](std::size_t u, unsigned) {
        std::vector<Builder::Task> none;
        subtrees[u].resize(1);
        Builder::Task task = units[u];
        task.node = 0;
        builder.build(task, subtrees[u], 0, none);
    });
    for (std::size_t u = 0; u < units.size(); ++u)
        graft(bvh.nodes, units[u].node, subtrees[u]);
    bvh.order.resize(items.size());
    for (std::size_t i = 0; i < items.size(); ++i)
        bvh.order[i] = items[i].index;
    return bvh;
}

namespace {

template <int N>
void set_child(WideNode<N>& node, int slot, const Box3f& box, std::uint32_t first, std::uint32_t count) {
    for (int k = 0; k < 3; ++k) {
        node.bounds[2 * k][slot] = box.min[k];
        node.bounds[2 * k + 1][slot] = box.max[k];
    }
    node.first[slot] = first;
    node.count[slot] = count;
}

/// The up to N descendants of `root` that become its children: the largest inner one is opened again and again.
template <int N>
int pull_up(const Bvh& bvh, std::uint32_t root, std::array<std::uint32_t, N>& children) {
    const BvhNode& node = bvh.nodes[root];
    int count = 0;
    if (node.leaf()) {
        children[0] = root;
        return 1;
    }
    children[0] = node.first;
    children[1] = node.first + 1;
    count = 2;
    while (count < N) {
        int largest = -1;
        float area = -1;
        for (int i = 0; i < count; ++i) {
            const BvhNode& child = bvh.nodes[children[static_cast<std::size_t>(i)]];
            if (!child.leaf() && half_area(child.box) > area) {
                area = half_area(child.box);
                largest = i;
            }
        }
        if (largest < 0)
            break;
        std::uint32_t opened = bvh.nodes[children[static_cast<std::size_t>(largest)]].first;
        children[static_cast<std::size_t>(largest)] = opened;
        children[static_cast<std::size_t>(count++)] = opened + 1;
    }
    return count;
}

} // namespace

template <int N>
WideBvh<N> widen(Bvh bvh) {
    WideBvh<N> wide;
    if (bvh.nodes.empty())
        return wide;
    struct Task {
        std::uint32_t binary, wide;
    };
    std::vector<Task> todo{{0, 0}};
    wide.nodes.resize(1);
    while (!todo.empty()) {
        Task task = todo.back();
        todo.pop_back();
        std::array<std::uint32_t, N> children;
        int count = pull_up<N>(bvh, task.binary, children);
        WideNode<N> node;
        std::size_t first_task = todo.size();
        for (int i = 0; i < N; ++i) {
            if (i >= count) {
                set_child<N>(node, i, Box3f{}, 0, 0);
                continue;
            }
            const BvhNode& child = bvh.nodes[children[static_cast<std::size_t>(i)]];
            std::uint32_t first = child.first;
            if (!child.leaf()) {
                first = static_cast<std::uint32_t>(wide.nodes.size());
                wide.nodes.emplace_back();
                todo.push_back({children[static_cast<std::size_t>(i)], first});
            }
            set_child<N>(node, i, child.box, first, child.count);
        }
        std::reverse(todo.begin() + static_cast<std::ptrdiff_t>(first_task), todo.end());
        wide.nodes[task.wide] = node;
    }
    wide.order = std::move(bvh.order);
    return wide;
}

template WideBvh<4> widen<4>(Bvh bvh);
template WideBvh<8> widen<8>(Bvh bvh);

} // namespace antumbra
