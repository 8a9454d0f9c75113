#include <antumbra/occluders.hpp>

#include <algorithm>
#include <numeric>
#include <string>

namespace antumbra {
namespace {

struct EdgeUse {
    std::uint32_t low, high; ///< vertices
    std::uint32_t polygon, slot;
    bool forward; ///< runs from low to high
};

std::vector<EdgeUse> sorted_edges(const OccluderSet& set) {
    std::vector<EdgeUse> uses;
    uses.reserve(set.loops.size());
    for (std::uint32_t p = 0; p < set.polygons.size(); ++p) {
        const OccluderPolygon& polygon = set.polygons[p];
        for (std::uint32_t i = 0; i < polygon.count; ++i) {
            std::uint32_t a = set.loops[polygon.first + i];
            std::uint32_t b = set.loops[polygon.first + (i + 1 == polygon.count ? 0 : i + 1)];
            uses.push_back({std::min(a, b), std::max(a, b), p, polygon.first + i, a < b});
        }
    }
    std::sort(uses.begin(), uses.end(), [](const EdgeUse& a, const EdgeUse& b) {
        return a.low != b.low ? a.low < b.low : a.high != b.high ? a.high < b.high : a.slot < b.slot;
    });
    return uses;
}

/// The best partner of `use` among the others of the same edge: one that runs the other way before one that does
/// not (which only counts if a double-sided polygon is among them), alike in sidedness before unlike.
std::uint32_t partner(const OccluderSet& set, std::span<const EdgeUse> edge, const EdgeUse& use) {
    std::uint32_t best = kNoPolygon;
    int best_rank = 0;
    for (const EdgeUse& other : edge) {
        if (other.polygon == use.polygon)
            continue;
        const OccluderPolygon& a = set.polygons[use.polygon];
        const OccluderPolygon& b = set.polygons[other.polygon];
        bool opposite = other.forward != use.forward;
        if (!opposite && !a.double_sided && !b.double_sided)
            continue;
        int rank = 1 + 2 * opposite + (a.double_sided == b.double_sided);
        if (rank > best_rank) {
            best_rank = rank;
            best = other.polygon | (opposite ? 0 : kSameDirection);
        }
    }
    return best;
}

bool is_finite_polygon(const OccluderPolygon& p) {
    return is_finite(p.normal) && std::isfinite(p.offset) && std::isfinite(p.area) && is_finite(p.centre);
}

Status corrupt(const char* what, std::size_t index) {
    return Status(ErrorCode::corrupt, std::string("occluders: ") + what + " " + std::to_string(index) +
                                          " is out of range or not finite; make them again");
}

} // namespace

void measure_occluder(const OccluderSet& set, OccluderPolygon& polygon) {
    std::span<const std::uint32_t> loop = set.loop(polygon);
    Vec3d first = to_double(set.vertices[loop[0]]), sum, area;
    for (std::size_t i = 0; i < loop.size(); ++i) {
        sum += to_double(set.vertices[loop[i]]);
        area += cross(to_double(set.vertices[loop[i]]) - first,
                      to_double(set.vertices[loop[(i + 1) % loop.size()]]) - first);
    }
    polygon.normal = normalized(area);
    polygon.offset = -dot(polygon.normal, first);
    polygon.area = length(area) / 2;
    polygon.centre = sum / double(loop.size());
}

Status check_occluders(const OccluderSet& set) {
    if (set.neighbours.size() != set.loops.size() || set.polygons.size() >= kNoPolygon)
        return Status(ErrorCode::corrupt, "occluders: the lists do not fit together; make them again");
    for (std::size_t v = 0; v < set.vertices.size(); ++v)
        if (!is_finite(set.vertices[v]))
            return corrupt("vertex", v);
    for (std::size_t i = 0; i < set.loops.size(); ++i) {
        std::uint32_t neighbour = set.neighbours[i] & ~kSameDirection;
        if (set.loops[i] >= set.vertices.size() || (neighbour != kNoPolygon && neighbour >= set.polygons.size()))
            return corrupt("corner", i);
    }
    for (std::size_t p = 0; p < set.polygons.size(); ++p) {
        const OccluderPolygon& polygon = set.polygons[p];
        if (polygon.count < 3 || polygon.first > set.loops.size() || polygon.count > set.loops.size() - polygon.first ||
            !is_finite_polygon(polygon) || (polygon.synthetic && polygon.solid >= set.solids.size()))
            return corrupt("polygon", p);
    }
    for (std::size_t p = 0; p < set.patches.size(); ++p) {
        const OccluderPatch& patch = set.patches[p];
        if (patch.core > patch.count || patch.first > set.patch_polygons.size() ||
            patch.count > set.patch_polygons.size() - patch.first)
            return corrupt("patch", p);
    }
    for (std::size_t i = 0; i < set.patch_polygons.size(); ++i)
        if (set.patch_polygons[i] >= set.polygons.size())
            return corrupt("polygon of a patch", i);
    return {};
}

void connect_occluders(OccluderSet& set) {
    set.neighbours.assign(set.loops.size(), kNoPolygon);
    std::vector<EdgeUse> uses = sorted_edges(set);
    for (std::size_t begin = 0; begin < uses.size();) {
        std::size_t end = begin;
        while (end < uses.size() && uses[end].low == uses[begin].low && uses[end].high == uses[begin].high)
            ++end;
        for (std::size_t i = begin; i < end; ++i)
            set.neighbours[uses[i].slot] = partner(set, {uses.data() + begin, end - begin}, uses[i]);
        begin = end;
    }
}

void group_occluders(OccluderSet& set, std::uint32_t most_polygons) {
    constexpr std::uint32_t kFree = 0xFFFFFFFFu;
    std::vector<std::uint32_t> by_area(set.polygons.size());
    std::iota(by_area.begin(), by_area.end(), 0u);
    std::sort(by_area.begin(), by_area.end(), [&](std::uint32_t a, std::uint32_t b) {
        double left = set.polygons[a].area, right = set.polygons[b].area;
        return left != right ? left > right : a < b;
    });
    std::vector<std::uint32_t> owner(set.polygons.size(), kFree), seen_by(set.polygons.size(), kFree);
    set.patches.clear();
    set.patch_polygons.clear();
    auto for_neighbours = [&](std::uint32_t polygon, auto&& visit) {
        const OccluderPolygon& p = set.polygons[polygon];
        for (std::uint32_t i = 0; i < p.count; ++i)
            if (std::uint32_t n = set.neighbours[p.first + i] & ~kSameDirection; n != kNoPolygon)
                visit(n);
    };
    for (std::uint32_t seed : by_area) {
        if (owner[seed] != kFree)
            continue;
        auto index = static_cast<std::uint32_t>(set.patches.size());
        OccluderPatch patch;
        patch.first = static_cast<std::uint32_t>(set.patch_polygons.size());
        set.patch_polygons.push_back(seed);
        owner[seed] = index;
        for (std::size_t at = patch.first; at < set.patch_polygons.size(); ++at) // breadth first
            for_neighbours(set.patch_polygons[at], [&](std::uint32_t n) {
                if (owner[n] == kFree && set.patch_polygons.size() - patch.first < most_polygons) {
                    owner[n] = index;
                    set.patch_polygons.push_back(n);
                }
            });
        patch.core = static_cast<std::uint32_t>(set.patch_polygons.size()) - patch.first;
        for (std::uint32_t i = 0; i < patch.core; ++i) {
            std::uint32_t polygon = set.patch_polygons[patch.first + i];
            for (std::uint32_t v : set.loop(set.polygons[polygon]))
                patch.box.extend(set.vertices[v]);
            for_neighbours(polygon, [&](std::uint32_t n) {
                if (owner[n] != index && seen_by[n] != index) {
                    seen_by[n] = index;
                    set.patch_polygons.push_back(n);
                }
            });
        }
        patch.count = static_cast<std::uint32_t>(set.patch_polygons.size()) - patch.first;
        set.patches.push_back(patch);
    }
}

} // namespace antumbra
