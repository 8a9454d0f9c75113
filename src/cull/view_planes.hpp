// A view, checked and turned into what the frustum tests eat.
#pragma once

#include "geometry/camera.hpp"

#include <antumbra/cull.hpp>

namespace antumbra {

/// `view` must have no problem.
Camera camera_of(const View& view);

/// Around the near rectangle, where every line of sight of the picture starts; grown by the rounding of the camera.
Box3d near_box(const Camera& camera);

/// Half-spaces in float, padded so that no rounding of the float test
///     ((nx*px + ny*py) + nz*pz) + offset < 0
/// can reject a point of the box `domain` that lies in the real view volume.
struct FrustumPlanes {
    static constexpr int kMost = 6;
    int count = 0;
    float normal[kMost][3];
    float offset[kMost];  ///< with the padding: below zero is certainly outside
    float inside[kMost];  ///< without: nodes wholly above zero skip the plane further down

    std::uint32_t mask() const { return (1u << count) - 1; }
};
FrustumPlanes frustum_planes(const Camera& camera, const Box3f& domain);

} // namespace antumbra
