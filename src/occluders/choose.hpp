// The choice of occluders at run time: the k groups of the largest area-angle, refreshed a little each frame.
#pragma once

#include "occluders/convex_groups.hpp"

#include <algorithm>

namespace antumbra {

/// A tree over groups for best-first search; immutable.
struct OccluderTree {
    struct Node {
        Box3f box;
        float area = 0; ///< the largest below
        std::uint32_t right = 0;  ///< 0: a leaf; the left child follows its parent
        std::uint32_t group = 0;  ///< of a leaf
    };
    std::vector<Node> nodes;
};
OccluderTree build_occluder_tree(const ConvexGroups& groups);

/// The area-angle of Coorg and Teller without the viewing direction: area / squared distance to the nearest point of
/// the box (never less than a hundredth of the area, so that it stays finite).
inline float area_angle_bound(float area, const Box3f& box, const Vec3f& eye) {
    float distance = 0; // only an order: it needs no care
    for (int axis = 0; axis < 3; ++axis) {
        float gap = std::max(std::max(box.min[axis] - eye[axis], eye[axis] - box.max[axis]), 0.0f);
        distance += gap * gap;
    }
    return area / (distance + 0.01f * area + 1e-30f);
}

/// A best-first search for the `wanted` groups with the largest area-angle from one place, which can be spread over
/// frames. Allocates only at first.
class OccluderSearch {
  public:
    /// Begins at `eye`; results so far are kept until the search is done.
    void begin(const OccluderTree& tree, const Vec3d& eye, std::uint32_t wanted);
    /// Opens at most `steps` nodes. True when the search has ended: found() is then what was looked for.
    /// `score(group)` is what a group promises from begin()'s eye, at most its area_angle_bound(); 0: nothing.
    /// What lies in boxes for which `wanted_box(box)` is false is not looked at.
    template <class Score, class WantedBox>
    bool advance(const OccluderTree& tree, std::uint32_t steps, Score&& score, WantedBox&& wanted_box);
    template <class Score>
    bool advance(const OccluderTree& tree, std::uint32_t steps, Score&& score) {
        return advance(tree, steps, score, [](const Box3f&) { return true; });
    }
    const std::vector<std::uint32_t>& found() const { return found_; }
    /// Forgets everything; keeps the memory.
    void clear() {
        heap_.clear();
        found_.clear();
        finding_.clear();
        running_ = false;
    }
    /// The best of the search under way, so far: they are found best first.
    const std::vector<std::uint32_t>& found_so_far() const { return running_ ? finding_ : found_; }
    bool running() const { return running_; }

  private:
    static constexpr std::uint32_t kScored = 0x80000000u; ///< a leaf whose bound is its score
    struct Item {
        float bound;
        std::uint32_t node; ///< | kScored
        bool operator<(const Item& other) const {
            return bound != other.bound ? bound < other.bound : node > other.node;
        }
    };
    std::vector<Item> heap_;
    std::vector<std::uint32_t> found_, finding_;
    Vec3f eye_;
    std::uint32_t wanted_ = 0;
    bool running_ = false;
};

template <class Score, class WantedBox>
bool OccluderSearch::advance(const OccluderTree& tree, std::uint32_t steps, Score&& score, WantedBox&& wanted_box) {
    auto push = [&](float bound, std::uint32_t item) {
        if (!(bound > 0))
            return;
        heap_.push_back({bound, item});
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
        const OccluderTree::Node& node = tree.nodes[item.node & ~kScored];
        if (item.node & kScored) {
            finding_.push_back(node.group);
        } else if (node.right == 0) {
            push(score(node.group), item.node | kScored);
        } else {
            for (std::uint32_t child : {item.node + 1, node.right})
                if (wanted_box(tree.nodes[child].box))
                    push(area_angle_bound(tree.nodes[child].area, tree.nodes[child].box, eye_), child);
        }
    }
    return !running_;
}

} // namespace antumbra
