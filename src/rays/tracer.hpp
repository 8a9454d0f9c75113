// The strict-double tracer: its answer is a pure function of the ray and the triangles, the same on every
// machine, whatever the tree above the triangles looks like.
#pragma once

#include "rays/caster.hpp"

#include <antumbra/job.hpp>
#include <antumbra/scene.hpp>

#include <memory>
#include <utility>
#include <vector>

namespace antumbra {

/// What a batch of rays saw: for ray i, as Tracer::seen() gives them.
struct SeenBatch {
    std::vector<Hit> hits;
    std::vector<std::uint32_t> triangles, begin; ///< of ray i: triangles[begin[i] .. begin[i + 1])
    std::span<const std::uint32_t> of(std::size_t i) const {
        return std::span(triangles).subspan(begin[i], begin[i + 1] - begin[i]);
    }
};

/// Keeps a reference to the scene: the scene must outlive it. Immutable and thread-safe once built.
class Tracer final : public FirstHitCaster {
  public:
    static Tracer build(const Scene& scene, const Job& job = {});
    ~Tracer() override;
    Tracer(Tracer&&) noexcept;
    Tracer& operator=(Tracer&&) noexcept;

    const Scene& scene() const;

    Hit first_hit(const Ray& ray) const;
    void first_hits(std::span<const Ray> rays, std::span<Hit> hits) const override;

    /// Appends to `triangles` one triangle of every object that the ray sees: all objects tied at the first
    /// occluding hit, and every non-occluding drawn surface at or in front of it. Sorted by object, one
    /// triangle (the nearest, ties by index) per object. Returns the first occluding hit.
    Hit seen(const Ray& ray, std::vector<std::uint32_t>& triangles) const;

    /// seen() for many rays, with the same answers. Rays that run alike should be neighbours: up to 16 of
    /// them (with nearby origins, directions within about 7 degrees) share their way through the tree, which
    /// makes pixels of a view about twice as fast; scattered rays gain nothing. So does first_hits(). No
    /// allocation once `seen` has room.
    void seen_batch(std::span<const Ray> rays, SeenBatch& seen) const;

    /// The nearest triangle of all, whatever its sides and flags: from inside solid matter it is a back face.
    /// `back` tells whether the ray met its back and the triangle is single-sided and occluding.
    Hit nearest_surface(const Ray& ray, bool& back) const;

    /// Calls visit(triangle) for every triangle whose slightly enlarged box the segment p..q touches; a
    /// superset of those that it meets, in no order. `visit` returns false to stop.
    template <class Visit>
    void for_each_near_segment(const Vec3d& p, const Vec3d& q, Visit&& visit) const {
        std::vector<std::uint32_t> found = std::move(scratch()); // taken, so that `visit` may call this again
        collect_near_segment(p, q, found);
        for (std::uint32_t triangle : found)
            if (!visit(triangle))
                break;
        scratch() = std::move(found);
    }

    /// Share of the memory: bytes of the tree.
    std::size_t memory_bytes() const;

  private:
    friend class Arbiter;
    struct Tree;
    Tracer();
    template <class List>
    void see(std::span<const Ray> rays, Hit* hits, List&& list) const;
    static std::vector<std::uint32_t>& scratch(); ///< of the calling thread
    /// Occluding triangles whose slightly enlarged boxes the points p + t * direction, 0 <= t <= end, touch.
    void collect_near_ray(const Vec3d& p, const Vec3d& direction, double end,
                          std::vector<std::uint32_t>& found) const;
    void collect_near_segment(const Vec3d& p, const Vec3d& q, std::vector<std::uint32_t>& found) const;
    std::unique_ptr<Tree> tree_;
};

} // namespace antumbra
