// The query of the modern culler: is a box certainly hidden? One pass with the silhouette of the box instead of one for
// each of its faces, from where a box around it has already come down to, and an end at the first part that shows.
#include "occlusion_tree/occlusion_tree.hpp"

namespace antumbra {
namespace {

/// Corners of the outline for one, two and three visible faces. Bits of a corner: 1, 2, 4 turn to the far side along
/// the first, second and third axis of the box, visible ones first.
constexpr std::uint8_t kOutline[3][6] = {{0, 2, 6, 4, 0, 0}, {2, 6, 4, 5, 1, 0}, {1, 3, 2, 6, 4, 5}};
constexpr int kOutlineCorners[3] = {4, 6, 6};

} // namespace

bool OcclusionTree::silhouette_of(const Box3d& box, PicturePolygon& silhouette) {
    const Vec3d& eye = sight_.eye();
    int axes[3], visible = 0, rest = 0;
    bool high[3]; // the near side is the maximum
    for (int axis = 0; axis < 3; ++axis) {
        if (!(box.min[axis] < box.max[axis]))
            return false;
        high[axis] = eye[axis] > box.max[axis];
        visible += high[axis] || eye[axis] < box.min[axis];
    }
    if (visible == 0)
        return false;
    int at = 0;
    for (int axis = 0; axis < 3; ++axis) {
        bool shows = high[axis] || eye[axis] < box.min[axis];
        axes[shows ? at++ : visible + rest++] = axis;
    }
    std::uint32_t loop[6];
    int corners = kOutlineCorners[visible - 1];
    // Turning round with the order of the axes and with each near maximum.
    bool even = (axes[1] == (axes[0] + 1) % 3) ^ (high[0] ^ high[1] ^ high[2]);
    for (int i = 0; i < corners; ++i) {
        std::uint8_t bits = kOutline[visible - 1][even ? i : corners - 1 - i];
        Vec3d p;
        for (int k = 0; k < 3; ++k) {
            bool take_max = high[axes[k]] != ((bits >> k & 1) != 0);
            p[axes[k]] = take_max ? box.max[axes[k]] : box.min[axes[k]];
        }
        loop[i] = sight_.add_point(p);
    }
    silhouette.count = 0;
    for (int i = 0; i < corners; ++i)
        silhouette.push(sight_.toward(loop[i]), sight_.add_edge(loop[i], loop[(i + 1) % corners]), false);
    return true;
}

OcclusionTree::Start OcclusionTree::descend(const Box3d& box, Start start) {
    Child child = start.child;
    while (child >= 0) {
        const Node& node = nodes_[static_cast<std::size_t>(child)];
        Sight::Range range = sight_.line_range(node.line, box);
        ++planes_tested_;
        if (range.least >= 0)
            child = node.inside;
        else if (range.most <= 0)
            child = node.outside;
        else
            break;
    }
    return {child};
}

/// Certainly in front of the fragment's plane, or exactly on it: what lies in an occluder's plane is not hidden by it, and
/// a box with such a point reaches in front of the plane or has a face in it. (Exactly: planes across an axis only.)
bool OcclusionTree::is_before(const Fragment& fragment, const Vec3d& point) const {
    return sight_.plane_range(fragment.plane, point).least > 0 || sight_.is_on_axis_plane(fragment.plane, point);
}

bool OcclusionTree::is_seen(const Vec3d& point, Start start) {
    Child child = start.child;
    while (child >= 0) {
        const Node& node = nodes_[static_cast<std::size_t>(child)];
        Sight::Range range = sight_.line_range(node.line, point);
        ++planes_tested_;
        if (range.least > 0)
            child = node.inside;
        else if (range.most < 0)
            child = node.outside;
        else
            return false;
    }
    return child == kOut || is_before(fragments_[fragment_of(child)], point);
}

/// Where a sight line in the middle of a piece of the outline enters the box.
bool OcclusionTree::point_in_sight(const Box3d& box, const PicturePolygon& piece, Vec3d& seen) const {
    Vec3d way{};
    for (int i = 0; i < piece.count; ++i)
        way += Vec3d{piece.x[i], piece.y[i], piece.z[i]} / piece.size[i];
    double enter = 0;
    int entered = -1;
    for (int axis = 0; axis < 3; ++axis) {
        double near = way[axis] > 0 ? box.min[axis] : box.max[axis];
        double t = (near - sight_.eye()[axis]) / way[axis];
        if (t > enter) {
            enter = t;
            entered = axis;
        }
    }
    if (entered < 0)
        return false;
    seen = sight_.eye() + way * enter;
    seen[entered] = way[entered] > 0 ? box.min[entered] : box.max[entered];
    return box.contains(seen);
}

/// Does the part of the box that lies in a piece of its outline lie behind the fragment's plane? A line of sight enters the
/// box at the farthest of the planes of the faces that show.
bool OcclusionTree::is_behind_in(const Box3d& box, const Fragment& fragment, const PicturePolygon& piece, std::size_t free) {
    Sight::Mark mark = sight_.mark();
    std::uint64_t all = (std::uint64_t(1) << piece.count) - 1, before = all;
    bool behind = false;
    for (int axis = 0; axis < 3 && !behind; ++axis) {
        double eye = sight_.eye()[axis];
        if (!(eye < box.min[axis]) && !(eye > box.max[axis]))
            continue;
        std::uint32_t face = sight_.add_axis_plane(axis, eye < box.min[axis] ? box.min[axis] : box.max[axis]);
        SideMasks farther = sight_.certain_sides(sight_.add_meeting(face, fragment.plane), piece);
        ++planes_tested_;
        behind = farther.positive == all;
        before &= farther.negative;
    }
    sight_.forget(mark);
    if (behind || before != 0)
        return behind;
    // Some faces here, some there.
    LineRef lines[PicturePolygon::kMost];
    std::size_t count = 0;
    for (int i = 0; i < piece.count; ++i)
        if (piece.flagged(i)) // the others are of the outline
            lines[count++] = piece.edge(i);
    planes_tested_ += 3 * count;
    return misses_pyramid(box, fragment.plane, {lines, count}, free);
}

/// Of the work on the stack. If it is not all hidden, `shown` is what shows, or cannot be decided; the rest stays on the stack.
bool OcclusionTree::all_hidden(const Box3d& box, Vec3d* seen, Work& shown) {
    signed char sides[PicturePolygon::kMost];
    while (!stack_.empty()) {
        Work work = stack_.back();
        stack_.pop_back();
        shown = work;
        while (work.child >= 0) {
            const Node& node = nodes_[static_cast<std::size_t>(work.child)];
            shown = work;
            ++planes_tested_;
            Place place = locate(sight_, node.line, pool(work.polygon), sides);
            if (place == Place::undecided)
                return false;
            if (place == Place::both) {
                if (!cut_in_pool(node.line, work.polygon, sides))
                    return false;
                stack_.push_back({node.outside, kRoot, work.polygon});
                work = {node.inside, kRoot, work.polygon + 1};
            } else {
                work.child = place == Place::inside ? node.inside : node.outside;
            }
        }
        shown = work;
        if (work.child != kOut) {
            const Fragment& fragment = fragments_[fragment_of(work.child)];
            Sight::Range range = sight_.plane_range(fragment.plane, box);
            if (range.most < 0)
                continue;
            // Where the plane crosses the box, what lies in the fragment's frustum decides. A point in front is found without
            // splitting, mostly.
            Vec3d point;
            if (range.least < 0 && !(point_in_sight(box, pool(work.polygon), point) && is_before(fragment, point)) &&
                is_behind_in(box, fragment, pool(work.polygon), work.polygon + 1))
                continue;
        }
        Vec3d point;
        if (seen && point_in_sight(box, pool(work.polygon), point))
            *seen = point;
        return false;
    }
    return true;
}

bool OcclusionTree::hides(const Box3d& box, Start start, Vec3d* seen) {
    if (start.child == kOut || box.contains(sight_.eye()))
        return false;
    Sight::Mark mark = sight_.mark();
    if (!silhouette_of(box, pool(0)))
        return visibility_by_faces(box) == Visibility::invisible;
    stack_.assign(1, {start.child, kRoot, 0});
    Work shown;
    bool hidden = all_hidden(box, seen, shown);
    sight_.forget(mark);
    return hidden;
}

} // namespace antumbra
