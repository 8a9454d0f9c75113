// Rays against the visibility that the maps' own compiler computed: whatever a ray sees between two clusters, blocked
// by nothing but the solid opaque brushes, must be in the baked set (which is conservative for the brushes).
//
//   bench_quake3_pvs MAP.bsp.. [--rays N]      prints CSV; exits 1 if more than 0.05% of the seen pairs are not in it
//
// The brushes are met as what they are, intersections of half spaces, so that brushes which share a plane leave no
// crack between them. Pairs below the compiler's own tolerances may be missing from its set: they are listed with
// their line, to be judged one by one.
#include "base/file.hpp"
#include "base/random.hpp"
#include "tree/bvh.hpp"

#include <antumbra/quake3.hpp>

#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <map>
#include <set>

using namespace antumbra;

namespace {

constexpr std::uint32_t kSolid = 1, kTranslucent = 0x20000000;

/// The solid opaque brushes of the world, with a tree over their boxes.
class Brushes {
  public:
    explicit Brushes(const Quake3Reference& map) : map_(map) {
        const Quake3Reference::Model& world = map.models.at(0);
        std::vector<Box3f> boxes;
        for (std::uint32_t b = world.first_brush; b < world.first_brush + world.brush_count; ++b) {
            const Quake3Reference::Brush& brush = map.brushes[b];
            std::uint32_t contents = map.shaders[std::size_t(brush.shader)].contents;
            if (!(contents & kSolid) || (contents & kTranslucent) || brush.side_count < 4)
                continue;
            brushes_.push_back(b);
            boxes.push_back(bounds(brush));
        }
        tree_ = build_bvh(boxes, {.leaf_size = 2});
    }
    std::size_t count() const { return brushes_.size(); }

    /// Where from + t * direction first enters a brush, 0 < t < limit; `limit` if nowhere. 0 inside of one.
    double first_hit(const Vec3d& from, const Vec3d& direction, double limit) const {
        std::uint32_t stack[kMaxBvhDepth + 8];
        int depth = 0;
        stack[depth++] = 0;
        while (depth > 0) {
            const BvhNode& node = tree_.nodes[stack[--depth]];
            if (!meets(node.box, from, direction, limit))
                continue;
            if (!node.leaf()) {
                stack[depth++] = node.first;
                stack[depth++] = node.first + 1;
                continue;
            }
            for (std::uint32_t i = node.first; i < node.first + node.count; ++i)
                limit = std::min(limit, enter(map_.brushes[brushes_[tree_.order[i]]], from, direction, limit));
        }
        return limit;
    }

  private:
    /// The compiler writes the six axial sides of a brush first.
    Box3f bounds(const Quake3Reference::Brush& brush) const {
        Box3d box{{-1e6, -1e6, -1e6}, {1e6, 1e6, 1e6}};
        for (std::uint32_t s = brush.first_side; s < brush.first_side + brush.side_count; ++s) {
            const Quake3Reference::Plane& plane = map_.planes[std::size_t(map_.brush_sides[s].plane)];
            for (int k = 0; k < 3; ++k) {
                if (plane.normal[k] == 1)
                    box.max[k] = std::min(box.max[k], plane.distance);
                if (plane.normal[k] == -1)
                    box.min[k] = std::max(box.min[k], -plane.distance);
            }
        }
        Box3f outward;
        for (int k = 0; k < 3; ++k) {
            outward.min[k] = float(box.min[k] - 1);
            outward.max[k] = float(box.max[k] + 1);
        }
        return outward;
    }

    static bool meets(const Box3f& box, const Vec3d& from, const Vec3d& direction, double limit) {
        double enter = 0, leave = limit;
        for (int k = 0; k < 3; ++k) {
            if (direction[k] == 0) {
                if (from[k] < box.min[k] || from[k] > box.max[k])
                    return false;
                continue;
            }
            double a = (box.min[k] - from[k]) / direction[k], b = (box.max[k] - from[k]) / direction[k];
            enter = std::max(enter, std::min(a, b));
            leave = std::min(leave, std::max(a, b));
        }
        return enter <= leave;
    }

    double enter(const Quake3Reference::Brush& brush, const Vec3d& from, const Vec3d& direction, double limit) const {
        double first = 0, last = limit;
        for (std::uint32_t s = brush.first_side; s < brush.first_side + brush.side_count; ++s) {
            const Quake3Reference::Plane& plane = map_.planes[std::size_t(map_.brush_sides[s].plane)];
            double above = dot(plane.normal, from) - plane.distance, slope = dot(plane.normal, direction);
            if (slope == 0) {
                if (above > 0)
                    return limit;
            } else if (slope < 0) {
                first = std::max(first, -above / slope);
            } else {
                last = std::min(last, -above / slope);
            }
        }
        return first <= last ? first : limit;
    }

