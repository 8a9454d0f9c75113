#include "occluder_finding/closed_objects.hpp"

#include <algorithm>
#include <cstdlib>

namespace antumbra {
namespace {

using grid::Point;
using grid::Triangle;

/// An edge that its object runs through more often in one direction.
struct OpenEdge {
    std::uint32_t low, high; ///< welded vertices
    int balance;             ///< from low to high, less those from high to low
    std::uint32_t object;
    bool same_edge(const OpenEdge& other) const { return low == other.low && high == other.high; }
};

/// Sums the balance of equal edges; those that are balanced go. `object` is that of the first.
void balance(std::vector<OpenEdge>& edges) {
    std::sort(edges.begin(), edges.end(), [](const OpenEdge& a, const OpenEdge& b) {
        return a.low != b.low ? a.low < b.low : a.high != b.high ? a.high < b.high : a.object < b.object;
    });
    std::size_t kept = 0;
    for (std::size_t i = 0, next; i < edges.size(); i = next) {
        OpenEdge sum = edges[i];
        for (next = i + 1; next < edges.size() && edges[next].same_edge(sum); ++next)
            sum.balance += edges[next].balance;
        if (sum.balance != 0)
            edges[kept++] = sum;
    }
    edges.resize(kept);
}

/// A surface without any has a winding number everywhere off itself.
std::vector<OpenEdge> open_edges(const Scene& scene, std::uint32_t index, const std::vector<std::uint32_t>& welded) {
    const Object& object = scene.objects()[index];
    std::vector<OpenEdge> edges;
    edges.reserve(3 * std::size_t(object.triangle_count));
    for (std::uint32_t t = 0; t < object.triangle_count; ++t) {
        const TriangleIndices& triangle = scene.triangles()[object.first_triangle + t];
        for (std::size_t c = 0; c < 3; ++c) {
            std::uint32_t a = welded[triangle[c]], b = welded[triangle[(c + 1) % 3]];
            if (a != b)
                edges.push_back({std::min(a, b), std::max(a, b), a < b ? 1 : -1, index});
        }
    }
    balance(edges);
    return edges;
}

double half_surface(const Box3f& box) {
    Vec3f size = box.size();
    return double(size.x) * size.y + double(size.y) * size.z + double(size.z) * size.x;
}

void extend(GridMesh& mesh, const Triangle& triangle) {
    for (const Point& p : triangle)
        for (std::size_t k = 0; k < 3; ++k) {
            mesh.min[k] = std::min(mesh.min[k], p[k]);
            mesh.max[k] = std::max(mesh.max[k], p[k]);
        }
    mesh.triangles.push_back(triangle);
}

GridMesh empty_mesh() { return {{}, {INT64_MAX, INT64_MAX, INT64_MAX}, {INT64_MIN, INT64_MIN, INT64_MIN}}; }

void append(const Scene& scene, const Object& object, GridMesh& mesh) {
    for (std::uint32_t t = 0; t < object.triangle_count; ++t) {
        Triangle triangle;
        for (std::size_t c = 0; c < 3; ++c)
            triangle[c] = grid::point_of(scene.positions()[scene.triangles()[object.first_triangle + t][c]], scene.step());
        extend(mesh, triangle);
    }
}

/// Groups of objects that are closed but together.
class Grouper {
  public:
    Grouper(const Scene& scene, const std::vector<Point>& points) : scene_(scene), points_(points) {}

    void run(std::vector<OpenEdge> edges, std::uint32_t peels, std::vector<Enclosure>& found) {
        for (std::vector<OpenEdge>& part : connected(std::move(edges)))
            close(std::move(part), peels, found);
    }

  private:
    static constexpr std::size_t kMostBoundary = 4096;
    static constexpr double kLeastShare = 0.5; ///< of the extent that an opening leaves

    std::uint32_t root(std::uint32_t object) {
        while (parents_[object] != object)
            object = parents_[object] = parents_[parents_[object]];
        return object;
    }

