// What the rest of the toolkit asks of a ray engine. All coordinates are local (see scene.hpp).
//
// Sidedness: a triangle exists for a ray only if it is drawn from the side the ray comes from: always when its
// object is kDoubleSided, else when the ray meets its front (counter-clockwise) side. Objects without kOccludes
// are seen but let the ray pass.
#pragma once

#include <antumbra/math.hpp>

#include <cstdint>
#include <limits>
#include <span>

namespace antumbra {

inline constexpr std::uint32_t kNoTriangle = 0xFFFFFFFFu;

struct Ray {
    Vec3d origin;
    Vec3d direction; ///< finite, not zero; need not be of unit length
};

struct Hit {
    double t = std::numeric_limits<double>::infinity(); ///< in units of the direction's length
    std::uint32_t triangle = kNoTriangle;               ///< ties: the lowest index
    explicit operator bool() const { return triangle != kNoTriangle; }
};

/// Finds, for each ray, the first *occluding* triangle drawn towards it. Thread-safe.
class FirstHitCaster {
  public:
    virtual ~FirstHitCaster() = default;
    /// hits.size() == rays.size().
    virtual void first_hits(std::span<const Ray> rays, std::span<Hit> hits) const = 0;
};

} // namespace antumbra
