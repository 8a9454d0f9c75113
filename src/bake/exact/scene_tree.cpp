#include "bake/exact/scene_tree.hpp"

#include "bake/exact/integer.hpp"

#include <algorithm>
#include <cmath>
#include <numeric>

namespace antumbra::exact {
namespace {

constexpr std::uint32_t kLeafTriangles = 2;
constexpr int kBins = 16;

double half_area(const GridBox& b) {
    double d[3];
    for (int k = 0; k < 3; ++k)
        d[k] = static_cast<double>(b.max[k] - b.min[k]);
    return d[0] * d[1] + d[1] * d[2] + d[2] * d[0];
}

struct Item {
    GridBox box;
    std::uint32_t id;
    std::int64_t centre(int axis) const { return box.min[axis] + box.max[axis]; }
};

/// Where to cut a range of items in two: by the surface area heuristic over bins of centres, or in the middle.
std::size_t partition(std::vector<Item>& items, std::size_t first, std::size_t count) {
    int best_axis = -1, best_bin = 0;
    double best_cost = 0;
    std::int64_t low[3], high[3];
    for (int axis = 0; axis < 3; ++axis) {
        low[axis] = INT64_MAX;
        high[axis] = INT64_MIN;
        for (std::size_t i = first; i < first + count; ++i) {
            low[axis] = std::min(low[axis], items[i].centre(axis));
            high[axis] = std::max(high[axis], items[i].centre(axis));
        }
    }
    auto bin_of = [&](const Item& item, int axis) {
        return static_cast<int>((item.centre(axis) - low[axis]) * kBins / (high[axis] - low[axis] + 1));
    };
    for (int axis = 0; axis < 3; ++axis) {
        if (low[axis] == high[axis])
            continue;
        GridBox boxes[kBins];
        std::size_t counts[kBins] = {};
        for (std::size_t i = first; i < first + count; ++i) {
            int bin = bin_of(items[i], axis);
            boxes[bin].extend(items[i].box);
            ++counts[bin];
        }
        double right_area[kBins];
        GridBox sum;
        for (int bin = kBins - 1; bin > 0; --bin) {
            if (counts[bin])
                sum.extend(boxes[bin]);
            right_area[bin] = sum.min.x > sum.max.x ? 0 : half_area(sum);
        }
        sum = {};
        std::size_t left = 0;
        for (int bin = 0; bin + 1 < kBins; ++bin) {
            if (counts[bin])
                sum.extend(boxes[bin]);
            left += counts[bin];
            if (left == 0 || left == count)
                continue;
            double cost = static_cast<double>(left) * half_area(sum) +
                          static_cast<double>(count - left) * right_area[bin + 1];
            if (best_axis < 0 || cost < best_cost) {
                best_axis = axis;
                best_bin = bin;
                best_cost = cost;
            }
        }
    }
    if (best_axis < 0)
        return first + count / 2;
    auto begin = items.begin() + static_cast<std::ptrdiff_t>(first);
    auto middle = std::stable_partition(begin, begin + static_cast<std::ptrdiff_t>(count), [&](const Item& item) {
        return bin_of(item, best_axis) <= best_bin;
    });
    return static_cast<std::size_t>(middle - items.begin());
}

} // namespace

struct SceneTree::Builder {
    SceneTree& tree;
    std::vector<Item> triangles;

