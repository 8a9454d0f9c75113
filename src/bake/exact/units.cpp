#include "bake/exact/units.hpp"

#include <algorithm>
#include <cmath>
#include <numeric>

namespace antumbra::exact {
namespace {

double half_area(const Box3f& box) {
    Vec3d d = to_double(box).size();
    return d.x * d.y + d.y * d.z + d.z * d.x;
}

Box3f box_of(const Scene& scene, std::uint32_t triangle) {
    Box3f box;
    for (std::uint32_t corner : scene.triangles()[triangle])
        box.extend(scene.positions()[corner]);
    return box;
}

Vec3d unit_normal(const Scene& scene, std::uint32_t triangle) {
    Vec3d a = scene.vertex(triangle, 0);
    Vec3d n = cross(scene.vertex(triangle, 1) - a, scene.vertex(triangle, 2) - a);
    return n * (1 / std::sqrt(dot(n, n)));
}

/// Space and directions that some triangles take up.
struct Extent {
    Box3f box;
    Box3d normals;

    /// How likely it is that they are seen, up to a factor: the surface area heuristic times the share of directions from
    /// which some of them show their front: (1 + sin a) / 2 for normals within an angle of a about a common one.
    double cost() const {
        Vec3d half = normals.size() * 0.5;
        return half_area(box) * (1 + std::min(1.0, std::sqrt(dot(half, half))));
    }
};

/// Cuts an object's triangles into parts, first half before second.
class Cutter {
  public:
    Cutter(const Scene& scene, std::uint32_t most, ClusterOrder order) : most_(most), order_(order) {
        for (std::uint32_t t = 0; t < scene.triangles().size(); ++t) {
            boxes_.push_back(box_of(scene, t));
            normals_.push_back(unit_normal(scene, t));
        }
    }

    /// `triangles` is brought into the order of the parts; `visit(part)` for each of them, from the first to the last.
    template <class Visit>
    void cut(std::span<std::uint32_t> triangles, const Visit& visit) {
        std::vector<std::span<std::uint32_t>> open = {triangles};
        while (!open.empty()) {
            std::span<std::uint32_t> part = open.back();
            open.pop_back();
            if (part.size() <= most_) {
                visit(part);
                continue;
            }
            std::size_t at = order_ == ClusterOrder::file ? cheapest(part).first : halve(part);
            open.push_back(part.subspan(at)); // the lower half comes off first
            open.push_back(part.first(at));
        }
    }

  private:
    /// Where to cut the sequence, and what that costs.
    std::pair<std::size_t, double> cheapest(std::span<const std::uint32_t> part) {
        std::size_t n = part.size();
        right_.assign(n + 1, 0);
        Extent extent;
        for (std::size_t i = n; i > 0; --i) {
            extend(extent, part[i - 1]);
            right_[i - 1] = extent.cost() * double(n - i + 1);
        }
        // A cut close to an end would make slivers of the tree: keep at least an eighth on either side.
        std::size_t least = std::max<std::size_t>(1, n / 8), best = n / 2;
        double best_cost = -1;
        extent = {};
        for (std::size_t i = 1; i < n; ++i) {
            extend(extent, part[i - 1]);
            double cost = extent.cost() * double(i) + right_[i];
            if (i >= least && i <= n - least && (best_cost < 0 || cost < best_cost)) {
                best = i;
                best_cost = cost;
            }
        }
        return {best, best_cost};
    }

    void extend(Extent& extent, std::uint32_t t) const {
        extent.box.extend(boxes_[t]);
        extent.normals.extend(normals_[t]);
    }

    /// Sorts the part along the axis, of space or of normals, or by the order of the file, on which it can be cut at the least cost,
    /// and tells where.
    std::size_t halve(std::span<std::uint32_t> part) {
        std::vector<std::uint32_t> sorted(part.begin(), part.end()), best;
        std::size_t best_at = 0;
        double best_cost = -1;
        for (int axis = 0; axis < 7; ++axis) {
            auto place = [&](std::uint32_t t) {
                return axis < 3   ? double(boxes_[t].min[axis]) + double(boxes_[t].max[axis])
                       : axis < 6 ? normals_[t][axis - 3]
                                  : double(t);
            };
            std::sort(sorted.begin(), sorted.end(), [&](std::uint32_t a, std::uint32_t b) {
                double x = place(a), y = place(b);
                return x != y ? x < y : a < b;
            });
            auto [at, cost] = cheapest(sorted);
            if (best.empty() || cost < best_cost) {
                best = sorted;
                best_at = at;
                best_cost = cost;
            }
        }
        std::copy(best.begin(), best.end(), part.begin());
        return best_at;
    }

    std::uint32_t most_;
    ClusterOrder order_;
    std::vector<Box3f> boxes_;
    std::vector<Vec3d> normals_;
    std::vector<double> right_;
};

} // namespace

Units Units::from_numbers(std::vector<std::uint32_t> of) {
    Units units;
    units.of = std::move(of);
    std::uint32_t count = 0;
    for (std::uint32_t unit : units.of)
        count = std::max(count, unit + 1);
    units.first.assign(std::size_t(count) + 1, 0);
    for (std::uint32_t unit : units.of)
        ++units.first[unit + 1];
    std::partial_sum(units.first.begin(), units.first.end(), units.first.begin());
    units.order.resize(units.of.size());
    std::vector<std::uint32_t> next(units.first);
    for (std::uint32_t t = 0; t < units.of.size(); ++t)
        units.order[next[units.of[t]]++] = t;
    return units;
}

Units Units::objects(const Scene& scene) {
    Units units = from_numbers({scene.triangle_objects().begin(), scene.triangle_objects().end()});
    units.first.resize(scene.objects().size() + 1, static_cast<std::uint32_t>(scene.triangles().size()));
    return units;
}

Units Units::triangles(const Scene& scene) {
    std::vector<std::uint32_t> of(scene.triangles().size());
    std::iota(of.begin(), of.end(), 0u);
    return from_numbers(std::move(of));
}

Units Units::clusters(const Scene& scene, std::uint32_t most, ClusterOrder order) {
    Cutter cutter(scene, std::max(1u, most), order);
    std::vector<std::uint32_t> triangles(scene.triangles().size()), of(triangles.size());
    std::iota(triangles.begin(), triangles.end(), 0u);
    std::uint32_t unit = 0;
    for (const Object& object : scene.objects())
        cutter.cut(std::span(triangles).subspan(object.first_triangle, object.triangle_count),
                   [&](std::span<const std::uint32_t> part) {
                       for (std::uint32_t t : part)
                           of[t] = unit;
                       unit += !part.empty();
                   });
    return from_numbers(std::move(of));
}

Units Units::make(const Scene& scene, const ExactOptions& options) {
    switch (options.granularity) {
    case Granularity::triangle:
        return triangles(scene);
    case Granularity::cluster:
        return clusters(scene, options.cluster_triangles, options.cluster_order);
    case Granularity::object:
        break;
    }
    return objects(scene);
}

} // namespace antumbra::exact
