#include "cull/tangent_table.hpp"

#include <array>
#ifdef __SSE2__
#include <immintrin.h>
#endif

namespace antumbra {
namespace {

constexpr int kMostEdges = 6;

struct Silhouette {
    int count = 0; ///< 4, 6, or 0 for the region inside
    std::array<std::uint8_t, kMostEdges> vertex{}; ///< in order around
    std::array<std::uint8_t, kMostEdges> axis{};   ///< of the edge from vertex i to the next
    std::array<bool, kMostEdges> forward{};        ///< does it run along that axis, or against it?
    std::array<Tangents, 64> tangents{};           ///< per bit code of the sides of its edges
};

/// The box has twelve edges, three times four parallel ones; their sides are one code of twelve bits. Those of a
/// silhouette are taken out of it by two look-ups of six bits each.
struct Region {
    std::array<std::array<std::uint8_t, 64>, 2> take{};
    std::array<Tangents, 64> tangents{};
};

/// Edges along `axis` are numbered by the places of their corners along the next two axes.
int edge_number(int corner, int axis) {
    int u = (axis + 1) % 3, v = (axis + 2) % 3;
    return 4 * axis + (corner >> u & 1) + 2 * (corner >> v & 1);
}

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
            result.forward[slot] = edge.a == at;
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
}

std::array<Region, 27> make_table() {
    std::array<Region, 27> table;
    for (int r = 0; r < 27; ++r) {
        Silhouette silhouette = silhouette_of({r % 3, r / 3 % 3, r / 9});
        fill_tangents(silhouette);
        Region& region = table[static_cast<std::size_t>(r)];
        region.tangents = silhouette.tangents;
        for (std::size_t i = 0; i < static_cast<std::size_t>(silhouette.count); ++i) {
            int number = edge_number(silhouette.vertex[i], silhouette.axis[i]);
            for (unsigned code = 0; code < 64; ++code)
                if ((code >> (number % 6) & 1) == unsigned(silhouette.forward[i]))
                    region.take[static_cast<std::size_t>(number / 6)][code] |= static_cast<std::uint8_t>(1u << i);
        }
    }
    return table;
}

const std::array<Region, 27> kTable = make_table();

struct Code {
    unsigned region, edges;
};

/// Bit e of `edges`: (w x axis) . direction > 0 for the corner w (seen from the origin) of edge e, which runs along its
/// axis, so that two products do: w_v direction_u - w_u direction_v.
#ifdef __SSE2__
inline Code code_of(const Box3d& box, const Vec3d& origin, const Vec3d& direction) {
    const __m128d zero = _mm_setzero_pd();
    __m128d corners[3] = {_mm_sub_pd(_mm_set_pd(box.max.x, box.min.x), _mm_set1_pd(origin.x)),
                          _mm_sub_pd(_mm_set_pd(box.max.y, box.min.y), _mm_set1_pd(origin.y)),
                          _mm_sub_pd(_mm_set_pd(box.max.z, box.min.z), _mm_set1_pd(origin.z))};
    const __m128d along[3] = {_mm_set1_pd(direction.x), _mm_set1_pd(direction.y), _mm_set1_pd(direction.z)};
    auto place = [&](int axis) {
        // Below the box is place 0, beside it 1, above it 2.
        auto above_zero = static_cast<unsigned>(_mm_movemask_pd(_mm_cmpgt_pd(corners[axis], zero)));
        auto below_zero = static_cast<unsigned>(_mm_movemask_pd(_mm_cmplt_pd(corners[axis], zero)));
        return 1 - (above_zero & 1) + (below_zero >> 1);
    };
    auto sides = [&](int u, int v) {
        __m128d across = _mm_mul_pd(corners[u], along[v]), other = _mm_mul_pd(corners[v], along[u]);
        __m128d low = _mm_sub_pd(_mm_unpacklo_pd(other, other), across);
        __m128d high = _mm_sub_pd(_mm_unpackhi_pd(other, other), across);
        return static_cast<unsigned>(_mm_movemask_pd(_mm_cmpgt_pd(low, zero)) |
                                     _mm_movemask_pd(_mm_cmpgt_pd(high, zero)) << 2);
    };
    return {place(0) + 3 * place(1) + 9 * place(2), sides(1, 2) | sides(2, 0) << 4 | sides(0, 1) << 8};
}
#else
inline Code code_of(const Box3d& box, const Vec3d& origin, const Vec3d& direction) {
    double corners[3][2];
    for (int axis = 0; axis < 3; ++axis) {
        corners[axis][0] = box.min[axis] - origin[axis];
        corners[axis][1] = box.max[axis] - origin[axis];
    }
    auto place = [&](int axis) { return 1u - unsigned(corners[axis][0] > 0) + unsigned(corners[axis][1] < 0); };
    auto sides = [&](int u, int v) {
        double across[2] = {corners[u][0] * direction[v], corners[u][1] * direction[v]};
        double other[2] = {corners[v][0] * direction[u], corners[v][1] * direction[u]};
        return unsigned(other[0] - across[0] > 0) | unsigned(other[0] - across[1] > 0) << 1 |
               unsigned(other[1] - across[0] > 0) << 2 | unsigned(other[1] - across[1] > 0) << 3;
    };
    return {place(0) + 3 * place(1) + 9 * place(2), sides(1, 2) | sides(2, 0) << 4 | sides(0, 1) << 8};
}
#endif

} // namespace

Tangents find_tangents(const Box3d& box, const Vec3d& origin, const Vec3d& direction) {
    Code code = code_of(box, origin, direction);
    const Region& region = kTable[code.region];
    return region.tangents[region.take[0][code.edges & 63] | region.take[1][code.edges >> 6]];
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
