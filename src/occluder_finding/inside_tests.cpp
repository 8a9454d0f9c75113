#include "occluder_finding/inside_tests.hpp"

#include <algorithm>

namespace antumbra {
namespace {

using grid::Point;
using grid::Wide;
using grid::Triangle;

int sign_of(Wide value) { return value > 0 ? 1 : value < 0 ? -1 : 0; }

/// `open`: of the box without its surface.
bool meets(const Point& min, const Point& max, const Triangle& triangle, bool open) {
    // Twice the coordinates about the centre of the box, so that the centre is a whole number.
    Point half;
    Triangle t;
    for (std::size_t k = 0; k < 3; ++k) {
        half[k] = max[k] - min[k];
        for (std::size_t c = 0; c < 3; ++c)
            t[c][k] = 2 * triangle[c][k] - (min[k] + max[k]);
    }
    auto separates = [&](const Point& axis) {
        Wide reach = 0;
        for (std::size_t k = 0; k < 3; ++k)
            reach += Wide(axis[k] < 0 ? -axis[k] : axis[k]) * half[k];
        Wide a = grid::dot(axis, t[0]), b = grid::dot(axis, t[1]), c = grid::dot(axis, t[2]);
        if (open) // an axis of length zero separates nothing
            return reach > 0 && (std::min({a, b, c}) >= reach || std::max({a, b, c}) <= -reach);
        return std::min({a, b, c}) > reach || std::max({a, b, c}) < -reach;
    };
    for (std::size_t k = 0; k < 3; ++k) {
        Point axis{};
        axis[k] = 1;
        if (separates(axis))
            return false;
    }
    Point edges[3] = {grid::minus(t[1], t[0]), grid::minus(t[2], t[1]), grid::minus(t[0], t[2])};
    if (separates(grid::cross(edges[0], edges[1])))
        return false;
    for (const Point& edge : edges)
        for (std::size_t k = 0; k < 3; ++k) {
            Point axis{};
            axis[k] = 1;
            if (separates(grid::cross(axis, edge)))
                return false;
        }
    return true;
}

} // namespace

bool touches(const Point& min, const Point& max, const Triangle& triangle) {
    return meets(min, max, triangle, false);
}

bool enters(const Point& min, const Point& max, const Triangle& triangle) { return meets(min, max, triangle, true); }

bool are_apart(const Triangle& a, const Triangle& b) {
    auto separates = [&](const Point& axis) {
        Wide a0 = grid::dot(axis, a[0]), a1 = grid::dot(axis, a[1]), a2 = grid::dot(axis, a[2]);
        Wide b0 = grid::dot(axis, b[0]), b1 = grid::dot(axis, b[1]), b2 = grid::dot(axis, b[2]);
        return std::min({a0, a1, a2}) > std::max({b0, b1, b2}) || std::max({a0, a1, a2}) < std::min({b0, b1, b2});
    };
    Point of_a[3], of_b[3];
    for (std::size_t c = 0; c < 3; ++c) {
        of_a[c] = grid::minus(a[(c + 1) % 3], a[c]);
        of_b[c] = grid::minus(b[(c + 1) % 3], b[c]);
    }
    if (separates(grid::cross(of_a[0], of_a[1])) || separates(grid::cross(of_b[0], of_b[1])))
        return true;
    for (const Point& p : of_a)
        for (const Point& q : of_b)
            if (separates(grid::cross(p, q)))
                return true;
    return false;
}

bool winding_number(const Point& point, const std::vector<Triangle>& surface, int& winding) {
    winding = 0;
    for (const Triangle& triangle : surface) {
        // Where the ray passes in the (y, z) plane: left of all edges, right of all, or outside.
        int sides[3];
        for (std::size_t c = 0; c < 3; ++c) {
            const Point &a = triangle[c], &b = triangle[(c + 1) % 3];
            sides[c] = sign_of(Wide(b[1] - a[1]) * (point[2] - a[2]) - Wide(b[2] - a[2]) * (point[1] - a[1]));
        }
        bool outside = (std::min({sides[0], sides[1], sides[2]}) < 0 && std::max({sides[0], sides[1], sides[2]}) > 0);
        if (outside)
            continue;
        Point normal = grid::cross(grid::minus(triangle[1], triangle[0]), grid::minus(triangle[2], triangle[0]));
        bool grazes = sides[0] == 0 || sides[1] == 0 || sides[2] == 0;
        Wide height = grid::dot(normal, grid::minus(point, triangle[0]));
        if (grazes) {
            // Behind the point in x an edge does not matter.
            if (std::max({triangle[0][0], triangle[1][0], triangle[2][0]}) < point[0])
                continue;
            bool beside = false; // on the line of an edge but beyond its ends
            for (std::size_t k = 1; k < 3; ++k) {
                auto [from, to] = std::minmax({triangle[0][k], triangle[1][k], triangle[2][k]});
                beside = beside || point[k] < from || point[k] > to;
            }
            if (beside)
                continue;
            return false;
        }
        // Crossed ahead of the point iff the point lies on the side of the plane that looks towards -x.
        int facing = sign_of(normal[0]);
        if (sign_of(height) * facing < 0)
            winding += facing;
    }
    return true;
}

} // namespace antumbra
