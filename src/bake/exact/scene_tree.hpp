// The scene on its integer grid, in a tree of boxes: first objects, then the units of each, then the triangles of each
// unit. What exact queries walk from front to back, and where the occluders along a line are found.
#pragma once

#include "bake/exact/convex_patches.hpp"
#include "bake/exact/units.hpp"
#include "geometry/pluecker.hpp"

#include <antumbra/scene.hpp>

#include <span>
#include <vector>

namespace antumbra::exact {

/// Closed, in grid coordinates.
struct GridBox {
    GridPoint min{INT32_MAX, INT32_MAX, INT32_MAX}, max{INT32_MIN, INT32_MIN, INT32_MIN};

    void extend(const GridPoint& p) {
        for (int k = 0; k < 3; ++k) {
            min[k] = std::min(min[k], p[k]);
            max[k] = std::max(max[k], p[k]);
        }
    }
    void extend(const GridBox& b) {
        extend(b.min);
        extend(b.max);
    }
    bool touches(const GridBox& b) const {
        for (int k = 0; k < 3; ++k)
            if (min[k] > b.max[k] || b.min[k] > max[k])
                return false;
        return true;
    }
    bool operator==(const GridBox&) const = default;
};

/// Does the closed triangle touch the closed box? Exact (separating axes in integers).
bool touches(const GridBox& box, const std::array<GridPoint, 3>& triangle);

/// The four corners of a box's face, counter-clockwise seen from outside. side 0: low, 1: high.
std::array<GridPoint, 4> face_of(const GridBox& box, int axis, int side);

/// Immutable, thread-safe; refers to the scene.
class SceneTree {
  public:
    static constexpr std::uint32_t kManyObjects = 0xFFFFFFFFu;
    struct Node {
        GridBox box;
        std::uint32_t children = 0; ///< two in a row; 0: a leaf
        std::uint32_t first = 0, count = 0; ///< into order()
        std::uint32_t object = kManyObjects; ///< the object of all its triangles, if there is only one
        std::uint32_t unit = kManyObjects;   ///< the unit of all its triangles, if there is only one
        std::uint32_t units = 0;             ///< how many units have triangles below
    };

    /// O(n log n). All triangles of the scene take part. Without units, every object is one.
    static SceneTree build(const Scene& scene);
    static SceneTree build(const Scene& scene, Units units);

    const Scene& scene() const { return *scene_; }
    const Units& units() const { return units_; }
    /// The highest node that holds nothing but this unit; UINT32_MAX if it has no triangle.
    std::uint32_t root_of(std::uint32_t unit) const { return root_of_[unit]; }
    const std::vector<Node>& nodes() const { return nodes_; }
    /// The boxes of a node's two children, grown by kGrown on all sides, in single precision: for finding what a segment may
    /// meet, fast.
    struct ChildBoxes {
        float low[3][2], high[3][2];
    };
    static constexpr float kGrown = 32; ///< grid units
    const ChildBoxes& child_boxes(std::uint32_t children) const { return child_boxes_[(children - 1) / 2]; } ///< Node::children
    /// Parent of each node; the root is its own.
    const std::vector<std::uint32_t>& parents() const { return parents_; }
    /// Triangles, so that every node's are contiguous.
    const std::vector<std::uint32_t>& order() const { return order_; }
    std::uint32_t leaf_of(std::uint32_t triangle) const { return leaf_of_[triangle]; }
    const std::array<GridPoint, 3>& corners(std::uint32_t triangle) const { return corners_[triangle]; }
    std::size_t corners_count() const { return corners_.size(); } ///< triangles
    bool occludes(std::uint32_t triangle) const { return scene_->object_of(triangle).has(kOccludes); }
    bool both_sides(std::uint32_t triangle) const { return scene_->object_of(triangle).has(kDoubleSided); }
    /// Edge 3 t + k runs from corner k of triangle t to the next. All edges of occluding triangles between the same two
    /// points, this one included; nothing for triangles that do not occlude.
    std::span<const std::uint32_t> edges_like(std::uint32_t edge) const {
        std::uint32_t group = edge_group_[edge];
        return group == kNoGroup ? std::span<const std::uint32_t>()
                                 : std::span(edges_).subspan(group_first_[group], group_first_[group + 1] - group_first_[group]);
    }
    /// A number for the point where an edge starts: equal numbers are equal points.
    std::uint32_t edge_start(std::uint32_t edge) const { return point_of_[edge]; }
    /// Neighbouring triangles joined to larger occluders.
    const ConvexPatches& patches() const { return patches_; }
    /// Local coordinates must be whole multiples of the scene's step.
    GridPoint to_grid(const Vec3d& local) const;
    Vec3d to_local(const Vec3d& grid) const { return grid * scene_->step(); }

  private:
    const Scene* scene_ = nullptr;
    Units units_;
    std::vector<Node> nodes_;
    std::vector<ChildBoxes> child_boxes_; // children come in pairs, after the root
    std::vector<std::uint32_t> parents_, order_, leaf_of_, root_of_;
    std::vector<std::array<GridPoint, 3>> corners_;
    static constexpr std::uint32_t kNoGroup = 0xFFFFFFFFu;
    std::vector<std::uint32_t> point_of_;              // per corner 3 t + k
    std::vector<std::uint32_t> edge_group_;            // per edge
    std::vector<std::uint32_t> group_first_, edges_;   // edges by group
    void connect_edges();
    void copy_child_boxes();
    ConvexPatches patches_;

    struct Builder;
};

} // namespace antumbra::exact
