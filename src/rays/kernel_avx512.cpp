#include "rays/kernel.hpp"

#include <cmath>
#include <limits>

#if defined(__x86_64__)

#include <immintrin.h>

// Everything below may use AVX-512; nothing below has a name outside of this file but avx512_kernel().
#if defined(__clang__)
#pragma clang attribute push(__attribute__((target("avx2,bmi,avx512f,avx512vl,avx512dq"))),                  \
                             apply_to = function)
#else
#pragma GCC diagnostic ignored "-Wuninitialized" // GCC 12 warns about its own header
#pragma GCC diagnostic ignored "-Wmaybe-uninitialized"
#pragma GCC target("avx2,bmi,avx512f,avx512vl,avx512dq")
#endif

namespace antumbra::rays {
namespace {

#include "rays/kernel.inl"
#include "rays/prepare_x86.inl"

/// The operations of the scalar kernel, sixteen boxes and eight triangles at a time.
struct Avx512 {
    static bool prepare(const Ray& ray, double scene_size, PreparedRay& prepared) {
        return prepare_x86(ray, scene_size, prepared);
    }

    static int enter(const Node& node, const PreparedRay& ray, float limit, float* distance) {
        __m512 first = _mm512_setzero_ps();
        __m512 last = _mm512_set1_ps(limit);
        for (int k = 0; k < 3; ++k) {
            __m512 near = _mm512_sub_ps(_mm512_load_ps(node.bounds[ray.near_row[k]]),
                                        _mm512_set1_ps(ray.near_origin[k]));
            __m512 far =
                _mm512_sub_ps(_mm512_load_ps(node.bounds[ray.far_row[k]]), _mm512_set1_ps(ray.far_origin[k]));
            first = _mm512_max_ps(_mm512_mul_ps(near, _mm512_set1_ps(ray.near_inverse[k])), first);
            last = _mm512_min_ps(_mm512_mul_ps(far, _mm512_set1_ps(ray.far_inverse[k])), last);
        }
        _mm512_store_ps(distance, first);
        return _mm512_cmp_ps_mask(first, last, _CMP_LE_OQ);
    }

    static int enter_box(const Node& node, int child, const Packet& packet) {
        __m512 first = _mm512_setzero_ps();
        __m512 last = _mm512_load_ps(packet.limit_above);
        for (int k = 0; k < 3; ++k) {
            __m512 near_plane = _mm512_set1_ps(node.bounds[packet.bounds.near_row[k]][child]);
            __m512 far_plane = _mm512_set1_ps(node.bounds[packet.bounds.far_row[k]][child]);
            __m512 near = _mm512_sub_ps(near_plane, _mm512_load_ps(packet.near_origin[k]));
            __m512 far = _mm512_sub_ps(far_plane, _mm512_load_ps(packet.far_origin[k]));
            first = _mm512_max_ps(_mm512_mul_ps(near, _mm512_load_ps(packet.near_inverse[k])), first);
            last = _mm512_min_ps(_mm512_mul_ps(far, _mm512_load_ps(packet.far_inverse[k])), last);
        }
        return _mm512_cmp_ps_mask(first, last, _CMP_LE_OQ);
    }

    static __m512d corner(const float* row, double origin) {
        return _mm512_sub_pd(_mm512_cvtps_pd(_mm256_load_ps(row)), _mm512_set1_pd(origin));
    }
    /// a * b - c * d
    static __m512d cross_difference(__m512d a, __m512d b, __m512d c, __m512d d) {
        return _mm512_sub_pd(_mm512_mul_pd(a, b), _mm512_mul_pd(c, d));
    }

    static int cover(const Block& block, const PreparedRay& ray, Candidates& candidates) {
        __m512d x[3], y[3], z[3];
        __m512d shear_x = _mm512_set1_pd(ray.shear_x), shear_y = _mm512_set1_pd(ray.shear_y);
        for (int c = 0; c < 3; ++c) {
            z[c] = corner(block.corner[c][ray.axis_z], ray.origin[ray.axis_z]);
            x[c] = _mm512_sub_pd(corner(block.corner[c][ray.axis_x], ray.origin[ray.axis_x]),
                                 _mm512_mul_pd(shear_x, z[c]));
            y[c] = _mm512_sub_pd(corner(block.corner[c][ray.axis_y], ray.origin[ray.axis_y]),
                                 _mm512_mul_pd(shear_y, z[c]));
        }
        __m512d u = cross_difference(x[2], y[1], y[2], x[1]);
        __m512d v = cross_difference(x[0], y[2], y[0], x[2]);
        __m512d w = cross_difference(x[1], y[0], y[1], x[0]);
        __m512d zero = _mm512_setzero_pd();
        int below = _mm512_cmp_pd_mask(_mm512_min_pd(_mm512_min_pd(u, v), w), zero, _CMP_LT_OQ);
        int above = _mm512_cmp_pd_mask(_mm512_max_pd(_mm512_max_pd(u, v), w), zero, _CMP_GT_OQ);
        int lanes = below ^ above; // inside: not both signs, but not all zero either
        if (!lanes)
            return 0;
        __m512d area = _mm512_add_pd(_mm512_add_pd(u, v), w);
        __m512d depth = _mm512_add_pd(_mm512_add_pd(_mm512_mul_pd(u, z[0]), _mm512_mul_pd(v, z[1])),
                                      _mm512_mul_pd(w, z[2]));
        __m512d t = _mm512_div_pd(_mm512_mul_pd(depth, _mm512_set1_pd(ray.shear_z)), area);
        _mm512_store_pd(candidates.area, area);
        _mm512_store_pd(candidates.t, t);
        return lanes;
    }
};

} // namespace

const Kernel* avx512_kernel() {
    static constexpr Kernel kernel = make_kernel<Avx512>("avx512");
    bool supported = __builtin_cpu_supports("avx512f") && __builtin_cpu_supports("avx512vl") &&
                     __builtin_cpu_supports("avx512dq") && __builtin_cpu_supports("bmi");
    return supported ? &kernel : nullptr;
}

} // namespace antumbra::rays

#if defined(__clang__)
#pragma clang attribute pop
#endif

#else

namespace antumbra::rays {
const Kernel* avx512_kernel() {
    return nullptr;
}
} // namespace antumbra::rays

#endif
