#include "scene/cracks.hpp"

#include "tree/bvh.hpp"

#include <algorithm>
#include <cmath>
#include <functional>
#include <numeric>
#include <set>
#include <tuple>

namespace antumbra {
namespace {

constexpr std::uint32_t kNone = 0xFFFFFFFFu;

auto key(const Vec3d& p) { return std::tuple(p.x, p.y, p.z); }

/// Numbers of points: equal numbers are equal places; ascending with x, y, z.
std::vector<std::uint32_t> number_places(const std::vector<Vec3d>& positions, std::vector<Vec3d>& places) {
    std::vector<std::uint32_t> order(positions.size()), number(positions.size());
    std::iota(order.begin(), order.end(), 0u);
    std::sort(order.begin(), order.end(), [&](std::uint32_t a, std::uint32_t b) {
        return std::tuple(key(positions[a]), a) < std::tuple(key(positions[b]), b);
    });
    for (std::uint32_t v : order) {
        if (places.empty() || key(places.back()) != key(positions[v]))
            places.push_back(positions[v]);
        number[v] = std::uint32_t(places.size() - 1);
    }
    return number;
}

bool has_area(const Vec3d& a, const Vec3d& b, const Vec3d& c) { // exact: products of whole numbers below 2^50
    Vec3d n = cross(b - a, c - a);
    return n.x != 0 || n.y != 0 || n.z != 0;
}

/// Points in a tree, to be asked for by boxes.
class PointTree {
  public:
    PointTree(const std::vector<Vec3d>& places, std::vector<std::uint32_t> points) : places_(places), points_(std::move(points)) {
        std::vector<Box3f> boxes;
        for (std::uint32_t p : points_) {
            Vec3f at{float(places[p].x), float(places[p].y), float(places[p].z)}; // exact: below 2^24
            boxes.push_back({at, at});
        }
        bvh_ = build_bvh(boxes);
    }
    void within(const Box3d& box, const std::function<void(std::uint32_t)>& visit) const {
        std::vector<std::uint32_t> open;
        if (!bvh_.nodes.empty())
            open.push_back(0);
        while (!open.empty()) {
            const BvhNode& node = bvh_.nodes[open.back()];
            open.pop_back();
            if (!to_double(node.box).overlaps(box))
                continue;
            if (!node.leaf()) {
                open.push_back(node.first);
                open.push_back(node.first + 1);
                continue;
            }
            for (std::uint32_t i = node.first; i < node.first + node.count; ++i)
                if (std::uint32_t p = points_[bvh_.order[i]]; box.contains(places_[p]))
                    visit(p);
        }
    }

  private:
    const std::vector<Vec3d>& places_;
    std::vector<std::uint32_t> points_;
    Bvh bvh_;
};

/// An edge of one occluding triangle only, as this runs along it.
struct OpenEdge {
    std::uint32_t from, to; ///< places
    std::uint32_t triangle;
};

using Places = std::vector<std::array<std::uint32_t, 3>>; ///< per triangle

std::vector<OpenEdge> open_edges(const GridMesh& mesh, const std::vector<bool>& occludes, const Places& corners) {
    std::vector<OpenEdge> edges, open;
    for (std::uint32_t t = 0; t < mesh.triangles.size(); ++t)
        if (occludes[mesh.object_of[t]])
            for (std::size_t k = 0; k < 3; ++k)
                edges.push_back({corners[t][k], corners[t][(k + 1) % 3], t});
    auto ends = [](const OpenEdge& e) { return std::pair(std::min(e.from, e.to), std::max(e.from, e.to)); };
    std::sort(edges.begin(), edges.end(), [&](const OpenEdge& a, const OpenEdge& b) {
        return std::tuple(ends(a), a.triangle) < std::tuple(ends(b), b.triangle);
    });
    for (std::size_t i = 0, last = 0; i < edges.size(); i = last) {
        for (last = i + 1; last < edges.size() && ends(edges[last]) == ends(edges[i]);)
            ++last;
        if (last == i + 1 && edges[i].from != edges[i].to)
            open.push_back(edges[i]);
    }
    return open;
}

std::vector<std::uint32_t> ends_of(const std::vector<OpenEdge>& edges) {
    std::vector<std::uint32_t> ends;
    for (const OpenEdge& edge : edges) {
        ends.push_back(edge.from);
        ends.push_back(edge.to);
    }
    std::sort(ends.begin(), ends.end());
    ends.erase(std::unique(ends.begin(), ends.end()), ends.end());
    return ends;
}

class CrackCloser {
  public:
    CrackCloser(GridMesh& mesh, const std::vector<bool>& occludes, double width)
        : mesh_(mesh), occludes_(occludes), width_(width) {
        std::vector<std::uint32_t> number = number_places(mesh.positions, places_);
        for (const TriangleIndices& triangle : mesh.triangles)
            corners_.push_back({number[triangle[0]], number[triangle[1]], number[triangle[2]]});
        number_ = std::move(number);
    }

