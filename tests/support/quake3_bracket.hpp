// The Quake III bracket: from a box inscribed in a leaf of the map, what rays see is in the exact set, and what is in the
// exact set lies in the set that the map's own compiler baked for the leaf's cluster.
//
// The compiler let only brushes hide, and took clusters for view cells: both make its set larger, so with the brushes as
// occluders beside the drawn surfaces the law must hold. Brushes are opaque solids; of them only what their own faces
// show to the outside is added, for this check alone.
#pragma once

#include "base/random.hpp"

#include <antumbra/bake.hpp>
#include <antumbra/quake3.hpp>

#include <algorithm>
#include <cmath>
#include <memory>
#include <set>
#include <string>
#include <vector>

namespace antumbra::test {

class Quake3Bracket {
  public:
    struct Counts {
        std::uint64_t cells = 0, solid = 0, sampled = 0, exact = 0, undecided = 0;
        std::uint64_t sampled_not_exact = 0; ///< breaks the lower law
        std::uint64_t surfaces = 0;          ///< exact, drawn by the world, in some leaf of the tree
        std::uint64_t baked_surfaces = 0;    ///< in the compiler's set
        std::vector<std::string> exceptions; ///< "MAP leaf L cluster C surface S": break the upper law
    };

    Quake3Bracket(const Quake3Map& map, std::string name) : map_(map.reference), name_(std::move(name)) {
        RawScene raw = map.scene;
        surfaces_ = raw.objects.size();
        add_brushes(raw);
        scene_ = std::make_unique<Scene>(std::move(Scene::create(std::move(raw))).value());
        clusters_of_.resize(surfaces_);
        for (const Quake3Reference::Leaf& leaf : map_.leaves)
            for (std::uint32_t k = leaf.first_surface; leaf.cluster >= 0 && k < leaf.first_surface + leaf.surface_count; ++k)
                if (std::int32_t object = map_.surface_objects[map_.leaf_surfaces[k]]; object >= 0)
                    clusters_of_[std::size_t(object)].insert(leaf.cluster);
        collect_leaves(0, {});
    }

    const Scene& scene() const { return *scene_; }
    std::size_t leaves() const { return open_.size(); }
    std::size_t brushes() const { return scene_->objects().size() - surfaces_; }

    /// Brackets `cells` leaves drawn at random.
    Counts check(std::uint32_t cells, std::uint64_t seed, const BakeOptions& base, const Job& job = {}) const {
        Counts counts;
        Random random(seed);
        for (std::uint32_t tries = 0; counts.cells < cells && tries < 20 * cells && !job.cancelled(); ++tries) {
            const Open& leaf = open_[random.below(std::uint32_t(open_.size()))];
            if (Box3d box = inscribed(leaf, random); !box.empty())
                check_leaf(leaf, box, base, job, counts);
        }
        return counts;
    }

  private:
    struct Side {
        Vec3d normal;
        double distance; ///< inside: dot(normal, p) >= distance
    };
    struct Open {
        std::uint32_t leaf;
        std::vector<Side> sides;
    };

    /// Convex polygon, counter-clockwise about `normal`, of a plane within all half spaces dot(n, p) <= d.
    static std::vector<Vec3d> face(const Vec3d& normal, double distance, const std::vector<Side>& behind, std::size_t self) {
        constexpr double kFar = 65536;
        int axis = 0;
        for (int k = 1; k < 3; ++k)
            if (std::abs(normal[k]) > std::abs(normal[axis]))
                axis = k;
        Vec3d u, v;
        u[(axis + 1) % 3] = 1;
        u = u - normal * dot(u, normal);
        v = cross(normal, u);
        Vec3d middle = normal * distance;
        std::vector<Vec3d> polygon = {middle - u * kFar - v * kFar, middle + u * kFar - v * kFar, middle + u * kFar + v * kFar,
                                      middle - u * kFar + v * kFar};
        for (std::size_t s = 0; s < behind.size() && !polygon.empty(); ++s) {
            if (s == self)
                continue;
            std::vector<Vec3d> kept;
            for (std::size_t i = 0; i < polygon.size(); ++i) {
                const Vec3d &a = polygon[i], &b = polygon[(i + 1) % polygon.size()];
                double at_a = dot(behind[s].normal, a) - behind[s].distance, at_b = dot(behind[s].normal, b) - behind[s].distance;
                if (at_a <= 0)
                    kept.push_back(a);
                if ((at_a < -1e-9 && at_b > 1e-9) || (at_a > 1e-9 && at_b < -1e-9))
                    kept.push_back(a + (b - a) * (at_a / (at_a - at_b)));
            }
            polygon = kept.size() < 3 ? std::vector<Vec3d>() : kept;
        }
        return polygon;
    }

