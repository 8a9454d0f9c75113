#include "bake/sampled/view_tree_builder.hpp"

#include "bake/keys.hpp"

#include <algorithm>
#include <bit>
#include <cmath>
#include <map>
#include <utility>

namespace antumbra {
namespace {

constexpr std::size_t kCandidatesPerAxis = 64;

std::uint64_t region_key(const ViewRegion& box) {
    std::uint64_t key = cell_key(box.space());
    if (box.whole_sphere())
        return key;
    for (int axis : {int(kAxisTheta), int(kAxisPhi)}) {
        key = mix_bits(key + std::bit_cast<std::uint64_t>(box.min[std::size_t(axis)] + 0.0));
        key = mix_bits(key + std::bit_cast<std::uint64_t>(box.max[std::size_t(axis)] + 0.0));
    }
    return key;
}

ViewPoint5 coordinates(const Ray& ray) {
    auto [theta, phi] = view_angles(ray.direction);
    return {ray.origin.x, ray.origin.y, ray.origin.z, theta, phi};
}

double power(double base, std::uint32_t exponent) {
    double result = 1;
    for (; exponent; exponent >>= 1, base *= base)
        if (exponent & 1)
            result *= base;
    return result;
}

struct Split {
    int axis = -1;
    double plane = 0;
    double effectiveness = 0;
};

/// What the cached rays of a node saw, per object: the range of coordinates from which it was seen along each axis.
class RoughVisibility {
  public:
    RoughVisibility(const Scene& scene, const RayCache& cache)
        : rays_(cache.entries.size()), index_(scene.objects().size(), kNone) {
        for (const RayCache::Entry& entry : cache.entries) {
            ViewPoint5 at = coordinates(entry.ray);
            for (std::uint32_t triangle : cache.seen(entry)) {
                std::uint32_t object = scene.triangle_objects()[triangle];
                if (index_[object] == kNone) {
                    index_[object] = std::uint32_t(ranges_.size());
                    ranges_.push_back({at, at, 0});
                    triangles_ += scene.objects()[object].source_triangles;
                }
                Range& range = ranges_[index_[object]];
                ++range.rays;
                for (std::size_t axis = 0; axis < kViewAxes; ++axis) {
                    range.low[axis] = std::min(range.low[axis], at[axis]);
                    range.high[axis] = std::max(range.high[axis], at[axis]);
                }
            }
        }
        std::map<std::uint32_t, std::uint32_t> histogram;
        for (const Range& range : ranges_)
            ++histogram[range.rays];
        objects_by_rays_.assign(histogram.begin(), histogram.end());
    }
    std::size_t objects() const { return ranges_.size(); }
    std::size_t rays() const { return rays_; }
    std::uint64_t triangles() const { return triangles_; }

    /// How many objects would be seen from both sides by chance alone if the plane, with the share `below` of the rays
    /// on its lower side, separated nothing: an object that n rays saw is on one side only with probability
    /// below^n + (1-below)^n. Few rays make every plane look effective; this is what to measure against.
    double expected_by_both(double below) const {
        double expected = 0;
        for (auto [rays, objects] : objects_by_rays_)
            expected += objects * (1 - power(below, rays) - power(1 - below, rays));
        return expected;
    }
    /// Share of the cached rays below each plane.
    static double share_below(const std::vector<double>& sorted, double plane) {
        auto below = std::lower_bound(sorted.begin(), sorted.end(), plane) - sorted.begin();
        return double(below) / double(std::max<std::size_t>(sorted.size(), 1));
    }

    /// Objects seen from both sides of each plane; planes ascending.
    std::vector<std::size_t> seen_by_both(int axis, const std::vector<double>& planes) const {
        // An object is seen from both sides of the planes in (low, high]: count where those runs begin and end.
        std::vector<std::size_t> begins(planes.size() + 1), ends(planes.size() + 1), both(planes.size());
        for (const Range& range : ranges_) {
            auto after = [&](double value) {
                return std::size_t(std::upper_bound(planes.begin(), planes.end(), value) - planes.begin());
            };
            ++begins[after(range.low[std::size_t(axis)])];
            ++ends[after(range.high[std::size_t(axis)])];
        }
        std::size_t open = 0;
        for (std::size_t p = 0; p < planes.size(); ++p) {
            open += begins[p];
            open -= ends[p];
            both[p] = open;
        }
        return both;
    }

