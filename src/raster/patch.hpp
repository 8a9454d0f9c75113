// A connected patch of convex polygons, laid out for drawing.
#pragma once

#include <antumbra/math.hpp>

#include <cstdint>
#include <vector>

namespace antumbra {

inline constexpr std::uint16_t kNoLocal = 0xFFFF;
inline constexpr std::uint16_t kLocalSameDirection = 0x8000;

struct PatchPolygon {
    Vec3d normal; ///< unit length
    double offset = 0;
    std::uint32_t first = 0; ///< into PatchStore::corners and ::neighbours
    std::uint16_t count = 0;
    bool double_sided = false;
};

struct PatchRange {
    std::uint32_t first_vertex = 0, vertex_count = 0;
    std::uint32_t first_polygon = 0, polygon_count = 0;
};

/// All patches of a scene, flat. Vertices are structure of arrays.
struct PatchStore {
    std::vector<float> x, y, z;
    std::vector<PatchPolygon> polygons;
    std::vector<std::uint16_t> corners;    ///< vertex within the patch
    std::vector<std::uint16_t> neighbours; ///< polygon within the patch | kLocalSameDirection, or kNoLocal
    std::vector<PatchRange> patches;
    std::uint32_t most_vertices = 0, most_polygons = 0, most_corners = 0;
};

} // namespace antumbra
