#include "occluder_finding/inner_boxes.hpp"

#include <algorithm>
#include <map>

namespace antumbra {
namespace {

using grid::Point;
using grid::Wide;
using Triangle = std::array<Point, 3>;

struct Mesh {
    std::vector<Triangle> triangles;
    Point min, max;
};

struct GridBox {
    Point min, max;
    double worth() const { // half the surface: what it can hide from somewhere
        double x = double(max[0] - min[0]), y = double(max[1] - min[1]), z = double(max[2] - min[2]);
        return x * y + y * z + z * x;
    }
};

/// Edge balance: a surface without boundary has a winding number everywhere off itself.
bool is_closed(const Scene& scene, const Object& object, const std::vector<std::uint32_t>& welded) {
    std::map<std::pair<std::uint32_t, std::uint32_t>, int> balance;
    for (std::uint32_t t = 0; t < object.triangle_count; ++t) {
        const TriangleIndices& triangle = scene.triangles()[object.first_triangle + t];
        for (std::size_t c = 0; c < 3; ++c) {
            std::uint32_t a = welded[triangle[c]], b = welded[triangle[(c + 1) % 3]];
            balance[{std::min(a, b), std::max(a, b)}] += a < b ? 1 : -1;
        }
    }
    return std::all_of(balance.begin(), balance.end(), [](const auto& edge) { return edge.second == 0; });
}

Mesh mesh_of(const Scene& scene, const Object& object) {
    Mesh mesh;
    mesh.min = {INT64_MAX, INT64_MAX, INT64_MAX};
    mesh.max = {INT64_MIN, INT64_MIN, INT64_MIN};
    for (std::uint32_t t = 0; t < object.triangle_count; ++t) {
        Triangle triangle;
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

/// The bounds of a mesh cut into cells; a cell is free if no triangle touches it and it lies inside.
class Cells {
  public:
    Cells(const Mesh& mesh, std::uint32_t resolution, bool any_winding) : mesh_(mesh) {
        std::int64_t longest = 1;
        for (std::size_t k = 0; k < 3; ++k)
            longest = std::max(longest, mesh.max[k] - mesh.min[k]);
        for (std::size_t k = 0; k < 3; ++k) {
            std::int64_t size = mesh.max[k] - mesh.min[k];
            std::int64_t wanted = size * std::int64_t(resolution) / longest;
            count_[k] = static_cast<int>(std::clamp<std::int64_t>(wanted, 3, resolution));
        }
        free_.assign(static_cast<std::size_t>(count_[0] * count_[1] * count_[2]), 1);
        for (const Triangle& triangle : mesh.triangles)
            mark_touched(triangle);
        keep_inside(any_winding);
    }

    /// The free box of cells with the largest surface; worth 0 if there is none.
    GridBox largest() const {
        GridBox best{};
        std::array<int, 3> low{}, high{};
        for (low[0] = 0; low[0] < count_[0]; ++low[0])
            for (high[0] = low[0]; high[0] < count_[0]; ++high[0])
                for (low[1] = 0; low[1] < count_[1]; ++low[1])
                    for (high[1] = low[1]; high[1] < count_[1]; ++high[1])
                        longest_run(low, high, best);
        return best;
    }

  private:
    std::int64_t border(std::size_t axis, int cell) const {
        return mesh_.min[axis] + (mesh_.max[axis] - mesh_.min[axis]) * cell / count_[axis];
    }
    std::size_t index(int i, int j, int k) const {
        return static_cast<std::size_t>(i + count_[0] * (j + count_[1] * k));
    }
    GridBox cell_box(const std::array<int, 3>& low, const std::array<int, 3>& high) const {
        GridBox box{};
        for (std::size_t axis = 0; axis < 3; ++axis) {
            box.min[axis] = border(axis, low[axis]);
            box.max[axis] = border(axis, high[axis] + 1);
        }
        return box;
    }

    void mark_touched(const Triangle& triangle) {
        std::array<int, 3> low{}, high{};
        for (std::size_t axis = 0; axis < 3; ++axis) {
            auto [from, to] = std::minmax({triangle[0][axis], triangle[1][axis], triangle[2][axis]});
            while (low[axis] + 1 < count_[axis] && border(axis, low[axis] + 1) < from)
                ++low[axis];
            high[axis] = low[axis];
            while (high[axis] + 1 < count_[axis] && border(axis, high[axis] + 1) <= to)
                ++high[axis];
        }
        for (int k = low[2]; k <= high[2]; ++k)
            for (int j = low[1]; j <= high[1]; ++j)
                for (int i = low[0]; i <= high[0]; ++i) {
                    char& cell = free_[index(i, j, k)];
                    GridBox box = cell_box({i, j, k}, {i, j, k});
                    if (cell && touches(box.min, box.max, triangle))
                        cell = 0;
                }
    }

    /// Face-connected free cells share one winding number; only those inside stay free.
    void keep_inside(bool any_winding) {
        std::vector<char> todo = free_;
        for (int k = 0; k < count_[2]; ++k)
            for (int j = 0; j < count_[1]; ++j)
                for (int i = 0; i < count_[0]; ++i) {
                    if (!todo[index(i, j, k)])
                        continue;
                    std::vector<std::array<int, 3>> component{{i, j, k}};
                    todo[index(i, j, k)] = 0;
                    for (std::size_t at = 0; at < component.size(); ++at)
                        for (std::size_t axis = 0; axis < 3; ++axis)
                            for (int side : {-1, 1}) {
                                std::array<int, 3> next = component[at];
                                next[axis] += side;
                                if (next[axis] < 0 || next[axis] >= count_[axis] ||
                                    !todo[index(next[0], next[1], next[2])])
                                    continue;
                                todo[index(next[0], next[1], next[2])] = 0;
                                component.push_back(next);
                            }
                    if (!is_inside(component, any_winding))
                        for (const std::array<int, 3>& cell : component)
                            free_[index(cell[0], cell[1], cell[2])] = 0;
                }
    }

    bool is_inside(const std::vector<std::array<int, 3>>& component, bool any_winding) const {
        for (std::size_t i = 0; i < component.size() && i < 8; ++i) {
            GridBox box = cell_box(component[i], component[i]);
            // Any point will do; uneven shares keep the ray off the edges of regular meshes.
            constexpr std::int64_t kShares[3] = {5, 4, 7};
            Point inside;
            for (std::size_t axis = 0; axis < 3; ++axis)
                inside[axis] = box.min[axis] + (box.max[axis] - box.min[axis]) * kShares[axis] / 11;
            int winding = 0;
            if (winding_number(inside, mesh_.triangles, winding))
                return winding > 0 || (any_winding && winding != 0);
        }
        return false;
    }

    void longest_run(std::array<int, 3> low, std::array<int, 3> high, GridBox& best) const {
        for (low[2] = 0; low[2] < count_[2]; low[2] = high[2] + 1) {
            high[2] = low[2];
            while (high[2] < count_[2] && is_free_slab(low, high, high[2]))
                ++high[2];
            if (high[2] == low[2])
                continue;
            --high[2];
            GridBox box = cell_box(low, high);
            if (box.worth() > best.worth())
                best = box;
        }
    }
    bool is_free_slab(const std::array<int, 3>& low, const std::array<int, 3>& high, int k) const {
        for (int j = low[1]; j <= high[1]; ++j)
            for (int i = low[0]; i <= high[0]; ++i)
                if (!free_[index(i, j, k)])
                    return false;
        return true;
    }

    const Mesh& mesh_;
    std::array<int, 3> count_{};
    std::vector<char> free_;
};

/// Pushes each face outward, by halving steps, as far as no triangle is touched: nothing that the box sweeps over
/// on the way touches one either, so its winding number stays.
void grow(GridBox& box, const Mesh& mesh) {
    auto is_clear = [&](const GridBox& grown) {
        return std::none_of(mesh.triangles.begin(), mesh.triangles.end(),
                            [&](const Triangle& t) { return touches(grown.min, grown.max, t); });
    };
    for (std::size_t axis = 0; axis < 3; ++axis)
        for (bool upper : {false, true}) {
            std::int64_t room = upper ? mesh.max[axis] - box.max[axis] : box.min[axis] - mesh.min[axis];
            for (std::int64_t step = room / 2, i = 0; step > 0 && i < 8; step /= 2, ++i) {
                GridBox grown = box;
                (upper ? grown.max : grown.min)[axis] += upper ? step : -step;
                if (is_clear(grown))
                    box = grown;
            }
        }
}

int sign_of(Wide value) { return value > 0 ? 1 : value < 0 ? -1 : 0; }

} // namespace

bool touches(const Point& min, const Point& max, const Triangle& triangle) {
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

InnerBoxes find_inner_boxes(const Scene& scene, const std::vector<std::uint32_t>& welded,
                            const OccluderOptions& options) {
    InnerBoxes result;
    if (!options.inner_boxes)
        return result;
    for (std::uint32_t o = 0; o < scene.objects().size(); ++o) {
        const Object& object = scene.objects()[o];
        if (!object.has(kOccludes) || object.triangle_count < 4 || !is_closed(scene, object, welded))
            continue;
        ++result.closed_objects;
        if (object.triangle_count < 6 * options.inner_box_triangles)
            continue;
        Mesh mesh = mesh_of(scene, object);
        GridBox box = Cells(mesh, options.inner_box_resolution, object.has(kDoubleSided)).largest();
        if (!(box.worth() > 0))
            continue;
        grow(box, mesh);
        InnerBox inner;
        inner.object = o;
        for (int k = 0; k < 3; ++k) {
            auto axis = static_cast<std::size_t>(k);
            inner.box.min[k] = static_cast<float>(double(box.min[axis]) * scene.step());
            inner.box.max[k] = static_cast<float>(double(box.max[axis]) * scene.step());
            inner.shell.min[k] = static_cast<float>(double(mesh.min[axis]) * scene.step());
            inner.shell.max[k] = static_cast<float>(double(mesh.max[axis]) * scene.step());
        }
        result.boxes.push_back(inner);
    }
    return result;
}

} // namespace antumbra