  private:
    static constexpr std::uint32_t kNone = ~0u;
    struct Range {
        ViewPoint5 low, high;
        std::uint32_t rays; ///< that saw the object
    };
    std::size_t rays_;
    std::vector<std::pair<std::uint32_t, std::uint32_t>> objects_by_rays_; ///< (rays, objects seen by so many)
    std::vector<std::uint32_t> index_;
    std::vector<Range> ranges_;
    std::uint64_t triangles_ = 0;
};

class Builder {
  public:
    Builder(const SamplingScene& shared, const ViewRegion& tile)
        : shared_(shared), scene_(shared.scene()), options_(shared.options().tree) {
        grow(tile, RayCache(), 0);
    }
    BuiltTree take() { return std::move(tree_); }

  private:
    /// Adds the node of `box` and all below it; returns its index.
    std::uint32_t grow(const ViewRegion& box, RayCache cache, std::uint32_t depth) {
        auto index = std::uint32_t(tree_.nodes.size());
        tree_.nodes.emplace_back();
        RegionSampler sampler(shared_, box, region_key(box));
        std::size_t inherited = std::min<std::size_t>(cache.entries.size(), options_.node_rays);
        tree_.rays_reused += inherited;
        sampler.adopt(cache);
        sampler.look_around(options_.node_rays - std::uint32_t(inherited), &cache);
        Split split;
        if (depth < options_.max_depth && sampler.has_viewpoint())
            split = choose(box, cache);
        if (split.axis < 0) {
            finish_leaf(index, box, sampler, cache, depth);
            return index;
        }
        // The rays cast here count here; the children begin with them.
        rays_above_ += std::move(sampler).finish().rays;
        divide(index, box, split, std::move(cache), depth);
        return index;
    }

    void divide(std::uint32_t index, const ViewRegion& box, const Split& split, RayCache cache, std::uint32_t depth) {
        tree_.nodes[index].axis = split.axis;
        tree_.nodes[index].split = split.plane;
        RayCache halves[2];
        for (const RayCache::Entry& entry : cache.entries)
            halves[coordinates(entry.ray)[std::size_t(split.axis)] >= split.plane].add(entry.ray, cache.seen(entry));
        cache = {};
        ViewRegion below = box, above = box;
        below.max[std::size_t(split.axis)] = above.min[std::size_t(split.axis)] = split.plane;
        std::uint32_t first = grow(below, std::move(halves[0]), depth + 1);
        std::uint32_t second = grow(above, std::move(halves[1]), depth + 1);
        tree_.nodes[index].children[0] = first;
        tree_.nodes[index].children[1] = second;
    }

    void finish_leaf(std::uint32_t index, const ViewRegion& box, RegionSampler& sampler, RayCache& cache,
                     std::uint32_t depth) {
        // The paper's experimental setting: spatial splits, then each leaf cut into eight headings.
        if (options_.subdivision == Subdivision::angular && box.extent(kAxisTheta) > 0.5 && sampler.has_viewpoint()) {
            rays_above_ += std::move(sampler).finish().rays;
            double middle = (box.min[kAxisTheta] + box.max[kAxisTheta]) / 2;
            divide(index, box, {kAxisTheta, middle, 1}, std::move(cache), std::max(depth, options_.max_depth)); // no more
            return;
        }
        std::uint32_t wanted = shared_.options().rays_per_cell;
        sampler.look_around(wanted - std::min(wanted, std::uint32_t(cache.entries.size())));
        sampler.aim_at_unseen();
        sampler.measure_misses(shared_.options().holdout_rays);
        RegionSample sample = std::move(sampler).finish();
        sample.rays += std::exchange(rays_above_, 0);
        tree_.nodes[index].leaf = std::uint32_t(tree_.leaves.size());
        tree_.leaves.push_back(std::move(sample));
    }