    /// The edges of objects that share some, together.
    std::vector<std::vector<OpenEdge>> connected(std::vector<OpenEdge> edges) {
        parents_.resize(scene_.objects().size());
        for (const OpenEdge& edge : edges)
            parents_[edge.object] = edge.object;
        std::sort(edges.begin(), edges.end(), [](const OpenEdge& a, const OpenEdge& b) {
            return a.low != b.low ? a.low < b.low : a.high != b.high ? a.high < b.high : a.object < b.object;
        });
        for (std::size_t i = 1; i < edges.size(); ++i)
            if (edges[i].same_edge(edges[i - 1])) {
                std::uint32_t a = root(edges[i].object), b = root(edges[i - 1].object);
                parents_[std::max(a, b)] = std::min(a, b);
            }
        std::stable_sort(edges.begin(), edges.end(),
                         [&](const OpenEdge& a, const OpenEdge& b) { return root(a.object) < root(b.object); });
        std::vector<std::vector<OpenEdge>> parts;
        for (std::size_t i = 0; i < edges.size(); ++i) {
            if (i == 0 || root(edges[i].object) != root(edges[i - 1].object))
                parts.emplace_back();
            parts.back().push_back(edges[i]);
        }
        return parts;
    }

    void close(std::vector<OpenEdge> edges, std::uint32_t peels, std::vector<Enclosure>& found) {
        Enclosure group;
        for (const OpenEdge& edge : edges)
            group.objects.push_back(edge.object);
        std::sort(group.objects.begin(), group.objects.end());
        group.objects.erase(std::unique(group.objects.begin(), group.objects.end()), group.objects.end());
        if (is_closed(edges, group)) {
            describe(scene_, group);
            found.push_back(std::move(group));
            return;
        }
        if (group.objects.size() < 2 || peels == 0)
            return;
        std::uint32_t largest = *std::max_element(group.objects.begin(), group.objects.end(), [&](std::uint32_t a, std::uint32_t b) {
            return half_surface(scene_.objects()[a].bounds) < half_surface(scene_.objects()[b].bounds);
        });
        auto others = std::stable_partition(edges.begin(), edges.end(), [&](const OpenEdge& e) { return e.object == largest; });
        std::vector<OpenEdge> rest(others, edges.end());
        edges.erase(others, edges.end());
        close(std::move(edges), 0, found);
        run(std::move(rest), peels - 1, found);
    }

    bool is_closed(std::vector<OpenEdge> edges, Enclosure& group) const {
        balance(edges);
        if (edges.empty())
            return true;
        if (edges.size() > kMostBoundary)
            return false;
        Point low = points_[edges[0].low], high = low;
        for (const OpenEdge& edge : edges)
            for (std::uint32_t v : {edge.low, edge.high})
                for (std::size_t k = 0; k < 3; ++k) {
                    low[k] = std::min(low[k], points_[v][k]);
                    high[k] = std::max(high[k], points_[v][k]);
                }
        if (!find_opening(low, high, group))
            return false;
        // A cone over the boundary: it lies within the bounds of the boundary, and closes whatever this is made of.
        Point tip;
        for (std::size_t k = 0; k < 3; ++k)
            tip[k] = low[k] + (high[k] - low[k]) / 2;
        for (const OpenEdge& edge : edges)
            for (int n = std::abs(edge.balance); n > 0; --n) {
                const Point &a = points_[edge.balance > 0 ? edge.high : edge.low], &b = points_[edge.balance > 0 ? edge.low : edge.high];
                group.cap.push_back({a, b, tip});
            }
        return true;
    }

