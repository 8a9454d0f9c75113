// Occlusion trees (Bittner, Havran, Slavik, "Hierarchical visibility culling with occlusion trees", CGI 1998): the
// shadows of many convex occluders, seen from one point, merged into one binary tree of shadow planes.
//
// Run-time module: standard library only, no exceptions. All signs are exact (see sight.hpp): a tree knows precisely
// which directions its occluders cover and how far away, whatever the order in which they came.
//
//     OcclusionTree tree;
//     tree.begin(eye, size, {.form = TreeForm::modified});
//     tree.insert(polygons of the viewer's choice);
//     if (tree.visibility_by_faces(box) == Visibility::invisible) skip(box);
#pragma once

#include "occlusion_tree/picture_polygon.hpp"

#include <array>
#include <span>

namespace antumbra {

/// Section 6: the modified tree leaves out planes that are on the path already.
enum class TreeForm : std::uint8_t { plain, modified };

/// Of a box: with respect to the occluders of the tree alone.
enum class Visibility : std::uint8_t { invisible, partial, full };

/// Table 1 of the paper.
constexpr Visibility combine(Visibility a, Visibility b) { return a == b ? a : Visibility::partial; }

/// What visibility_unsplit() asks at a leaf whose occluder's plane crosses the box.
enum class LeafTest : std::uint8_t {
    conservative, ///< C: partial
    pyramid,      ///< E made safe: invisible only if the box misses the closed pyramid of viewpoint and fragment
};

/// What visibility_unsplit() asks at a node whose plane crosses the box. The paper sketches `region`: "intersection tests also
/// in the inner nodes ... Then the algorithm always determines visibility exactly with regard to the selected occluders".
enum class InnerTest : std::uint8_t {
    none,   ///< as published: the box goes to both children
    region, ///< only to those whose part of the picture it reaches
};

/// The paper's future work: "inserting additional nodes to the MOBSP, where the probability of visibility misclassification is
/// high". Here: where two shadow planes meet at a sharp angle, a plane that cuts off what only touches their continuations.
enum class ExtraNodes : std::uint8_t { none, at_sharp_angles };

struct OcclusionTreeLimits {
    std::uint32_t nodes = 1u << 15, lines = 1u << 16, fragments = 1u << 14;
};

class OcclusionTree {
  public:
    /// Memory is taken here, once, and never grows.
    explicit OcclusionTree(const OcclusionTreeLimits& limits = {});

    /// Empty, for a new eye. `size`: of the scene, for scaling only.
    void begin(const Vec3d& eye, double size, TreeForm form, ExtraNodes extra_nodes = ExtraNodes::none);
    Sight& sight() { return sight_; }

    /// Points of occluders are added by the caller (sight().add_point), so that polygons can share them.
    /// A convex planar polygon given by `loop`, counter-clockwise seen from the eye, without straight corners; `plane`
    /// from sight().add_plane(). In front of or behind what is there already, or both. False if memory ran out: then the tree
    /// covers less, which is conservative.
    bool insert(std::span<const std::uint32_t> loop, std::uint32_t plane, std::uint32_t occluder);
    /// The same for a polygon of the picture.
    bool insert(const PicturePolygon& polygon, std::uint32_t plane, std::uint32_t occluder);
    /// False if the polygon has too many corners.
    bool picture_of(std::span<const std::uint32_t> loop, PicturePolygon& polygon);

    /// Section 5.2, exact: splits the faces of the box that the eye sees.
    Visibility visibility_by_faces(const Box3d& box);
    /// Section 6.2, conservative: the box goes to both children of a plane that it crosses. Modified trees only.
    /// With LeafTest::pyramid and InnerTest::region exact.
    Visibility visibility_unsplit(const Box3d& box, LeafTest test, InnerTest inner = InnerTest::none);
    /// The same for regions of other shapes (conservative, LeafTest::conservative): "the only operation ... is the
    /// determination of the position of a region relative to a plane". `hull`: corners of any convex region.
    Visibility visibility_unsplit(const Ball& ball);
    Visibility visibility_unsplit(std::span<const Vec3d> hull);

    // -- the modern query: one silhouette instead of three faces, only hidden or not ----------------------------------

    /// A place in the tree: where queries of boxes within a box may start.
    struct Start {
        std::int32_t child;
    };
    Start root() const { return {root_}; }
    /// The deepest place, from `start` on, whose region of the picture holds all of the box.
    Start descend(const Box3d& box, Start start);
    /// Certainly hidden? `start`: of descend() for this box or one around it. As exact as visibility_by_faces() where the
    /// occluders came front to back, else conservative. If not hidden, `seen` (may be nullptr) becomes a point of the box
    /// for is_seen() in later frames, or stays as it is if none is at hand.
    bool hides(const Box3d& box, Start start, Vec3d* seen);

    /// Another place to start: the leaves, and the nodes not looked into yet, that a box reached without being hidden, each
    /// with the part of the picture in which it was reached. Lives until release() of a reach from before it.
    struct Reach {
        std::uint32_t first, count;
    };
    Reach whole_picture();
    /// What lies outside of this convex window does not count from now on: whole_picture() is what is seen through it. After
    /// begin(); corners clockwise as the eye sees them.
    void look_through(const std::array<Vec3d, 4>& window);
    /// hides() from there, for a box within the one that reached it (or any, from whole_picture()). If the box is not hidden and
    /// `reached` is not nullptr, that becomes where boxes within this one may start.
    bool hides(const Box3d& box, Reach from, Vec3d* seen, Reach* reached);
    /// Where a box within that of `from` can be, as far as bounds tell, without asking whether it is hidden.
    Reach narrow(const Box3d& box, Reach from);
    bool is_seen(const Vec3d& point, Reach from);
    /// Forgets all reaches that came after this one.
    void release(Reach last);

