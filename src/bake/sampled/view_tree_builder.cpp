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
/// Standard deviations by which a plane must separate more than chance does.
constexpr double kSignificance = 3;

std::uint64_t region_key(const SamplingRegion& box) {
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
    std::uint32_t step = 0;
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
    struct Chance {
        double expected = 0, variance = 0;
    };
    Chance seen_by_both_by_chance(double below) const {
        Chance chance;
        for (auto [rays, objects] : objects_by_rays_) {
            double both = 1 - power(below, rays) - power(1 - below, rays);
            chance.expected += objects * both;
            chance.variance += objects * both * (1 - both);
        }
        return chance;
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
    Builder(const SamplingScene& shared, const ViewTree& space, const ViewRegion& tile)
        : shared_(shared), scene_(shared.scene()), options_(shared.options().tree), space_(space) {
        grow(tile, RayCache(), 0);
    }
    BuiltTree take() { return std::move(tree_); }

  private:
    /// Coordinate of a step, as SamplingRegion has it.
    double coordinate(int axis, std::uint32_t step) const {
        if (axis == kAxisTheta)
            return double(step) * 4 / kViewSteps;
        if (axis == kAxisPhi)
            return double(step) * 2 / kViewSteps - 1;
        return space_.position(axis, step) - scene_.origin()[axis];
    }

    /// Adds the node of `box` and all below it.
    void grow(const ViewRegion& box, RayCache cache, std::uint32_t depth) {
        std::size_t index = tree_.nodes.size();
        tree_.nodes.emplace_back();
        SamplingRegion region = region_of(scene_, space_, box);
        RegionSampler sampler(shared_, region, region_key(region));
        std::size_t inherited = std::min<std::size_t>(cache.entries.size(), options_.node_rays);
        tree_.rays_reused += inherited;
        sampler.adopt(cache);
        sampler.look_around(options_.node_rays - std::uint32_t(inherited), &cache);
        Split split;
        if (sampler.has_viewpoint() && depth < options_.max_depth)
            split = choose(box, cache);
        // The paper's experimental setting: spatial splits, then each leaf cut into eight headings.
        if (split.axis < 0 && sampler.has_viewpoint() && options_.subdivision == Subdivision::angular &&
            box.high[kAxisTheta] - box.low[kAxisTheta] > kViewSteps / 8) {
            split = {kAxisTheta, (box.low[kAxisTheta] + box.high[kAxisTheta]) / 2, 1};
            depth = options_.max_depth; // and no further in space
        }
        if (split.axis < 0) {
            finish_leaf(index, sampler, cache);
            return;
        }
        rays_above_ += std::move(sampler).finish().rays; // its rays go on to the children
        divide(index, box, split, std::move(cache), depth);
    }

    void divide(std::size_t index, const ViewRegion& box, const Split& split, RayCache cache, std::uint32_t depth) {
        auto axis = std::size_t(split.axis);
        double plane = coordinate(split.axis, split.step);
        RayCache halves[2];
        for (const RayCache::Entry& entry : cache.entries)
            halves[coordinates(entry.ray)[axis] >= plane].add(entry.ray, cache.seen(entry));
        cache = {};
        ViewRegion below = box, above = box;
        below.high[axis] = above.low[axis] = split.step;
        grow(below, std::move(halves[0]), depth + 1);
        std::size_t second = tree_.nodes.size();
        grow(above, std::move(halves[1]), depth + 1);
        tree_.nodes[index] = {std::uint8_t(split.axis), std::uint16_t(split.step), std::uint32_t(second)};
    }

    void finish_leaf(std::size_t index, RegionSampler& sampler, const RayCache& cache) {
        std::uint32_t wanted = shared_.options().rays_per_cell;
        sampler.look_around(wanted - std::min(wanted, std::uint32_t(cache.entries.size())));
        sampler.aim_at_unseen(knowledge_);
        sampler.measure_misses(shared_.options().holdout_rays);
        RegionSample sample = std::move(sampler).finish();
        sample.rays += std::exchange(rays_above_, 0);
        tree_.nodes[index].link = std::uint32_t(tree_.leaves.size());
        tree_.leaves.push_back(std::move(sample));
    }

    Split choose(const ViewRegion& box, const RayCache& cache) const {
        RoughVisibility rough(scene_, cache);
        Split best;
        if (rough.objects() == 0 || rough.triangles() < options_.min_visible)
            return best;
        int axes = options_.subdivision == Subdivision::five ? int(kViewAxes) : 3;
        for (int axis = 0; axis < axes; ++axis) {
            std::vector<std::uint32_t> steps =
                axis < 3 ? spatial_candidates(box, axis) : angular_candidates(box, axis);
            std::vector<double> planes, sorted;
            for (std::uint32_t step : steps)
                planes.push_back(coordinate(axis, step));
            for (const RayCache::Entry& entry : cache.entries)
                sorted.push_back(coordinates(entry.ray)[std::size_t(axis)]);
            std::sort(sorted.begin(), sorted.end());
            std::vector<std::size_t> both = rough.seen_by_both(axis, planes);
            for (std::size_t p = 0; p < planes.size(); ++p) {
                double seen = double(rough.objects());
                if (options_.estimate == SplitEstimate::corrected) {
                    auto chance = rough.seen_by_both_by_chance(RoughVisibility::share_below(sorted, planes[p]));
                    seen = chance.expected;
                    double excess = seen - double(both[p]);
                    if (!(excess > 0 && excess * excess > kSignificance * kSignificance * chance.variance))
                        continue;
                }
                double below = double(steps[p] - box.low[std::size_t(axis)]);
                double above = double(box.high[std::size_t(axis)] - steps[p]);
                double effectiveness = split_effectiveness(double(both[p]), seen, below, above);
                if (effectiveness > best.effectiveness)
                    best = {axis, steps[p], effectiveness};
            }
        }
        return best.effectiveness > options_.effectiveness ? best : Split{};
    }

    /// Planes of the bounding boxes of objects that reach into the node, to the nearest step, thinned evenly; and the
    /// middle, since a node without objects may still see different things from its ends.
    std::vector<std::uint32_t> spatial_candidates(const ViewRegion& box, int axis) const {
        auto a = std::size_t(axis);
        auto margin = std::max(1u, std::uint32_t(options_.min_extent * kViewSteps));
        std::vector<std::uint32_t> steps;
        if (box.high[a] - box.low[a] < 2 * margin)
            return steps;
        std::uint32_t first = box.low[a] + margin, last = box.high[a] - margin;
        steps.push_back((first + last) / 2);
        Box3d space = region_of(scene_, space_, box).space();
        double start = coordinate(axis, 0), length = coordinate(axis, kViewSteps) - start;
        for (const Object& object : scene_.objects()) {
            Box3d bounds = to_double(object.bounds);
            if (!bounds.overlaps(space))
                continue;
            for (double side : {bounds.min[axis], bounds.max[axis]}) {
                double step = std::floor((side - start) / length * kViewSteps + 0.5);
                if (step >= first && step <= last)
                    steps.push_back(std::uint32_t(step));
            }
        }
        std::sort(steps.begin(), steps.end());
        steps.erase(std::unique(steps.begin(), steps.end()), steps.end());
        if (steps.size() > kCandidatesPerAxis) {
            for (std::size_t i = 0; i < kCandidatesPerAxis; ++i)
                steps[i] = steps[i * steps.size() / kCandidatesPerAxis];
            steps.resize(kCandidatesPerAxis);
        }
        return steps;
    }

    /// Regular positions: eighths of a turn, quarters of the elevation.
    static std::vector<std::uint32_t> angular_candidates(const ViewRegion& box, int axis) {
        std::uint32_t stride = axis == kAxisTheta ? kViewSteps / 8 : kViewSteps / 4;
        std::vector<std::uint32_t> steps;
        for (std::uint32_t step = stride; step < kViewSteps; step += stride)
            if (step > box.low[std::size_t(axis)] && step < box.high[std::size_t(axis)])
                steps.push_back(step);
        return steps;
    }

    const SamplingScene& shared_;
    const Scene& scene_;
    const ViewTreeOptions& options_;
    const ViewTree& space_;
    BuiltTree tree_;
    PriorKnowledge knowledge_; ///< handed on from leaf to leaf of the tile
    std::uint64_t rays_above_ = 0; ///< cast in inner nodes since the last leaf
};

} // namespace

SamplingRegion region_of(const Scene& scene, const ViewTree& space, const ViewRegion& box) {
    Box3d spatial = space.spatial_box(box);
    SamplingRegion region = SamplingRegion::all_directions({scene.to_local(spatial.min), scene.to_local(spatial.max)});
    region.min[kAxisTheta] = double(box.low[kAxisTheta]) * 4 / kViewSteps;
    region.max[kAxisTheta] = double(box.high[kAxisTheta]) * 4 / kViewSteps;
    region.min[kAxisPhi] = double(box.low[kAxisPhi]) * 2 / kViewSteps - 1;
    region.max[kAxisPhi] = double(box.high[kAxisPhi]) * 2 / kViewSteps - 1;
    return region;
}

BuiltTree build_view_tree(const SamplingScene& shared, const ViewTree& space, const ViewRegion& tile) {
    return Builder(shared, space, tile).take();
}

} // namespace antumbra
