#include "occluder_finding/closed_objects.hpp"

#include <algorithm>

namespace antumbra {
namespace {

/// Edge balance: a surface without boundary has a winding number everywhere off itself.
bool is_closed(const Scene& scene, const Object& object, const std::vector<std::uint32_t>& welded) {
    struct Edge {
        std::uint32_t low, high;
        int balance;
    };
    std::vector<Edge> edges;
    edges.reserve(3 * std::size_t(object.triangle_count));
    for (std::uint32_t t = 0; t < object.triangle_count; ++t) {
        const TriangleIndices& triangle = scene.triangles()[object.first_triangle + t];
        for (std::size_t c = 0; c < 3; ++c) {
            std::uint32_t a = welded[triangle[c]], b = welded[triangle[(c + 1) % 3]];
            edges.push_back({std::min(a, b), std::max(a, b), a < b ? 1 : -1});
        }
    }
    std::sort(edges.begin(), edges.end(),
              [](const Edge& a, const Edge& b) { return a.low != b.low ? a.low < b.low : a.high < b.high; });
    for (std::size_t i = 0; i < edges.size();) {
        int balance = 0;
        std::size_t first = i;
        for (; i < edges.size() && edges[i].low == edges[first].low && edges[i].high == edges[first].high; ++i)
            balance += edges[i].balance;
        if (balance != 0)
            return false;
    }
    return true;
}

double half_surface(const Box3f& box) {
    Vec3f size = box.size();
    return double(size.x) * size.y + double(size.y) * size.z + double(size.z) * size.x;
}

} // namespace

GridMesh mesh_of(const Scene& scene, const Object& object) {
    GridMesh mesh;
    mesh.min = {INT64_MAX, INT64_MAX, INT64_MAX};
    mesh.max = {INT64_MIN, INT64_MIN, INT64_MIN};
    for (std::uint32_t t = 0; t < object.triangle_count; ++t) {
        grid::Triangle triangle;
        for (std::size_t c = 0; c < 3; ++c) {
            triangle[c] = grid::point_of(scene.positions()[scene.triangles()[object.first_triangle + t][c]],
                                         scene.step());
            for (std::size_t k = 0; k < 3; ++k) {
                mesh.min[k] = std::min(mesh.min[k], triangle[c][k]);
                mesh.max[k] = std::max(mesh.max[k], triangle[c][k]);
            }
        }
        mesh.triangles.push_back(triangle);
    }
    return mesh;
}

std::vector<std::uint32_t> closed_objects(const Scene& scene, const std::vector<std::uint32_t>& welded) {
    std::vector<std::uint32_t> list;
    for (std::uint32_t o = 0; o < scene.objects().size(); ++o) {
        const Object& object = scene.objects()[o];
        if (object.has(kOccludes) && object.triangle_count >= 4 && is_closed(scene, object, welded))
            list.push_back(o);
    }
    std::stable_sort(list.begin(), list.end(), [&](std::uint32_t a, std::uint32_t b) {
        return half_surface(scene.objects()[a].bounds) > half_surface(scene.objects()[b].bounds);
    });
    return list;
}

} // namespace antumbra
