// One patch at a time from the shared occluder set to the flat arrays that the rasterisers draw.
#pragma once

#include "raster/patch.hpp"

#include <antumbra/occluders.hpp>

#include <algorithm>
#include <span>
#include <vector>

namespace antumbra {

/// Numbers the vertices and polygons of each patch from zero. Keeps 4 bytes per vertex and polygon of the set, so that
/// a patch costs what it holds; make one and use it again.
class PatchLayout {
  public:
    explicit PatchLayout(const OccluderSet& set)
        : vertex_number_(set.vertices.size(), kNone), polygon_number_(set.polygons.size(), kNone) {}

    /// `set` is that of the constructor. Edges to polygons outside of `polygons` count as open.
    void add(const OccluderSet& set, std::span<const std::uint32_t> polygons, PatchStore& store) {
        PatchRange range;
        range.first_vertex = static_cast<std::uint32_t>(store.x.size());
        range.first_polygon = static_cast<std::uint32_t>(store.polygons.size());
        vertices_.clear();
        // A patch too large for 16-bit numbers, which group_occluders never makes, draws only its first part.
        polygons = polygons.first(std::min(polygons.size(), kMostLocal));
        for (std::uint32_t i = 0; i < polygons.size(); ++i)
            polygon_number_[polygons[i]] = i;
        for (std::uint32_t polygon : polygons)
            add_polygon(set, set.polygons[polygon], store);
        for (std::uint32_t v : vertices_) {
            store.x.push_back(set.vertices[v].x);
            store.y.push_back(set.vertices[v].y);
            store.z.push_back(set.vertices[v].z);
            vertex_number_[v] = kNone;
        }
        for (std::uint32_t polygon : polygons)
            polygon_number_[polygon] = kNone;
        range.vertex_count = static_cast<std::uint32_t>(vertices_.size());
        range.polygon_count = static_cast<std::uint32_t>(store.polygons.size()) - range.first_polygon;
        store.most_vertices = std::max(store.most_vertices, range.vertex_count);
        store.most_polygons = std::max(store.most_polygons, range.polygon_count);
        store.patches.push_back(range);
    }

  private:
    static constexpr std::uint32_t kNone = 0xFFFFFFFFu;
    static constexpr std::size_t kMostLocal = 0x7FFF; ///< vertices or polygons of one patch

    void add_polygon(const OccluderSet& set, const OccluderPolygon& source, PatchStore& store) {
        PatchPolygon polygon;
        polygon.normal = source.normal;
        polygon.offset = source.offset;
        polygon.first = static_cast<std::uint32_t>(store.corners.size());
        polygon.count = static_cast<std::uint16_t>(std::min(source.count, 0xFFFFu));
        polygon.double_sided = source.double_sided;
        for (std::uint32_t i = 0; i < polygon.count; ++i) {
            std::uint32_t vertex = set.loops[source.first + i];
            if (vertex_number_[vertex] == kNone) {
                vertex_number_[vertex] = static_cast<std::uint32_t>(vertices_.size());
                vertices_.push_back(vertex);
            }
            store.corners.push_back(static_cast<std::uint16_t>(vertex_number_[vertex]));
            store.neighbours.push_back(local_neighbour(set.neighbours[source.first + i]));
        }
        store.polygons.push_back(polygon);
    }

    std::uint16_t local_neighbour(std::uint32_t neighbour) const {
        std::uint32_t polygon = neighbour & ~kSameDirection;
        if (polygon == kNoPolygon || polygon_number_[polygon] == kNone)
            return kNoLocal;
        return static_cast<std::uint16_t>(polygon_number_[polygon] |
                                          (neighbour & kSameDirection ? kLocalSameDirection : 0));
    }

    std::vector<std::uint32_t> vertex_number_, polygon_number_, vertices_;
};

} // namespace antumbra