    void set_leaf(std::uint32_t node, std::size_t first, std::size_t count) {
        Node& n = tree.nodes_[node];
        n.first = static_cast<std::uint32_t>(tree.order_.size());
        n.count = static_cast<std::uint32_t>(count);
        for (std::size_t i = first; i < first + count; ++i) {
            n.box.extend(triangles[i].box);
            tree.order_.push_back(triangles[i].id);
            tree.leaf_of_[triangles[i].id] = node;
        }
    }
    std::uint32_t add_children(std::uint32_t node) {
        auto children = static_cast<std::uint32_t>(tree.nodes_.size());
        tree.nodes_[node].children = children;
        tree.nodes_.resize(tree.nodes_.size() + 2);
        tree.parents_.resize(tree.nodes_.size(), node);
        return children;
    }
    void close(std::uint32_t node) {
        const Node &a = tree.nodes_[tree.nodes_[node].children], &b = tree.nodes_[tree.nodes_[node].children + 1];
        Node& n = tree.nodes_[node];
        n.box.extend(a.box);
        n.box.extend(b.box);
        n.first = a.first;
        n.count = a.count + b.count;
        n.object = a.object == b.object ? a.object : kManyObjects;
        n.unit = a.unit == b.unit ? a.unit : kManyObjects;
        n.units = n.unit != kManyObjects ? 1 : a.units + b.units;
    }
    /// The triangles of one unit.
    void build_triangles(std::uint32_t node, std::size_t first, std::size_t count) {
        if (count <= kLeafTriangles) {
            set_leaf(node, first, count);
            Node& n = tree.nodes_[node];
            n.object = tree.scene_->triangle_objects()[triangles[first].id];
            n.unit = tree.units_.of[triangles[first].id];
            n.units = 1;
            return;
        }
        std::size_t middle = partition(triangles, first, count);
        std::uint32_t children = add_children(node);
        build_triangles(children, first, middle - first);
        build_triangles(children + 1, middle, first + count - middle);
        close(node);
    }
    /// Items [first, first + count) of a level; `build_one` goes on below a single one.
    template <class BuildOne>
    void build_level(std::uint32_t node, std::vector<Item>& items, std::size_t first, std::size_t count,
                     const BuildOne& build_one) {
        if (count == 1) {
            build_one(node, items[first].id);
            return;
        }
        std::size_t middle = partition(items, first, count);
        std::uint32_t children = add_children(node);
        build_level(children, items, first, middle - first, build_one);
        build_level(children + 1, items, middle, first + count - middle, build_one);
        close(node);
    }
    GridBox box_of(std::uint32_t first, std::uint32_t last) const {
        GridBox box;
        for (std::uint32_t t = first; t < last; ++t)
            box.extend(triangles[t].box); // by unit: each range is sorted within itself
        return box;
    }
    void build_unit(std::uint32_t node, std::uint32_t unit) {
        const Units& units = tree.units_;
        build_triangles(node, units.first[unit], units.first[unit + 1] - units.first[unit]);
    }
    void build_object(std::uint32_t node, std::uint32_t index) {
        const Object& object = tree.scene_->objects()[index];
        auto [first, last] = tree.units_.range_of(object);
        std::vector<Item> items;
        for (std::uint32_t u = first; u <= last; ++u)
            items.push_back({box_of(tree.units_.first[u], tree.units_.first[u + 1]), u});
        build_level(node, items, 0, items.size(), [&](std::uint32_t n, std::uint32_t unit) { build_unit(n, unit); });
    }
    void build_all() {
        std::vector<Item> items;
        for (std::uint32_t o = 0; o < tree.scene_->objects().size(); ++o) {
            const Object& object = tree.scene_->objects()[o];
            if (object.triangle_count > 0)
                items.push_back({box_of(object.first_triangle, object.first_triangle + object.triangle_count), o});
        }
        build_level(0, items, 0, items.size(), [&](std::uint32_t n, std::uint32_t o) { build_object(n, o); });
    }
};

GridPoint SceneTree::to_grid(const Vec3d& local) const {
    GridPoint p;
    for (int k = 0; k < 3; ++k)
        p[k] = static_cast<std::int64_t>(std::floor(local[k] / scene_->step() + 0.5)); // exact: a power of two
    return p;
}

/// Groups edges by their two end points, whichever vertex of the file these are.
void SceneTree::connect_edges() {
    auto count = static_cast<std::uint32_t>(3 * corners_.size());
    auto point = [&](std::uint32_t corner) -> const GridPoint& { return corners_[corner / 3][corner % 3]; };
    std::vector<std::uint32_t> order(count);
    std::iota(order.begin(), order.end(), 0u);
    std::sort(order.begin(), order.end(), [&](std::uint32_t a, std::uint32_t b) {
        const GridPoint &p = point(a), &q = point(b);
        return p.x != q.x ? p.x < q.x : p.y != q.y ? p.y < q.y : p.z < q.z;
    });
    point_of_.resize(count);
    for (std::uint32_t k = 0, id = 0; k < count; ++k) {
        if (k > 0 && !(point(order[k]) == point(order[k - 1])))
            ++id;
        point_of_[order[k]] = id;
    }
    edges_.clear();
    std::vector<std::uint64_t> key(count);
    for (std::uint32_t e = 0; e < count; ++e) {
        std::uint32_t a = point_of_[e], b = point_of_[e / 3 * 3 + (e % 3 + 1) % 3];
        key[e] = std::uint64_t(std::min(a, b)) << 32 | std::max(a, b);
        if (occludes(e / 3))
            edges_.push_back(e);
    }
    std::sort(edges_.begin(), edges_.end(),
              [&](std::uint32_t a, std::uint32_t b) { return key[a] != key[b] ? key[a] < key[b] : a < b; });
    edge_group_.assign(count, kNoGroup);
    for (std::uint32_t k = 0; k < edges_.size(); ++k) {
        if (k == 0 || key[edges_[k]] != key[edges_[k - 1]])
            group_first_.push_back(k);
        edge_group_[edges_[k]] = static_cast<std::uint32_t>(group_first_.size() - 1);
    }
    group_first_.push_back(static_cast<std::uint32_t>(edges_.size()));
}

SceneTree SceneTree::build(const Scene& scene) { return build(scene, Units::objects(scene)); }

void SceneTree::copy_child_boxes() {
    child_boxes_.resize(nodes_.size() / 2);
    for (std::size_t n = 1; n < nodes_.size(); ++n) {
        ChildBoxes& boxes = child_boxes_[(n - 1) / 2];
        for (int k = 0; k < 3; ++k) {
            boxes.low[k][(n - 1) % 2] = static_cast<float>(nodes_[n].box.min[k]) - kGrown;
            boxes.high[k][(n - 1) % 2] = static_cast<float>(nodes_[n].box.max[k]) + kGrown;
        }
    }
}

SceneTree SceneTree::build(const Scene& scene, Units units) {
    SceneTree tree;
    tree.scene_ = &scene;
    tree.units_ = std::move(units);
    auto count = static_cast<std::uint32_t>(scene.triangles().size());
    tree.corners_.resize(count);
    tree.leaf_of_.resize(count);
    tree.order_.reserve(count);
    Builder builder{tree, {}};
    builder.triangles.resize(count);
    std::vector<GridBox> boxes(count);
    for (std::uint32_t t = 0; t < count; ++t) {
        GridBox box;
        for (int c = 0; c < 3; ++c) {
            GridPoint p = tree.to_grid(scene.vertex(t, c));
            tree.corners_[t][static_cast<std::size_t>(c)] = p;
            box.extend(p);
        }
        boxes[t] = box;
    }
    for (std::uint32_t k = 0; k < count; ++k)
        builder.triangles[k] = {boxes[tree.units_.order[k]], tree.units_.order[k]};
    tree.nodes_.resize(1);
    tree.parents_.push_back(0);
    builder.build_all();
    tree.copy_child_boxes();
    tree.root_of_.assign(tree.units_.count(), UINT32_MAX);
    for (std::uint32_t n = 0; n < tree.nodes_.size(); ++n) // parents come before their children
        if (std::uint32_t unit = tree.nodes_[n].unit; unit != kManyObjects && tree.root_of_[unit] == UINT32_MAX)
            tree.root_of_[unit] = n;
    tree.connect_edges();
    tree.patches_ = ConvexPatches::build(tree);
    return tree;
}

bool touches(const GridBox& box, const std::array<GridPoint, 3>& triangle) {
    // Twice the coordinates, so that the box's centre is an integer.
    GridPoint centre = box.min + box.max, half = box.max - box.min;
    GridPoint v[3];
    for (std::size_t i = 0; i < 3; ++i)
        v[i] = triangle[i] * 2 - centre;
    auto separates = [&](const GridPoint& axis) {
        Int128 low = 0, high = 0, reach = 0;
        for (int i = 0; i < 3; ++i) {
            Int128 at = 0;
            for (int k = 0; k < 3; ++k)
                at += static_cast<Int128>(axis[k]) * v[i][k];
            low = i == 0 || at < low ? at : low;
            high = i == 0 || at > high ? at : high;
        }
        for (int k = 0; k < 3; ++k)
            reach += static_cast<Int128>(axis[k] < 0 ? -axis[k] : axis[k]) * half[k];
        return low > reach || high < -reach;
    };
    GridPoint e[3] = {triangle[1] - triangle[0], triangle[2] - triangle[1], triangle[0] - triangle[2]};
    if (separates(cross(e[0], e[1])))
        return false;
    for (int k = 0; k < 3; ++k) {
        GridPoint axis{0, 0, 0};
        axis[k] = 1;
        if (separates(axis))
            return false;
        for (const GridPoint& edge : e)
            if (separates(cross(axis, edge)))
                return false;
    }
    return true;
}

std::array<GridPoint, 4> face_of(const GridBox& box, int axis, int side) {
    int b = (axis + 1) % 3, c = (axis + 2) % 3;
    std::array<GridPoint, 4> corners;
    for (int k = 0; k < 4; ++k) {
        GridPoint p;
        p[axis] = side ? box.max[axis] : box.min[axis];
        p[b] = k == 1 || k == 2 ? box.max[b] : box.min[b];
        p[c] = k >= 2 ? box.max[c] : box.min[c];
        corners[static_cast<std::size_t>(side ? k : 3 - k)] = p;
    }
    return corners;
}

} // namespace antumbra::exact
