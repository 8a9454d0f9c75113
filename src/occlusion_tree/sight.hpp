// The picture seen from one point: directions, and planes through the eye that divide them ("lines" of the picture).
//
// Everything an occlusion tree asks is the side of a line on which a direction lies. Lines and directions are never
// stored as rounded numbers alone: each knows the input points it is made of, so that its sign can be decided exactly.
//
//   direction   an input point as seen from the eye, or the crossing of two lines
//   line        the plane through the eye and two input points (a shadow plane), or the meeting of two surfaces: where, in
//               the picture, one plane of the scene passes behind another. The inverse of the distance to a plane is
//               linear in the direction, so depth is one more side of a line.
//
// Doubles with a proven bound decide first; where they cannot, ExactNumber does. Crossings are always made of two lines
// of the input, never of other crossings, so that errors do not pile up.
#pragma once

#include "occlusion_tree/side_kernels.hpp"

#include <antumbra/math.hpp>

#include <cstdint>
#include <span>
#include <vector>

namespace antumbra {

/// A line and which of its sides counts as positive.
struct LineRef {
    std::uint32_t bits = 0;
    std::uint32_t index() const { return bits >> 1; }
    bool turned() const { return bits & 1; }
    LineRef operator-() const { return {bits ^ 1}; }
};

inline constexpr std::uint32_t kNoPoint = 0xFFFFFFFFu;

/// Of any length; the true vector is within `error` of `d`.
struct Direction {
    Vec3d d;
    double error = 0, size = 0; ///< size: of d, at least
    std::uint32_t point = kNoPoint; ///< an input point, or the crossing first x second
    LineRef first, second;
};

/// Sides: 1, 0, -1 are certain.
inline constexpr int kUndecided = 2;

struct SightTally {
    std::uint64_t asked = 0;     ///< signs
    std::uint64_t plain = 0;     ///< zeros because of shared coordinates or lines
    std::uint64_t exact = 0, undecided = 0; ///< by exact numbers; the rest was certain in doubles
    std::uint64_t filtered() const { return asked - plain - exact - undecided; }
};

/// A region of space.
struct Ball {
    Vec3d centre;
    double radius = 0;
};

class Sight {
  public:
    /// Numbers added after a mark can be dropped again.
    struct Mark {
        std::size_t points, lines, planes;
    };

    /// Forgets everything. `size` is that of the scene, only for scaling. Eye and points finite, below 1e17.
    void begin(const Vec3d& eye, double size);
    void reserve(std::size_t points, std::size_t lines, std::size_t planes);
    Mark mark() const { return {points_.size(), lines_.size(), planes_.size()}; }
    void forget(const Mark& mark);
    const Vec3d& eye() const { return eye_; }

    std::uint32_t add_point(const Vec3d& point);
    /// Positive where (a - eye, b - eye, direction) turn counter-clockwise: their determinant is positive.
    LineRef add_edge(std::uint32_t a, std::uint32_t b);
    /// Through three points, counter-clockwise seen from the eye, which must lie strictly in front (see is_in_front()).
    std::uint32_t add_plane(std::uint32_t a, std::uint32_t b, std::uint32_t c);
    /// The plane where coordinate `axis` is `at`; the eye is not on it.
    std::uint32_t add_axis_plane(int axis, double at);
    /// Positive where `farther` is met behind `nearer`.
    LineRef add_meeting(std::uint32_t farther, std::uint32_t nearer);

    /// Exactly: is the eye strictly in front of the triangle of these points?
    bool is_in_front(const Vec3d& a, const Vec3d& b, const Vec3d& c) const;

    Direction toward(std::uint32_t point) const;
    /// Where a walk along the edge's line (positive side to the left) meets `line`, from its negative to its positive
    /// side if `rising`, else the other way.
    Direction crossing(LineRef edge, LineRef line, bool rising) const;

