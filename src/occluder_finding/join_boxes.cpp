#include "occluder_finding/inner_boxes.hpp"

#include "tree/bvh_overlaps.hpp"

#include <algorithm>
#include <limits>

namespace antumbra {
namespace {

using grid::Point;

constexpr std::size_t kMostSteps = 256; ///< of one face: how many boxes it can run along
/// Growth along an axis below this share of the size is given up: a pavement below a house would only widen the shell.
constexpr double kLeastGrowth = 0.05;
constexpr double kLeastGain = 1.2; ///< in worth, over the best of the boxes alone
constexpr double kMostShell = 4;   ///< volume of the shell over that of the box

struct Region {
    Point min, max;
};

bool overlap(const Region& a, const InnerBox& b) {
    for (std::size_t k = 0; k < 3; ++k)
        if (a.min[k] >= b.max[k] || b.min[k] >= a.max[k])
            return false;
    return true;
}

/// Boxes found by place.
class BoxIndex {
  public:
    explicit BoxIndex(const std::vector<InnerBox>& boxes) : boxes_(boxes) {
        std::vector<Box3f> bounds;
        for (const InnerBox& box : boxes)
            bounds.push_back(to_float(box.min, box.max));
        BvhOptions options;
        options.leaf_size = 2;
        tree_ = build_bvh(bounds, options);
    }

    /// Those whose insides meet that of the region, by number.
    void find(const Region& region, std::vector<std::uint32_t>& found) const {
        found.clear();
        Box3f around = to_float(region.min, region.max);
        find_in_bvh(tree_, [&](const Box3f& box) { return box.overlaps(around); },
                    [&](std::uint32_t b) {
                        if (overlap(region, boxes_[b]))
                            found.push_back(b);
                        return false;
                    });
        std::sort(found.begin(), found.end());
    }

  private:
    /// Coordinates below 2^24 are exact in float.
    static Box3f to_float(const Point& min, const Point& max) {
        Box3f box;
        for (std::size_t k = 0; k < 3; ++k) {
            box.min[int(k)] = static_cast<float>(min[k]);
            box.max[int(k)] = static_cast<float>(max[k]);
        }
        return box;
    }

    const std::vector<InnerBox>& boxes_;
    Bvh tree_;
};

/// Whether the boxes of `list` from `next` on cover the region; those that were needed are added to `used`.
bool is_covered(Region region, const std::vector<InnerBox>& boxes, std::span<const std::uint32_t> list,
                std::vector<std::uint32_t>& used) {
    for (std::size_t next = 0; next < list.size(); ++next) {
        const InnerBox& box = boxes[list[next]];
        if (!overlap(region, box))
            continue;
        used.push_back(list[next]);
        // What sticks out on each side must be covered by the others.
        for (std::size_t k = 0; k < 3; ++k) {
            if (region.min[k] < box.min[k]) {
                Region below = region;
                below.max[k] = box.min[k];
                if (!is_covered(below, boxes, list.subspan(next + 1), used))
                    return false;
                region.min[k] = box.min[k];
            }
            if (region.max[k] > box.max[k]) {
                Region above = region;
                above.min[k] = box.max[k];
                if (!is_covered(above, boxes, list.subspan(next + 1), used))
                    return false;
                region.max[k] = box.max[k];
            }
        }
        return true;
    }
    return false;
}

class Joiner {
  public:
    explicit Joiner(const std::vector<InnerBox>& boxes) : boxes_(boxes), index_(boxes) {}

    /// The seed, grown along the axes in this order.
    InnerBox grow(std::uint32_t seed, const std::array<std::size_t, 3>& axes) {
        members_.assign(1, seed);
        Region region{boxes_[seed].min, boxes_[seed].max};
        for (std::size_t axis : axes) {
            Region grown = region;
            std::size_t before = members_.size();
            push(grown, axis, false);
            push(grown, axis, true);
            double old_size = double(region.max[axis] - region.min[axis]);
            if (double(grown.max[axis] - grown.min[axis]) > (1 + kLeastGrowth) * old_size)
                region = grown;
            else
                members_.resize(before);
        }
        return finish(region);
    }

    /// Worth of the best single box of the last grow().
    double largest_member() const { return largest_member_; }

