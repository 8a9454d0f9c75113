// Within one octant the planes of constant theta and of constant phi pass through the eye, so both coordinates of
// a convex cone of directions reach their extremes on its edges. A frustum is therefore clipped to the octants and the
// edges of each piece are looked at; nothing depends on an angle.
#include "pvs/direction.hpp"

#include <algorithm>
#include <cmath>

namespace antumbra {
namespace {

constexpr double kQuarter = kViewSteps / 4;
/// How far beyond an octant's border a unit vector still counts as inside: covers the rounding of clipping.
constexpr double kBorder = 1e-12;
/// Unit vectors nearer to the y axis than this have no theta that can be told from its neighbours.
constexpr double kPole = 1e-9;

/// Corners of a cone: four edges, one more for each of three planes.
struct Cone {
    std::array<Vec3d, 8> edges;
    std::size_t count = 0;
    void add(const Vec3d& edge) {
        if (count < edges.size())
            edges[count++] = edge;
    }
};

/// The part of the cone where sign * component >= 0 (Sutherland, Hodgman 1974).
Cone clip(const Cone& cone, int axis, double sign) {
    Cone inside;
    for (std::size_t i = 0; i < cone.count; ++i) {
        const Vec3d &a = cone.edges[i], &b = cone.edges[(i + 1) % cone.count];
        double at_a = sign * a[axis], at_b = sign * b[axis];
        if (at_a >= -kBorder)
            inside.add(a);
        if ((at_a > kBorder && at_b < -kBorder) || (at_a < -kBorder && at_b > kBorder)) {
            Vec3d between = normalized(a * (at_b / (at_b - at_a)) - b * (at_a / (at_b - at_a)));
            between[axis] = 0;
            inside.add(between);
        }
    }
    return inside;
}

/// theta / quarter turns within an octant's quadrant, in [0, 1].
double part_of_quadrant(const Vec3d& d, bool by_z) {
    double x = std::abs(d.x), z = std::abs(d.z);
    return (by_z ? z : x) / (x + z);
}

/// Quadrants count from +x over +z; in each, theta grows with |z| or with |x|.
int quadrant_of(bool x_negative, bool z_negative) { return z_negative ? (x_negative ? 2 : 3) : (x_negative ? 1 : 0); }
bool grows_with_z(int quadrant) { return quadrant % 2 == 0; }

double phi_of(const Vec3d& d) { return d.y / (std::abs(d.x) + std::abs(d.y) + std::abs(d.z)); }

std::uint32_t outward_low(double steps, double limit) {
    return static_cast<std::uint32_t>(std::max(std::floor(steps) - 1, limit));
}
std::uint32_t outward_high(double steps, double limit) {
    return static_cast<std::uint32_t>(std::min(std::ceil(steps) + 1, limit));
}

DirectionBox cover(const Cone& cone, int quadrant) {
    double theta_low = 1, theta_high = 0, phi_low = 1, phi_high = -1;
    for (std::size_t i = 0; i < cone.count; ++i) {
        const Vec3d& d = cone.edges[i];
        phi_low = std::min(phi_low, phi_of(d));
        phi_high = std::max(phi_high, phi_of(d));
        bool at_pole = std::abs(d.x) + std::abs(d.z) < kPole;
        double theta = at_pole ? 0 : part_of_quadrant(d, grows_with_z(quadrant));
        theta_low = std::min(theta_low, theta);
        theta_high = std::max(theta_high, at_pole ? 1 : theta);
    }
    double start = quadrant * kQuarter;
    return {outward_low(start + theta_low * kQuarter, start), outward_high(start + theta_high * kQuarter, start + kQuarter),
            outward_low((phi_low + 1) * (kViewSteps / 2), 0), outward_high((phi_high + 1) * (kViewSteps / 2), kViewSteps)};
}

bool is_direction(const Vec3d& d) { return is_finite(d) && (d.x != 0 || d.y != 0 || d.z != 0); }

/// Unit length without overflow or loss of small numbers.
Vec3d unit(const Vec3d& d) {
    double largest = std::max({std::abs(d.x), std::abs(d.y), std::abs(d.z)});
    return normalized(d / largest);
}

constexpr DirectionBox kAllDirections{0, kViewSteps, 0, kViewSteps};

} // namespace

DirectionBoxes cover_directions(const ViewRange& range) {
    DirectionBoxes cover_boxes;
    cover_boxes.boxes[0] = kAllDirections;
    cover_boxes.count = 1;
    Cone cone;
    for (const Vec3d& corner : range.corners) {
        if (range.all_directions || !is_direction(corner))
            return cover_boxes;
        cone.add(unit(corner));
    }
    cover_boxes.count = 0;
    for (int octant = 0; octant < 8; ++octant) {
        bool x_negative = octant & 1, y_negative = octant & 2, z_negative = octant & 4;
        Cone piece = clip(clip(clip(cone, 0, x_negative ? -1 : 1), 1, y_negative ? -1 : 1), 2, z_negative ? -1 : 1);
        if (piece.count > 0)
            cover_boxes.boxes[cover_boxes.count++] = cover(piece, quadrant_of(x_negative, z_negative));
    }
    return cover_boxes;
}

ViewRange camera_range(const Box3d& eyes, const Vec3d& direction, const Vec3d& up, double tan_half_fov_y,
                       double aspect) {
    ViewRange range{eyes, true, {}};
    if (!is_direction(direction) || !is_direction(up))
        return range;
    Vec3d forward = unit(direction), right = cross(forward, unit(up));
    double width = tan_half_fov_y * aspect;
    // Beyond a million the frustum is half of space but for rounding.
    if (!(length(right) > 1e-9) || !(tan_half_fov_y > 0) || !(width > 0) || !(tan_half_fov_y < 1e6) || !(width < 1e6))
        return range;
    right = normalized(right);
    Vec3d top = cross(right, forward) * tan_half_fov_y;
    right = right * width;
    range.all_directions = false;
    range.corners = {forward - right - top, forward + right - top, forward + right + top, forward - right + top};
    return range;
}

ViewDirection to_view_direction(const Vec3d& d) {
    double x = std::abs(d.x), z = std::abs(d.z);
    int quadrant = quadrant_of(d.x < 0, d.z < 0);
    double theta = x + z > 0 ? quadrant + part_of_quadrant(d, grows_with_z(quadrant)) : 0;
    return {theta >= 4 ? 0 : theta * kQuarter, (phi_of(d) + 1) * (kViewSteps / 2)};
}

Vec3d from_view_direction(const ViewDirection& direction) {
    double y = direction.phi / (kViewSteps / 2) - 1, theta = direction.theta / kQuarter;
    double quadrant = std::min(std::floor(theta), 3.0), part = theta - quadrant, around = 1 - std::abs(y);
    double low = (1 - part) * around, high = part * around;
    switch (static_cast<int>(quadrant)) {
    case 0:
        return {low, y, high};
    case 1:
        return {-high, y, low};
    case 2:
        return {-low, y, -high};
    default:
        return {high, y, -low};
    }
}

} // namespace antumbra
