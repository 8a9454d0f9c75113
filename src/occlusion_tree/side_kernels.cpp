#include "occlusion_tree/side_kernels.hpp"

#include "base/cpu.hpp"
#include "occlusion_tree/picture_polygon.hpp"

#include <cmath>

#if ANTUMBRA_X86_KERNELS
#include <immintrin.h>
#endif

namespace antumbra {

SideMasks certain_sides_scalar(const LineFilter& line, const PicturePolygon& polygon) {
    SideMasks masks{0, 0};
    for (int i = 0; i < polygon.count; ++i) {
        double value = line.n.x * polygon.x[i] + line.n.y * polygon.y[i] + line.n.z * polygon.z[i];
        double bound = polygon.size[i] * line.size_factor + polygon.error[i] * line.error_factor;
        masks.positive |= std::uint64_t(value > bound) << i;
        masks.negative |= std::uint64_t(-value > bound) << i;
    }
    return masks;
}

#if ANTUMBRA_X86_KERNELS
namespace {

constexpr std::uint64_t used(int count) { return (std::uint64_t(1) << count) - 1; }

ANTUMBRA_TARGET_AVX2 SideMasks certain_sides_avx2(const LineFilter& line, const PicturePolygon& polygon) {
    SideMasks masks{0, 0};
    __m256d nx = _mm256_set1_pd(line.n.x), ny = _mm256_set1_pd(line.n.y), nz = _mm256_set1_pd(line.n.z);
    __m256d sf = _mm256_set1_pd(line.size_factor), ef = _mm256_set1_pd(line.error_factor);
    for (int i = 0; i < polygon.count; i += 4) {
        __m256d value = _mm256_add_pd(_mm256_add_pd(_mm256_mul_pd(nx, _mm256_loadu_pd(polygon.x + i)),
                                                    _mm256_mul_pd(ny, _mm256_loadu_pd(polygon.y + i))),
                                      _mm256_mul_pd(nz, _mm256_loadu_pd(polygon.z + i)));
        __m256d bound = _mm256_add_pd(_mm256_mul_pd(_mm256_loadu_pd(polygon.size + i), sf),
                                      _mm256_mul_pd(_mm256_loadu_pd(polygon.error + i), ef));
        __m256d negated = _mm256_xor_pd(value, _mm256_set1_pd(-0.0));
        masks.positive |= std::uint64_t(_mm256_movemask_pd(_mm256_cmp_pd(value, bound, _CMP_GT_OQ))) << i;
        masks.negative |= std::uint64_t(_mm256_movemask_pd(_mm256_cmp_pd(negated, bound, _CMP_GT_OQ))) << i;
    }
    return {masks.positive & used(polygon.count), masks.negative & used(polygon.count)};
}

ANTUMBRA_TARGET_AVX512 SideMasks certain_sides_avx512(const LineFilter& line, const PicturePolygon& polygon) {
    SideMasks masks{0, 0};
    __m512d nx = _mm512_set1_pd(line.n.x), ny = _mm512_set1_pd(line.n.y), nz = _mm512_set1_pd(line.n.z);
    __m512d sf = _mm512_set1_pd(line.size_factor), ef = _mm512_set1_pd(line.error_factor);
    for (int i = 0; i < polygon.count; i += 8) {
        __m512d value = _mm512_add_pd(_mm512_add_pd(_mm512_mul_pd(nx, _mm512_loadu_pd(polygon.x + i)),
                                                    _mm512_mul_pd(ny, _mm512_loadu_pd(polygon.y + i))),
                                      _mm512_mul_pd(nz, _mm512_loadu_pd(polygon.z + i)));
        __m512d bound = _mm512_add_pd(_mm512_mul_pd(_mm512_loadu_pd(polygon.size + i), sf),
                                      _mm512_mul_pd(_mm512_loadu_pd(polygon.error + i), ef));
        __m512d negated = _mm512_xor_pd(value, _mm512_set1_pd(-0.0));
        masks.positive |= std::uint64_t(_mm512_cmp_pd_mask(value, bound, _CMP_GT_OQ)) << i;
        masks.negative |= std::uint64_t(_mm512_cmp_pd_mask(negated, bound, _CMP_GT_OQ)) << i;
    }
    return {masks.positive & used(polygon.count), masks.negative & used(polygon.count)};
}

} // namespace
#endif

SideKernel side_kernel(SideKernelKind kind) {
#if ANTUMBRA_X86_KERNELS
    switch (kind) {
    case SideKernelKind::scalar: return certain_sides_scalar;
    case SideKernelKind::avx2: return cpu_has_avx2() ? certain_sides_avx2 : nullptr;
    case SideKernelKind::avx512: return cpu_has_avx512() ? certain_sides_avx512 : nullptr;
    case SideKernelKind::best:
        return cpu_has_avx512() ? certain_sides_avx512 : cpu_has_avx2() ? certain_sides_avx2 : certain_sides_scalar;
    }
    return nullptr;
#else
    return kind == SideKernelKind::best || kind == SideKernelKind::scalar ? certain_sides_scalar : nullptr;
#endif
}

} // namespace antumbra
