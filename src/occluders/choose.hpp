// The choice of occluders at run time: the k groups of the largest area-angle, refreshed a little each frame.
#pragma once

#include "occluders/convex_groups.hpp"

#include <algorithm>

namespace antumbra {

/// A tree over groups for best-first search; immutable.
struct OccluderTree {
    struct Node {
        Box3f box;
        double area = 0; ///< the largest below
        std::uint32_t right = 0;  ///< 0: a leaf; the left child follows its parent
        std::uint32_t group = 0;  ///< of a leaf
    };
    std::vector<Node> nodes;
};
OccluderTree build_occluder_tree(const ConvexGroups& groups);

/// The area-angle of Coorg and Teller without the viewing direction: area / squared distance to the nearest point of
/// the box (never less than a hundredth of the area, so that it stays finite).
double area_angle_bound(double area, const Box3f& box, const Vec3d& eye);

/// A best-first search for the `wanted` groups with the largest area-angle from one place, which can be spread over
/// frames. Allocates only at first.
class OccluderSearch {
  public:
    /// Begins at `eye`; results so far are kept until the search is done.
    void begin(const OccluderTree& tree, const Vec3d& eye, std::uint32_t wanted);
    /// Opens at most `steps` nodes. True when the search has ended: found() is then what was looked for.
    /// `score(group)` is what a group promises from begin()'s eye, at most its area_angle_bound(); 0: nothing.
    template <class Score>
    bool advance(const OccluderTree& tree, std::uint32_t steps, Score&& score);
    const std::vector<std::uint32_t>& found() const { return found_; }
    /// The best of the search under way, so far: they are found best first.
    const std::vector<std::uint32_t>& found_so_far() const { return running_ ? finding_ : found_; }
    bool running() const { return running_; }

  private:
    struct Item {
        double bound;
        std::uint32_t node;
        bool scored = false; ///< a leaf whose bound is its score
        bool operator<(const Item& other) const {
            return bound != other.bound ? bound < other.bound : node > other.node;
        }
    };
    std::vector<Item> heap_;
    std::vector<std::uint32_t> found_, finding_;
    Vec3d eye_;
    std::uint32_t wanted_ = 0;
    bool running_ = false;
};

template <class Score>
bool OccluderSearch::advance(const OccluderTree& tree, std::uint32_t steps, Score&& score) {
    auto push = [&](double bound, std::uint32_t index, bool scored) {
        if (!(bound > 0))
            return;
        heap_.push_back({bound, index, scored});
        std::push_heap(heap_.begin(), heap_.end());
    };
    for (std::uint32_t step = 0; running_ && step < steps; ++step) {
        if (heap_.empty() || finding_.size() >= wanted_) {
            running_ = false;
            std::swap(found_, finding_);
            break;
        }
        std::pop_heap(heap_.begin(), heap_.end());
        Item item = heap_.back();
        heap_.pop_back();
        const OccluderTree::Node& node = tree.nodes[item.node];
        if (item.scored) {
            finding_.push_back(node.group);
        } else if (node.right == 0) {
            push(score(node.group), item.node, true);
        } else {
            for (std::uint32_t child : {item.node + 1, node.right})
                push(area_angle_bound(tree.nodes[child].area, tree.nodes[child].box, eye_), child, false);
        }
    }
    return !running_;
}

} // namespace antumbra