    const Quake3Reference& map_;
    std::vector<std::uint32_t> brushes_;
    Bvh tree_;
};

/// Calls visit(leaf, length) for every leaf that the segment from + [t0, t1] * direction passes through.
template <class Visit>
void walk_leaves(const Quake3Reference& map, std::int32_t node, const Vec3d& from, const Vec3d& direction, double t0,
                 double t1, const Visit& visit) {
    while (node >= 0) {
        const Quake3Reference::Node& inner = map.nodes[std::size_t(node)];
        const Quake3Reference::Plane& plane = map.planes[std::size_t(inner.plane)];
        double offset = dot(plane.normal, from) - plane.distance, slope = dot(plane.normal, direction);
        double d0 = offset + slope * t0, d1 = offset + slope * t1;
        if (d0 >= 0 && d1 >= 0) {
            node = inner.children[0];
        } else if (d0 < 0 && d1 < 0) {
            node = inner.children[1];
        } else {
            double middle = -offset / slope;
            walk_leaves(map, inner.children[d0 < 0], from, direction, t0, middle, visit);
            node = inner.children[d0 >= 0];
            t0 = middle;
        }
    }
    visit(-1 - node, t1 - t0);
}

int check(const char* path, std::uint64_t rays) {
    Result<MappedFile> file = MappedFile::open(path);
    if (!file)
        return std::fprintf(stderr, "%s\n", file.status().message().c_str()), 1;
    Result<Quake3Map> read = import_quake3(file->bytes(), path);
    if (!read)
        return std::fprintf(stderr, "%s\n", read.status().message().c_str()), 1;
    const Quake3Reference& map = read->reference;
    Brushes brushes(map);
    std::vector<std::uint32_t> open;
    for (std::uint32_t l = 0; l < map.leaves.size(); ++l)
        if (map.leaves[l].cluster >= 0)
            open.push_back(l);
    // A ray must run through a leaf for a unit of the map (about 2 cm) to count as seeing it.
    constexpr double kPassage = 1.0;
    std::set<std::pair<std::int32_t, std::int32_t>> seen, missing;
    std::map<std::pair<std::int32_t, std::int32_t>, std::string> lines;
    std::uint64_t cast = 0;
    Random random(1);
    for (std::uint64_t r = 0; r < rays; ++r) {
        const Quake3Reference::Leaf& leaf = map.leaves[open[random.below(std::uint32_t(open.size()))]];
        Vec3d from;
        for (int k = 0; k < 3; ++k)
            from[k] = random.uniform(leaf.bounds.min[k], leaf.bounds.max[k]);
        std::int32_t at = map.leaf_of(from);
        Vec3d direction;
        do
            direction = {random.uniform(-1, 1), random.uniform(-1, 1), random.uniform(-1, 1)};
        while (dot(direction, direction) > 1 || dot(direction, direction) < 0.01);
        direction = normalized(direction);
        if (at < 0 || map.leaves[std::size_t(at)].cluster != leaf.cluster)
            continue;
        double reach = brushes.first_hit(from, direction, 1e5);
        if (reach <= 0 || reach >= 1e5)
            continue; // in a brush, or out into the void
        ++cast;
        walk_leaves(map, 0, from, direction, 0, reach, [&](std::int32_t other, double passage) {
            std::int32_t cluster = map.leaves[std::size_t(other)].cluster;
            if (cluster < 0 || passage < kPassage)
                return;
            std::pair pair{leaf.cluster, cluster};
            if (!seen.insert(pair).second || pair.first == pair.second || map.cluster_sees(pair.first, pair.second) ||
                map.cluster_sees(pair.second, pair.first))
                return;
            missing.insert(pair);
            char line[200];
            std::snprintf(line, sizeof line, "from %.9g,%.9g,%.9g along %.9g,%.9g,%.9g to %.9g, %.3g inside", from.x,
                          from.y, from.z, direction.x, direction.y, direction.z, reach, passage);
            lines[pair] = line;
        });
    }
    std::uint64_t baked = 0;
    for (std::uint32_t a = 0; a < map.clusters; ++a)
        for (std::uint32_t b = 0; b < map.clusters; ++b)
            baked += a == b || map.cluster_sees(std::int32_t(a), std::int32_t(b)) ||
                     map.cluster_sees(std::int32_t(b), std::int32_t(a));
    const char* name = std::strrchr(path, '/');
    std::printf("%s,%u,%zu,%llu,%zu,%llu,%.4f,%zu,%.6f\n", name ? name + 1 : path, map.clusters, brushes.count(),
                static_cast<unsigned long long>(cast), seen.size(), static_cast<unsigned long long>(baked),
                double(seen.size()) / double(baked), missing.size(), double(missing.size()) / double(seen.size()));
    for (const auto& [pair, line] : lines)
        std::fprintf(stderr, "%s: clusters %d and %d: %s\n", name ? name + 1 : path, pair.first, pair.second,
                     line.c_str());
    return double(missing.size()) > 0.0005 * double(seen.size());
}

} // namespace

int main(int argc, char** argv) {
    std::uint64_t rays = 2'000'000;
    int failed = 0;
    std::puts("map,clusters,brushes,rays,pairs_seen,pairs_baked,share_proved,seen_but_not_baked,share_of_seen");
    for (int i = 1; i < argc; ++i)
        if (i + 1 < argc && std::strcmp(argv[i], "--rays") == 0)
            rays = std::strtoull(argv[++i], nullptr, 10);
        else
            failed |= check(argv[i], rays);
    return failed;
}