    void add_brushes(RawScene& raw) const {
        constexpr std::uint32_t kSolid = 1, kTranslucent = 0x20000000;
        const Quake3Reference::Model& world = map_.models.at(0);
        for (std::uint32_t b = world.first_brush; b < world.first_brush + world.brush_count; ++b) {
            const Quake3Reference::Brush& brush = map_.brushes[b];
            std::uint32_t contents = map_.shaders[std::size_t(brush.shader)].contents;
            if (!(contents & kSolid) || (contents & kTranslucent) || brush.side_count < 4)
                continue;
            std::vector<Side> sides;
            for (std::uint32_t s = brush.first_side; s < brush.first_side + brush.side_count; ++s) {
                const Quake3Reference::Plane& plane = map_.planes[std::size_t(map_.brush_sides[s].plane)];
                bool known = std::any_of(sides.begin(), sides.end(), [&](const Side& side) {
                    return side.normal == plane.normal && side.distance == plane.distance;
                });
                if (!known)
                    sides.push_back({plane.normal, plane.distance});
            }
            RawObject object;
            object.name = "brush " + std::to_string(b);
            object.flags = kOccludes;
            object.first_triangle = std::uint32_t(raw.triangles.size());
            for (std::size_t s = 0; s < sides.size(); ++s) {
                std::vector<Vec3d> polygon = face(sides[s].normal, sides[s].distance, sides, s);
                auto first = std::uint32_t(raw.positions.size());
                raw.positions.insert(raw.positions.end(), polygon.begin(), polygon.end());
                for (std::uint32_t k = 2; k < polygon.size(); ++k)
                    raw.triangles.push_back({first, first + k - 1, first + k});
            }
            object.triangle_count = std::uint32_t(raw.triangles.size()) - object.first_triangle;
            if (object.triangle_count > 0)
                raw.objects.push_back(object);
        }
    }

    void collect_leaves(std::int32_t node, std::vector<Side> sides) {
        if (node < 0) {
            auto leaf = std::uint32_t(-1 - node);
            if (map_.leaves[leaf].cluster >= 0) {
                const Box3d& bounds = map_.leaves[leaf].bounds;
                for (int k = 0; k < 3; ++k) {
                    Vec3d up, down;
                    up[k] = 1;
                    down[k] = -1;
                    sides.push_back({up, bounds.min[k]});
                    sides.push_back({down, -bounds.max[k]});
                }
                open_.push_back({leaf, std::move(sides)});
            }
            return;
        }
        const Quake3Reference::Node& inner = map_.nodes[std::size_t(node)];
        const Quake3Reference::Plane& plane = map_.planes[std::size_t(inner.plane)];
        std::vector<Side> behind = sides;
        behind.push_back({-plane.normal, -plane.distance});
        sides.push_back({plane.normal, plane.distance});
        collect_leaves(inner.children[0], std::move(sides));
        collect_leaves(inner.children[1], std::move(behind));
    }

    /// A box within the leaf, four grid steps clear of its sides: bake() rounds it outward by up to one.
    Box3d inscribed(const Open& leaf, Random& random) const {
        const Box3d& bounds = map_.leaves[leaf.leaf].bounds;
        Box3d best;
        double best_half = 8 * scene_->step();
        for (int draw = 0; draw < 64; ++draw) {
            Vec3d centre;
            for (int k = 0; k < 3; ++k)
                centre[k] = random.uniform(bounds.min[k], bounds.max[k]);
            double half = 1e30;
            for (const Side& side : leaf.sides)
                half = std::min(half, (dot(side.normal, centre) - side.distance) /
                                          (std::abs(side.normal.x) + std::abs(side.normal.y) + std::abs(side.normal.z)));
            if (half > best_half) {
                best_half = half;
                double inner = half - 4 * scene_->step();
                best = {centre - Vec3d{inner, inner, inner}, centre + Vec3d{inner, inner, inner}};
            }
        }
        return best;
    }

    void check_leaf(const Open& leaf, const Box3d& box, const BakeOptions& base, const Job& job, Counts& counts) const {
        BakeOptions options = base;
        options.where = {box};
        options.cells = {1, 1, 1};
        options.method = "sampled";
        Result<BakeResult> sampled = bake(*scene_, options, job);
        options.method = "exact";
        Result<BakeResult> exact = bake(*scene_, options, job);
        if (!sampled || !exact || sampled->pvs.row_count == 0 || exact->pvs.row_count == 0) {
            ++counts.solid;
            return;
        }
        ++counts.cells;
        counts.undecided += exact->statistics.exact.undecided;
        std::int32_t cluster = map_.leaves[leaf.leaf].cluster;
        auto listed = [](const PvsData& pvs, std::size_t o) { return pvs.rows[o / 64] >> (o % 64) & 1; };
        for (std::size_t o = 0; o < scene_->objects().size(); ++o) {
            if (scene_->objects()[o].has(kAlwaysVisible))
                continue;
            bool seen = listed(sampled->pvs, o), is_visible = listed(exact->pvs, o);
            counts.sampled += seen;
            counts.exact += is_visible;
            counts.sampled_not_exact += seen && !is_visible;
            if (o >= surfaces_ || clusters_of_[o].empty() || scene_->objects()[o].id.primitive != 0)
                continue;
            bool baked = std::any_of(clusters_of_[o].begin(), clusters_of_[o].end(), [&](std::int32_t other) {
                return cluster == other || map_.cluster_sees(cluster, other) || map_.cluster_sees(other, cluster);
            });
            counts.baked_surfaces += baked;
            counts.surfaces += is_visible;
            if (is_visible && !baked)
                counts.exceptions.push_back(name_ + " leaf " + std::to_string(leaf.leaf) + " cluster " +
                                            std::to_string(cluster) + " surface " +
                                            std::to_string(scene_->objects()[o].id.node));
        }
    }

    const Quake3Reference& map_;
    std::string name_;
    std::unique_ptr<Scene> scene_;
    std::size_t surfaces_ = 0;
    std::vector<std::set<std::int32_t>> clusters_of_;
    std::vector<Open> open_;
};

} // namespace antumbra::test
