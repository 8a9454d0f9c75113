#include "bake/sampled/region_sampler.hpp"

#include "bake/keys.hpp"
#include "bake/viewpoint.hpp"
#include "base/random.hpp"

#include <algorithm>
#include <bit>

namespace antumbra {
namespace {

constexpr std::uint32_t kRaysPerViewpoint = 32;
constexpr std::uint32_t kKeptRaysPerViewpoint = 8;
constexpr std::uint32_t kSolidAfterAttempts = 256;
constexpr std::uint32_t kAttemptsPerViewpoint = 8;

/// Streams of one region.
enum Stream : std::uint32_t { kViewpoints, kDirections, kAimed, kHoldout, kGuided, kVolumes };

constexpr unsigned kBuckets = PriorKnowledge::kBuckets;
constexpr double kRoughWeight = 8;
/// How often guided sampling aims at a neighbour of something seen, and how often it looks anywhere instead.
constexpr std::size_t kGuidedTries = 4;
constexpr std::uint32_t kGuidedUniformEvery = 32;
/// Rays that an object gets however unlikely it is to be visible.
constexpr std::uint32_t kFewestAimedRays = 4;

} // namespace

SamplingScene::SamplingScene(const Tracer& tracer, const BakeOptions& options)
    : tracer_(tracer), options_(options), sequential_(options.sequential), volumes_(tracer.scene(), options.volumes) {
    if (options.sampling == Sampling::guided)
        neighbours_.emplace(scene());
    area_until_.resize(scene().triangles().size());
    for (const Object& object : scene().objects()) {
        double sum = 0;
        for (std::uint32_t t = object.first_triangle; t < object.first_triangle + object.triangle_count; ++t) {
            Vec3d a = scene().vertex(t, 0);
            sum += length(cross(scene().vertex(t, 1) - a, scene().vertex(t, 2) - a));
            area_until_[t] = sum;
        }
    }
}

Vec3d SamplingScene::surface_point(std::uint32_t index, double pick, double u, double v) const {
    const Object& object = scene().objects()[index];
    auto first = area_until_.begin() + object.first_triangle;
    auto last = first + object.triangle_count;
    auto chosen = std::min(std::upper_bound(first, last, pick * *(last - 1)), last - 1);
    auto triangle = static_cast<std::uint32_t>(chosen - area_until_.begin());
    if (u + v > 1) {
        u = 1 - u;
        v = 1 - v;
    }
    Vec3d a = scene().vertex(triangle, 0);
    return a + (scene().vertex(triangle, 1) - a) * u + (scene().vertex(triangle, 2) - a) * v;
}

void RayCache::add(const Ray& ray, std::span<const std::uint32_t> seen) {
    entries.push_back({ray, std::uint32_t(triangles.size()), std::uint32_t(seen.size())});
    triangles.insert(triangles.end(), seen.begin(), seen.end());
}

RegionSampler::RegionSampler(const SamplingScene& shared, const SamplingRegion& region, std::uint64_t key)
    : shared_(shared), tracer_(shared.tracer()), scene_(shared.scene()), arbiter_(shared.tracer()), region_(region),
      key_(key), positions_(shared.options().seed, key, kViewpoints),
      directions_(shared.options().seed, key, kDirections) {
    sample_.visible.assign(shared.words(), 0);
    proposed_.assign(shared.words(), 0);
    for (std::uint32_t o = 0; o < scene_.objects().size(); ++o)
        if (scene_.objects()[o].has(kAlwaysVisible))
            set(o);
}

void RegionSampler::set(std::uint32_t object) { sample_.visible[object / 64] |= std::uint64_t(1) << (object % 64); }

bool RegionSampler::check_viewpoint(const Vec3d& point) {
    sample_.rays += 3; // what is_viewpoint costs at the least
    return is_viewpoint(tracer_, point);
}

bool RegionSampler::has_viewpoint() {
    ensure_viewpoints(1);
    return !viewpoints_.empty();
}

void RegionSampler::ensure_viewpoints(std::size_t wanted) {
    std::size_t most = std::max<std::size_t>(kSolidAfterAttempts, wanted * kAttemptsPerViewpoint);
    for (; viewpoints_.size() < wanted && attempts_ < most; ++attempts_) {
        if (viewpoints_.empty() && attempts_ >= kSolidAfterAttempts)
            return;
        Vec3d point = uniform_point(region_.space(), positions_);
        if (check_viewpoint(point))
            viewpoints_.push_back(point);
    }
}

void RegionSampler::record(const Ray& ray, std::span<const std::uint32_t> triangles) {
    for (std::uint32_t triangle : triangles) {
        std::uint32_t object = scene_.triangle_objects()[triangle];
        if (seen(object))
            continue;
        proposed_[object / 64] |= std::uint64_t(1) << (object % 64);
        if (arbiter_.sees(ray.origin, ray.origin + ray.direction, triangle) == Verdict::clear) {
            set(object);
            ++sample_.confirmed;
        }
    }
}

void RegionSampler::cast(const Ray& ray) {
    ++sample_.rays;
    hits_.clear();
    Hit hit = tracer_.seen(ray, hits_);
    record(ray, hits_);
    record_volumes(ray, hit.t);
}

void RegionSampler::record_volumes(const Ray& ray, double end) {
    if (shared_.volumes().count() == 0)
        return;
    auto first = std::uint32_t(scene_.objects().size());
    shared_.volumes().walk(ray, end, [&](std::uint64_t volume, const Vec3d& middle) {
        std::uint32_t bit = first + std::uint32_t(volume);
        if (!seen(bit) && arbiter_.segment(ray.origin, middle) == Verdict::clear)
            set(bit);
    });
}

void RegionSampler::aim_at_unseen_volumes() {
    auto first = std::uint32_t(scene_.objects().size());
    std::uint32_t give_up = shared_.sequential().misses_to_give_up();
    for (std::uint32_t volume = 0; volume < shared_.volumes().count(); ++volume) {
        Random random(shared_.options().seed, key_ ^ mix_bits(volume + 1), kVolumes);
        for (std::uint32_t r = 0; r < give_up && !seen(first + volume); ++r) {
            const Vec3d& from = viewpoints_[random.below(std::uint32_t(viewpoints_.size()))];
            double u = random.uniform(), v = random.uniform(), w = random.uniform();
            Vec3d direction = shared_.volumes().point_in(volume, u, v, w) - from;
            if (!(dot(direction, direction) > 0) || !region_.holds_direction(direction))
                continue;
            cast({from, direction});
            ++sample_.aimed_rays;
        }
    }
}

void RegionSampler::adopt(const RayCache& cache) {
    for (const RayCache::Entry& entry : cache.entries) {
        record(entry.ray, cache.seen(entry));
        if (viewpoints_.empty() || !(viewpoints_.back() == entry.ray.origin))
            viewpoints_.push_back(entry.ray.origin);
    }
}

void RegionSampler::look_around(std::uint32_t count, RayCache* keep) {
    if (!has_viewpoint())
        return;
    // Kept rays measure where things are seen from: they need many origins.
    ensure_viewpoints(viewpoints_.size() + count / (keep ? kKeptRaysPerViewpoint : kRaysPerViewpoint));
    // Rays from one viewpoint follow each other: they share the top of the tree in the caches.
    std::uint32_t per_viewpoint = std::max(1u, count / std::uint32_t(viewpoints_.size()));
    for (std::uint32_t r = 0; r < count; ++r) {
        Ray ray{viewpoints_[looked_++ / per_viewpoint % viewpoints_.size()], uniform_direction(region_, directions_)};
        cast(ray);
        if (keep)
            keep->add(ray, hits_);
    }
}

void RegionSampler::look_guided(std::uint32_t count) {
    if (!has_viewpoint())
        return;
    ensure_viewpoints(viewpoints_.size() + count / kRaysPerViewpoint);
    struct Candidate {
        std::uint32_t object;
        Vec3d from;
    };
    // Candidates by how often they were tried; the first in the least tried list is next.
    std::vector<Candidate> lists[kGuidedTries];
    std::size_t next[kGuidedTries] = {};
    std::vector<bool> expanded(scene_.objects().size());
    Random random(shared_.options().seed, key_, kGuided);
    auto expand = [&](const Vec3d& from) {
        for (std::uint32_t triangle : hits_) {
            std::uint32_t object = scene_.triangle_objects()[triangle];
            if (expanded[object])
                continue;
            expanded[object] = true;
            for (std::uint32_t neighbour : shared_.neighbours()->of(object))
                if (!seen(neighbour) && scene_.objects()[neighbour].triangle_count > 0)
                    lists[0].push_back({neighbour, from});
        }
    };
    auto anywhere = [&] {
        Ray ray{viewpoints_[random.below(std::uint32_t(viewpoints_.size()))], uniform_direction(region_, random)};
        cast(ray);
        expand(ray.origin);
    };
    for (std::uint32_t r = 0; r < count; ++r) {
        std::size_t tries = 0;
        while (tries < kGuidedTries && next[tries] == lists[tries].size())
            ++tries;
        if (tries == kGuidedTries || r % kGuidedUniformEvery == 0) {
            anywhere();
            continue;
        }
        Candidate candidate = lists[tries][next[tries]++];
        if (seen(candidate.object)) {
            --r; // nothing was cast
            continue;
        }
        double pick = random.uniform(), u = random.uniform(), v = random.uniform();
        Vec3d direction = shared_.surface_point(candidate.object, pick, u, v) - candidate.from;
        if (!(dot(direction, direction) > 0) || !region_.holds_direction(direction))
            continue;
        cast({candidate.from, direction});
        expand(candidate.from);
        if (!seen(candidate.object) && tries + 1 < kGuidedTries)
            lists[tries + 1].push_back({candidate.object, viewpoints_[random.below(std::uint32_t(viewpoints_.size()))]});
    }
}

/// Objects of like apparent size: by powers of two of size over distance.
unsigned RegionSampler::bucket_of(std::uint32_t object) const {
    Box3d box = to_double(scene_.objects()[object].bounds);
    Vec3d apart = box.centre() - region_.space().centre();
    double size = dot(box.size(), box.size()), distance = dot(apart, apart);
    int exponent = 0;
    std::frexp(distance > 0 ? size / distance : 1e30, &exponent); // of the square: half powers of two
    return unsigned(std::clamp(exponent + 24, 0, int(kBuckets) - 1));
}

/// The two pseudo-counts keep the odds finite.
std::array<double, PriorKnowledge::kBuckets> RegionSampler::rough_odds() const {
    std::array<double, PriorKnowledge::kBuckets> visible, hidden;
    visible.fill(1);
    hidden.fill(1);
    for (std::uint32_t o = 0; o < scene_.objects().size(); ++o)
        (seen(o) ? visible : hidden)[bucket_of(o)] += 1;
    for (std::size_t b = 0; b < visible.size(); ++b)
        visible[b] /= hidden[b];
    return visible;
}

void RegionSampler::aim_at_unseen(PriorKnowledge& knowledge) {
    if (!has_viewpoint())
        return;
    ensure_viewpoints(kRaysPerViewpoint);
    const BakeOptions& options = shared_.options();
    std::array<double, PriorKnowledge::kBuckets> rough{};
    if (options.informed_prior)
        rough = rough_odds();
    std::span<const Object> objects = scene_.objects();
    for (std::uint32_t o = 0; o < objects.size(); ++o) {
        if (objects[o].triangle_count == 0 || seen(o) || !may_look_at(region_, to_double(objects[o].bounds)))
            continue;
        std::uint32_t give_up = shared_.sequential().misses_to_give_up();
        unsigned bucket = options.informed_prior ? bucket_of(o) : 0;
        if (options.informed_prior) {
            // What looking around found weighs as much as kRoughWeight objects that went through the test.
            double odds = (knowledge.found[bucket] + kRoughWeight * rough[bucket]) /
                          (knowledge.given_up[bucket] + kRoughWeight);
            give_up = std::max(kFewestAimedRays, shared_.sequential().misses_to_give_up(odds));
        }
        Random random(options.seed, key_ ^ object_key(objects[o].id), kAimed);
        // Draws outside the angles are no samples; an object mostly outside of them ends by the count of draws.
        std::uint32_t misses = 0, most_draws = give_up * 16;
        for (std::uint32_t draw = 0; draw < most_draws && misses < give_up && !seen(o); ++draw) {
            const Vec3d& from = viewpoints_[random.below(std::uint32_t(viewpoints_.size()))];
            double pick = random.uniform(), u = random.uniform(), v = random.uniform();
            Vec3d direction = shared_.surface_point(o, pick, u, v) - from;
            if (!(dot(direction, direction) > 0) || !region_.holds_direction(direction))
                continue;
            cast({from, direction});
            ++sample_.aimed_rays;
            ++misses;
        }
        if (!seen(o))
            sample_.fewest_aimed = std::min(sample_.fewest_aimed, misses);
        (seen(o) ? knowledge.found : knowledge.given_up)[bucket] += 1;
    }
    aim_at_unseen_volumes();
}

void RegionSampler::measure_misses(std::uint32_t count) {
    Random random(shared_.options().seed, key_, kHoldout);
    std::vector<Ray> misses;
    for (std::uint64_t attempt = 0;
         sample_.holdout_rays < count && attempt < std::uint64_t(count) * kAttemptsPerViewpoint; ++attempt) {
        Ray ray{uniform_point(region_.space(), random), uniform_direction(region_, random)};
        if (!check_viewpoint(ray.origin))
            continue;
        ++sample_.holdout_rays;
        ++sample_.rays;
        hits_.clear();
        tracer_.seen(ray, hits_);
        bool miss = std::any_of(hits_.begin(), hits_.end(), [&](std::uint32_t triangle) {
            return !seen(scene_.triangle_objects()[triangle]);
        });
        if (miss) {
            ++sample_.holdout_misses;
            misses.push_back(ray);
        }
    }
    for (const Ray& ray : misses)
        cast(ray);
}

void RegionSampler::run_all() {
    const BakeOptions& options = shared_.options();
    if (!has_viewpoint())
        return;
    if (options.sampling == Sampling::guided)
        look_guided(options.rays_per_cell);
    else
        look_around(options.rays_per_cell);
    PriorKnowledge knowledge;
    aim_at_unseen(knowledge);
    measure_misses(options.holdout_rays);
}

RegionSample RegionSampler::finish() && {
    sample_.solid = !has_viewpoint();
    if (sample_.solid)
        sample_.visible.clear();
    for (std::size_t w = 0; w < sample_.visible.size(); ++w)
        sample_.unconfirmed += std::uint32_t(std::popcount(proposed_[w] & ~sample_.visible[w]));
    return std::move(sample_);
}

} // namespace antumbra
