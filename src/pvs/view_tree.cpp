// Walks over a view tree. All of them keep their stack on the machine's: depth is bounded by the format.
#include "pvs/direction.hpp"
#include "pvs/grid.hpp"


namespace antumbra {
namespace {

/// A node and the box of view space that it stands for.
struct Visit {
    std::uint32_t node;
    std::uint32_t depth;
    ViewRegion box;
};

/// Nodes still to be visited: in preorder at most one per level waits, beside the one in hand.
class VisitStack {
  public:
    bool empty() const { return count_ == 0; }
    void push(const Visit& visit) { visits_[count_++] = visit; }
    Visit pop() { return visits_[--count_]; }

  private:
    std::array<Visit, ViewTree::kMostDepth + 1> visits_;
    std::size_t count_ = 0;
};

Visit below(const ViewNode& inner, const Visit& visit) {
    Visit child{visit.node + 1, visit.depth + 1, visit.box};
    child.box.high[inner.axis] = inner.split;
    return child;
}
Visit above(const ViewNode& inner, const Visit& visit) {
    Visit child{inner.link, visit.depth + 1, visit.box};
    child.box.low[inner.axis] = inner.split;
    return child;
}

bool is_answer(std::uint32_t row, std::uint32_t row_count) { return row < row_count || row >= kCellSolid; }

Status refuse(std::size_t node, const char* what) {
    return {ErrorCode::usage, "node " + std::to_string(node) + " of the view tree " + what};
}

} // namespace

double ViewTree::position(int axis, std::uint32_t step) const {
    return slab_start(bounds.min[axis], bounds.max[axis], kViewSteps, step);
}

Box3d ViewTree::spatial_box(const ViewRegion& box) const {
    Box3d space;
    for (int axis = 0; axis < 3; ++axis) {
        auto k = static_cast<std::size_t>(axis);
        space.min[axis] = position(axis, box.low[k]);
        space.max[axis] = position(axis, box.high[k]);
    }
    return space;
}

ViewRegion ViewTree::region(std::uint32_t node) const {
    Visit visit{0, 0, {}};
    while (visit.node < node) {
        const ViewNode& inner = nodes[visit.node];
        visit = node < inner.link ? below(inner, visit) : above(inner, visit);
    }
    return visit.box;
}

std::int64_t ViewTree::find_leaf(const Vec3d& eye) const {
    if (nodes.empty() || !bounds.contains(eye))
        return -1;
    for (std::uint32_t n = 0;;) {
        const ViewNode& node = nodes[n];
        if (node.axis == ViewNode::kLeaf)
            return n;
        if (node.axis > 2)
            return -1;
        n = eye[node.axis] < position(node.axis, node.split) ? n + 1 : node.link;
    }
}

Status ViewTree::check(std::uint32_t row_count) const {
    if (nodes.empty())
        return {};
    if (!are_usable_bounds(bounds))
        return {ErrorCode::usage, "the bounds of the view tree are empty or not finite"};
    if (nodes.size() > 0xFFFFFFFFu)
        return {ErrorCode::limit, "the view tree has more than 2^32 nodes"};
    VisitStack stack;
    stack.push({0, 0, {}});
    // In preorder the next node is always the one on top of the stack.
    for (std::size_t n = 0; n < nodes.size(); ++n) {
        if (stack.empty())
            return refuse(n, "belongs to no parent");
        Visit visit = stack.pop();
        const ViewNode& node = nodes[n];
        if (visit.node != n)
            return refuse(n, "is not where its parent says");
        if (node.axis == ViewNode::kLeaf) {
            if (!is_answer(node.link, row_count))
                return refuse(n, "refers to a row that does not exist");
            continue;
        }
        if (node.axis > ViewNode::kLeaf)
            return refuse(n, "splits no axis");
        if (node.split <= visit.box.low[node.axis] || node.split >= visit.box.high[node.axis])
            return refuse(n, "splits outside its own box");
        if (visit.depth == kMostDepth)
            return refuse(n, "lies too deep");
        stack.push(above(node, visit));
        stack.push(below(node, visit));
    }
    return stack.empty() ? Status() : refuse(nodes.size(), "is missing");
}

bool ViewTree::find_leaves(const ViewRange& range, std::vector<std::uint32_t>& leaves) const {
    // contains() is false for NaN.
    if (nodes.empty() || !bounds.contains(range.eyes.min) || !bounds.contains(range.eyes.max) || range.eyes.empty())
        return false;
    DirectionBoxes directions = cover_directions(range);
    VisitStack stack;
    stack.push({0, 0, {}});
    while (!stack.empty()) {
        Visit visit = stack.pop();
        const ViewNode& node = nodes[visit.node];
        if (node.axis == ViewNode::kLeaf) {
            leaves.push_back(visit.node);
            continue;
        }
        Visit low = below(node, visit), high = above(node, visit);
        bool is_spatial = node.axis < 3;
        double split = is_spatial ? position(node.axis, node.split) : 0;
        if (is_spatial ? range.eyes.max[node.axis] >= split : directions.touch(high.box))
            stack.push(high);
        if (is_spatial ? range.eyes.min[node.axis] < split : directions.touch(low.box))
            stack.push(low);
    }
    return true;
}

} // namespace antumbra
