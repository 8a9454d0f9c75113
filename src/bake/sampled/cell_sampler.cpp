#include "bake/sampled/cell_sampler.hpp"

#include "bake/keys.hpp"
#include "bake/viewpoint.hpp"
#include "base/random.hpp"

#include <algorithm>
#include <bit>

namespace antumbra {
namespace {

constexpr std::uint32_t kRaysPerViewpoint = 32;
constexpr std::uint32_t kSolidAfterAttempts = 256;
constexpr std::uint32_t kAttemptsPerViewpoint = 8;

/// Streams of one cell.
enum Stream : std::uint32_t { kViewpoints, kDirections, kAimed, kHoldout };

Vec3d uniform_point(const Box3d& box, Random& random) {
    Vec3d point;
    for (int k = 0; k < 3; ++k)
        point[k] = random.uniform(box.min[k], box.max[k]);
    return point;
}

/// Uniform on the sphere, of length at most 1: by rejection from the cube, so that no libm function is involved.
Vec3d uniform_direction(Random& random) {
    for (;;) {
        Vec3d d{random.uniform(-1, 1), random.uniform(-1, 1), random.uniform(-1, 1)};
        double squared = dot(d, d);
        if (squared <= 1 && squared > 1e-6)
            return d;
    }
}

} // namespace

CellSampler::CellSampler(const Tracer& tracer, const BakeOptions& options)
    : tracer_(tracer), scene_(tracer.scene()), options_(options) {
    area_until_.resize(scene_.triangles().size());
    for (const Object& object : scene_.objects()) {
        double sum = 0;
        for (std::uint32_t t = object.first_triangle; t < object.first_triangle + object.triangle_count; ++t) {
            Vec3d a = scene_.vertex(t, 0);
            sum += length(cross(scene_.vertex(t, 1) - a, scene_.vertex(t, 2) - a));
            area_until_[t] = sum;
        }
    }
}

Vec3d CellSampler::surface_point(std::uint32_t index, double pick, double u, double v) const {
    const Object& object = scene_.objects()[index];
    auto first = area_until_.begin() + object.first_triangle;
    auto last = first + object.triangle_count;
    auto chosen = std::min(std::upper_bound(first, last, pick * *(last - 1)), last - 1);
    auto triangle = static_cast<std::uint32_t>(chosen - area_until_.begin());
    if (u + v > 1) {
        u = 1 - u;
        v = 1 - v;
    }
    Vec3d a = scene_.vertex(triangle, 0);
    return a + (scene_.vertex(triangle, 1) - a) * u + (scene_.vertex(triangle, 2) - a) * v;
}

/// The state of one cell under way.
class CellSampler::Work {
  public:
    Work(const CellSampler& sampler, const Box3d& cell)
        : sampler_(sampler), tracer_(sampler.tracer_), arbiter_(sampler.tracer_), options_(sampler.options_),
          box_{sampler.scene_.to_local(cell.min), sampler.scene_.to_local(cell.max)}, key_(cell_key(cell)) {}

    CellSample run() {
        find_viewpoints();
        if (viewpoints_.empty()) {
            sample_.solid = true;
            return std::move(sample_);
        }
        std::size_t words = (sampler_.scene_.objects().size() + 63) / 64;
        sample_.visible.assign(words, 0);
        proposed_.assign(words, 0);
        for (std::uint32_t o = 0; o < sampler_.scene_.objects().size(); ++o)
            if (sampler_.scene_.objects()[o].has(kAlwaysVisible))
                set(o);
        look_around();
        look_at_unseen_objects();
        measure_misses();
        for (std::size_t w = 0; w < words; ++w)
            sample_.unconfirmed += std::uint32_t(std::popcount(proposed_[w] & ~sample_.visible[w]));
        return std::move(sample_);
    }

  private:
    bool seen(std::uint32_t object) const { return sample_.visible[object / 64] >> (object % 64) & 1; }
    void set(std::uint32_t object) { sample_.visible[object / 64] |= std::uint64_t(1) << (object % 64); }

