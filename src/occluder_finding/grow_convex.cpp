#include "occluder_finding/grow_convex.hpp"

#include <algorithm>

namespace antumbra {
namespace {

using Corners = std::array<Vec3d, 3>;

constexpr double kReach = 0.5; ///< grid steps that a triangle must reach in to count

Vec3d nearest_in_box(const Vec3d& p, const Box3d& box) {
    Vec3d q;
    for (int axis = 0; axis < 3; ++axis)
        q[axis] = std::clamp(p[axis], box.min[axis], box.max[axis]);
    return q;
}

/// Ericson, Real-Time Collision Detection (2005), 5.1.5.
Vec3d nearest_in_triangle(const Vec3d& p, const Corners& t) {
    Vec3d ab = t[1] - t[0], ac = t[2] - t[0], ap = p - t[0];
    double d1 = dot(ab, ap), d2 = dot(ac, ap);
    if (d1 <= 0 && d2 <= 0)
        return t[0];
    Vec3d bp = p - t[1];
    double d3 = dot(ab, bp), d4 = dot(ac, bp);
    if (d3 >= 0 && d4 <= d3)
        return t[1];
    double vc = d1 * d4 - d3 * d2;
    if (vc <= 0 && d1 >= 0 && d3 <= 0)
        return t[0] + ab * (d1 / (d1 - d3));
    Vec3d cp = p - t[2];
    double d5 = dot(ab, cp), d6 = dot(ac, cp);
    if (d6 >= 0 && d5 <= d6)
        return t[2];
    double vb = d5 * d2 - d1 * d6;
    if (vb <= 0 && d2 >= 0 && d6 <= 0)
        return t[0] + ac * (d2 / (d2 - d6));
    double va = d3 * d6 - d5 * d4;
    if (va <= 0 && d4 >= d3 && d5 >= d6)
        return t[1] + (t[2] - t[1]) * ((d4 - d3) / ((d4 - d3) + (d5 - d6)));
    double sum = va + vb + vc;
    return t[0] + ab * (vb / sum) + ac * (vc / sum);
}

/// What of a triangle lies inside of all planes, as the squared distance of its nearest corner to the seed; nothing if it
/// stays out.
std::optional<double> reaches_in(const Corners& triangle, const std::vector<HalfSpace>& planes, const Box3d& seed) {
    Vec3d polygon[40], next[40];
    std::copy(triangle.begin(), triangle.end(), polygon);
    int count = 3;
    for (const HalfSpace& plane : planes) {
        int kept = 0;
        for (int i = 0; i < count; ++i) {
            const Vec3d &a = polygon[i], &b = polygon[i + 1 == count ? 0 : i + 1];
            double va = plane.offset - kReach - dot(plane.normal, a), vb = plane.offset - kReach - dot(plane.normal, b);
            if (va > 0)
                next[kept++] = a;
            if ((va > 0) != (vb > 0))
                next[kept++] = a + (b - a) * (va / (va - vb));
        }
        count = kept;
        if (count == 0)
            return {};
        std::copy(next, next + count, polygon);
    }
    double nearest = std::numeric_limits<double>::infinity();
    for (int i = 0; i < count; ++i) {
        Vec3d gap = polygon[i] - nearest_in_box(polygon[i], seed);
        nearest = std::min(nearest, dot(gap, gap));
    }
    return nearest;
}

double farthest(const Box3d& box, const Vec3d& normal) {
    double sum = 0;
    for (int axis = 0; axis < 3; ++axis)
        sum += normal[axis] * (normal[axis] > 0 ? box.max[axis] : box.min[axis]);
    return sum;
}

/// The triangle's own plane if the seed is on one side of it; else the plane between the nearest points of the two.
std::optional<HalfSpace> cut(const Corners& t, const Box3d& seed) {
    Vec3d normal = cross(t[1] - t[0], t[2] - t[0]);
    if (double size = length(normal); size > 0) {
        normal = normal / size;
        for (const Vec3d& side : {normal, -normal})
            if (double offset = dot(side, t[0]); farthest(seed, side) <= offset)
                return HalfSpace{side, offset};
    }
    Vec3d on_seed = seed.centre(), on_triangle = t[0];
    for (int round = 0; round < 40; ++round) {
        on_triangle = nearest_in_triangle(on_seed, t);
        on_seed = nearest_in_box(on_triangle, seed);
    }
    normal = on_triangle - on_seed;
    double size = length(normal);
    if (!(size > 1e-3))
        return {};
    normal = normal / size;
    double offset = std::min({dot(normal, t[0]), dot(normal, t[1]), dot(normal, t[2])});
    if (farthest(seed, normal) > offset)
        return {};
    return HalfSpace{normal, offset};
}

} // namespace

std::optional<std::vector<HalfSpace>> grow_convex(const std::vector<Corners>& triangles, const Box3d& seed,
                                                  std::vector<HalfSpace> planes, std::size_t most) {
    std::vector<std::uint32_t> active(triangles.size());
    for (std::uint32_t t = 0; t < active.size(); ++t)
        active[t] = t;
    while (true) {
        double nearest = std::numeric_limits<double>::infinity();
        std::uint32_t first = 0;
        // What is out stays out.
        std::erase_if(active, [&](std::uint32_t t) {
            std::optional<double> distance = reaches_in(triangles[t], planes, seed);
            if (distance && *distance < nearest) {
                nearest = *distance;
                first = t;
            }
            return !distance;
        });
        if (active.empty())
            return planes;
        if (planes.size() == most)
            return {};
        std::optional<HalfSpace> plane = cut(triangles[first], seed);
        if (!plane)
            return {};
        planes.push_back(*plane);
    }
}

std::vector<Vec3d> corners_of(std::vector<HalfSpace> planes, double inset) {
    for (HalfSpace& plane : planes)
        if (!plane.on_grid)
            plane.offset -= inset;
    double scale = 1;
    for (const HalfSpace& plane : planes)
        scale = std::max(scale, std::abs(plane.offset));
    std::vector<Vec3d> corners;
    for (std::size_t i = 0; i < planes.size(); ++i)
        for (std::size_t j = i + 1; j < planes.size(); ++j)
            for (std::size_t k = j + 1; k < planes.size(); ++k) {
                const Vec3d &a = planes[i].normal, &b = planes[j].normal, &c = planes[k].normal;
                double volume = dot(a, cross(b, c));
                if (std::abs(volume) < 1e-6)
                    continue;
                Vec3d p = (cross(b, c) * planes[i].offset + cross(c, a) * planes[j].offset + cross(a, b) * planes[k].offset) / volume;
                bool inside = true;
                for (std::size_t n = 0; n < planes.size() && inside; ++n)
                    inside = n == i || n == j || n == k || dot(planes[n].normal, p) <= planes[n].offset + 1e-9 * scale;
                if (inside)
                    corners.push_back(p);
            }
    return corners;
}

} // namespace antumbra