    /// The side to which most of the group lies beyond the boundary.
    bool find_opening(const Point& low, const Point& high, Enclosure& group) const {
        Box3f bounds;
        for (std::uint32_t object : group.objects)
            bounds.extend(scene_.objects()[object].bounds);
        Point min = grid::point_of(bounds.min, scene_.step()), max = grid::point_of(bounds.max, scene_.step());
        double best = kLeastShare;
        for (std::size_t k = 0; k < 3; ++k) {
            double extent = double(max[k] - min[k]);
            if (extent > 0 && double(max[k] - high[k]) / extent > best) {
                best = double(max[k] - high[k]) / extent;
                group.opening = {int(k), true, high[k]};
            }
            if (extent > 0 && double(low[k] - min[k]) / extent > best) {
                best = double(low[k] - min[k]) / extent;
                group.opening = {int(k), false, low[k]};
            }
        }
        return group.opening.is_open();
    }

  public:
    static void describe(const Scene& scene, Enclosure& group) {
        Box3f bounds;
        group.any_winding = true;
        group.triangles = 0;
        for (std::uint32_t o : group.objects) {
            const Object& object = scene.objects()[o];
            bounds.extend(object.bounds);
            group.any_winding = group.any_winding && object.has(kDoubleSided);
            group.triangles += object.triangle_count;
        }
        group.size = half_surface(bounds);
    }

  private:
    const Scene& scene_;
    const std::vector<Point>& points_;
    std::vector<std::uint32_t> parents_;
};

/// How often the largest object is taken out of one group.
constexpr std::uint32_t kMostPeels = 8;

bool may_enclose(const Object& object) { return object.has(kOccludes) && object.triangle_count > 0; }

} // namespace

void Opening::cut(Point& min, Point& max) const {
    if (!is_open())
        return;
    auto k = static_cast<std::size_t>(axis);
    if (above)
        min[k] = std::max(min[k], at + 1);
    else
        max[k] = std::min(max[k], at - 1);
}

GridMesh mesh_of(const Scene& scene, const Object& object) {
    GridMesh mesh = empty_mesh();
    append(scene, object, mesh);
    return mesh;
}

GridMesh mesh_of(const Scene& scene, const Enclosure& enclosure) {
    GridMesh mesh = empty_mesh();
    for (std::uint32_t object : enclosure.objects)
        append(scene, scene.objects()[object], mesh);
    for (const Triangle& triangle : enclosure.cap)
        if (grid::cross(grid::minus(triangle[1], triangle[0]), grid::minus(triangle[2], triangle[0])) != Point{0, 0, 0})
            extend(mesh, triangle);
    return mesh;
}

std::vector<std::uint32_t> closed_objects(const Scene& scene, const std::vector<std::uint32_t>& welded) {
    std::vector<std::uint32_t> list;
    for (std::uint32_t o = 0; o < scene.objects().size(); ++o)
        if (may_enclose(scene.objects()[o]) && scene.objects()[o].triangle_count >= 4 && open_edges(scene, o, welded).empty())
            list.push_back(o);
    std::stable_sort(list.begin(), list.end(), [&](std::uint32_t a, std::uint32_t b) {
        return half_surface(scene.objects()[a].bounds) > half_surface(scene.objects()[b].bounds);
    });
    return list;
}

std::vector<Enclosure> find_enclosures(const Scene& scene, const std::vector<std::uint32_t>& welded,
                                       const std::vector<Point>& points) {
    std::vector<Enclosure> found;
    std::vector<OpenEdge> open;
    for (std::uint32_t o = 0; o < scene.objects().size(); ++o) {
        if (!may_enclose(scene.objects()[o]))
            continue;
        std::vector<OpenEdge> edges = open_edges(scene, o, welded);
        open.insert(open.end(), edges.begin(), edges.end());
        if (!edges.empty() || scene.objects()[o].triangle_count < 4)
            continue;
        Enclosure alone;
        alone.objects = {o};
        Grouper::describe(scene, alone);
        found.push_back(std::move(alone));
    }
    Grouper(scene, points).run(std::move(open), kMostPeels, found);
    std::stable_sort(found.begin(), found.end(), [](const Enclosure& a, const Enclosure& b) { return a.size > b.size; });
    return found;
}

} // namespace antumbra