    /// 1, 0, -1 or kUndecided.
    int side(LineRef line, const Direction& direction) const;
    /// The corners of a polygon whose sides doubles decide.
    SideMasks certain_sides(LineRef line, const PicturePolygon& polygon) const;
    /// side() where doubles did not decide.
    int unfiltered_side(LineRef line, const Direction& direction) const;
    void use(SideKernel kernel) { kernel_ = kernel; }
    /// Is an input point behind the plane (1), on it (0), in front of it (-1)? Never undecided.
    int behind(std::uint32_t plane, std::uint32_t point) const;

    /// Bounds of normal . (p - eye) + distance over the box, rounding included; > 0 in front of the plane.
    struct Range {
        double least, most;
    };
    Range plane_range(std::uint32_t plane, const Box3d& box) const;
    Range plane_range(std::uint32_t plane, const Vec3d& point) const { return plane_range(plane, Box3d{point, point}); }
    /// Exactly on the plane? Only known of planes across an axis; false for others.
    bool is_on_axis_plane(std::uint32_t plane, const Vec3d& point) const {
        return planes_[plane].axis < 3 && point[planes_[plane].axis] == planes_[plane].at;
    }
    /// The same for a line: the certain bounds of its values over the box.
    Range line_range(LineRef line, const Box3d& box) const;
    Range line_range(LineRef line, const Vec3d& point) const { return line_range(line, Box3d{point, point}); }

    Range plane_range(std::uint32_t plane, const Ball& ball) const;
    Range plane_range(std::uint32_t plane, std::span<const Vec3d> hull) const;
    Range line_range(LineRef line, const Ball& ball) const;
    Range line_range(LineRef line, std::span<const Vec3d> hull) const;

    /// A line with all directions on its positive side that are on the positive sides of both. Only line_range() knows it.
    LineRef add_blend(LineRef a, LineRef b);
    /// Of the angle between their normals, roughly.
    double cosine(LineRef a, LineRef b) const;

    const SightTally& tally() const { return tally_; }

  private:
    struct Line {
        Vec3d n;            ///< of any length
        double error, size; ///< the true normal is within `error`; size: of n, at least
        bool meeting;
        bool nowhere;       ///< the meeting of a plane with itself: nothing is in front or behind
        std::uint32_t a, b; ///< points of an edge, planes of a meeting
        /// 0..2: the line is the picture of a straight line of the scene along that axis, where the next two coordinates (in
        /// turn) are `at`: an edge along the axis, or the meeting of planes across the other two. 3: it is not.
        int axis = 3;
        double at[2] = {0, 0};
        bool is_same(const Line& other) const {
            if (axis < 3)
                return axis == other.axis && at[0] == other.at[0] && at[1] == other.at[1];
            return meeting == other.meeting && ((a == other.a && b == other.b) || (a == other.b && b == other.a));
        }
        double coordinate(int of) const { return at[of == (axis + 1) % 3 ? 0 : 1]; }
    };
    struct Plane {
        Vec3d n;         ///< unit length, towards the eye
        double distance; ///< of the eye: normal . (p - eye) + distance = 0
        double n_error, distance_error;
        int axis; ///< 3: made of points
        double at;
        std::uint32_t a, b, c;
    };
    LineFilter filter_of(const Line& line) const;
    int exact_side(LineRef line, const Direction& direction) const;
    void find_axis(Line& line) const;
    bool contains(const Plane& plane, const Vec3d& point) const;
    bool contains(const Line& line, const Vec3d& point) const;
    int common_points(const Line& u, const Line& v, Vec3d* points) const;
    /// Is the direction on the line because of coordinates or corners that they share? False says nothing.
    bool meet_plainly(const Line& line, const Direction& direction) const;
    int settle(int sign) const;

    Vec3d eye_;
    double scale_ = 1;
    std::vector<Vec3d> points_, offsets_; ///< offsets: point - eye, rounded
    std::vector<Line> lines_;
    std::vector<Plane> planes_;
    mutable SightTally tally_;
    SideKernel kernel_ = side_kernel(SideKernelKind::best);
};

} // namespace antumbra