  private:
    /// One face, from box to box.
    void push(Region& region, std::size_t axis, bool upper) {
        for (std::size_t step = 0; step < kMostSteps; ++step) {
            Region beyond = region;
            (upper ? beyond.min : beyond.max)[axis] = (upper ? region.max : region.min)[axis];
            (upper ? beyond.max : beyond.min)[axis] += upper ? 1 : -1;
            index_.find(beyond, found_);
            // As far as the first of them ends.
            std::int64_t end = upper ? std::numeric_limits<std::int64_t>::max() : std::numeric_limits<std::int64_t>::min();
            for (std::uint32_t b : found_)
                end = upper ? std::min(end, boxes_[b].max[axis]) : std::max(end, boxes_[b].min[axis]);
            if (found_.empty())
                return;
            (upper ? beyond.max : beyond.min)[axis] = end;
            used_.clear();
            if (!is_covered(beyond, boxes_, found_, used_))
                return;
            members_.insert(members_.end(), used_.begin(), used_.end());
            (upper ? region.max : region.min)[axis] = end;
        }
    }

    InnerBox finish(const Region& region) {
        std::sort(members_.begin(), members_.end());
        members_.erase(std::unique(members_.begin(), members_.end()), members_.end());
        InnerBox joined = boxes_[members_[0]];
        joined.min = region.min;
        joined.max = region.max;
        std::vector<std::uint32_t> objects;
        largest_member_ = 0;
        bool agree = true;
        for (std::uint32_t m : members_) {
            agree = agree && join(joined.opening, boxes_[m].opening);
            largest_member_ = std::max(largest_member_, boxes_[m].worth());
            objects.push_back(boxes_[m].object);
            for (std::size_t k = 0; k < 3; ++k) {
                joined.shell_min[k] = std::min(joined.shell_min[k], boxes_[m].shell_min[k]);
                joined.shell_max[k] = std::max(joined.shell_max[k], boxes_[m].shell_max[k]);
            }
        }
        std::sort(objects.begin(), objects.end());
        joined.triangles = static_cast<std::uint32_t>(std::unique(objects.begin(), objects.end()) - objects.begin());
        if (!agree)
            joined.triangles = 0; // of no use to anybody
        joined.opening.cut(joined.min, joined.max);
        return joined;
    }

    /// Viewers must be on the whole side of all openings. False if these look to different sides.
    static bool join(Opening& all, const Opening& one) {
        if (!one.is_open())
            return true;
        if (!all.is_open())
            all = one;
        all.at = one.above ? std::max(all.at, one.at) : std::min(all.at, one.at);
        return all.axis == one.axis && all.above == one.above;
    }

    const std::vector<InnerBox>& boxes_;
    BoxIndex index_;
    std::vector<std::uint32_t> members_, found_, used_;
    double largest_member_ = 0;
};

double volume(const Point& min, const Point& max) {
    return double(max[0] - min[0]) * double(max[1] - min[1]) * double(max[2] - min[2]);
}

/// Whoever stands within the shell cannot use the box: it shall not be much larger. And six faces more want to be worth
/// it.
bool is_useful(const InnerBox& joined, double largest_member) {
    return joined.triangles > 1 && joined.min[0] < joined.max[0] && joined.min[1] < joined.max[1] &&
           joined.min[2] < joined.max[2] && joined.worth() > kLeastGain * largest_member &&
           volume(joined.shell_min, joined.shell_max) <= kMostShell * volume(joined.min, joined.max);
}

/// Drops what another one holds; of equal ones the first stays.
std::vector<InnerBox> keep_largest(std::vector<InnerBox> boxes) {
    std::stable_sort(boxes.begin(), boxes.end(), [](const InnerBox& a, const InnerBox& b) { return a.worth() > b.worth(); });
    boxes.erase(std::unique(boxes.begin(), boxes.end(),
                            [](const InnerBox& a, const InnerBox& b) { return a.min == b.min && a.max == b.max; }),
                boxes.end());
    BoxIndex index(boxes);
    std::vector<InnerBox> kept;
    std::vector<std::uint32_t> near;
    for (std::size_t i = 0; i < boxes.size(); ++i) {
        index.find({boxes[i].min, boxes[i].max}, near);
        if (std::none_of(near.begin(), near.end(), [&](std::uint32_t n) { return n < i && boxes[n].holds(boxes[i]); }))
            kept.push_back(boxes[i]);
    }
    return kept;
}

} // namespace

std::vector<InnerBox> join_boxes(const std::vector<InnerBox>& boxes, std::uint32_t most) {
    Joiner joiner(boxes);
    std::vector<InnerBox> joined;
    constexpr std::array<std::size_t, 3> kOrders[6] = {{0, 1, 2}, {0, 2, 1}, {1, 0, 2}, {1, 2, 0}, {2, 0, 1}, {2, 1, 0}};
    for (std::uint32_t seed = 0; seed < boxes.size(); ++seed)
        for (const auto& order : kOrders)
            if (InnerBox box = joiner.grow(seed, order); is_useful(box, joiner.largest_member()))
                joined.push_back(box);
    joined = keep_largest(std::move(joined));
    joined.resize(std::min<std::size_t>(joined.size(), most));
    return joined;
}

} // namespace antumbra
