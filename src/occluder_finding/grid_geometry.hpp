// Exact geometry on the snapped grid: coordinates are whole numbers below 2^24 in magnitude.
#pragma once

#include <antumbra/scene.hpp>

#include <array>
#include <cstdint>

namespace antumbra::grid {

__extension__ typedef __int128 Wide;
using Point = std::array<std::int64_t, 3>;
using Triangle = std::array<Point, 3>;

inline Point point_of(const Vec3f& local, double step) {
    // Locals are exact multiples of a power of two: the division and the conversion are exact.
    return {static_cast<std::int64_t>(local.x / step), static_cast<std::int64_t>(local.y / step),
            static_cast<std::int64_t>(local.z / step)};
}

inline Point minus(const Point& a, const Point& b) { return {a[0] - b[0], a[1] - b[1], a[2] - b[2]}; }

/// Components below 2^51 for differences of points.
inline Point cross(const Point& a, const Point& b) {
    return {a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]};
}

inline Wide dot(const Point& a, const Point& b) {
    return Wide(a[0]) * b[0] + Wide(a[1]) * b[1] + Wide(a[2]) * b[2];
}

/// Same direction exactly.
inline bool same_direction(const Point& a, const Point& b) {
    return Wide(a[1]) * b[2] == Wide(a[2]) * b[1] && Wide(a[2]) * b[0] == Wide(a[0]) * b[2] &&
           Wide(a[0]) * b[1] == Wide(a[1]) * b[0] && dot(a, b) > 0;
}

} // namespace antumbra::grid
