// The uniform sampled bake of one cell: rays in all directions, then rays aimed at what those did not find, each new
// (cell, object) pair proved by one exact segment, then rays that only measure what is still missing.
//
// Guarantee: aggressive. Source: Gotsman, Sudarsky, Fayman 1999, section 3, with fixed numbers of rays.
#pragma once

#include "rays/arbiter.hpp"

#include <antumbra/bake.hpp>

#include <vector>

namespace antumbra {

struct CellSample {
    bool solid = false;                 ///< no viewpoint was found
    std::vector<std::uint64_t> visible; ///< bit set over objects; empty when solid
    std::uint64_t rays = 0;             ///< of all kinds, probes included
    std::uint32_t confirmed = 0;        ///< pairs proved
    std::uint32_t unconfirmed = 0;      ///< pairs proposed but never proved
    std::uint32_t holdout_rays = 0, holdout_misses = 0;
};

/// What the cells of one bake share. Immutable and thread-safe; refers to the tracer.
class CellSampler {
  public:
    CellSampler(const Tracer& tracer, const BakeOptions& options);

    /// `cell` in world coordinates. A pure function of (scene, options, cell).
    CellSample sample(const Box3d& cell) const;

  private:
    class Work;
    /// A point uniform on the object's surface: of the triangle `pick` in [0,1) of the area, at (u, v).
    Vec3d surface_point(std::uint32_t object, double pick, double u, double v) const;

    const Tracer& tracer_;
    const Scene& scene_;
    BakeOptions options_;
    std::vector<double> area_until_; ///< per triangle: twice the area of its object's triangles up to and with it
};

} // namespace antumbra
