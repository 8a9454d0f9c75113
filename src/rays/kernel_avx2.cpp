#include "rays/kernel.hpp"

#include <cmath>
#include <limits>

#if defined(__x86_64__)

#include <immintrin.h>

// Everything below may use AVX2; nothing below has a name outside of this file but avx2_kernel().
#if defined(__clang__)
#pragma clang attribute push(__attribute__((target("avx2"))), apply_to = function)
#else
#pragma GCC target("avx2")
#endif

namespace antumbra::rays {
namespace {

#include "rays/kernel.inl"
#include "rays/prepare_x86.inl"
/// The operations of the scalar kernel, eight boxes and four triangles at a time.
struct Avx2 {
    static bool prepare(const Ray& ray, double scene_size, PreparedRay& prepared) {
        return prepare_x86(ray, scene_size, prepared);
    }

    static int enter(const Node& node, const PreparedRay& ray, float limit, float* distance) {
        int mask = 0;
        for (int at = 0; at < kWidth; at += 8) {
            __m256 first = _mm256_setzero_ps();
            __m256 last = _mm256_set1_ps(limit);
            for (int k = 0; k < 3; ++k) {
                __m256 near = _mm256_sub_ps(_mm256_load_ps(node.bounds[ray.near_row[k]] + at),
                                            _mm256_broadcast_ss(&ray.near_origin[k]));
                __m256 far = _mm256_sub_ps(_mm256_load_ps(node.bounds[ray.far_row[k]] + at),
                                           _mm256_broadcast_ss(&ray.far_origin[k]));
                first = _mm256_max_ps(_mm256_mul_ps(near, _mm256_broadcast_ss(&ray.near_inverse[k])), first);
                last = _mm256_min_ps(_mm256_mul_ps(far, _mm256_broadcast_ss(&ray.far_inverse[k])), last);
            }
            _mm256_store_ps(distance + at, first);
            mask |= _mm256_movemask_ps(_mm256_cmp_ps(first, last, _CMP_LE_OQ)) << at;
        }
        return mask;
    }

    static int enter_box(const Node& node, int child, const Packet& packet) {
        int mask = 0;
        for (int at = 0; at < kPacket; at += 8) {
            __m256 first = _mm256_setzero_ps();
            __m256 last = _mm256_load_ps(packet.limit_above + at);
            for (int k = 0; k < 3; ++k) {
                __m256 near_plane = _mm256_broadcast_ss(&node.bounds[packet.bounds.near_row[k]][child]);
                __m256 far_plane = _mm256_broadcast_ss(&node.bounds[packet.bounds.far_row[k]][child]);
                __m256 near = _mm256_sub_ps(near_plane, _mm256_load_ps(packet.near_origin[k] + at));
                __m256 far = _mm256_sub_ps(far_plane, _mm256_load_ps(packet.far_origin[k] + at));
                first =
                    _mm256_max_ps(_mm256_mul_ps(near, _mm256_load_ps(packet.near_inverse[k] + at)), first);
                last = _mm256_min_ps(_mm256_mul_ps(far, _mm256_load_ps(packet.far_inverse[k] + at)), last);
            }
            mask |= _mm256_movemask_ps(_mm256_cmp_ps(first, last, _CMP_LE_OQ)) << at;
        }
        return mask;
    }

    static __m256d corner(const float* row, double origin) {
        return _mm256_sub_pd(_mm256_cvtps_pd(_mm_load_ps(row)), _mm256_set1_pd(origin));
    }
    /// a * b - c * d
    static __m256d cross_difference(__m256d a, __m256d b, __m256d c, __m256d d) {
        return _mm256_sub_pd(_mm256_mul_pd(a, b), _mm256_mul_pd(c, d));
    }

    static int cover(const Block& block, const PreparedRay& ray, Candidates& candidates) {
        int mask = 0;
        for (int at = 0; at < kLanes; at += 4)
            mask |= cover_four(block, at, ray, candidates) << at;
        return mask;
    }

    static int cover_four(const Block& block, int at, const PreparedRay& ray, Candidates& candidates) {
        __m256d x[3], y[3], z[3];
        __m256d shear_x = _mm256_set1_pd(ray.shear_x), shear_y = _mm256_set1_pd(ray.shear_y);
        for (int c = 0; c < 3; ++c) {
            z[c] = corner(block.corner[c][ray.axis_z] + at, ray.origin[ray.axis_z]);
            x[c] = _mm256_sub_pd(corner(block.corner[c][ray.axis_x] + at, ray.origin[ray.axis_x]),
                                 _mm256_mul_pd(shear_x, z[c]));
            y[c] = _mm256_sub_pd(corner(block.corner[c][ray.axis_y] + at, ray.origin[ray.axis_y]),
                                 _mm256_mul_pd(shear_y, z[c]));
        }
        __m256d u = cross_difference(x[2], y[1], y[2], x[1]);
        __m256d v = cross_difference(x[0], y[2], y[0], x[2]);
        __m256d w = cross_difference(x[1], y[0], y[1], x[0]);
        __m256d zero = _mm256_setzero_pd();
        __m256d below = _mm256_cmp_pd(_mm256_min_pd(_mm256_min_pd(u, v), w), zero, _CMP_LT_OQ);
        __m256d above = _mm256_cmp_pd(_mm256_max_pd(_mm256_max_pd(u, v), w), zero, _CMP_GT_OQ);
        // Inside: not both signs, but not all zero either.
        int lanes = _mm256_movemask_pd(_mm256_xor_pd(below, above));
        if (!lanes)
            return 0;
        __m256d area = _mm256_add_pd(_mm256_add_pd(u, v), w);
        __m256d depth = _mm256_add_pd(_mm256_add_pd(_mm256_mul_pd(u, z[0]), _mm256_mul_pd(v, z[1])),
                                      _mm256_mul_pd(w, z[2]));
        __m256d t = _mm256_div_pd(_mm256_mul_pd(depth, _mm256_set1_pd(ray.shear_z)), area);
        _mm256_store_pd(candidates.area + at, area);
        _mm256_store_pd(candidates.t + at, t);
        return lanes;
    }
};

} // namespace

const Kernel* avx2_kernel() {
    static constexpr Kernel kernel = make_kernel<Avx2>("avx2");
    return __builtin_cpu_supports("avx2") ? &kernel : nullptr;
}

} // namespace antumbra::rays

#if defined(__clang__)
#pragma clang attribute pop
#endif

#else

namespace antumbra::rays {
const Kernel* avx2_kernel() {
    return nullptr;
}
} // namespace antumbra::rays

#endif
