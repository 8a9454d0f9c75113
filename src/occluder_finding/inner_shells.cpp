#include "occluder_finding/inner_shells.hpp"

#include "occluder_finding/closed_objects.hpp"
#include "tree/bvh_overlaps.hpp"

#include <meshoptimizer.h>

#include <algorithm>
#include <map>

namespace antumbra {
namespace {

using grid::Point;
using grid::Triangle;

/// How far inward vertices are moved, in units of the error of the simplification; 16: for creases and thin places.
constexpr double kDistances[] = {1, 2, 4, 8, 16};
/// Error that simplification may make, as a share of the object's size.
constexpr float kMostError = 0.1f;

/// The mesh with its triangles found by place.
class Original {
  public:
    Original(GridMesh mesh, bool any_winding) : mesh_(std::move(mesh)), any_winding_(any_winding) {
        std::vector<Box3f> boxes;
        for (const Triangle& triangle : mesh_.triangles)
            boxes.push_back(bounds_of(triangle));
        tree_ = build_bvh(boxes);
    }
    const GridMesh& mesh() const { return mesh_; }

    /// Off the surface all corners have the winding number of the whole triangle.
    bool is_inside(const Triangle& triangle) const {
        if (meets(triangle))
            return false;
        for (const Point& corner : triangle)
            if (int winding = 0; winding_number(corner, mesh_.triangles, winding))
                return winding > 0 || (any_winding_ && winding != 0);
        return false;
    }

  private:
    /// Coordinates below 2^24 are exact in float.
    static Box3f bounds_of(const Triangle& triangle) {
        Box3f box;
        for (const Point& p : triangle)
            box.extend(Vec3f{static_cast<float>(p[0]), static_cast<float>(p[1]), static_cast<float>(p[2])});
        return box;
    }

    bool meets(const Triangle& triangle) const {
        Box3f box = bounds_of(triangle);
        return find_in_bvh(tree_, [&](const Box3f& node) { return node.overlaps(box); },
                           [&](std::uint32_t t) {
                               const Triangle& other = mesh_.triangles[t];
                               return bounds_of(other).overlaps(box) && !are_apart(triangle, other);
                           });
    }

    GridMesh mesh_;
    bool any_winding_;
    Bvh tree_;
};

/// Welded vertices of one object and its triangles over them.
struct IndexedMesh {
    std::vector<Vec3f> positions; ///< local
    std::vector<unsigned> indices;
};

IndexedMesh indexed(const Scene& scene, const Object& object, const std::vector<std::uint32_t>& welded) {
    IndexedMesh mesh;
    std::map<std::uint32_t, unsigned> number;
    for (std::uint32_t t = 0; t < object.triangle_count; ++t)
        for (std::uint32_t corner : scene.triangles()[object.first_triangle + t]) {
            auto [at, is_new] = number.try_emplace(welded[corner], unsigned(mesh.positions.size()));
            if (is_new)
                mesh.positions.push_back(scene.positions()[corner]);
            mesh.indices.push_back(at->second);
        }
    return mesh;
}

/// Simplifies in place; returns the error in scene units.
double simplify(IndexedMesh& mesh, std::uint32_t triangles) {
    std::vector<unsigned> out(mesh.indices.size());
    float error = 0;
    std::size_t count = meshopt_simplify(out.data(), mesh.indices.data(), mesh.indices.size(), &mesh.positions[0].x,
                                         mesh.positions.size(), sizeof(Vec3f), 3 * std::size_t(triangles), kMostError,
                                         0, &error);
    out.resize(count);
    mesh.indices = std::move(out);
    return double(error) * meshopt_simplifyScale(&mesh.positions[0].x, mesh.positions.size(), sizeof(Vec3f));
}

/// Mean of the normals around each vertex, weighted by area; zero where there are none.
std::vector<Vec3d> vertex_normals(const IndexedMesh& mesh) {
    std::vector<Vec3d> normals(mesh.positions.size());
    for (std::size_t i = 0; i + 2 < mesh.indices.size(); i += 3) {
        Vec3d a = to_double(mesh.positions[mesh.indices[i]]);
        Vec3d normal = cross(to_double(mesh.positions[mesh.indices[i + 1]]) - a, to_double(mesh.positions[mesh.indices[i + 2]]) - a);
        for (std::size_t c = 0; c < 3; ++c)
            normals[mesh.indices[i + c]] += normal;
    }
    for (Vec3d& normal : normals)
        if (double size = length(normal); size > 0)
            normal = normal / size;
    return normals;
}

double area_of(const InnerShell& shell) {
    double sum = 0;
    for (const auto& t : shell.triangles) {
        Point n = grid::cross(grid::minus(shell.points[t[1]], shell.points[t[0]]), grid::minus(shell.points[t[2]], shell.points[t[0]]));
        sum += std::sqrt(double(n[0]) * double(n[0]) + double(n[1]) * double(n[1]) + double(n[2]) * double(n[2]));
    }
    return sum;
}

InnerShell shrunk(const IndexedMesh& mesh, const std::vector<Vec3d>& normals, double distance, double step,
                  const Original& original) {
    InnerShell shell;
    for (std::size_t v = 0; v < mesh.positions.size(); ++v) {
        Vec3d moved = (to_double(mesh.positions[v]) - normals[v] * distance) / step;
        shell.points.push_back({std::llround(moved.x), std::llround(moved.y), std::llround(moved.z)});
    }
    for (std::size_t i = 0; i + 2 < mesh.indices.size(); i += 3) {
        std::array<std::uint32_t, 3> t{mesh.indices[i], mesh.indices[i + 1], mesh.indices[i + 2]};
        Triangle triangle{shell.points[t[0]], shell.points[t[1]], shell.points[t[2]]};
        Point normal = grid::cross(grid::minus(triangle[1], triangle[0]), grid::minus(triangle[2], triangle[0]));
        if (normal != Point{0, 0, 0} && original.is_inside(triangle))
            shell.triangles.push_back(t);
        else
            ++shell.dropped;
    }
    return shell;
}

} // namespace

std::vector<InnerShell> find_inner_shells(const Scene& scene, const std::vector<std::uint32_t>& welded,
                                          const OccluderOptions& options) {
    std::vector<InnerShell> shells;
    std::vector<std::uint32_t> solids = closed_objects(scene, welded);
    std::erase_if(solids, [&](std::uint32_t o) { return scene.objects()[o].triangle_count < options.inner_shell_least; });
    solids.resize(std::min<std::size_t>(solids.size(), options.most_solids));
    for (std::uint32_t o : solids) {
        const Object& object = scene.objects()[o];
        IndexedMesh mesh = indexed(scene, object, welded);
        double error = simplify(mesh, options.inner_shell_triangles);
        std::vector<Vec3d> normals = vertex_normals(mesh);
        Original original(mesh_of(scene, object), object.has(kDoubleSided));
        InnerShell best;
        for (double distance : kDistances) {
            InnerShell shell = shrunk(mesh, normals, distance * error + 2 * scene.step(), scene.step(), original);
            if (area_of(shell) > area_of(best))
                best = std::move(shell);
        }
        if (best.triangles.empty())
            continue;
        best.object = o;
        best.shell_min = original.mesh().min;
        best.shell_max = original.mesh().max;
        shells.push_back(std::move(best));
    }
    return shells;
}

} // namespace antumbra