    bool check_viewpoint(const Vec3d& point) {
        sample_.rays += 3; // what is_viewpoint costs at the least
        return is_viewpoint(tracer_, point);
    }

    void find_viewpoints() {
        Random random(options_.seed, key_, kViewpoints);
        std::uint32_t wanted = std::max(1u, options_.rays_per_cell / kRaysPerViewpoint);
        std::uint32_t most = std::max(kSolidAfterAttempts, wanted * kAttemptsPerViewpoint);
        for (std::uint32_t attempt = 0; attempt < most && viewpoints_.size() < wanted; ++attempt) {
            if (viewpoints_.empty() && attempt >= kSolidAfterAttempts)
                return;
            Vec3d point = uniform_point(box_, random);
            if (check_viewpoint(point))
                viewpoints_.push_back(point);
        }
    }

    /// Casts one ray and proves what it sees for the first time. Counts, and does not prove, with `count_only`.
    /// Returns whether everything it saw was known.
    bool cast(const Ray& ray) {
        ++sample_.rays;
        hits_.clear();
        tracer_.seen(ray, hits_);
        bool known = true;
        for (std::uint32_t triangle : hits_) {
            std::uint32_t object = sampler_.scene_.triangle_objects()[triangle];
            if (seen(object))
                continue;
            known = false;
            proposed_[object / 64] |= std::uint64_t(1) << (object % 64);
            if (arbiter_.sees(ray.origin, ray.origin + ray.direction, triangle) == Verdict::clear) {
                set(object);
                ++sample_.confirmed;
            }
        }
        return known;
    }

    void look_around() {
        Random random(options_.seed, key_, kDirections);
        for (std::uint32_t r = 0; r < options_.rays_per_cell; ++r)
            cast({viewpoints_[r % viewpoints_.size()], uniform_direction(random)});
    }

    void look_at_unseen_objects() {
        std::span<const Object> objects = sampler_.scene_.objects();
        for (std::uint32_t o = 0; o < objects.size(); ++o) {
            if (objects[o].triangle_count == 0)
                continue;
            Random random(options_.seed, key_ ^ object_key(objects[o].id), kAimed);
            for (std::uint32_t r = 0; r < options_.rays_per_object && !seen(o); ++r) {
                const Vec3d& from = viewpoints_[random.below(std::uint32_t(viewpoints_.size()))];
                double pick = random.uniform(), u = random.uniform(), v = random.uniform();
                Vec3d direction = sampler_.surface_point(o, pick, u, v) - from;
                if (dot(direction, direction) > 0)
                    cast({from, direction});
            }
        }
    }

    /// Fresh viewpoints, one ray each, so that the rays are independent draws. What they find is added afterwards:
    /// the measured rate is that of the set before them.
    void measure_misses() {
        Random random(options_.seed, key_, kHoldout);
        std::vector<Ray> misses;
        for (std::uint32_t attempt = 0; sample_.holdout_rays < options_.holdout_rays &&
                                        attempt < options_.holdout_rays * kAttemptsPerViewpoint; ++attempt) {
            Vec3d point = uniform_point(box_, random);
            Vec3d direction = uniform_direction(random);
            if (!check_viewpoint(point))
                continue;
            ++sample_.holdout_rays;
            ++sample_.rays;
            hits_.clear();
            tracer_.seen({point, direction}, hits_);
            bool miss = false;
            for (std::uint32_t triangle : hits_)
                miss = miss || !seen(sampler_.scene_.triangle_objects()[triangle]);
            if (miss) {
                ++sample_.holdout_misses;
                misses.push_back({point, direction});
            }
        }
        for (const Ray& ray : misses)
            cast(ray);
    }

    const CellSampler& sampler_;
    const Tracer& tracer_;
    Arbiter arbiter_;
    const BakeOptions& options_;
    Box3d box_; ///< local
    std::uint64_t key_;
    CellSample sample_;
    std::vector<Vec3d> viewpoints_;
    std::vector<std::uint64_t> proposed_;
    std::vector<std::uint32_t> hits_;
};

CellSample CellSampler::sample(const Box3d& cell) const { return Work(*this, cell).run(); }

} // namespace antumbra
