#include "bake/exact/occluders_along.hpp"

#include <algorithm>
#include <cmath>

namespace antumbra::exact {
namespace {

Vec3d to_vector(const GridPoint& p) {
    return {static_cast<double>(p.x), static_cast<double>(p.y), static_cast<double>(p.z)};
}

/// A segment in single precision.
///
/// *No box that it touches is missed*: let it be at t in the box. Rounding the start and the grown box, and their difference, below
/// 2^25, adds up to less than 4 units; rounding the direction, its inverse and the product to less than 2^-22 of a distance
/// below 2^25, 8 units. So along each axis the computed interval reaches at least SceneTree::kGrown - 12 units further than t on
/// either side. A direction of almost nothing counts as 1e-30: then the interval holds all t, or the box is missed by more than
/// it was grown.
class Segment {
  public:
    Segment(const Vec3d& p, const Vec3d& d) {
        for (int k = 0; k < 3; ++k) {
            start_[k] = static_cast<float>(p[k]);
            inverse_[k] = 1 / (std::abs(d[k]) > 1e-30 ? static_cast<float>(d[k]) : 1e-30f);
        }
    }
    struct Entry {
        float at[2];  ///< parameter where it comes into each box
        bool meets[2];
    };
    Entry enter(const SceneTree::ChildBoxes& boxes) const {
        float first[2] = {0, 0}, last[2] = {1, 1};
        for (int k = 0; k < 3; ++k)
            for (int c = 0; c < 2; ++c) {
                float a = (boxes.low[k][c] - start_[k]) * inverse_[k], b = (boxes.high[k][c] - start_[k]) * inverse_[k];
                first[c] = std::max(first[c], std::min(a, b));
                last[c] = std::min(last[c], std::max(a, b));
            }
        return {{first[0], first[1]}, {first[0] <= last[0], first[1] <= last[1]}};
    }

