#include <antumbra/occluder_finding.hpp>

#include "occluder_finding/inner_boxes.hpp"
#include "occluder_finding/inner_shells.hpp"
#include "occluder_finding/merge.hpp"

#include <algorithm>
#include <numeric>

namespace antumbra {
namespace {

using grid::Point;

/// Equal positions become one vertex, whatever object they belong to.
struct Welded {
    std::vector<std::uint32_t> vertex; ///< per position of the scene
    std::vector<Vec3f> positions;
    std::vector<Point> points;
};

Welded weld(const Scene& scene) {
    std::span<const Vec3f> positions = scene.positions();
    std::vector<std::uint32_t> order(positions.size());
    std::iota(order.begin(), order.end(), 0u);
    auto less = [&](std::uint32_t a, std::uint32_t b) {
        const Vec3f &p = positions[a], &q = positions[b];
        return p.x != q.x ? p.x < q.x : p.y != q.y ? p.y < q.y : p.z < q.z;
    };
    std::sort(order.begin(), order.end(), less);
    Welded welded;
    welded.vertex.resize(positions.size());
    for (std::size_t i = 0; i < order.size(); ++i) {
        if (i == 0 || less(order[i - 1], order[i])) {
            welded.positions.push_back(positions[order[i]]);
            welded.points.push_back(grid::point_of(positions[order[i]], scene.step()));
        }
        welded.vertex[order[i]] = static_cast<std::uint32_t>(welded.positions.size() - 1);
    }
    return welded;
}

std::vector<GrowingPolygon> triangles_of(const Scene& scene, const Welded& welded) {
    std::vector<GrowingPolygon> polygons;
    for (std::uint32_t t = 0; t < scene.triangles().size(); ++t) {
        const Object& object = scene.object_of(t);
        if (!object.has(kOccludes))
            continue;
        GrowingPolygon polygon;
        for (std::uint32_t corner : scene.triangles()[t])
            polygon.loop.push_back(welded.vertex[corner]);
        const Point& a = welded.points[polygon.loop[0]];
        polygon.normal = grid::cross(grid::minus(welded.points[polygon.loop[1]], a),
                                     grid::minus(welded.points[polygon.loop[2]], a));
        polygon.object = scene.triangle_objects()[t];
        polygon.double_sided = object.has(kDoubleSided);
        polygons.push_back(std::move(polygon));
    }
    return polygons;
}

void append(OccluderSet& set, const GrowingPolygon& source) {
    OccluderPolygon polygon;
    polygon.first = static_cast<std::uint32_t>(set.loops.size());
    polygon.count = static_cast<std::uint32_t>(source.loop.size());
    polygon.object = source.object;
    polygon.double_sided = source.double_sided;
    set.loops.insert(set.loops.end(), source.loop.begin(), source.loop.end());
    set.polygons.push_back(polygon);
}

/// Leaves out straight corners whose two edges have the same neighbour (or none): the edge stays whole on both
/// sides, and fewer edges are drawn.
void drop_straight_corners(OccluderSet& set, const std::vector<Point>& points) {
    std::vector<std::uint32_t> loops;
    loops.reserve(set.loops.size());
    for (OccluderPolygon& polygon : set.polygons) {
        auto first = static_cast<std::uint32_t>(loops.size());
        for (std::uint32_t i = 0; i < polygon.count; ++i) {
            std::uint32_t before = (i + polygon.count - 1) % polygon.count, after = (i + 1) % polygon.count;
            const Point& at = points[set.loops[polygon.first + i]];
            Point along = grid::minus(at, points[set.loops[polygon.first + before]]);
            Point onward = grid::minus(points[set.loops[polygon.first + after]], at);
            bool same = set.neighbours[polygon.first + before] == set.neighbours[polygon.first + i];
            if (!(same && grid::same_direction(along, onward)))
                loops.push_back(set.loops[polygon.first + i]);
        }
        polygon.first = first;
        polygon.count = static_cast<std::uint32_t>(loops.size()) - first;
    }
    set.loops = std::move(loops);
    for (OccluderPolygon& polygon : set.polygons)
        measure_occluder(set, polygon);
    connect_occluders(set);
}

/// The faces of a box, seen from outside: corner numbers as in Box3::corner.
constexpr std::uint32_t kFaces[6][4] = {{0, 4, 6, 2}, {1, 3, 7, 5}, {0, 1, 5, 4}, {2, 6, 7, 3}, {0, 2, 3, 1}, {4, 5, 7, 6}};

Box3f box_of(const Point& min, const Point& max, double step) {
    Box3f box;
    for (std::size_t k = 0; k < 3; ++k) {
        box.min[int(k)] = static_cast<float>(double(min[k]) * step); // exact
        box.max[int(k)] = static_cast<float>(double(max[k]) * step);
    }
    return box;
}

/// Bounds, and where viewers must be for the sake of an opening.
OccluderSolid solid_of(const Point& shell_min, const Point& shell_max, const Opening& opening, double step) {
    OccluderSolid solid;
    solid.shell = box_of(shell_min, shell_max, step);
    if (opening.is_open())
        (opening.above ? solid.viewers.min : solid.viewers.max)[opening.axis] = static_cast<float>(double(opening.at) * step); // exact
    return solid;
}

void append_box(OccluderSet& set, const InnerBox& inner, double step) {
    auto base = static_cast<std::uint32_t>(set.vertices.size());
    Box3f box = box_of(inner.min, inner.max, step);
    for (int corner = 0; corner < 8; ++corner)
        set.vertices.push_back(box.corner(corner));
    for (std::uint32_t face = 0; face < 6; ++face) {
        OccluderPolygon polygon;
        polygon.first = static_cast<std::uint32_t>(set.loops.size());
        polygon.count = 4;
        polygon.object = inner.object;
        polygon.synthetic = true;
        polygon.solid = static_cast<std::uint32_t>(set.solids.size());
        for (std::uint32_t corner : kFaces[face])
            set.loops.push_back(base + corner);
        measure_occluder(set, polygon);
        set.polygons.push_back(polygon);
    }
    set.solids.push_back(solid_of(inner.shell_min, inner.shell_max, inner.opening, step));
}

/// A face of the solid that is about to be appended; `corners` count from the set's vertex `base`.
template <class Corners>
void append_face(OccluderSet& set, const Corners& corners, std::uint32_t base, std::uint32_t object) {
    OccluderPolygon polygon;
    polygon.first = static_cast<std::uint32_t>(set.loops.size());
    polygon.count = static_cast<std::uint32_t>(corners.size());
    polygon.object = object;
    polygon.synthetic = true;
    polygon.solid = static_cast<std::uint32_t>(set.solids.size());
    for (std::uint32_t corner : corners)
        set.loops.push_back(base + corner);
    measure_occluder(set, polygon);
    set.polygons.push_back(polygon);
}

void append_solid(OccluderSet& set, const InnerSolid& inner, double step) {
    auto base = static_cast<std::uint32_t>(set.vertices.size());
    for (const Point& p : inner.shape.points)
        set.vertices.push_back(box_of(p, p, step).min);
    for (const auto& face : inner.shape.faces)
        append_face(set, face, base, inner.object);
    set.solids.push_back(solid_of(inner.shell_min, inner.shell_max, inner.opening, step));
}

void append_shell(OccluderSet& set, const InnerShell& shell, double step) {
    auto base = static_cast<std::uint32_t>(set.vertices.size());
    for (const Point& p : shell.points)
        set.vertices.push_back(box_of(p, p, step).min);
    for (const auto& triangle : shell.triangles)
        append_face(set, triangle, base, shell.object);
    set.solids.push_back(solid_of(shell.shell_min, shell.shell_max, {}, step));
}

} // namespace

OccluderSet find_occluders(const Scene& scene, const OccluderOptions& options, OccluderStatistics* statistics) {
    Welded welded = weld(scene);
    std::vector<GrowingPolygon> polygons = triangles_of(scene, welded);
    OccluderStatistics counts;
    counts.triangles = polygons.size();
    InnerBoxes inner = find_inner_boxes(scene, welded.vertex, welded.points, options);
    if (options.merge)
        merge_coplanar(polygons, welded.points, options.most_corners);
    OccluderSet set;
    set.vertices = std::move(welded.positions);
    for (const GrowingPolygon& polygon : polygons)
        if (!polygon.loop.empty())
            append(set, polygon);
    counts.polygons = set.polygons.size();
    connect_occluders(set);
    drop_straight_corners(set, welded.points);
    std::vector<InnerBox> joined = join_boxes(inner.boxes, options.most_joined_boxes);
    for (const InnerBox& box : joined)
        append_box(set, box, scene.step());
    counts.joined_boxes = joined.size();
    for (const InnerBox& box : inner.boxes)
        if (box.triangles >= 6 * options.inner_box_triangles)
            append_box(set, box, scene.step());
    counts.inner_boxes = set.solids.size();
    for (const InnerSolid& solid : inner.solids) {
        append_solid(set, solid, scene.step());
        counts.oriented_boxes += solid.is_box;
    }
    counts.inner_solids = inner.solids.size();
    if (options.inner_shells)
        for (const InnerShell& shell : find_inner_shells(scene, welded.vertex, options)) {
            append_shell(set, shell, scene.step());
            ++counts.inner_shells;
            counts.inner_shell_triangles += shell.triangles.size();
            counts.inner_shell_dropped += shell.dropped;
        }
    connect_occluders(set);
    group_occluders(set, options.patch_polygons);
    counts.closed_objects = inner.closed_objects;
    counts.enclosures = inner.enclosures;
    for (const OccluderSolid& solid : set.solids)
        counts.restricted_solids += solid.is_restricted();
    counts.patches = set.patches.size();
    for (const OccluderPolygon& polygon : set.polygons)
        counts.largest_area = std::max(counts.largest_area, polygon.area);
    if (statistics)
        *statistics = counts;
    return set;
}

} // namespace antumbra
