// Polygons of text formats to triangles.
#pragma once

#include <antumbra/math.hpp>

#include <array>
#include <cstdint>
#include <span>
#include <vector>

namespace antumbra {

/// Ear clipping is quadratic: longer concave polygons are cut as fans, so that any input takes linear time.
inline constexpr std::size_t kLongestConcavePolygon = 1024;

/// Cuts a polygon of n >= 3 corners into n - 2 triangles of corner numbers, with its winding. Convex ones as a fan
/// from corner 0; concave ones by clipping ears in the projection along their Newell normal. Whatever has no ear
/// (crossing or collapsed outlines) is finished as a fan. False: concave but longer than the limit above.
bool triangulate(std::span<const Vec3d> corners, std::vector<std::array<std::uint32_t, 3>>& triangles);

} // namespace antumbra
