// Asking the tree by splitting the faces of a box (section 5).
#include "occlusion_tree/occlusion_tree.hpp"

namespace antumbra {

bool OcclusionTree::face_of(const Box3d& box, int axis, std::uint32_t& plane, PicturePolygon& face) {
    const Vec3d& eye = sight_.eye();
    bool below = eye[axis] < box.min[axis];
    if (!below && !(eye[axis] > box.max[axis]))
        return false;
    int b = (axis + 1) % 3, c = (axis + 2) % 3;
    if (!(box.min[b] < box.max[b] && box.min[c] < box.max[c]))
        return false;
    double at = below ? box.min[axis] : box.max[axis];
    plane = sight_.add_axis_plane(axis, at);
    std::uint32_t loop[4];
    face_points_ = static_cast<std::uint32_t>(sight_.mark().points);
    for (int i = 0; i < 4; ++i) {
        // Around +axis, or against it: clockwise seen from the eye, as edges want it.
        int corner = below ? i : 3 - i;
        Vec3d p;
        p[axis] = at;
        p[b] = corner == 1 || corner == 2 ? box.max[b] : box.min[b];
        p[c] = corner >= 2 ? box.max[c] : box.min[c];
        loop[i] = sight_.add_point(p);
    }
    face.count = 0;
    for (int i = 0; i < 4; ++i)
        face.push(sight_.toward(loop[i]), sight_.add_edge(loop[i], loop[(i + 1) % 4]), false);
    return true;
}

/// In an in-leaf: a piece of a face that lies in the plane `surface`, against the fragment that occludes there.
Visibility OcclusionTree::leaf_visibility(std::uint32_t surface, const PicturePolygon& piece, std::uint32_t plane) {
    Sight::Mark mark = sight_.mark();
    LineRef farther = sight_.add_meeting(surface, plane);
    bool behind = false, before = false;
    for (int i = 0; i < piece.count && !(behind && before); ++i) {
        // Corners of the face itself are points of the scene; corners of occluders that got into the piece are not.
        std::uint32_t point = piece.point(i);
        int side = point != kNoPoint && point >= face_points_ ? sight_.behind(plane, point)
                                                              : sight_.side(farther, piece.at(i));
        behind |= side == 1 || side == kUndecided;
        before |= side == -1 || side == kUndecided;
    }
    sight_.forget(mark);
    // Neither: the face lies in the occluder's plane and is not hidden.
    return behind && before ? Visibility::partial : behind ? Visibility::invisible : Visibility::full;
}

/// Figure 4 of the paper. The polygon, in the plane `surface`, is in pool(0).
Visibility OcclusionTree::visibility_of(std::uint32_t surface) {
    signed char sides[PicturePolygon::kMost];
    bool any = false;
    Visibility all = Visibility::full;
    stack_.clear();
    stack_.push_back({root_, kRoot, 0});
    while (!stack_.empty()) {
        Work work = stack_.back();
        stack_.pop_back();
        while (work.child >= 0) {
            const Node& node = nodes_[static_cast<std::size_t>(work.child)];
            ++planes_tested_;
            Place place = locate(sight_, node.line, pool(work.polygon), sides);
            if (place == Place::undecided)
                return Visibility::partial;
            if (place == Place::both) {
                if (!cut_in_pool(node.line, work.polygon, sides))
                    return Visibility::partial;
                stack_.push_back({node.outside, 0, work.polygon});
                work = {node.inside, 0, work.polygon + 1};
            } else {
                work.child = place == Place::inside ? node.inside : node.outside;
            }
        }
        Visibility here = work.child == kOut ? Visibility::full
                                             : leaf_visibility(surface, pool(work.polygon), fragments_[fragment_of(work.child)].plane);
        all = any ? combine(all, here) : here;
        any = true;
        if (all == Visibility::partial)
            return all;
    }
    return all;
}

Visibility OcclusionTree::visibility_by_faces(const Box3d& box) {
    if (box.contains(sight_.eye()))
        return Visibility::partial;
    bool any = false;
    Visibility all = Visibility::partial; // of a box without a face that shows: nothing is known
    for (int axis = 0; axis < 3; ++axis) {
        Sight::Mark mark = sight_.mark();
        std::uint32_t plane;
        bool shows = face_of(box, axis, plane, pool(0));
        if (shows) {
            Visibility face = visibility_of(plane);
            all = any ? combine(all, face) : face;
            any = true;
        }
        sight_.forget(mark);
        if (any && all == Visibility::partial)
            break;
    }
    return all;
}

} // namespace antumbra
