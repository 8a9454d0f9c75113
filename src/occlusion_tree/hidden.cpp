// The query of the modern culler: is a box certainly hidden? One pass with the silhouette of the box instead of one for
// each of its faces, from where a box around it has already come down to, and an end at the first part that shows.
#include "occlusion_tree/occlusion_tree.hpp"

namespace antumbra {
namespace {

constexpr std::size_t kMostPending = 512;

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

bool OcclusionTree::hides(const Box3d& box, Start start, Vec3d* seen) {
    if (start.child == kOut || box.contains(sight_.eye()))
        return false;
    Sight::Mark mark = sight_.mark();
    if (!silhouette_of(box, pool_[0]))
        return visibility_by_faces(box) == Visibility::invisible;
    signed char sides[PicturePolygon::kMost];
    bool hidden = true;
    stack_.clear();
    stack_.push_back({start.child, kRoot, 0});
    while (hidden && !stack_.empty()) {
        Work work = stack_.back();
        stack_.pop_back();
        while (hidden && work.child >= 0) {
            const Node& node = nodes_[static_cast<std::size_t>(work.child)];
            ++planes_tested_;
            Place place = locate(sight_, node.line, pool_[work.polygon], sides);
            if (place == Place::undecided) {
                hidden = false;
            } else if (place == Place::both) {
                std::uint32_t other = work.polygon + 1;
                pool_[other + 1] = pool_[work.polygon];
                hidden = other + 2 < kMostPending &&
                         cut(sight_, node.line, pool_[other + 1], sides, &pool_[other], &pool_[work.polygon]);
                stack_.push_back({node.outside, kRoot, work.polygon});
                work = {node.inside, kRoot, other};
            } else {
                work.child = place == Place::inside ? node.inside : node.outside;
            }
        }
        if (!hidden)
            break;
        bool here = false;
        if (work.child != kOut) {
            const Fragment& fragment = fragments_[fragment_of(work.child)];
            Sight::Range range = sight_.plane_range(fragment.plane, box);
            // Where the plane crosses the box, what lies in the fragment's frustum decides.
            here = range.most < 0;
            if (!here && range.least < 0) {
                // A point in front is found without splitting, mostly.
                Vec3d point;
                if (!point_in_sight(box, pool_[work.polygon], point) || !is_before(fragment, point))
                    here = misses_pyramid(box, fragment, work.polygon + 1);
            }
        }
        if (!here && seen) {
            Vec3d point;
            if (point_in_sight(box, pool_[work.polygon], point))
                *seen = point;
        }
        hidden = here;
    }
    sight_.forget(mark);
    return hidden;
}

} // namespace antumbra
