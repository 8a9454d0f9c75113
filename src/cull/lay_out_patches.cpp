// Occluder patches from the shared set to flat arrays.
#include "cull/scene_data.hpp"

#include <algorithm>

namespace antumbra {
namespace {

constexpr std::size_t kMostLocal = 0x7FFF; ///< vertices or polygons of one patch

/// One patch at a time: numbers its vertices and polygons from zero.
class Layout {
  public:
    Layout(const OccluderSet& set, PatchStore& store)
        : set_(set), store_(store), vertex_number_(set.vertices.size(), kNone),
          polygon_number_(set.polygons.size(), kNone) {}

    void add(std::span<const std::uint32_t> polygons) {
        PatchRange range;
        range.first_vertex = static_cast<std::uint32_t>(store_.x.size());
        range.first_polygon = static_cast<std::uint32_t>(store_.polygons.size());
        vertices_.clear();
        // A patch too large for 16-bit numbers, which group_occluders never makes, draws only its first part.
        polygons = polygons.first(std::min(polygons.size(), kMostLocal));
        for (std::uint32_t i = 0; i < polygons.size(); ++i)
            polygon_number_[polygons[i]] = i;
        for (std::uint32_t polygon : polygons)
            add_polygon(set_.polygons[polygon]);
        for (std::uint32_t v : vertices_) {
            store_.x.push_back(set_.vertices[v].x);
            store_.y.push_back(set_.vertices[v].y);
            store_.z.push_back(set_.vertices[v].z);
            vertex_number_[v] = kNone;
        }
        for (std::uint32_t polygon : polygons)
            polygon_number_[polygon] = kNone;
        range.vertex_count = static_cast<std::uint32_t>(vertices_.size());
        range.polygon_count = static_cast<std::uint32_t>(store_.polygons.size()) - range.first_polygon;
        store_.most_vertices = std::max(store_.most_vertices, range.vertex_count);
        store_.most_polygons = std::max(store_.most_polygons, range.polygon_count);
        store_.patches.push_back(range);
    }

  private:
    static constexpr std::uint32_t kNone = 0xFFFFFFFFu;

    void add_polygon(const OccluderPolygon& source) {
        PatchPolygon polygon;
        polygon.normal = source.normal;
        polygon.offset = source.offset;
        polygon.first = static_cast<std::uint32_t>(store_.corners.size());
        polygon.count = static_cast<std::uint16_t>(std::min(source.count, 0xFFFFu));
        polygon.double_sided = source.double_sided;
        for (std::uint32_t i = 0; i < polygon.count; ++i) {
            std::uint32_t vertex = set_.loops[source.first + i];
            if (vertex_number_[vertex] == kNone) {
                vertex_number_[vertex] = static_cast<std::uint32_t>(vertices_.size());
                vertices_.push_back(vertex);
            }
            store_.corners.push_back(static_cast<std::uint16_t>(vertex_number_[vertex]));
            store_.neighbours.push_back(local_neighbour(set_.neighbours[source.first + i]));
        }
        store_.polygons.push_back(polygon);
    }

    std::uint16_t local_neighbour(std::uint32_t neighbour) const {
        std::uint32_t polygon = neighbour & ~kSameDirection;
        if (polygon == kNoPolygon || polygon_number_[polygon] == kNone)
            return kNoLocal;
        return static_cast<std::uint16_t>(polygon_number_[polygon] |
                                          (neighbour & kSameDirection ? kLocalSameDirection : 0));
    }

    const OccluderSet& set_;
    PatchStore& store_;
    std::vector<std::uint32_t> vertex_number_, polygon_number_, vertices_;
};

} // namespace

std::vector<Box3f> items_of(const CullScene::Data& scene) {
    std::vector<Box3f> items = scene.bounds;
    for (const OccluderPatch& patch : scene.occluders.patches)
        items.push_back(patch.box);
    return items;
}

ScenePatches lay_out_patches(const CullScene::Data& scene) {
    ScenePatches patches;
    const OccluderSet& set = scene.occluders;
    Layout layout(set, patches.store);
    patches.order = scene.order;
    std::uint32_t item = scene.object_count();
    for (const OccluderPatch& patch : set.patches) {
        std::span<const std::uint32_t> polygons(set.patch_polygons.data() + patch.first, patch.count);
        layout.add(polygons);
        patches.boxes.push_back(patch.box);
        Vec3d size = patch.box.empty() ? Vec3d{} : to_double(patch.box.max) - to_double(patch.box.min);
        double area = size.x * size.y + size.y * size.z + size.z * size.x;
        patches.area.push_back(static_cast<float>(area / std::max(patch.count, 1u)));
        patches.solid.push_back(patch.count ? set.polygons[polygons[0]].solid : kNoPolygon);
        if (patch.count && !patch.box.empty())
            patches.order.push_back(item);
        ++item;
    }
    return patches;
}

} // namespace antumbra
