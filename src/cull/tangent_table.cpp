#include "cull/tangent_table.hpp"

#include <array>

namespace antumbra {
namespace {

constexpr int kMostEdges = 6;

/// Always six edges, so that the look-up has no branches: those beyond `count` repeat the first and are masked out.
struct Silhouette {
    int count = 0; ///< 4, 6, or 0 for the region inside
    unsigned mask = 0;
    std::array<std::uint8_t, kMostEdges> vertex{}; ///< in order around
    std::array<std::uint8_t, kMostEdges> axis{};   ///< of the edge from vertex i to the next
    std::array<double, kMostEdges> way{};          ///< its direction along that axis, 1 or -1
    std::array<Tangents, 64> tangents{};           ///< per bit code of the sides of the edges
};

/// Corner v has a neighbour across each axis; the edge between them separates two faces.
bool is_visible(const std::array<int, 3>& region, int axis, bool upper) {
    return region[static_cast<std::size_t>(axis)] == (upper ? 2 : 0);
}

/// The silhouette edges are those between a visible and an invisible face; they form one loop.
Silhouette silhouette_of(const std::array<int, 3>& region) {
    struct Edge {
        int a, b, axis;
    };
    std::array<Edge, 12> edges{};
    int count = 0;
    for (int a = 0; a < 8; ++a)
        for (int axis = 0; axis < 3; ++axis) {
            int b = a | 1 << axis;
            if (b == a)
                continue;
            int u = (axis + 1) % 3, v = (axis + 2) % 3;
            if (is_visible(region, u, a >> u & 1) != is_visible(region, v, a >> v & 1))
                edges[static_cast<std::size_t>(count++)] = {a, b, axis};
        }
    Silhouette result;
    if (count == 0)
        return result;
    int at = edges[0].a, previous = -1;
    do {
        for (int i = 0; i < count; ++i) {
            const Edge& edge = edges[static_cast<std::size_t>(i)];
            if (i == previous || (edge.a != at && edge.b != at))
                continue;
            auto slot = static_cast<std::size_t>(result.count++);
            result.vertex[slot] = static_cast<std::uint8_t>(at);
            result.axis[slot] = static_cast<std::uint8_t>(edge.axis);
            result.way[slot] = edge.a == at ? 1.0 : -1.0;
            at = edge.a == at ? edge.b : edge.a;
            previous = i;
            break;
        }
    } while (at != edges[0].a);
    return result;
}

void fill_tangents(Silhouette& silhouette) {
    int n = silhouette.count;
    for (int code = 0; code < 1 << n; ++code) {
        int found = 0;
        Tangents tangents;
        for (int i = 0; i < n; ++i) {
            int before = (i + n - 1) % n;
            if ((code >> i & 1) == (code >> before & 1))
                continue;
            (found == 0 ? tangents.first : tangents.second) = silhouette.vertex[static_cast<std::size_t>(i)];
            ++found;
        }
        tangents.valid = found == 2;
        silhouette.tangents[static_cast<std::size_t>(code)] = tangents;
    }
    silhouette.mask = (1u << n) - 1;
    for (auto slot = static_cast<std::size_t>(n); n > 0 && slot < kMostEdges; ++slot) {
        silhouette.vertex[slot] = silhouette.vertex[0];
        silhouette.axis[slot] = silhouette.axis[0];
        silhouette.way[slot] = silhouette.way[0];
    }
}

std::array<Silhouette, 27> make_table() {
    std::array<Silhouette, 27> table;
    for (int region = 0; region < 27; ++region) {
        table[static_cast<std::size_t>(region)] = silhouette_of({region % 3, region / 3 % 3, region / 9});
        fill_tangents(table[static_cast<std::size_t>(region)]);
    }
    return table;
}

const std::array<Silhouette, 27> kTable = make_table();

} // namespace

Tangents find_tangents(const Box3d& box, const Vec3d& origin, const Vec3d& direction) {
    const double low[3] = {box.min.x - origin.x, box.min.y - origin.y, box.min.z - origin.z};
    const double high[3] = {box.max.x - origin.x, box.max.y - origin.y, box.max.z - origin.z};
    // Below the box is place 0, beside it 1, above it 2.
    auto place = [&](int axis) { return 1 - int(low[axis] > 0) + int(high[axis] < 0); };
    const Silhouette& silhouette = kTable[static_cast<std::size_t>(place(0) + 3 * place(1) + 9 * place(2))];
    // corners[axis][0 or 1], twice over the axes, so that the next axes need no remainder.
    const double corners[5][2] = {{low[0], high[0]}, {low[1], high[1]}, {low[2], high[2]}, {low[0], high[0]}, {low[1], high[1]}};
    const double along[5] = {direction.x, direction.y, direction.z, direction.x, direction.y};
    constexpr int kNext[5] = {0, 1, 2, 0, 1};
    unsigned code = 0;
    for (int i = 0; i < kMostEdges; ++i) {
        // (w x e_axis) . direction needs two products: the edge runs along an axis.
        auto slot = static_cast<std::size_t>(i);
        int u = silhouette.axis[slot] + 1, v = u + 1, corner = silhouette.vertex[slot];
        double wu = corners[u][corner >> kNext[u] & 1], wv = corners[v][corner >> kNext[v] & 1];
        double side = (wv * along[u] - wu * along[v]) * silhouette.way[slot];
        code |= unsigned(side > 0) << i;
    }
    return silhouette.tangents[code & silhouette.mask];
}

Tangents find_tangents_naive(const Box3d& box, const Vec3d& origin, const Vec3d& direction) {
    Tangents result;
    int found = 0;
    for (int candidate = 0; candidate < 8 && found < 2; ++candidate) {
        Vec3d normal = cross(direction, box.corner(candidate) - origin);
        double least = 0, most = 0;
        for (int other = 0; other < 8; ++other) {
            double side = dot(normal, box.corner(other) - origin);
            if (other != candidate) {
                least = std::min(least, side);
                most = std::max(most, side);
            }
        }
        if (least < 0 && most > 0)
            continue;
        (found == 0 ? result.first : result.second) = static_cast<std::uint8_t>(candidate);
        ++found;
    }
    result.valid = found == 2;
    return result;
}

} // namespace antumbra