    CrackClosing join_ends() {
        std::vector<std::uint32_t> ends = ends_of(open_edges(mesh_, occludes_, corners_));
        PointTree tree(places_, ends);
        std::vector<std::uint32_t> goes_to(places_.size());
        std::iota(goes_to.begin(), goes_to.end(), 0u);
        for (std::uint32_t end : ends) {
            const Vec3d& p = places_[end];
            std::pair<double, std::uint32_t> best{width_ * width_, kNone};
            tree.within({p - around_, p + around_}, [&](std::uint32_t other) {
                Vec3d d = places_[other] - p;
                if (other < end && goes_to[other] == other) // one that stays
                    best = std::min(best, {dot(d, d), other});
            });
            if (best.second != kNone)
                goes_to[end] = best.second;
        }
        spare_triangles(goes_to);
        CrackClosing done;
        for (std::uint32_t end : ends)
            done.moved += goes_to[end] != end;
        for (std::array<std::uint32_t, 3>& triangle : corners_)
            for (std::uint32_t& corner : triangle)
                corner = goes_to[corner];
        for (std::size_t v = 0; v < mesh_.positions.size(); ++v)
            mesh_.positions[v] = places_[number_[v] = goes_to[number_[v]]];
        return done;
    }

    Result<std::uint64_t> seal_junctions() {
        std::vector<OpenEdge> edges = open_edges(mesh_, occludes_, corners_);
        PointTree tree(places_, ends_of(edges));
        struct Seal {
            std::uint32_t object;
            std::array<std::uint32_t, 3> places;
        };
        std::vector<Seal> seals;
        std::vector<std::pair<double, std::uint32_t>> between;
        for (const OpenEdge& edge : edges) {
            const Vec3d &a = places_[edge.from], &b = places_[edge.to];
            Vec3d d = b - a;
            Box3d box;
            box.extend(a);
            box.extend(b);
            between.clear();
            tree.within({box.min - around_, box.max + around_}, [&](std::uint32_t other) {
                if (other == edge.from || other == edge.to)
                    return;
                double at = dot(places_[other] - a, d) / dot(d, d);
                Vec3d off = places_[other] - a - d * at;
                if (at > 0 && at < 1 && dot(off, off) <= width_ * width_)
                    between.push_back({at, other});
            });
            std::sort(between.begin(), between.end());
            // a, v1, v2 .. b: with the edge, the rim of a fan about b.
            std::uint32_t last = edge.from;
            for (auto [at, next] : between) {
                if (has_area(places_[last], places_[next], b))
                    seals.push_back({mesh_.object_of[edge.triangle], {last, next, edge.to}});
                last = next;
            }
            if (seals.size() > 2 * mesh_.triangles.size() + 64)
                return Status(ErrorCode::usage, "--crack-width is too large for this scene: closing such cracks would add more "
                                                "than twice its triangles; choose a smaller width");
        }
        std::stable_sort(seals.begin(), seals.end(), [](const Seal& x, const Seal& y) { return x.object < y.object; });
        std::vector<std::uint32_t> vertex(places_.size(), kNone);
        for (std::uint32_t v = 0; v < number_.size(); ++v)
            vertex[number_[v]] = v;
        GridMesh joined;
        std::size_t next = 0;
        for (std::uint32_t t = 0; t < mesh_.triangles.size(); ++t) {
            joined.triangles.push_back(mesh_.triangles[t]);
            joined.object_of.push_back(mesh_.object_of[t]);
            if (t + 1 < mesh_.triangles.size() && mesh_.object_of[t + 1] == mesh_.object_of[t])
                continue;
            for (; next < seals.size() && seals[next].object == mesh_.object_of[t]; ++next) {
                const auto& p = seals[next].places;
                joined.triangles.push_back({vertex[p[0]], vertex[p[1]], vertex[p[2]]});
                joined.object_of.push_back(seals[next].object);
            }
        }
        mesh_.triangles = std::move(joined.triangles);
        mesh_.object_of = std::move(joined.object_of);
        return std::uint64_t(seals.size());
    }