  private:
    float start_[3], inverse_[3];
};

double norm1(const Vec3d& v) { return std::abs(v.x) + std::abs(v.y) + std::abs(v.z); }

/// False only if the line certainly passes outside one edge and inside another: the volumes' signs are beyond doubt.
bool may_cross(const Vec3d& d, const Vec3d* v, std::size_t n) {
    bool left = false, right = false;
    for (std::size_t i = 0; i < n; ++i) {
        const Vec3d &a = v[i], &b = v[(i + 1) % n];
        Vec3d c = cross(a, b);
        double value = dot(d, c), size = 0, area = 0;
        for (int k = 0; k < 3; ++k) {
            int x = (k + 1) % 3, y = (k + 2) % 3;
            double terms = std::abs(a[x] * b[y]) + std::abs(a[y] * b[x]);
            size += std::abs(d[k]) * terms;
            area += terms;
        }
        // Relative rounding of the sum below 8 u; the segment's ends may be off by 2^-20, the corners are exact.
        double around = norm1(a) + norm1(b) + 1;
        double doubt = 16 * kUnit * size + 0x1p-18 * ((norm1(d) + 1) * around + area);
        left |= value > doubt;
        right |= value < -doubt;
    }
    return !(left && right);
}

} // namespace

OccludersAlong::OccludersAlong(const SceneTree& tree, bool joined)
    : tree_(tree), joined_(joined), marks_(tree.nodes().size(), 0) {}

void OccludersAlong::forget_hidden() {
    for (std::uint32_t node : marked_)
        marks_[node] = 0;
    marked_.clear();
}

std::array<GridPoint, 4> OccludersAlong::virtual_polygon(const GridBox& box, int k) {
    if (k < 6)
        return face_of(box, k / 2, k % 2);
    // The six rectangles through two opposite edges: along each axis, the two diagonals of the other two.
    int axis = (k - 6) / 2, b = (axis + 1) % 3, c = (axis + 2) % 3;
    std::array<GridPoint, 4> corners;
    for (int i = 0; i < 4; ++i) {
        GridPoint p;
        bool far = i == 1 || i == 2;
        p[axis] = i >= 2 ? box.max[axis] : box.min[axis];
        p[b] = far ? box.max[b] : box.min[b];
        p[c] = far != (k % 2 == 1) ? box.max[c] : box.min[c];
        corners[static_cast<std::size_t>(i)] = p;
    }
    return corners;
}

const certify::Polygon& OccludersAlong::polygon(OccluderId id) {
    polygon_.corners.clear();
    if (is_patch(id)) {
        std::span<const GridPoint> rim = tree_.patches().rim(id - kPatch);
        polygon_.corners.assign(rim.begin(), rim.end());
        polygon_.both_sides = tree_.patches().both_sides(id - kPatch);
        return polygon_;
    }
    if (id < kPatch) {
        for (const GridPoint& p : tree_.corners(id))
            polygon_.corners.push_back(p);
        polygon_.both_sides = tree_.both_sides(id);
        return polygon_;
    }
    if (id < kVirtual) {
        id -= kFace;
        for (const GridPoint& p : face_of(tree_.nodes()[id / 6].box, static_cast<int>(id % 6 / 2), id % 2))
            polygon_.corners.push_back(p);
        polygon_.both_sides = false;
        return polygon_;
    }
    id -= kVirtual;
    for (const GridPoint& p : virtual_polygon(tree_.nodes()[id / 12].box, static_cast<int>(id % 12)))
        polygon_.corners.push_back(p);
    polygon_.both_sides = true;
    return polygon_;
}

bool OccludersAlong::neighbours(OccluderId id, std::size_t edge, std::vector<OccluderId>& found) {
    std::size_t before = found.size();
    bool reversed = false;
    auto mine = static_cast<std::uint32_t>(3 * id + edge);
    for (std::uint32_t other : tree_.edges_like(mine)) {
        if (other == mine)
            continue;
        reversed = tree_.edge_start(other) != tree_.edge_start(mine);
        found.push_back(other / 3);
    }
    return found.size() == before + 1 && reversed;
}

bool OccludersAlong::near_segment(const Vec3d& start, const Vec3d& end, std::size_t limit,
                                  std::vector<OccluderId>& found) {
    const Vec3d &p = from_end_ ? end : start, &q = from_end_ ? start : end; // the same line to may_cross()
    Vec3d d = q - p;
    Segment segment(p, d);
    const auto& nodes = tree_.nodes();
    stack_.assign(1, 0);
    while (!stack_.empty()) {
        if (found.size() >= limit)
            return true;
        std::uint32_t n = stack_.back();
        stack_.pop_back();
        const SceneTree::Node& node = nodes[n];
        std::uint64_t marks = marks_[n];
        if (from_ >= 0 && !(marks & kHidden) && (marks >> (6 * from_) & 63) != 0) {
            for (int to = 0; to < 6; ++to) {
                if (!(marks >> (6 * from_ + to) & 1))
                    continue;
                Vec3d v[4];
                std::array<GridPoint, 4> corners = face_of(node.box, to / 2, to % 2);
                for (std::size_t i = 0; i < 4; ++i)
                    v[i] = to_vector(corners[i]) - p;
                if (may_cross(d, v, 4))
                    found.push_back(kFace + 6 * n + static_cast<OccluderId>(to));
            }
        }
        if (marks & kHidden) {
            for (int k = 0; k < 12; ++k) {
                Vec3d v[4];
                std::array<GridPoint, 4> corners = virtual_polygon(node.box, k);
                if (corners[0] == corners[1] || corners[1] == corners[2])
                    continue; // no area
                for (std::size_t i = 0; i < 4; ++i)
                    v[i] = to_vector(corners[i]) - p;
                if (may_cross(d, v, 4))
                    found.push_back(kVirtual + 12 * n + static_cast<OccluderId>(k));
            }
            continue;
        }
        if (node.children == 0) {
            for (std::uint32_t i = node.first; i < node.first + node.count; ++i) {
                std::uint32_t t = tree_.order()[i];
                if (!tree_.occludes(t))
                    continue;
                Vec3d v[3];
                for (std::size_t c = 0; c < 3; ++c)
                    v[c] = to_vector(tree_.corners(t)[c]) - p;
                if (!may_cross(d, v, 3))
                    continue;
                if (OccluderId whole = whole_of(t); whole != t)
                    found.push_back(whole);
                found.push_back(t);
            }
            continue;
        }
        // The nearer child last, so that it comes off first.
        Segment::Entry entry = segment.enter(tree_.child_boxes(node.children));
        std::uint32_t near = entry.at[0] < entry.at[1] ? 0 : 1;
        for (std::uint32_t c : {1 - near, near})
            if (entry.meets[c])
                stack_.push_back(node.children + c);
    }
    return false;
}

bool OccludersAlong::in_hull(std::span<const GridPlane> around, std::vector<OccluderId>& found) {
    auto behind = [&](std::span<const GridPoint> corners) {
        return std::any_of(around.begin(), around.end(), [&](const GridPlane& plane) {
            return std::all_of(corners.begin(), corners.end(), [&](const GridPoint& p) { return plane.at(p) <= 0; });
        });
    };
    auto misses = [&](const GridBox& box) {
        return std::any_of(around.begin(), around.end(), [&](const GridPlane& plane) {
            GridPoint furthest;
            for (int k = 0; k < 3; ++k)
                furthest[k] = plane.n[k] > 0 ? box.max[k] : box.min[k];
            return plane.at(furthest) <= 0;
        });
    };
    std::vector<std::uint32_t> open = {0};
    while (!open.empty()) {
        std::uint32_t n = open.back();
        open.pop_back();
        const SceneTree::Node& node = tree_.nodes()[n];
        if (misses(node.box))
            continue;
        std::uint64_t marks = marks_[n];
        if (marks & kHidden) {
            for (int k = 0; k < 12; ++k) {
                std::array<GridPoint, 4> corners = virtual_polygon(node.box, k);
                if (corners[0] != corners[1] && corners[1] != corners[2] && !behind(corners))
                    found.push_back(kVirtual + 12 * n + static_cast<OccluderId>(k));
            }
            continue;
        }
        for (int to = 0; from_ >= 0 && to < 6; ++to)
            if (marks >> (6 * from_ + to) & 1 && !behind(face_of(node.box, to / 2, to % 2)))
                found.push_back(kFace + 6 * n + static_cast<OccluderId>(to));
        if (node.children != 0) {
            open.push_back(node.children + 1);
            open.push_back(node.children);
            continue;
        }
        for (std::uint32_t i = node.first; i < node.first + node.count; ++i)
            if (std::uint32_t t = tree_.order()[i]; tree_.occludes(t) && !behind(tree_.corners(t)))
                found.push_back(t);
    }
    return true;
}

} // namespace antumbra::exact
