// Building the tree: polygons are filtered down to the leaves and enlarge the tree there (sections 4.1, 5 and 6.1).
#include "occlusion_tree/occlusion_tree.hpp"

#include <numeric>

namespace antumbra {
namespace {

constexpr double kSharp = 0.2; ///< cosine of the angle between planes that meet sharply
constexpr std::size_t kMostPoints = 1u << 15;

} // namespace

OcclusionTree::OcclusionTree(const OcclusionTreeLimits& limits) : limits_(limits) {
    sight_.reserve(kMostPoints, limits.lines + 256, limits.fragments + 256);
    nodes_.reserve(limits.nodes);
    fragments_.reserve(limits.fragments);
    fragment_edges_.reserve(std::size_t(limits.fragments) * 6);
    stack_.reserve(kMostPending);
    unsplit_stack_.reserve(limits.nodes + 1);
    unsplit_path_.reserve(limits.nodes + 1);
    pool_.resize(kMostPending);
    slots_.resize(kMostPending);
    std::iota(slots_.begin(), slots_.end(), std::uint16_t(0));
    reached_.reserve(kMostReached);
    reached_lines_.reserve(4 * kMostReached);
}

void OcclusionTree::begin(const Vec3d& eye, double size, TreeForm form, ExtraNodes extra_nodes) {
    sight_.begin(eye, size);
    form_ = form;
    extra_nodes_ = extra_nodes;
    extra_.clear();
    root_ = kOut;
    ran_out_ = false;
    nodes_.clear();
    fragments_.clear();
    fragment_edges_.clear();
    planes_tested_ = 0;
    reached_.assign(1, {kOut, 0, 0});
    reached_lines_.clear();
}

OcclusionTree::Child& OcclusionTree::child_at(std::uint32_t parent) {
    if (parent == kRoot)
        return root_;
    Node& node = nodes_[parent >> 1];
    return parent & 1 ? node.inside : node.outside;
}

bool OcclusionTree::picture_of(std::span<const std::uint32_t> loop, PicturePolygon& polygon) {
    polygon.count = 0;
    if (loop.size() > PicturePolygon::kMost || sight_.mark().lines + loop.size() > limits_.lines)
        return false;
    // Seen from the eye the loop turns left; edges that keep the polygon on the positive side turn right.
    for (std::size_t i = loop.size(); i-- > 0;) {
        std::uint32_t next = loop[i == 0 ? loop.size() - 1 : i - 1];
        polygon.push(sight_.toward(loop[i]), sight_.add_edge(loop[i], next), false);
    }
    return true;
}

bool OcclusionTree::cut_in_pool(LineRef line, std::uint32_t polygon, const signed char* sides) {
    std::uint32_t inside = polygon + 1, outside = polygon + 2;
    if (outside >= kMostPending || !cut(sight_, line, pool(polygon), sides, &pool(inside), &pool(outside)))
        return false;
    std::swap(slots_[polygon], slots_[outside]);
    return true;
}

bool OcclusionTree::insert(std::span<const std::uint32_t> loop, std::uint32_t plane, std::uint32_t occluder) {
    if (!picture_of(loop, pool(0))) {
        ran_out_ = true;
        return false;
    }
    return filter_down(plane, occluder);
}

bool OcclusionTree::insert(const PicturePolygon& polygon, std::uint32_t plane, std::uint32_t occluder) {
    pool(0) = polygon;
    return filter_down(plane, occluder);
}

/// Figure 3 of the paper, with a stack of our own. The polygon is in pool(0).
bool OcclusionTree::filter_down(std::uint32_t plane, std::uint32_t occluder) {
    signed char sides[PicturePolygon::kMost];
    bool whole = true;
    stack_.clear();
    stack_.push_back({root_, kRoot, 0});
    while (!stack_.empty()) {
        Work work = stack_.back();
        stack_.pop_back();
        bool done = false;
        while (!done && work.child >= 0) {
            const Node& node = nodes_[static_cast<std::size_t>(work.child)];
            std::uint32_t at = static_cast<std::uint32_t>(work.child) << 1;
            ++planes_tested_;
            switch (locate(sight_, node.line, pool(work.polygon), sides)) {
            case Place::inside: work = {node.inside, at | 1, work.polygon}; break;
            case Place::outside: work = {node.outside, at, work.polygon}; break;
            case Place::both: {
                if (!cut_in_pool(node.line, work.polygon, sides)) {
                    done = true;
                    whole = false;
                    break;
                }
                stack_.push_back({node.outside, at, work.polygon});
                work = {node.inside, at | 1, work.polygon + 1};
                break;
            }
            case Place::undecided:
                done = true;
                whole = false;
                break;
            }
        }
        if (done)
            continue;
        work.child = child_at(work.parent);
        whole &= work.child == kOut ? enlarge(work, plane, occluder) : enlarge_in_front(work, plane, occluder);
    }
    ran_out_ |= !whole;
    return whole;
}

/// New nodes for the edges that are not flagged (for all, in the plain form), and in the innermost place the fragment.
bool OcclusionTree::enlarge(const Work& work, std::uint32_t plane, std::uint32_t occluder) {
    const PicturePolygon& polygon = pool(work.polygon);
    auto edges = static_cast<std::size_t>(polygon.count);
    if (nodes_.size() + edges > limits_.nodes || fragments_.size() == limits_.fragments ||
        fragment_edges_.size() + edges > fragment_edges_.capacity())
        return false;
    Child before = child_at(work.parent);
    fragments_.push_back({plane, occluder, static_cast<std::uint32_t>(fragment_edges_.size()),
                          static_cast<std::uint32_t>(edges)});
    std::uint32_t at = work.parent;
    std::int32_t node_of_edge[PicturePolygon::kMost];
    for (int i = 0; i < polygon.count; ++i) {
        fragment_edges_.push_back(polygon.edge(i));
        node_of_edge[i] = -1;
        if (polygon.flagged(i) && form_ == TreeForm::modified)
            continue;
        node_of_edge[i] = static_cast<std::int32_t>(nodes_.size());
        child_at(at) = static_cast<Child>(nodes_.size());
        at = static_cast<std::uint32_t>(nodes_.size()) << 1 | 1;
        nodes_.push_back({polygon.edge(i), kOut, before});
    }
    child_at(at) = in_leaf(fragments_.size() - 1);
    if (extra_nodes_ != ExtraNodes::none)
        add_extra_nodes(polygon, {node_of_edge, edges});
    return true;
}

/// Where an edge meets a neighbour whose plane is on the path already, the parts of the picture on both sides of the edge lie
/// between two planes. If they meet at a sharp angle, what crosses both planes need not come in between.
void OcclusionTree::add_extra_nodes(const PicturePolygon& polygon, std::span<const std::int32_t> node_of_edge) {
    extra_.resize(nodes_.size());
    auto count = static_cast<int>(node_of_edge.size());
    for (int i = 0; i < count; ++i) {
        if (node_of_edge[static_cast<std::size_t>(i)] < 0)
            continue;
        Extra& extra = extra_[static_cast<std::size_t>(node_of_edge[static_cast<std::size_t>(i)])];
        for (int side = 0; side < 2 && sight_.mark().lines + 2 <= limits_.lines; ++side) {
            int neighbour = (i + (side ? 1 : count - 1)) % count;
            std::int32_t node = node_of_edge[static_cast<std::size_t>(neighbour)];
            bool on_path = node >= 0 ? node < node_of_edge[static_cast<std::size_t>(i)] : polygon.flagged(neighbour);
            if (!on_path)
                continue;
            double cosine = sight_.cosine(polygon.edge(neighbour), polygon.edge(i));
            if (cosine > kSharp)
                extra.outside[side ? 1 : 0] = sight_.add_blend(polygon.edge(neighbour), -polygon.edge(i));
            else if (cosine < -kSharp)
                extra.inside[side ? 1 : 0] = sight_.add_blend(polygon.edge(neighbour), polygon.edge(i));
        }
        if (extra.outside[0].bits == kNoLine)
            std::swap(extra.outside[0], extra.outside[1]);
        if (extra.inside[0].bits == kNoLine)
            std::swap(extra.inside[0], extra.inside[1]);
    }
}

/// At an in-leaf only the part that lies in front of what is there counts. With occluders in front-to-back order there
/// is none, and nothing is done.
bool OcclusionTree::enlarge_in_front(const Work& work, std::uint32_t plane, std::uint32_t occluder) {
    std::uint32_t there = fragments_[fragment_of(work.child)].plane;
    if (there == plane)
        return true;
    if (sight_.mark().lines == limits_.lines)
        return false;
    signed char sides[PicturePolygon::kMost];
    LineRef nearer = sight_.add_meeting(there, plane); // positive: what is there is farther
    bool positive = false, negative = false;
    PicturePolygon& polygon = pool(work.polygon);
    for (int i = 0; i < polygon.count; ++i) {
        int side = sight_.side(nearer, polygon.at(i));
        if (side == kUndecided)
            return false;
        sides[i] = static_cast<signed char>(side);
        positive |= side > 0;
        negative |= side < 0;
    }
    if (!positive)
        return true;
    if (negative) {
        std::uint32_t other = work.polygon + 1;
        if (other >= kMostPending || !cut(sight_, nearer, polygon, sides, &pool(other), nullptr))
            return false;
        for (int i = 0; i < pool(other).count; ++i) // no plane of the tree holds that edge
            pool(other).facts[i].flagged &= pool(other).edge(i).bits != nearer.bits;
        return enlarge({work.child, work.parent, other}, plane, occluder);
    }
    return enlarge(work, plane, occluder);
}

} // namespace antumbra
