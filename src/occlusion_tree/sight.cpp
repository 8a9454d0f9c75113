#include "occlusion_tree/sight.hpp"

#include "geometry/predicates.hpp"
#include "occlusion_tree/exact_number.hpp"
#include "occlusion_tree/picture_polygon.hpp"

namespace antumbra {
namespace {

/// Half an ulp of 1. The bounds below count roundings to first order and then take about twice as many.
constexpr double kUnit = 0x1p-53;

double norm(const Vec3d& v) { return std::sqrt(dot(v, v)); }
/// Not less than the length, without a root.
double size_of(const Vec3d& v) { return std::abs(v.x) + std::abs(v.y) + std::abs(v.z); }

/// `v`, off by at most `error`, made a unit vector; how far the true unit vector can be.
double normalise(Vec3d& v, double error) {
    double size = norm(v);
    if (!(size > 4 * error) || !(size > 1e-290)) {
        v = {0, 0, 0};
        return 4; // says nothing: every question goes to exact numbers
    }
    v = v * (1 / size);
    return 2 * error / size + 8 * kUnit;
}

ExactVector difference(const Vec3d& a, const Vec3d& b, double scale) {
    return {ExactNumber::difference(a.x * scale, b.x * scale), ExactNumber::difference(a.y * scale, b.y * scale),
            ExactNumber::difference(a.z * scale, b.z * scale)};
}

ExactVector exact_cross(const ExactVector& a, const ExactVector& b) {
    return {a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x};
}

ExactNumber exact_dot(const ExactVector& a, const ExactVector& b) { return a.x * b.x + a.y * b.y + a.z * b.z; }

ExactVector scaled(const ExactVector& a, const ExactNumber& s) { return {a.x * s, a.y * s, a.z * s}; }

ExactVector turned(const ExactVector& a, bool turn) { return turn ? ExactVector{-a.x, -a.y, -a.z} : a; }

} // namespace

void Sight::begin(const Vec3d& eye, double size) {
    forget({0, 0, 0});
    eye_ = eye;
    // Exact products of fifteen factors neither vanish nor explode for coordinates near 2^20.
    scale_ = size > 0 && std::isfinite(size) ? std::ldexp(1.0, 20 - std::ilogb(size)) : 1;
    tally_ = {};
}

void Sight::reserve(std::size_t points, std::size_t lines, std::size_t planes) {
    points_.reserve(points);
    offsets_.reserve(points);
    lines_.reserve(lines);
    planes_.reserve(planes);
}

void Sight::forget(const Mark& mark) {
    points_.resize(mark.points);
    offsets_.resize(mark.points);
    lines_.resize(mark.lines);
    planes_.resize(mark.planes);
}

std::uint32_t Sight::add_point(const Vec3d& point) {
    points_.push_back(point);
    offsets_.push_back(point - eye_);
    return static_cast<std::uint32_t>(points_.size() - 1);
}

LineRef Sight::add_edge(std::uint32_t a, std::uint32_t b) {
    const Vec3d &u = offsets_[a], &v = offsets_[b];
    Line line{cross(u, v), 16 * kUnit * size_of(u) * size_of(v), 0, false, false, a, b};
    line.size = size_of(line.n);
    find_axis(line);
    lines_.push_back(line);
    return {static_cast<std::uint32_t>(lines_.size() - 1) << 1};
}

std::uint32_t Sight::add_plane(std::uint32_t a, std::uint32_t b, std::uint32_t c) {
    // Walls and floors mostly: no rounding, and whether two of them are one plane is seen at once.
    for (int axis = 0; axis < 3; ++axis)
        if (points_[a][axis] == points_[b][axis] && points_[a][axis] == points_[c][axis])
            return add_axis_plane(axis, points_[a][axis]);
    Vec3d u = points_[b] - points_[a], v = points_[c] - points_[a];
    Plane plane{cross(u, v), 0, 0, 0, 3, 0, a, b, c};
    plane.n_error = normalise(plane.n, 16 * kUnit * norm(u) * norm(v));
    plane.distance = -dot(plane.n, offsets_[a]);
    plane.distance_error = norm(offsets_[a]) * (plane.n_error + 8 * kUnit);
    planes_.push_back(plane);
    return static_cast<std::uint32_t>(planes_.size() - 1);
}

std::uint32_t Sight::add_axis_plane(int axis, double at) {
    Plane plane{{0, 0, 0}, std::abs(eye_[axis] - at), 0, 0, axis, at, 0, 0, 0};
    plane.n[axis] = eye_[axis] > at ? 1 : -1;
    plane.distance_error = kUnit * plane.distance;
    planes_.push_back(plane);
    return static_cast<std::uint32_t>(planes_.size() - 1);
}

LineRef Sight::add_meeting(std::uint32_t farther, std::uint32_t nearer) {
    const Plane &f = planes_[farther], &g = planes_[nearer];
    Line line{f.n * g.distance - g.n * f.distance, 0, 0, true, false, farther, nearer};
    line.nowhere = f.axis < 3 && f.axis == g.axis && f.at == g.at;
    line.error = f.n_error * g.distance + g.distance_error + g.n_error * f.distance + f.distance_error +
                 8 * kUnit * (f.distance + g.distance);
    line.size = size_of(line.n);
    find_axis(line);
    lines_.push_back(line);
    return {static_cast<std::uint32_t>(lines_.size() - 1) << 1};
}

void Sight::find_axis(Line& line) const {
    Vec3d known{};
    int unknown = 0;
    if (line.meeting) {
        const Plane &f = planes_[line.a], &g = planes_[line.b];
        if (f.axis == 3 || g.axis == 3 || f.axis == g.axis)
            return;
        line.axis = 3 - f.axis - g.axis;
        known[f.axis] = f.at;
        known[g.axis] = g.at;
    } else {
        for (int axis = 0; axis < 3; ++axis)
            if (points_[line.a][axis] != points_[line.b][axis]) {
                line.axis = axis;
                ++unknown;
            }
        known = points_[line.a];
        if (unknown != 1)
            line.axis = 3;
    }
    line.at[0] = known[(line.axis + 1) % 3];
    line.at[1] = known[(line.axis + 2) % 3];
}

bool Sight::contains(const Plane& plane, const Vec3d& point) const {
    if (plane.axis < 3)
        return point[plane.axis] == plane.at;
    const Vec3d &a = points_[plane.a], &b = points_[plane.b], &c = points_[plane.c];
    return point == a || point == b || point == c || orient3d(a, b, c, point) == 0;
}

/// The straight line of the scene that a line is the picture of.
bool Sight::contains(const Line& line, const Vec3d& point) const {
    if (line.axis < 3)
        return point[(line.axis + 1) % 3] == line.at[0] && point[(line.axis + 2) % 3] == line.at[1];
    if (line.meeting)
        return contains(planes_[line.a], point) && contains(planes_[line.b], point);
    return point == points_[line.a] || point == points_[line.b];
}

/// Of two straight lines of the scene, where coordinates or corners show it.
int Sight::common_points(const Line& u, const Line& v, Vec3d* points) const {
    int count = 0;
    if (u.axis < 3 && v.axis < 3) {
        int third = 3 - u.axis - v.axis;
        if (u.axis != v.axis && u.coordinate(third) == v.coordinate(third)) {
            points[0][u.axis] = v.coordinate(u.axis);
            points[0][v.axis] = u.coordinate(v.axis);
            points[0][third] = u.coordinate(third);
            count = 1;
        }
        return count;
    }
    for (const Line* edge : {&u, &v}) {
        if (edge->meeting || edge->axis < 3)
            continue;
        for (std::uint32_t end : {edge->a, edge->b})
            if (contains(edge == &u ? v : u, points_[end]))
                points[count++] = points_[end];
    }
    return count;
}

bool Sight::meet_plainly(const Line& line, const Direction& direction) const {
    if (direction.point != kNoPoint)
        return contains(line, points_[direction.point]);
    const Line &first = lines_[direction.first.index()], &second = lines_[direction.second.index()];
    if (line.is_same(first) || line.is_same(second))
        return true;
    // Pictures of straight lines through one point of the scene: a corner of a box, of a polygon.
    Vec3d points[4];
    for (const Line* other : {&second, &line})
        for (int i = 0, count = common_points(first, *other, points); i < count; ++i)
            if (contains(other == &line ? second : line, points[i]))
                return true;
    return false;
}

bool Sight::is_in_front(const Vec3d& a, const Vec3d& b, const Vec3d& c) const {
    return in_exact_range(eye_) && orient3d(a, b, c, eye_) > 0;
}

Direction Sight::toward(std::uint32_t point) const {
    double size = size_of(offsets_[point]);
    return {offsets_[point], 2 * kUnit * size, size, point, {}, {}};
}

Direction Sight::crossing(LineRef edge, LineRef line, bool rising) const {
    Direction x{{}, 0, 0, kNoPoint, rising ? line : edge, rising ? edge : line};
    const Line &e = lines_[edge.index()], &l = lines_[line.index()];
    x.d = cross(e.n, l.n) * (rising == (edge.turned() == line.turned()) ? -1.0 : 1.0);
    x.error = e.error * l.size + l.error * e.size + e.error * l.error + 8 * kUnit * e.size * l.size;
    x.size = size_of(x.d);
    // Lines of two edges that share an end meet there: a corner of a mesh stays one and the same direction.
    if (!e.meeting && !l.meeting && x.error < 0.1 * x.size)
        for (std::uint32_t shared : {e.a, e.b})
            if ((shared == l.a || shared == l.b) && dot(x.d, offsets_[shared]) > 0)
                return toward(shared);
    return x;
}

int Sight::settle(int sign) const {
    ++(sign == kUndecided ? tally_.undecided : tally_.exact);
    return sign;
}

/// |value - true value| <= line.error |d| + error |n| + line.error error + roundings of the dot product.
LineFilter Sight::filter_of(const Line& line) const {
    return {line.n, line.error + 8 * kUnit * line.size, line.size + line.error};
}

SideMasks Sight::certain_sides(LineRef ref, const PicturePolygon& polygon) const {
    const Line& line = lines_[ref.index()];
    tally_.asked += static_cast<std::uint64_t>(polygon.count);
    if (line.nowhere)
        return {0, 0};
    SideMasks masks = kernel_(filter_of(line), polygon);
    return ref.turned() ? SideMasks{masks.negative, masks.positive} : masks;
}

int Sight::side(LineRef ref, const Direction& direction) const {
    const Line& line = lines_[ref.index()];
    if (line.nowhere)
        return 0;
    ++tally_.asked;
    LineFilter filter = filter_of(line);
    double value = dot(line.n, direction.d);
    if (std::abs(value) > direction.size * filter.size_factor + direction.error * filter.error_factor)
        return (value > 0) != ref.turned() ? 1 : -1;
    return unfiltered_side(ref, direction);
}

int Sight::unfiltered_side(LineRef ref, const Direction& direction) const {
    const Line& line = lines_[ref.index()];
    bool plainly_on = line.nowhere;
    if (direction.point == kNoPoint)
        plainly_on |= direction.first.index() == ref.index() || direction.second.index() == ref.index();
    else
        plainly_on |= !line.meeting && (direction.point == line.a || direction.point == line.b);
    // Walls, floors and boxes: most of what rounding leaves open is exactly on the line, and for a simple reason.
    if (plainly_on || meet_plainly(line, direction)) {
        ++tally_.plain;
        return 0;
    }
    return exact_side(ref, direction);
}

int Sight::exact_side(LineRef ref, const Direction& direction) const {
    auto plane_of = [&](const Plane& plane, ExactNumber& distance) {
        ExactVector normal;
        if (plane.axis < 3) {
            ExactNumber gap = ExactNumber::difference(eye_[plane.axis] * scale_, plane.at * scale_);
            bool positive = plane.n[plane.axis] > 0;
            normal[plane.axis] = ExactNumber::difference(positive ? 1 : -1, 0);
            distance = positive ? gap : -gap;
        } else {
            normal = exact_cross(difference(points_[plane.b], points_[plane.a], scale_),
                                 difference(points_[plane.c], points_[plane.a], scale_));
            distance = exact_dot(normal, difference(eye_, points_[plane.a], scale_));
        }
        return normal;
    };
    auto line_of = [&](LineRef l) {
        const Line& line = lines_[l.index()];
        if (!line.meeting)
            return turned(exact_cross(difference(points_[line.a], eye_, scale_), difference(points_[line.b], eye_, scale_)),
                          l.turned());
        ExactNumber far_distance, near_distance;
        ExactVector farther = plane_of(planes_[line.a], far_distance), nearer = plane_of(planes_[line.b], near_distance);
        ExactVector a = scaled(farther, near_distance), b = scaled(nearer, far_distance);
        return turned({a.x - b.x, a.y - b.y, a.z - b.z}, l.turned());
    };
    ExactVector d = direction.point != kNoPoint ? difference(points_[direction.point], eye_, scale_)
                                                : exact_cross(line_of(direction.first), line_of(direction.second));
    ExactNumber value = exact_dot(line_of(ref), d);
    return settle(value.broken() ? kUndecided : value.sign());
}

int Sight::behind(std::uint32_t index, std::uint32_t point) const {
    const Plane& plane = planes_[index];
    if (plane.axis < 3) {
        double gap = points_[point][plane.axis] - plane.at;
        return gap == 0 ? 0 : (gap > 0) == (plane.n[plane.axis] > 0) ? -1 : 1;
    }
    if (point == plane.a || point == plane.b || point == plane.c)
        return 0;
    const Vec3d& offset = offsets_[point];
    double value = dot(plane.n, offset) + plane.distance;
    double bound = norm(offset) * (plane.n_error + 8 * kUnit) + plane.distance_error + 8 * kUnit * plane.distance;
    ++tally_.asked;
    if (std::abs(value) > bound)
        return value > 0 ? -1 : 1;
    ++tally_.exact;
    return -orient3d(points_[plane.a], points_[plane.b], points_[plane.c], points_[point]);
}

Sight::Range Sight::plane_range(std::uint32_t index, const Box3d& box) const {
    const Plane& plane = planes_[index];
    Range range{plane.distance, plane.distance};
    double reach = plane.distance, slack = plane.distance_error;
    for (int axis = 0; axis < 3; ++axis) {
        double low = box.min[axis] - eye_[axis], high = box.max[axis] - eye_[axis], n = plane.n[axis];
        range.least += n * (n > 0 ? low : high);
        range.most += n * (n > 0 ? high : low);
        double farthest = std::max(std::abs(low), std::abs(high));
        reach += std::abs(n) * farthest;
        slack += plane.n_error * farthest;
    }
    slack += 16 * kUnit * reach;
    return {range.least - slack, range.most + slack};
}

Sight::Range Sight::line_range(LineRef ref, const Box3d& box) const {
    const Line& line = lines_[ref.index()];
    Range range{0, 0};
    double slack = 0;
    for (int axis = 0; axis < 3; ++axis) {
        double low = box.min[axis] - eye_[axis], high = box.max[axis] - eye_[axis];
        double n = ref.turned() ? -line.n[axis] : line.n[axis];
        range.least += n * (n > 0 ? low : high);
        range.most += n * (n > 0 ? high : low);
        slack += (line.error + 16 * kUnit * line.size) * std::max(std::abs(low), std::abs(high));
    }
    return {range.least - slack, range.most + slack};
}

Sight::Range Sight::plane_range(std::uint32_t index, const Ball& ball) const {
    Range range = plane_range(index, Box3d{ball.centre, ball.centre});
    double reach = ball.radius * (1 + 32 * kUnit) * (1 + planes_[index].n_error);
    return {range.least - reach, range.most + reach};
}

Sight::Range Sight::line_range(LineRef line, const Ball& ball) const {
    Range range = line_range(line, Box3d{ball.centre, ball.centre});
    const Line& l = lines_[line.index()];
    double reach = ball.radius * (norm(l.n) * (1 + 32 * kUnit) + l.error);
    return {range.least - reach, range.most + reach};
}

Sight::Range Sight::plane_range(std::uint32_t index, std::span<const Vec3d> hull) const {
    Range range = plane_range(index, hull[0]);
    for (const Vec3d& point : hull.subspan(1)) {
        Range one = plane_range(index, point);
        range = {std::min(range.least, one.least), std::max(range.most, one.most)};
    }
    return range;
}

Sight::Range Sight::line_range(LineRef line, std::span<const Vec3d> hull) const {
    Range range = line_range(line, hull[0]);
    for (const Vec3d& point : hull.subspan(1)) {
        Range one = line_range(line, point);
        range = {std::min(range.least, one.least), std::max(range.most, one.most)};
    }
    return range;
}

double Sight::cosine(LineRef a, LineRef b) const {
    const Line &u = lines_[a.index()], &v = lines_[b.index()];
    double size = norm(u.n) * norm(v.n);
    return size > 0 ? dot(u.n, v.n) / size * (a.turned() == b.turned() ? 1 : -1) : 0;
}

LineRef Sight::add_blend(LineRef a, LineRef b) {
    const Line &u = lines_[a.index()], &v = lines_[b.index()];
    // The weights are taken as they are: any positive ones will do.
    double s = (a.turned() ? -1 : 1) / std::max(norm(u.n), 1e-300), t = (b.turned() ? -1 : 1) / std::max(norm(v.n), 1e-300);
    Line line{u.n * s + v.n * t, 0, 0, true, true, 0, 0};
    line.error = std::abs(s) * (u.error + 4 * kUnit * u.size) + std::abs(t) * (v.error + 4 * kUnit * v.size);
    line.size = size_of(line.n);
    lines_.push_back(line);
    return {static_cast<std::uint32_t>(lines_.size() - 1) << 1};
}

} // namespace antumbra
