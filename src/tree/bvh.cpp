#include "tree/bvh.hpp"

#include "base/parallel.hpp"

#include <array>

namespace antumbra {
namespace {

constexpr int kBins = 16;
/// Below this depth nodes are cut in halves by count, which ends after at most 32 more levels.
constexpr int kMedianDepth = 40;
/// Subtrees of at most this share of all items are built as units of parallel work. A constant, so that the
/// tree does not depend on the number of threads.
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
float key_of(const Box3f& box, int axis) {
    return box.min[axis] + box.max[axis];
}

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
        auto middle =
            std::partition(items_.begin() + static_cast<std::ptrdiff_t>(task.begin),
                           items_.begin() + static_cast<std::ptrdiff_t>(task.end),
                           [&](const Item& item) { return binning.bin(item.box, split.axis) < split.bin; });
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
                Bin& bin = bins[static_cast<std::size_t>(k)]
                               [static_cast<std::size_t>(binning.bin(items_[i].box, k))];
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
            float cost =
                count ? half_area(box) * blocks(count) + right[b] : std::numeric_limits<float>::infinity();
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

/// Chooses which descendants of a binary node become the children of a wide one, so that the expected cost of
/// a ray is least (Ylitie, Karras and Laine, "Efficient incoherent ray traversal on GPUs through compressed
/// wide BVHs", 2017, section 3.1). cost(n, i): of the subtree at n as a forest of at most i roots.
template <int N>
class Widener {
  public:
    Widener(const Bvh& bvh, const BvhOptions& options)
        : bvh_(bvh), options_(options), plans_(bvh.nodes.size()) {
        for (std::size_t n = bvh.nodes.size(); n-- > 0;) // children before parents
            plan(static_cast<std::uint32_t>(n));
    }

    /// Items below a node; they are contiguous in Bvh::order.
    std::uint32_t first(std::uint32_t n) const { return plans_[n].first; }
    std::uint32_t count(std::uint32_t n) const { return plans_[n].count; }
    bool leaf(std::uint32_t n) const { return plans_[n].leaf; }

    /// Fills in the children of the wide node at n.
    int children(std::uint32_t n, std::array<std::uint32_t, N>& out) const {
        int count = 0;
        if (leaf(n))
            out[static_cast<std::size_t>(count++)] = n; // only the root of a small tree
        else
            distribute(n, N, out, count);
        return count;
    }

  private:
    struct Plan {
        float cost[N]; ///< [i - 1]: as at most i roots, i = 1 .. N - 1; the last: its children as N roots
        std::uint8_t left[N]; ///< [i - 1]: roots of the left child when there are i; 0: use fewer roots
        bool leaf = false;    ///< as one root it is best a leaf
        std::uint32_t first, count;
    };

    void plan(std::uint32_t n) {
        const BvhNode& node = bvh_.nodes[n];
        Plan& plan = plans_[n];
        float area = half_area(node.box);
        if (node.leaf()) {
            plan.first = node.first;
            plan.count = node.count;
            plan.leaf = true;
            for (int i = 0; i < N; ++i) {
                plan.cost[i] = leaf_cost(area, node.count);
                plan.left[i] = 0;
            }
            return;
        }
        const Plan &l = plans_[node.first], &r = plans_[node.first + 1];
        plan.first = l.first;
        plan.count = l.count + r.count;
        for (int i = N; i >= 2; --i) {
            float best = std::numeric_limits<float>::infinity();
            for (int k = 1; k < i; ++k) {
                float cost = l.cost[k - 1] + r.cost[i - k - 1];
                if (cost < best) {
                    best = cost;
                    plan.left[i - 1] = static_cast<std::uint8_t>(k);
                }
            }
            plan.cost[i - 1] = best;
        }
        float inner = plan.cost[N - 1] + options_.node_cost * area;
        plan.leaf = plan.count <= options_.leaf_size && leaf_cost(area, plan.count) <= inner;
        plan.cost[0] = plan.leaf ? leaf_cost(area, plan.count) : inner;
        plan.left[0] = 0;
        for (int i = 2; i < N; ++i)
            if (plan.cost[i - 2] <= plan.cost[i - 1]) {
                plan.cost[i - 1] = plan.cost[i - 2];
                plan.left[i - 1] = 0;
            }
    }

    float leaf_cost(float area, std::uint32_t count) const {
        return area * static_cast<float>((count + options_.block_size - 1) / options_.block_size);
    }

    void distribute(std::uint32_t n, int roots, std::array<std::uint32_t, N>& out, int& count) const {
        const Plan& plan = plans_[n];
        int left = plan.left[roots - 1];
        const BvhNode& node = bvh_.nodes[n];
        place(node.first, left, out, count);
        place(node.first + 1, roots - left, out, count);
    }
    void place(std::uint32_t n, int roots, std::array<std::uint32_t, N>& out, int& count) const {
        while (roots > 1 && plans_[n].left[roots - 1] == 0)
            --roots;
        if (roots == 1)
            out[static_cast<std::size_t>(count++)] = n;
        else
            distribute(n, roots, out, count);
    }

    const Bvh& bvh_;
    BvhOptions options_;
    std::vector<Plan> plans_;
};

} // namespace

template <int N>
WideBvh<N> widen(Bvh bvh, const BvhOptions& options) {
    WideBvh<N> wide;
    if (bvh.nodes.empty())
        return wide;
    Widener<N> plan(bvh, options);
    struct Task {
        std::uint32_t binary, wide;
    };
    std::vector<Task> todo{{0, 0}};
    wide.nodes.resize(1);
    while (!todo.empty()) {
        Task task = todo.back();
        todo.pop_back();
        std::array<std::uint32_t, N> children;
        int count = plan.children(task.binary, children);
        WideNode<N> node;
        std::size_t first_task = todo.size();
        for (int i = 0; i < N; ++i) {
            if (i >= count) {
                set_child<N>(node, i, Box3f{}, 0, 0);
                continue;
            }
            std::uint32_t child = children[static_cast<std::size_t>(i)];
            if (plan.leaf(child)) {
                set_child<N>(node, i, bvh.nodes[child].box, plan.first(child), plan.count(child));
                continue;
            }
            auto inner = static_cast<std::uint32_t>(wide.nodes.size());
            wide.nodes.emplace_back();
            todo.push_back({child, inner});
            set_child<N>(node, i, bvh.nodes[child].box, inner, 0);
        }
        std::reverse(todo.begin() + static_cast<std::ptrdiff_t>(first_task), todo.end());
        wide.nodes[task.wide] = node;
    }
    wide.order = std::move(bvh.order);
    return wide;
}

template WideBvh<4> widen<4>(Bvh bvh, const BvhOptions& options);
template WideBvh<8> widen<8>(Bvh bvh, const BvhOptions& options);
template WideBvh<16> widen<16>(Bvh bvh, const BvhOptions& options);

} // namespace antumbra