    Split choose(const ViewRegion& box, const RayCache& cache) const {
        RoughVisibility rough(scene_, cache);
        Split best;
        if (rough.objects() == 0 || rough.triangles() < options_.min_visible)
            return best;
        int axes = options_.subdivision == Subdivision::five ? int(kViewAxes) : 3;
        for (int axis = 0; axis < axes; ++axis) {
            std::vector<double> planes = axis < 3 ? spatial_candidates(box, axis) : angular_candidates(box, axis);
            std::vector<std::size_t> both = rough.seen_by_both(axis, planes);
            std::vector<double> sorted;
            for (const RayCache::Entry& entry : cache.entries)
                sorted.push_back(coordinates(entry.ray)[std::size_t(axis)]);
            std::sort(sorted.begin(), sorted.end());
            for (std::size_t p = 0; p < planes.size(); ++p) {
                double below = planes[p] - box.min[std::size_t(axis)], above = box.max[std::size_t(axis)] - planes[p];
                double seen = options_.estimate == SplitEstimate::published
                                  ? double(rough.objects())
                                  : rough.expected_by_both(RoughVisibility::share_below(sorted, planes[p]));
                if (!(seen > 0))
                    continue;
                double effectiveness = split_effectiveness(double(both[p]), seen, below, above);
                if (effectiveness > best.effectiveness)
                    best = {axis, planes[p], effectiveness};
            }
        }
        return best.effectiveness > options_.effectiveness ? best : Split{};
    }

    /// Planes of the bounding boxes of objects that reach into the node, thinned evenly.
    std::vector<double> spatial_candidates(const ViewRegion& box, int axis) const {
        double low = box.min[std::size_t(axis)], high = box.max[std::size_t(axis)];
        double step = scene_.step();
        double margin = options_.min_extent * options_.view_space * double(scene_.local_bounds().size()[axis]);
        std::vector<double> planes;
        Box3d space = box.space();
        for (const Object& object : scene_.objects()) {
            Box3d bounds = to_double(object.bounds);
            if (!bounds.overlaps(space))
                continue;
            for (double side : {bounds.min[axis], bounds.max[axis]}) {
                double plane = std::floor(side / step + 0.5) * step;
                if (plane >= low + margin && plane <= high - margin && plane > low && plane < high)
                    planes.push_back(plane);
            }
        }
        // Half way always: a node without objects inside may still see different things from its ends.
        if (high - low > 2 * margin)
            planes.push_back(std::floor((low + high) / 2 / step) * step);
        std::sort(planes.begin(), planes.end());
        planes.erase(std::unique(planes.begin(), planes.end()), planes.end());
        if (planes.size() > kCandidatesPerAxis) {
            std::vector<double> thinned;
            for (std::size_t i = 0; i < kCandidatesPerAxis; ++i)
                thinned.push_back(planes[i * planes.size() / kCandidatesPerAxis]);
            planes = std::move(thinned);
        }
        return planes;
    }

    /// Regular positions: eighths of a turn; quarters of the sine.
    static std::vector<double> angular_candidates(const ViewRegion& box, int axis) {
        std::vector<double> planes;
        for (double plane = -1; plane < 4; plane += 0.5)
            if (plane > box.min[std::size_t(axis)] && plane < box.max[std::size_t(axis)])
                planes.push_back(plane);
        return planes;
    }

    const SamplingScene& shared_;
    const Scene& scene_;
    const ViewTreeOptions& options_;
    BuiltTree tree_;
    std::uint64_t rays_above_ = 0; ///< cast in inner nodes since the last leaf
};

} // namespace

BuiltTree build_view_tree(const SamplingScene& shared, const ViewRegion& tile) { return Builder(shared, tile).take(); }

} // namespace antumbra
