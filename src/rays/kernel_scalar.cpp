#include "rays/kernel.hpp"

#include <cmath>
#include <limits>

namespace antumbra::rays {
namespace {

#include "rays/kernel.inl"

struct Scalar {
    static bool prepare(const Ray& ray, double scene_size, PreparedRay& prepared) {
        return rays::prepare(ray.origin, ray.direction, scene_size, prepared);
    }

    /// Float slabs. the origins are moved by twice the margin, and the inverses are moved
    /// apart by 2^-21 relative, which outweighs the roundings of the subtraction, the inverse and the product
    /// (3 * 2^-24). So a stretch here contains the one that clamp_to_box computes in doubles for any box
    /// inside.
    static int enter(const Node& node, const PreparedRay& ray, float limit, float* distance) {
        int mask = 0;
        for (int i = 0; i < kWidth; ++i) {
            float first = 0, last = limit;
            for (int k = 0; k < 3; ++k) {
                float near = (node.bounds[ray.near_row[k]][i] - ray.near_origin[k]) * ray.near_inverse[k];
                float far = (node.bounds[ray.far_row[k]][i] - ray.far_origin[k]) * ray.far_inverse[k];
                first = near > first ? near : first;
                last = far < last ? far : last;
            }
            distance[i] = first;
            mask |= first <= last ? 1 << i : 0;
        }
        return mask;
    }

    static int enter_box(const Node& node, int child, const Packet& packet) {
        int mask = 0;
        for (int i = 0; i < kPacket; ++i) {
            float first = 0, last = packet.limit_above[i];
            for (int k = 0; k < 3; ++k) {
                float near_plane = node.bounds[packet.bounds.near_row[k]][child];
                float far_plane = node.bounds[packet.bounds.far_row[k]][child];
                float near = (near_plane - packet.near_origin[k][i]) * packet.near_inverse[k][i];
                float far = (far_plane - packet.far_origin[k][i]) * packet.far_inverse[k][i];
                first = near > first ? near : first;
                last = far < last ? far : last;
            }
            mask |= first <= last ? 1 << i : 0;
        }
        return mask;
    }

    /// Watertight test after Woop, Benthin and Wald (2013), in doubles: corners relative to the origin are
    /// sheared so that the ray runs along z; the signs of three 2D edge functions decide. Rounding to nearest
    /// is monotonic, so fl(fl(ab) - fl(cd)) is zero or has the sign of ab - cd; swapping an edge's ends
    /// negates it exactly; zero counts as inside. Hence of the triangles around a shared edge or vertex at
    /// least one is hit by every ray that passes between them.
    static int cover(const Block& block, const PreparedRay& ray, Candidates& candidates) {
        int mask = 0;
        for (int i = 0; i < kLanes; ++i) {
            double x[3], y[3], z[3];
            for (int c = 0; c < 3; ++c) {
                z[c] = static_cast<double>(block.corner[c][ray.axis_z][i]) - ray.origin[ray.axis_z];
                x[c] = (static_cast<double>(block.corner[c][ray.axis_x][i]) - ray.origin[ray.axis_x]) -
                       ray.shear_x * z[c];
                y[c] = (static_cast<double>(block.corner[c][ray.axis_y][i]) - ray.origin[ray.axis_y]) -
                       ray.shear_y * z[c];
            }
            double u = x[2] * y[1] - y[2] * x[1];
            double v = x[0] * y[2] - y[0] * x[2];
            double w = x[1] * y[0] - y[1] * x[0];
            bool below = u < 0 || v < 0 || w<0, above = u> 0 || v > 0 || w > 0;
            if (below == above) // outside; or no area
                continue;
            double area = (u + v) + w;
            candidates.area[i] = area;
            candidates.t[i] = (((u * z[0] + v * z[1]) + w * z[2]) * ray.shear_z) / area;
            mask |= 1 << i;
        }
        return mask;
    }
};

} // namespace

const Kernel& scalar_kernel() {
    static constexpr Kernel kernel = make_kernel<Scalar>("scalar");
    return kernel;
}

} // namespace antumbra::rays
