#include "occluder_finding/inner_boxes.hpp"

#include <algorithm>

namespace antumbra {

InnerBoxes find_inner_boxes(const Scene& scene, const std::vector<std::uint32_t>& welded,
                            const std::vector<grid::Point>& points, const OccluderOptions& options) {
    InnerBoxes result;
    if (!options.inner_boxes)
        return result;
    std::vector<Enclosure> enclosures = find_enclosures(scene, welded, points);
    result.enclosures = enclosures.size();
    for (const Enclosure& enclosure : enclosures)
        result.closed_objects += enclosure.objects.size() == 1 && !enclosure.opening.is_open();
    enclosures.resize(std::min<std::size_t>(enclosures.size(), options.most_solids));
    for (const Enclosure& enclosure : enclosures) {
        GridMesh mesh = mesh_of(scene, enclosure);
        std::vector<GridBox> boxes =
            largest_free_boxes(mesh, options.inner_box_resolution, enclosure.any_winding, options.boxes_per_solid);
        for (GridBox& box : boxes)
            enclosure.opening.cut(box.min, box.max);
        std::erase_if(boxes, [](const GridBox& box) {
            return box.min[0] >= box.max[0] || box.min[1] >= box.max[1] || box.min[2] >= box.max[2];
        });
        for (const GridBox& box : boxes)
            result.boxes.push_back({box.min, box.max, mesh.min, mesh.max, enclosure.objects[0], enclosure.triangles, enclosure.opening});
        if (!options.inner_solids || enclosure.triangles < 6 * options.inner_box_triangles)
            continue;
        std::vector<InnerSolid> solids = find_inner_solids(enclosure, mesh, boxes, options);
        std::move(solids.begin(), solids.end(), std::back_inserter(result.solids));
    }
    return result;
}

} // namespace antumbra
