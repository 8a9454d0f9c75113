#include "bake/exact/occluders_along.hpp"

#include <algorithm>
#include <cmath>

namespace antumbra::exact {
namespace {

Vec3d to_vector(const GridPoint& p) {
    return {static_cast<double>(p.x), static_cast<double>(p.y), static_cast<double>(p.z)};
}

/// Boxes are grown by this much (grid units) before a segment is tested. Coordinates stay below 2^25, so that all
/// roundings here, and that of the segment's ends, move a point by less than 2^-20.
constexpr double kMargin = 0x1p-8;

/// Parameter at which the segment enters the grown box; negative infinity is never returned. False: certainly misses.
bool enters(const GridBox& box, const Vec3d& p, const Vec3d& d, const Vec3d& inverse, double& at) {
    double first = 0, last = 1;
    for (int k = 0; k < 3; ++k) {
        double low = static_cast<double>(box.min[k]) - kMargin - p[k];
        double high = static_cast<double>(box.max[k]) + kMargin - p[k];
        if (d[k] == 0) {
            if (low > 0 || high < 0)
                return false;
            continue;
        }
        double a = low * inverse[k], b = high * inverse[k];
        first = std::max(first, std::min(a, b));
        last = std::min(last, std::max(a, b));
    }
    at = first;
    return first <= last * (1 + 0x1p-48) + 0x1p-48;
}

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

bool OccludersAlong::near_segment(const Vec3d& p, const Vec3d& q, std::size_t limit,
                                  std::vector<OccluderId>& found) {
    Vec3d d = q - p, inverse{1 / d.x, 1 / d.y, 1 / d.z};
    const auto& nodes = tree_.nodes();
    stack_.clear();
    double at = 0;
    if (enters(nodes[0].box, p, d, inverse, at))
        stack_.push_back({at, 0});
    while (!stack_.empty()) {
        if (found.size() >= limit)
            return true;
        std::uint32_t n = stack_.back().second;
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
        double at_a = 0, at_b = 0;
        bool a = enters(nodes[node.children].box, p, d, inverse, at_a);
        bool b = enters(nodes[node.children + 1].box, p, d, inverse, at_b);
        if (a && b && at_a < at_b) {
            stack_.push_back({at_b, node.children + 1});
            stack_.push_back({at_a, node.children});
        } else {
            if (a)
                stack_.push_back({at_a, node.children});
            if (b)
                stack_.push_back({at_b, node.children + 1});
        }
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
