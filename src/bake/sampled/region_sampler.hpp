// Samples what is visible from one region of view space (a cell, or a box of positions and directions): rays that look
// around, rays aimed at what those did not find, and rays that only measure what is still missing. Each new
// (region, object) pair is proved by one exact segment.
//
// Guarantee: aggressive. Source: Gotsman, Sudarsky, Fayman 1999, sections 3 and 5.
#pragma once

#include "bake/sampled/neighbours.hpp"
#include "bake/sampled/sequential_test.hpp"
#include "bake/sampled/sampling_region.hpp"
#include "bake/sampled/volume_grid.hpp"
#include "rays/arbiter.hpp"

#include <antumbra/bake.hpp>

#include <array>
#include <optional>
#include <span>
#include <vector>

namespace antumbra {

/// What all regions of one bake share. Immutable and thread-safe; refers to the tracer.
class SamplingScene {
  public:
    SamplingScene(const Tracer& tracer, const BakeOptions& options);

    const Tracer& tracer() const { return tracer_; }
    const Scene& scene() const { return tracer_.scene(); }
    const BakeOptions& options() const { return options_; }
    const SequentialTest& sequential() const { return sequential_; }
    /// Empty unless options ask for guided sampling.
    const std::optional<ObjectNeighbours>& neighbours() const { return neighbours_; }
    const VolumeGrid& volumes() const { return volumes_; }
    /// Words of a row: bits of objects, then of volumes.
    std::size_t words() const { return (scene().objects().size() + volumes_.count() + 63) / 64; }
    /// A point uniform on the object's surface: on the triangle at the share `pick` of its area, at (u, v).
    Vec3d surface_point(std::uint32_t object, double pick, double u, double v) const;

  private:
    const Tracer& tracer_;
    BakeOptions options_;
    SequentialTest sequential_;
    std::optional<ObjectNeighbours> neighbours_;
    VolumeGrid volumes_;
    std::vector<double> area_until_; ///< per triangle: twice the area of its object's triangles up to and with it
};

/// Rays and what they saw, to be used again.
struct RayCache {
    struct Entry {
        Ray ray;
        std::uint32_t first = 0, count = 0; ///< into `triangles`: one per object seen
    };
    std::vector<Entry> entries;
    std::vector<std::uint32_t> triangles;

    std::span<const std::uint32_t> seen(const Entry& entry) const { return {triangles.data() + entry.first, entry.count}; }
    void add(const Ray& ray, std::span<const std::uint32_t> seen);
};

/// The answer for one region.
struct RegionSample {
    bool solid = false;                 ///< no viewpoint was found
    std::vector<std::uint64_t> visible; ///< bit set over objects, then volumes; empty when solid
    std::uint64_t rays = 0;             ///< of all kinds, probes for viewpoints included
    std::uint64_t aimed_rays = 0;
    std::uint32_t confirmed = 0;   ///< pairs proved
    std::uint32_t unconfirmed = 0; ///< pairs proposed but never proved
    std::uint32_t holdout_rays = 0, holdout_misses = 0;
    std::uint32_t fewest_aimed = ~0u; ///< rays after which some object was given up, at the least

};

/// How objects of like apparent size fared in the sequential test so far: what an informed prior learns from, and
/// refines with every object. Start from none; hand on from region to region within one unit of work.
struct PriorKnowledge {
    static constexpr std::size_t kBuckets = 32;
    std::array<double, kBuckets> found{}, given_up{};
};

/// One region under way. Not thread-safe; make one per region. A pure function of (scene, options, region, key).
class RegionSampler {
  public:
    RegionSampler(const SamplingScene& shared, const SamplingRegion& region, std::uint64_t key);

    /// Uses rays that were cast before and lie in the region, and their origins as viewpoints. Their proof happens now.
    void adopt(const RayCache& cache);
    /// Casts `count` more rays uniform over positions and directions of the region; keeps them in `keep` if given.
    void look_around(std::uint32_t count, RayCache* keep = nullptr);
    /// Spends `count` rays where something new is likely: at the neighbours of what was just seen, from where it was
    /// seen, and now and then anywhere. Needs options.sampling guided. In the manner of guided visibility sampling
    /// (Wonka et al. 2006), for objects instead of triangles.
    void look_guided(std::uint32_t count);
    /// The sequential test of every object, and every occludee volume, not seen so far. With options.informed_prior its
    /// odds begin with `knowledge`, or, where that is silent, with what looking around has found; each object adds to it.
    void aim_at_unseen(PriorKnowledge& knowledge);
    /// Casts `count` fresh rays from fresh viewpoints and counts those that see an unlisted object. What they find is
    /// listed afterwards: the measured rate is that of the set before them.
    void measure_misses(std::uint32_t count);
    /// Everything in the order that options ask for.
    void run_all();

    /// False if the region has no viewpoint: it lies in matter. Costs probes on the first call.
    bool has_viewpoint();
    bool seen(std::uint32_t object) const { return sample_.visible[object / 64] >> (object % 64) & 1; }
    RegionSample finish() &&;

  private:
    bool check_viewpoint(const Vec3d& point);
    /// Searches until there are `wanted` viewpoints, or the region looks as if it had no more.
    void ensure_viewpoints(std::size_t wanted);
    /// Traces and records. `hits_` then holds what the ray saw.
    void cast(const Ray& ray);
    void record(const Ray& ray, std::span<const std::uint32_t> triangles);
    void set(std::uint32_t object);
    /// Sets the volumes that the ray passes through before `end`, each proved by an exact segment.
    void record_volumes(const Ray& ray, double end);
    void aim_at_unseen_volumes();
    /// Odds of "visible", per bucket, from what looking around has found.
    std::array<double, PriorKnowledge::kBuckets> rough_odds() const;
    unsigned bucket_of(std::uint32_t object) const;

    const SamplingScene& shared_;
    const Tracer& tracer_;
    const Scene& scene_;
    Arbiter arbiter_;
    SamplingRegion region_; ///< local
    std::uint64_t key_;
    RegionSample sample_;
    std::vector<Vec3d> viewpoints_;
    std::uint32_t attempts_ = 0; ///< at finding viewpoints
    Random positions_;           ///< of viewpoints
    Random directions_;          ///< of look_around
    std::uint32_t looked_ = 0;
    std::vector<std::uint64_t> proposed_;
    std::vector<std::uint32_t> hits_;
};

} // namespace antumbra
