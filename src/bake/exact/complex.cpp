#include "bake/exact/complex.hpp"

#include "base/random.hpp"

#include <algorithm>
#include <cmath>

namespace antumbra::exact {
namespace {

void make_primitive(Six& x) {
    Integer divisor = 0;
    for (const Integer& value : x)
        divisor = gcd(divisor, value);
    if (divisor != 0)
        for (Integer& value : x)
            value /= divisor;
}

/// The vector that is orthogonal to all of these, which span five dimensions; all zero if they do not.
Six normal_of(std::vector<Six> rows) {
    std::size_t rank = 0;
    std::array<std::size_t, 6> pivot{};
    for (std::size_t column = 0; column < 6 && rank < 5; ++column) {
        std::size_t from = rank;
        while (from < rows.size() && rows[from][column] == 0)
            ++from;
        if (from == rows.size())
            continue;
        std::swap(rows[rank], rows[from]);
        for (std::size_t r = 0; r < rows.size(); ++r) {
            if (r == rank || rows[r][column] == 0)
                continue;
            Integer a = rows[rank][column], b = rows[r][column];
            for (std::size_t k = 0; k < 6; ++k)
                rows[r][k] = rows[r][k] * a - rows[rank][k] * b;
            make_primitive(rows[r]);
        }
        pivot[rank++] = column;
    }
    Six normal;
    normal.fill(Integer(0));
    if (rank < 5)
        return normal;
    std::size_t free = 0;
    for (std::size_t r = 0; r < 5; ++r)
        free += pivot[r] == free;
    // Row r says: rows[r][pivot] * n[pivot] + rows[r][free] * n[free] = 0.
    Integer common = 1;
    for (std::size_t r = 0; r < 5; ++r)
        common *= rows[r][pivot[r]];
    normal[free] = common;
    for (std::size_t r = 0; r < 5; ++r)
        normal[pivot[r]] = -rows[r][free] * (common / rows[r][pivot[r]]);
    make_primitive(normal);
    return normal;
}

Integer dot(const Six& a, const Six& b) {
    Integer sum = 0;
    for (std::size_t k = 0; k < 6; ++k)
        sum += a[k] * b[k];
    return sum;
}

/// Uniform on a convex polygon.
Vec3d any_point(std::span<const GridPoint> polygon, Random& random) {
    auto at = [&](std::size_t i) {
        return Vec3d{double(polygon[i].x), double(polygon[i].y), double(polygon[i].z)};
    };
    std::vector<double> areas;
    for (std::size_t i = 1; i + 1 < polygon.size(); ++i)
        areas.push_back((areas.empty() ? 0 : areas.back()) + length(cross(at(i) - at(0), at(i + 1) - at(0))));
    double pick = random.uniform() * areas.back();
    std::size_t i = 0;
    while (i + 1 < areas.size() && areas[i] <= pick)
        ++i;
    double u = random.uniform(), v = random.uniform();
    if (u + v > 1) {
        u = 1 - u;
        v = 1 - v;
    }
    return at(0) + (at(i + 1) - at(0)) * u + (at(i + 2) - at(0)) * v;
}

} // namespace

bool ComplexPiece::holds(const Vec3d& p, const Vec3d& q) const {
    Vec3d d = q - p, m = cross(p, q);
    double line[6] = {d.x, d.y, d.z, m.x, m.y, m.z};
    return std::all_of(facets.begin(), facets.end(), [&](const ComplexFacet& facet) {
        double sum = 0, largest = 0;
        for (std::size_t k = 0; k < 6; ++k)
            largest = std::max(largest, std::abs(facet.hyperplane[k].convert_to<double>()));
        for (std::size_t k = 0; k < 6; ++k)
            sum += facet.hyperplane[k].convert_to<double>() / largest * line[k];
        return sum >= 0;
    });
}

std::vector<ComplexPiece> complete_complex(LineSpace& space) {
    std::vector<ComplexPiece> pieces;
    for (std::size_t k = 0; k < space.size(); ++k) {
        ComplexPiece piece;
        piece.vertices = space.cone(k);
        for (Six& vertex : piece.vertices)
            make_primitive(vertex);
        piece.faces = space.face_counts(k);
        for (std::vector<std::uint32_t>& vertices : space.facets(k)) {
            std::vector<Six> rows;
            for (std::uint32_t v : vertices)
                rows.push_back(piece.vertices[v]);
            ComplexFacet facet{normal_of(std::move(rows)), std::move(vertices)};
            for (const Six& vertex : piece.vertices)
                if (Integer side = dot(facet.hyperplane, vertex); side != 0) {
                    if (side < 0)
                        for (Integer& value : facet.hyperplane)
                            value = -value;
                    break;
                }
            piece.facets.push_back(std::move(facet));
        }
        pieces.push_back(std::move(piece));
    }
    return pieces;
}

double visible_share(std::span<const ComplexPiece> pieces, std::span<const GridPoint> s, std::span<const GridPoint> t,
                     std::uint32_t samples, std::uint64_t seed) {
    Random random(seed, 0x636f6d70);
    std::uint32_t held = 0;
    for (std::uint32_t k = 0; k < samples; ++k) {
        Vec3d p = any_point(s, random), q = any_point(t, random);
        held += std::any_of(pieces.begin(), pieces.end(), [&](const ComplexPiece& piece) { return piece.holds(p, q); });
    }
    return samples ? double(held) / samples : 0;
}

} // namespace antumbra::exact
