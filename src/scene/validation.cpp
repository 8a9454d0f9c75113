// Findings that need a search over the whole scene. Everything speaks of positions, not of vertex indices: formats
// split vertices along seams of texture or normal, which have nothing to do with the surface.
#include <antumbra/scene.hpp>

#include <algorithm>
#include <numeric>
#include <tuple>

namespace antumbra {
namespace {

/// For each vertex the lowest index of a vertex at the same position.
std::vector<std::uint32_t> weld(std::span<const Vec3f> positions) {
    std::vector<std::uint32_t> order(positions.size()), welded(positions.size());
    std::iota(order.begin(), order.end(), 0u);
    auto key = [&](std::uint32_t v) {
        const Vec3f& p = positions[v];
        return std::tuple(p.x, p.y, p.z);
    };
    std::sort(order.begin(), order.end(),
              [&](std::uint32_t a, std::uint32_t b) { return std::tuple(key(a), a) < std::tuple(key(b), b); });
    for (std::size_t i = 0; i < order.size(); ++i) {
        bool same = i > 0 && key(order[i]) == key(order[i - 1]);
        welded[order[i]] = same ? welded[order[i - 1]] : order[i];
    }
    return welded;
}

std::string place_of(const Scene& scene, std::uint32_t triangle) {
    std::uint32_t object = scene.triangle_objects()[triangle];
    return "triangle " + std::to_string(triangle - scene.objects()[object].first_triangle) + " of '" +
           std::string(scene.name(object)) + "'";
}

Finding find_duplicates(const Scene& scene, std::span<const std::uint32_t> welded) {
    std::vector<TriangleIndices> sorted(scene.triangles().size());
    for (std::size_t t = 0; t < sorted.size(); ++t) {
        for (std::size_t c = 0; c < 3; ++c)
            sorted[t][c] = welded[scene.triangles()[t][c]];
        std::sort(sorted[t].begin(), sorted[t].end());
    }
    std::vector<std::uint32_t> order(sorted.size());
    std::iota(order.begin(), order.end(), 0u);
    std::sort(order.begin(), order.end(), [&](std::uint32_t a, std::uint32_t b) {
        return sorted[a] != sorted[b] ? sorted[a] < sorted[b] : a < b;
    });
    Finding finding{"duplicate triangle", 0, ""};
    std::uint32_t first = 0;
    for (std::size_t i = 1; i < order.size(); ++i)
        if (sorted[order[i]] == sorted[order[i - 1]] && (finding.count++ == 0 || order[i] < first))
            first = order[i];
    if (finding.count > 0)
        finding.example = place_of(scene, first);
    return finding;
}

struct Edge {
    std::uint32_t low, high, triangle;
    bool operator<(const Edge& b) const {
        return std::tie(low, high, triangle) < std::tie(b.low, b.high, b.triangle);
    }
    bool joins_same(const Edge& b) const { return low == b.low && high == b.high; }
};

/// Edges of one triangle only, and edges of more than two.
std::array<Finding, 2> find_edges(const Scene& scene, std::span<const std::uint32_t> welded) {
    std::vector<Edge> edges;
    edges.reserve(scene.triangles().size() * 3);
    for (std::uint32_t t = 0; t < scene.triangles().size(); ++t)
        for (std::size_t c = 0; c < 3; ++c) {
            std::uint32_t a = welded[scene.triangles()[t][c]], b = welded[scene.triangles()[t][(c + 1) % 3]];
            edges.push_back({std::min(a, b), std::max(a, b), t});
        }
    std::sort(edges.begin(), edges.end());
    std::array<Finding, 2> findings{Finding{"boundary edge", 0, ""}, Finding{"non-manifold edge", 0, ""}};
    std::array<std::uint32_t, 2> first{0xFFFFFFFFu, 0xFFFFFFFFu};
    for (std::size_t begin = 0, end = 0; begin < edges.size(); begin = end) {
        while (end < edges.size() && edges[end].joins_same(edges[begin]))
            ++end;
        if (end - begin == 2)
            continue;
        std::size_t kind = end - begin == 1 ? 0 : 1;
        ++findings[kind].count;
        first[kind] = std::min(first[kind], edges[begin].triangle);
    }
    for (std::size_t kind = 0; kind < 2; ++kind)
        if (findings[kind].count > 0)
            findings[kind].example = place_of(scene, first[kind]);
    return findings;
}

} // namespace

std::vector<Finding> validate(const Scene& scene) {
    std::vector<std::uint32_t> welded = weld(scene.positions());
    std::vector<Finding> findings{find_duplicates(scene, welded)};
    for (Finding& finding : find_edges(scene, welded))
        findings.push_back(std::move(finding));
    std::erase_if(findings, [](const Finding& finding) { return finding.count == 0; });
    return findings;
}

} // namespace antumbra
