#include "bake/exact/convex_patches.hpp"

#include "bake/exact/frame.hpp"
#include "bake/exact/scene_tree.hpp"

#include <algorithm>
#include <cmath>

namespace antumbra::exact {
namespace {

constexpr std::size_t kMostEdges = 12;
constexpr double kNearlyFlat = 0.9999; ///< least cosine between the normals of a patch's triangles and its first one's

Vec3d to_vector(const GridPoint& p) {
    return {static_cast<double>(p.x), static_cast<double>(p.y), static_cast<double>(p.z)};
}

Int128 dot_wide(const GridPoint& a, const GridPoint& b) {
    return static_cast<Int128>(a.x) * b.x + static_cast<Int128>(a.y) * b.y + static_cast<Int128>(a.z) * b.z;
}

GridPoint normal_of(const std::array<GridPoint, 3>& t) { return cross(t[1] - t[0], t[2] - t[0]); }

/// A patch while it grows.
class Rim {
  public:
    Rim(const SceneTree& tree, std::uint32_t seed) : tree_(tree), normal_(normal_of(tree.corners(seed))) {
        Vec3d n = to_vector(normal_);
        unit_ = n / length(n);
        for (std::uint32_t k = 0; k < 3; ++k)
            edges_.push_back(3 * seed + k);
    }
    std::size_t edges() const { return edges_.size(); }

    /// Would the triangle beyond edge `at` of the rim fit? Its size, or 0.
    double fits(std::size_t at, std::uint32_t beyond) const {
        std::uint32_t apex = before(beyond);
        GridPoint n = normal_of(tree_.corners(beyond / 3));
        Vec3d v = to_vector(n);
        double size = length(v);
        if (!(dot(v, unit_) >= kNearlyFlat * size))
            return 0;
        for (std::uint32_t edge : edges_)
            if (tree_.edge_start(edge) == tree_.edge_start(apex))
                return 0; // a corner inside would be left
        std::size_t count = edges_.size();
        const GridPoint &a = start(at + count - 1), &u = start(at), &w = point(apex), &v1 = start(at + 1), &b = start(at + 2);
        return turns(a, u, w) && turns(u, w, v1) && turns(w, v1, b) ? size : 0;
    }
    void add(std::size_t at, std::uint32_t beyond) {
        // beyond runs along the rim's edge the other way; the other two edges of its triangle take the place of it.
        std::uint32_t t = beyond / 3, k = beyond % 3;
        edges_[at] = 3 * t + (k + 1) % 3;
        edges_.insert(edges_.begin() + static_cast<std::ptrdiff_t>(at) + 1, 3 * t + (k + 2) % 3);
    }
    std::uint32_t edge(std::size_t at) const { return edges_[at]; }

    std::vector<GridPoint> corners() const {
        std::vector<GridPoint> all, kept;
        for (std::size_t k = 0; k < edges_.size(); ++k)
            all.push_back(start(k));
        std::size_t n = all.size();
        for (std::size_t k = 0; k < n; ++k) {
            GridPoint turn = cross(all[k] - all[(k + n - 1) % n], all[(k + 1) % n] - all[k]);
            if (turn.x != 0 || turn.y != 0 || turn.z != 0)
                kept.push_back(all[k]);
        }
        return kept;
    }

  private:
    static std::uint32_t before(std::uint32_t edge) { return edge / 3 * 3 + (edge % 3 + 2) % 3; } // starts at the apex
    const GridPoint& point(std::uint32_t edge) const { return tree_.corners(edge / 3)[edge % 3]; }
    const GridPoint& start(std::size_t at) const { return point(edges_[at % edges_.size()]); }
    bool turns(const GridPoint& a, const GridPoint& b, const GridPoint& c) const {
        return dot_wide(cross(b - a, c - b), normal_) >= 0;
    }

    const SceneTree& tree_;
    GridPoint normal_;
    Vec3d unit_;
    std::vector<std::uint32_t> edges_; ///< in order, each an edge of a triangle as SceneTree numbers them
};

bool all_in_one_plane(std::span<const GridPoint> corners) {
    std::size_t triple[3];
    GridPlane plane = plane_of(corners, triple);
    return std::all_of(corners.begin(), corners.end(), [&](const GridPoint& p) { return plane.at(p) == 0; });
}

} // namespace

ConvexPatches ConvexPatches::build(const SceneTree& tree) {
    ConvexPatches patches;
    auto count = static_cast<std::uint32_t>(tree.corners_count());
    patches.of_.assign(count, kNone);
    patches.first_.push_back(0);
    patches.first_member_.push_back(0);
    std::vector<std::uint8_t> taken(count, 0);
    std::vector<std::uint32_t> members;
    for (std::uint32_t seed = 0; seed < count; ++seed) {
        if (taken[seed] || !tree.occludes(seed))
            continue;
        taken[seed] = 1;
        Rim rim(tree, seed);
        members.assign(1, seed);
        for (bool grown = true; grown && rim.edges() < kMostEdges;) {
            double best = 0;
            std::size_t best_at = 0;
            std::uint32_t best_edge = 0;
            for (std::size_t at = 0; at < rim.edges(); ++at) {
                std::span<const std::uint32_t> like = tree.edges_like(rim.edge(at));
                if (like.size() != 2)
                    continue;
                std::uint32_t other = like[0] == rim.edge(at) ? like[1] : like[0];
                if (taken[other / 3] || tree.edge_start(other) == tree.edge_start(rim.edge(at)) ||
                    tree.both_sides(other / 3) != tree.both_sides(seed))
                    continue;
                if (double size = rim.fits(at, other); size > best) {
                    best = size;
                    best_at = at;
                    best_edge = other;
                }
            }
            grown = best > 0;
            if (grown) {
                rim.add(best_at, best_edge);
                taken[best_edge / 3] = 1;
                members.push_back(best_edge / 3);
            }
        }
        if (members.size() == 1)
            continue;
        std::vector<GridPoint> corners = rim.corners();
        if (corners.size() < 3)
            continue;
        for (std::uint32_t t : members)
            patches.of_[t] = patches.count();
        patches.members_.insert(patches.members_.end(), members.begin(), members.end());
        patches.first_member_.push_back(static_cast<std::uint32_t>(patches.members_.size()));
        patches.flat_.push_back(all_in_one_plane(corners));
        patches.both_sides_.push_back(tree.both_sides(seed));
        patches.rims_.insert(patches.rims_.end(), corners.begin(), corners.end());
        patches.first_.push_back(static_cast<std::uint32_t>(patches.rims_.size()));
    }
    return patches;
}

} // namespace antumbra::exact
