// Asking without splitting (section 6.2): the region goes to both children of a plane that it crosses. Regions of any shape:
// only their side of a plane is needed. And what the paper only sketches: intersection tests at inner nodes, which make the
// answer exact, and extra nodes where the modified tree is likely to be wrong.
#include "occlusion_tree/occlusion_tree.hpp"

namespace antumbra {
namespace {

/// Does anything of the box have extent in the picture?
bool shows_a_face(const Box3d& box, const Vec3d& eye) {
    for (int axis = 0; axis < 3; ++axis) {
        int b = (axis + 1) % 3, c = (axis + 2) % 3;
        if ((eye[axis] < box.min[axis] || eye[axis] > box.max[axis]) && box.min[b] < box.max[b] && box.min[c] < box.max[c])
            return true;
    }
    return false;
}

} // namespace

/// Of the part of the box in the frustum of these edges, against the occluder's plane: combined over the faces (table 1).
Visibility OcclusionTree::pyramid_visibility(const Box3d& box, std::uint32_t occluder, std::span<const LineRef> edges,
                                             std::size_t free) {
    if (free + 2 > kMostPending)
        return Visibility::partial;
    signed char sides[PicturePolygon::kMost];
    bool any = false;
    Visibility all = Visibility::invisible; // of nothing
    for (int axis = 0; axis < 3 && !(any && all == Visibility::partial); ++axis) {
        Sight::Mark mark = sight_.mark();
        std::uint32_t plane;
        PicturePolygon *piece = &pool(free), *next = &pool(free + 1);
        bool inside = face_of(box, axis, plane, *piece), decided = true;
        for (std::size_t e = 0; e < edges.size() && inside && decided; ++e) {
            LineRef line = edges[e];
            switch (locate(sight_, line, *piece, sides)) {
            case Place::outside: inside = false; break;
            case Place::undecided: decided = false; break;
            case Place::inside: break;
            case Place::both:
                decided = cut(sight_, line, *piece, sides, next, nullptr);
                std::swap(piece, next);
                break;
            }
        }
        if (inside) {
            Visibility here = decided ? leaf_visibility(plane, *piece, occluder) : Visibility::partial;
            all = any ? combine(all, here) : here;
            any = true;
        }
        sight_.forget(mark);
    }
    return all;
}

bool OcclusionTree::misses_pyramid(const Box3d& box, std::uint32_t occluder, std::span<const LineRef> edges, std::size_t free) {
    return pyramid_visibility(box, occluder, edges, free) == Visibility::invisible;
}

/// Does the outline, in silhouette_, have extent within the lines that the region crosses on the way to a node?
bool OcclusionTree::reaches(std::span<const LineRef> path) {
    signed char sides[PicturePolygon::kMost];
    pool(0) = silhouette_;
    for (LineRef line : path) {
        ++planes_tested_;
        switch (locate(sight_, line, pool(0), sides)) {
        case Place::inside: break;
        case Place::outside: return false;
        case Place::undecided: return true;
        case Place::both:
            if (!cut(sight_, line, pool(0), sides, &pool(1), nullptr))
                return true;
            std::swap(slots_[0], slots_[1]);
            break;
        }
    }
    return true;
}

/// Beyond one of the extra nodes on that side of a node?
template <class Region>
bool OcclusionTree::is_cut_off(std::size_t node, bool inside, const Region& region) {
    if (extra_.empty())
        return false;
    const Extra& extra = extra_[node];
    for (LineRef line : inside ? extra.inside : extra.outside) {
        if (line.bits == kNoLine)
            break;
        ++planes_tested_;
        if (sight_.line_range(line, region).most < 0)
            return true;
    }
    return false;
}

template <class Region, class Reaches, class AtLeaf>
Visibility OcclusionTree::walk_unsplit(const Region& region, Reaches&& reaches_path, AtLeaf&& at_leaf) {
    bool any = false;
    Visibility all = Visibility::full;
    unsplit_stack_.assign(1, {root_, 0, {kNoLine}});
    unsplit_path_.clear();
    while (!unsplit_stack_.empty()) {
        Unsplit work = unsplit_stack_.back();
        unsplit_stack_.pop_back();
        unsplit_path_.resize(work.path);
        if (work.line.bits != kNoLine) {
            unsplit_path_.push_back(work.line);
            if (!reaches_path(unsplit_path_))
                continue;
        }
        Child child = work.child;
        bool lost = false;
        while (child >= 0 && !lost) {
            auto index = static_cast<std::size_t>(child);
            const Node& node = nodes_[index];
            ++planes_tested_;
            Sight::Range range = sight_.line_range(node.line, region);
            if (range.least >= 0) {
                child = node.inside;
            } else if (range.most <= 0) {
                child = node.outside;
            } else {
                if (!is_cut_off(index, false, region))
                    unsplit_stack_.push_back({node.outside, static_cast<std::uint32_t>(unsplit_path_.size()), -node.line});
                unsplit_path_.push_back(node.line);
                lost = is_cut_off(index, true, region) || !reaches_path(unsplit_path_);
                child = node.inside;
            }
        }
        if (lost)
            continue;
        Visibility here = Visibility::full;
        if (child != kOut) {
            const Fragment& fragment = fragments_[fragment_of(child)];
            Sight::Range range = sight_.plane_range(fragment.plane, region);
            here = range.most < 0 ? Visibility::invisible : range.least >= 0 ? Visibility::full : at_leaf(fragment);
        }
        all = any ? combine(all, here) : here;
        any = true;
        if (all == Visibility::partial)
            break;
    }
    return any ? all : Visibility::partial;
}

Visibility OcclusionTree::visibility_unsplit(const Box3d& box, LeafTest test, InnerTest inner) {
    if (box.contains(sight_.eye()) || !shows_a_face(box, sight_.eye()))
        return Visibility::partial;
    auto at_leaf = [&](const Fragment& fragment) {
        if (test == LeafTest::conservative)
            return Visibility::partial;
        Visibility here = pyramid_visibility(box, fragment.plane, edges_of(fragment), 2);
        // Without tests on the way it is not known that the box reaches the leaf at all.
        return here == Visibility::invisible || inner == InnerTest::region ? here : Visibility::partial;
    };
    Sight::Mark mark = sight_.mark();
    bool tests = inner == InnerTest::region && silhouette_of(box, silhouette_);
    std::uint32_t plane;
    for (int axis = 0; axis < 3 && inner == InnerTest::region && !tests; ++axis) // a flat box is its only face
        tests = face_of(box, axis, plane, silhouette_);
    Visibility result = tests ? walk_unsplit(box, [&](std::span<const LineRef> path) { return reaches(path); }, at_leaf)
                              : walk_unsplit(box, [](std::span<const LineRef>) { return true; }, at_leaf);
    sight_.forget(mark);
    return result;
}

Visibility OcclusionTree::visibility_unsplit(const Ball& ball) {
    Vec3d way = ball.centre - sight_.eye();
    if (!(ball.radius >= 0) || !(dot(way, way) * (1 - 1e-9) > ball.radius * ball.radius))
        return Visibility::partial;
    return walk_unsplit(ball, [](std::span<const LineRef>) { return true; }, [](const Fragment&) { return Visibility::partial; });
}

Visibility OcclusionTree::visibility_unsplit(std::span<const Vec3d> hull) {
    if (hull.empty())
        return Visibility::partial;
    return walk_unsplit(hull, [](std::span<const LineRef>) { return true; }, [](const Fragment&) { return Visibility::partial; });
}

} // namespace antumbra
