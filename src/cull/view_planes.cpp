#include "cull/view_planes.hpp"

namespace antumbra {
namespace {

constexpr double kLargestEye = 1e17;
constexpr double kLeastSine = 1e-6; ///< between up and the viewing direction

bool is_moderate(const Vec3d& v) {
    return std::abs(v.x) <= kLargestEye && std::abs(v.y) <= kLargestEye && std::abs(v.z) <= kLargestEye;
}

/// Float nearest above the double.
float rounded_up(double value) {
    auto nearest = static_cast<float>(value);
    return double(nearest) < value ? std::nextafter(nearest, std::numeric_limits<float>::infinity()) : nearest;
}

} // namespace

const char* problem_of(const View& view) {
    if (!is_moderate(view.eye) || !is_moderate(view.target) || !is_moderate(view.up))
        return "eye, target or up is not finite or beyond 1e17 units";
    Vec3d direction = view.target - view.eye;
    if (!(length(direction) > 0) || !(length(view.up) > 0))
        return "eye and target coincide or up is zero";
    if (!(length(cross(normalized(direction), normalized(view.up))) >= kLeastSine))
        return "up is parallel to the viewing direction";
    if (!(view.aspect >= 1e-6 && view.aspect <= 1e6))
        return "the aspect ratio is not between 1e-6 and 1e6";
    if (!(view.near_plane < view.far_plane) || !(std::abs(view.near_plane) <= kLargestEye))
        return "the near plane is not in front of the far plane";
    if (view.projection == Projection::orthographic)
        return view.height > 0 && view.height <= kLargestEye ? nullptr : "the height of the view is not positive";
    if (!(view.fov_y_deg >= 1e-6 && view.fov_y_deg <= 179.999))
        return "the field of view is not between 0 and 180 degrees";
    if (!(view.near_plane >= 0))
        return "the near plane of a perspective view lies behind the eye";
    return nullptr;
}

Camera camera_of(const View& view) {
    Camera camera = look_along(view.eye, view.target - view.eye, view.up);
    camera.orthographic = view.projection == Projection::orthographic;
    camera.near_plane = view.near_plane;
    // A far plane beyond everything is none.
    camera.far_plane = view.far_plane <= kLargestEye ? view.far_plane : std::numeric_limits<double>::infinity();
    if (camera.orthographic) {
        camera.half_height = view.height / 2;
    } else {
        HalfAngle half = half_angle(view.fov_y_deg);
        camera.half_height = half.sine / half.cosine;
    }
    camera.half_width = camera.half_height * view.aspect;
    return camera;
}

Box3d near_box(const Camera& camera) {
    double reach = camera.orthographic ? 1 : camera.near_plane;
    Vec3d middle = camera.eye + camera.forward * camera.near_plane;
    Box3d box;
    for (double x : {-1.0, 1.0})
        for (double y : {-1.0, 1.0})
            box.extend(middle + camera.right * (x * reach * camera.half_width) +
                       camera.up * (y * reach * camera.half_height));
    double size = 0;
    for (int axis = 0; axis < 3; ++axis)
        size = std::max({size, std::abs(box.min[axis]), std::abs(box.max[axis]), std::abs(camera.eye[axis])});
    double pad = camera.turn * 4 * size;
    return {box.min - Vec3d{pad, pad, pad}, box.max + Vec3d{pad, pad, pad}};
}

FrustumPlanes frustum_planes(const Camera& camera, const Box3f& domain) {
    // Per plane: normal and offset are each rounded once, three products and three sums follow. Seven roundings of
    // at most 2^-24 times the sum of the magnitudes; eight cover the second-order terms.
    constexpr double kRounding = 8 * 0x1p-24;
    FrustumPlanes planes;
    ViewVolume volume = view_volume(camera);
    planes.count = volume.count;
    for (int i = 0; i < volume.count; ++i) {
        const HalfSpace& plane = volume.planes[static_cast<std::size_t>(i)];
        double magnitude = std::abs(plane.offset), reach = 0;
        for (int axis = 0; axis < 3; ++axis) {
            double largest = std::max(std::abs(double(domain.min[axis])), std::abs(double(domain.max[axis])));
            magnitude += std::abs(plane.normal[axis]) * largest;
            reach += largest;
            planes.normal[i][axis] = static_cast<float>(plane.normal[axis]);
        }
        // Subnormal products lose more than a relative error; one smallest normal float covers all of them.
        double pad = kRounding * magnitude + plane.error_at_origin + plane.error_slope * reach + 0x1p-120;
        planes.offset[i] = rounded_up(plane.offset + pad);
        planes.inside[i] = static_cast<float>(plane.offset);
    }
    return planes;
}

} // namespace antumbra