  private:
    /// Leaves corners where they are until no triangle collapses or turns over.
    void spare_triangles(std::vector<std::uint32_t>& goes_to) const {
        for (bool changed = true; changed;) {
            changed = false;
            for (const std::array<std::uint32_t, 3>& was : corners_) {
                std::array<std::uint32_t, 3> is{goes_to[was[0]], goes_to[was[1]], goes_to[was[2]]};
                if (is == was)
                    continue;
                auto normal = [&](const std::array<std::uint32_t, 3>& p) {
                    return cross(places_[p[1]] - places_[p[0]], places_[p[2]] - places_[p[0]]);
                };
                if (dot(normal(is), normal(was)) > 0)
                    continue;
                for (std::uint32_t corner : was) {
                    changed |= goes_to[corner] != corner;
                    goes_to[corner] = corner;
                }
            }
        }
    }

    GridMesh& mesh_;
    const std::vector<bool>& occludes_;
    double width_;
    Vec3d around_{width_, width_, width_};
    std::vector<Vec3d> places_;
    std::vector<std::uint32_t> number_; ///< per vertex: its place
    Places corners_;
};

} // namespace

Result<CrackClosing> close_cracks(GridMesh& mesh, const std::vector<bool>& occludes, double width) {
    CrackCloser closer(mesh, occludes, width);
    CrackClosing done = closer.join_ends();
    Result<std::uint64_t> seals = closer.seal_junctions();
    if (!seals)
        return seals.status();
    done.seals = *seals;
    return done;
}

OpenedCracks count_opened_cracks(std::vector<SnappedPoint> points) {
    auto order = [](const SnappedPoint& p) { return std::tuple(key(p.after), p.object, key(p.before)); };
    std::sort(points.begin(), points.end(), [&](const auto& a, const auto& b) { return order(a) < order(b); });
    points.erase(std::unique(points.begin(), points.end(), [&](const auto& a, const auto& b) { return order(a) == order(b); }),
                 points.end());
    OpenedCracks cracks;
    auto at = [&](const Vec3d& place) {
        return std::lower_bound(points.begin(), points.end(), place,
                                [](const SnappedPoint& p, const Vec3d& wanted) { return key(p.after) < key(wanted); });
    };
    std::set<std::pair<std::tuple<double, double, double>, std::tuple<double, double, double>>> told;
    for (const SnappedPoint& p : points)
        // Places on the greater side only: each pair comes up once.
        for (int side = 1; side < 27; ++side) {
            Vec3d step{double(side % 3) - 1, double(side / 3 % 3) - 1, double(side / 9) - 1};
            if (key(step) < key(Vec3d{0, 0, 0}))
                continue;
            bool near = true; // what rounds to that place and lies near would have to lie beyond the border
            for (int k = 0; k < 3; ++k)
                near &= step[k] == 0 || (p.before[k] - p.after[k]) * step[k] > 0;
            if (!near || step == Vec3d{0, 0, 0})
                continue;
            for (auto other = at(p.after + step); other != points.end() && other->after == p.after + step; ++other) {
                Vec3d apart = other->before - p.before;
                if (other->object == p.object || std::abs(apart.x) >= 0.5 || std::abs(apart.y) >= 0.5 || std::abs(apart.z) >= 0.5)
                    continue;
                if (told.insert({key(p.after), key(other->after)}).second && cracks.count++ == 0) {
                    cracks.a = p.object;
                    cracks.b = other->object;
                }
            }
        }
    return cracks;
}

} // namespace antumbra
