#include "bake/exact/patch.hpp"

#include <algorithm>
#include <unordered_set>

namespace antumbra::exact {
namespace {

constexpr std::size_t kLargestPatch = 1024;
constexpr int kStarts = 2;

bool outside(const std::vector<GridPlane>& planes, const GridPoint& a, const GridPoint& b) {
    return std::any_of(planes.begin(), planes.end(),
                       [&](const GridPlane& plane) { return plane.at(a) >= 0 && plane.at(b) >= 0; });
}

/// Can no end of a segment, strictly inside `face`, lie on the triangle?
bool keeps_clear(const Face& face, const std::vector<GridPoint>& triangle) {
    bool front = false, back = false, on = false;
    for (const GridPoint& p : triangle) {
        int at = sign_of(face.plane.at(p));
        front |= at > 0;
        back |= at < 0;
        on |= at == 0;
    }
    if (!front || (!back && !on))
        return true;
    std::size_t triple[3];
    GridPlane plane = plane_of(triangle, triple);
    front = back = false;
    for (const GridPoint& p : face.corners) {
        Int128 at = plane.at(p);
        front |= at > 0;
        back |= at < 0;
    }
    return front != back;
}

template <bool F>
class Patch {
  public:
    Patch(LineStore<F>& store, const Frame& frame, OccluderSource& source, VertexId line)
        : store_(store), frame_(frame), source_(source), line_(line), around_(frame.planes_around()) {}

    std::size_t size() const { return members_.size(); }

    bool grow(OccluderId start) {
        members_.assign(1, start);
        inside_ = {start};
        crossings_ = 0;
        signed_count_ = 0;
        all_double_ = oriented_ = true;
        for (std::size_t k = 0; k < members_.size(); ++k)
            if (!visit(members_[k]))
                return false;
        // A negative number says that backs are crossed, which only helps where they block.
        if (all_double_)
            return crossings_ % 2 == 1 || (oriented_ && signed_count_ != 0);
        return oriented_ && signed_count_ > 0;
    }

  private:
    bool visit(OccluderId id) {
        const certify::Polygon& polygon = source_.polygon(id);
        std::vector<GridPoint> corners;
        for (const GridPoint& p : polygon.corners)
            corners.push_back(p - frame_.origin);
        all_double_ &= polygon.both_sides;
        if (!keeps_clear(frame_.s, corners) || !keeps_clear(frame_.t, corners))
            return false;
        if (!count(corners))
            return false;
        for (std::size_t k = 0; k < corners.size(); ++k) {
            const GridPoint &a = corners[k], &b = corners[(k + 1) % corners.size()];
            if (!may_be_met(a, b))
                continue;
            neighbours_.clear();
            bool reversed_once = source_.neighbours(id, k, neighbours_);
            if (neighbours_.size() % 2 == 0) // an odd number of others: even in all
                return false;
            oriented_ &= neighbours_.size() == 1 && reversed_once;
            if (!all_double_ && !oriented_)
                return false;
            for (OccluderId other : neighbours_)
                if (inside_.insert(other).second)
                    members_.push_back(other);
            if (members_.size() > kLargestPatch)
                return false;
        }
        return true;
    }

    /// Might a line from inside S to inside T meet the edge?
    bool may_be_met(const GridPoint& a, const GridPoint& b) {
        HalfSpace edge = store_.edge(a, b);
        bool positive = false, negative = false;
        for (VertexId line : frame_.lines) {
            int sign = store_.sign(edge.hyperplane, line);
            positive |= sign > 0;
            negative |= sign < 0;
            if (positive && negative)
                return !outside(around_, a, b);
        }
        // One sign on all corner lines, and not always zero: the same, strictly, on all lines between the insides.
        return !positive && !negative && !outside(around_, a, b);
    }

    /// Adds the line's crossing of the triangle in front of S and T. False if it is not a clear case.
    bool count(const std::vector<GridPoint>& corners) {
        int crossing = 0;
        for (std::size_t k = 0; k < corners.size(); ++k) {
            HalfSpace edge = store_.edge(corners[k], corners[(k + 1) % corners.size()]);
            int sign = store_.sign(edge.hyperplane, line_) * edge.sign;
            if (sign == 0)
                return false;
            if (crossing == 0)
                crossing = sign;
            else if (crossing != sign)
                return true; // passes by
        }
        std::size_t triple[3];
        GridPlane plane = plane_of(corners, triple);
        for (const Face* face : {&frame_.s, &frame_.t}) {
            bool front = false, back = false;
            for (const GridPoint& p : corners) {
                Int128 at = face->plane.at(p);
                front |= at > 0;
                back |= at < 0;
            }
            if (!front)
                return true; // crossed outside the segment
            if (!back)
                continue;
            // The part in front is bounded by the line where the planes meet.
            HyperplaneId cut = store_.hyperplane(dual(exact::meet(face->plane, plane)));
            int sign = store_.sign(cut, line_);
            if (sign == 0)
                return false;
            if (sign != crossing)
                return true;
        }
        ++crossings_;
        signed_count_ -= crossing; // against the normal: from the front
        return true;
    }

    LineStore<F>& store_;
    const Frame& frame_;
    OccluderSource& source_;
    VertexId line_;
    std::vector<GridPlane> around_;
    std::vector<OccluderId> members_, neighbours_;
    std::unordered_set<OccluderId> inside_;
    int crossings_ = 0, signed_count_ = 0;
    bool all_double_ = true, oriented_ = true;
};

} // namespace

template <bool F>
std::size_t patch_hides(LineStore<F>& store, const Frame& frame, OccluderSource& source,
                        const std::vector<OccluderId>& starts, VertexId line, QueryCounters& counters) {
    Patch<F> patch(store, frame, source, line);
    int tried = 0;
    for (OccluderId start : starts) {
        if (!source.has_neighbours(start))
            continue;
        if (tried++ == kStarts)
            break;
        ++counters.patches_tried;
        if (patch.grow(start)) {
            ++counters.patches_proved;
            return patch.size();
        }
    }
    return 0;
}

template std::size_t patch_hides(LineStore<true>&, const Frame&, OccluderSource&, const std::vector<OccluderId>&, VertexId,
                          QueryCounters&);
template std::size_t patch_hides(LineStore<false>&, const Frame&, OccluderSource&, const std::vector<OccluderId>&, VertexId,
                          QueryCounters&);

} // namespace antumbra::exact