    /// Certainly unblocked? Then no box with this point in it, within the region of `start`, is hidden. Cheap.
    bool is_seen(const Vec3d& point, Start start);

    std::size_t node_count() const { return nodes_.size(); }
    std::size_t fragment_count() const { return fragments_.size(); }
    bool ran_out() const { return ran_out_; }
    std::uint64_t planes_tested() const { return planes_tested_; }

  private:
    /// A child: a node, kOut, or an in-leaf (the complement of a fragment's index, beyond kOut).
    using Child = std::int32_t;
    static constexpr Child kOut = -1;
    static Child in_leaf(std::size_t fragment) { return -2 - static_cast<Child>(fragment); }
    static std::size_t fragment_of(Child leaf) { return static_cast<std::size_t>(-2 - leaf); }

    struct Node {
        LineRef line; ///< inside is its positive side
        Child inside = kOut, outside = kOut;
    };
    struct Fragment {
        std::uint32_t plane, occluder, first_edge, edges;
    };
    struct Work {
        Child child;       ///< where the polygon is
        std::uint32_t parent; ///< for building: node * 2 + (1: its inside child); kRoot
        std::uint32_t polygon; ///< in pool_
    };
    static constexpr std::uint32_t kRoot = 0xFFFFFFFFu;
    static constexpr std::uint32_t kMostPending = 512; ///< pieces of one polygon under way
    struct Reached {
        Child child;
        std::uint32_t first_line, lines; ///< bounds of that part of the picture, into reached_lines_
    };
    static constexpr std::uint32_t kMostReached = 4096;
    static constexpr std::uint32_t kNoLine = 0xFFFFFFFFu;
    struct Unsplit {
        Child child;
        std::uint32_t path; ///< how much of unsplit_path_ led there,
        LineRef line;       ///< and the line crossed last
    };
    /// Planes that have a child's part of the picture on their positive side.
    struct Extra {
        LineRef inside[2] = {{kNoLine}, {kNoLine}}, outside[2] = {{kNoLine}, {kNoLine}};
    };

    PicturePolygon& pool(std::size_t i) { return pool_[slots_[i]]; }
    /// The outer part takes the place of the polygon, the inner one the next place: the stack holds the rest.
    bool cut_in_pool(LineRef line, std::uint32_t polygon, const signed char* sides);
    bool filter_down(std::uint32_t plane, std::uint32_t occluder);
    /// Replaces the leaf `work.child` by the occlusion volume of the polygon.
    bool enlarge(const Work& work, std::uint32_t plane, std::uint32_t occluder);
    bool enlarge_in_front(const Work& work, std::uint32_t plane, std::uint32_t occluder);
    void set_child(std::uint32_t parent, Child child);
    Child& child_at(std::uint32_t parent);

    /// The face of the box across `axis` that the eye sees; false if there is none, or without area.
    bool face_of(const Box3d& box, int axis, std::uint32_t& plane, PicturePolygon& face);
    Visibility visibility_of(std::uint32_t plane);
    /// `plane`: of the occluder there.
    Visibility leaf_visibility(std::uint32_t surface, const PicturePolygon& piece, std::uint32_t plane);
    std::span<const LineRef> edges_of(const Fragment& fragment) const {
        return {fragment_edges_.data() + fragment.first_edge, fragment.edges};
    }
    /// Uses the pool from `free` on.
    Visibility pyramid_visibility(const Box3d& box, std::uint32_t plane, std::span<const LineRef> edges, std::size_t free);
    bool misses_pyramid(const Box3d& box, std::uint32_t plane, std::span<const LineRef> edges, std::size_t free);
    bool is_behind_in(const Box3d& box, const Fragment& fragment, const PicturePolygon& piece, std::size_t free);
    bool reaches(std::span<const LineRef> path);
    template <class Region> bool is_cut_off(std::size_t node, bool inside, const Region& region);
    template <class Region, class Reaches, class AtLeaf>
    Visibility walk_unsplit(const Region& region, Reaches&& reaches_path, AtLeaf&& at_leaf);
    void add_extra_nodes(const PicturePolygon& polygon, std::span<const std::int32_t> node_of_edge);
    bool silhouette_of(const Box3d& box, PicturePolygon& silhouette);
    bool all_hidden(const Box3d& box, Vec3d* seen, Work& shown);
    bool clip(PicturePolygon& polygon, const Reached& place);
    bool keep(Child child, const PicturePolygon& piece);
    bool keep(const Reached& place);
    bool point_in_sight(const Box3d& box, const PicturePolygon& piece, Vec3d& seen) const;
    bool is_before(const Fragment& fragment, const Vec3d& point) const;

    Sight sight_;
    OcclusionTreeLimits limits_;
    TreeForm form_ = TreeForm::plain;
    Child root_ = kOut;
    bool ran_out_ = false;
    std::vector<Node> nodes_;
    std::vector<Fragment> fragments_;
    std::vector<LineRef> fragment_edges_;
    std::vector<Work> stack_;
    std::vector<Unsplit> unsplit_stack_;
    std::vector<LineRef> unsplit_path_;
    std::vector<Extra> extra_; ///< per node, if there are extra nodes
    ExtraNodes extra_nodes_ = ExtraNodes::none;
    std::vector<PicturePolygon> pool_; ///< polygons of the work under way
    std::vector<std::uint16_t> slots_; ///< where in pool_ they are
    PicturePolygon silhouette_, clipped_;
    std::vector<Reached> reached_;
    std::vector<LineRef> reached_lines_;
    std::uint32_t face_points_ = 0;    ///< points from here on are corners of the face under way
    std::uint64_t planes_tested_ = 0;
};

} // namespace antumbra
