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

/// May a point of `box` (within the domain of the planes) be in view?
inline bool is_in_view(const Box3f& box, const FrustumPlanes& planes) {
    for (int i = 0; i < planes.count; ++i) {
        const float* n = planes.normal[i];
        float sum = n[0] * (n[0] >= 0 ? box.max.x : box.min.x) + n[1] * (n[1] >= 0 ? box.max.y : box.min.y) +
                    n[2] * (n[2] >= 0 ? box.max.z : box.min.z);
        if (sum + planes.offset[i] < 0)
            return false;
    }
    return true;
}

} // namespace antumbra
