#include "cull/box_kernels.hpp"

#include "base/cpu.hpp"

#if ANTUMBRA_X86_KERNELS
#include <immintrin.h>
#endif

namespace antumbra {

void test_boxes_scalar(const EightBoxes& boxes, const FrustumPlanes& planes, std::uint32_t active,
                       BoxVerdicts& verdicts) {
    verdicts.outside = 0;
    for (int lane = 0; lane < kWidth; ++lane) {
        verdicts.crossing[lane] = 0;
        for (int i = 0; i < planes.count; ++i) {
            if (!(active >> i & 1))
                continue;
            float far_sum = 0, near_sum = 0;
            for (int axis = 0; axis < 3; ++axis) {
                float normal = planes.normal[i][axis];
                float far_corner = normal >= 0 ? boxes.max[axis][lane] : boxes.min[axis][lane];
                float near_corner = normal >= 0 ? boxes.min[axis][lane] : boxes.max[axis][lane];
                far_sum = axis == 0 ? normal * far_corner : far_sum + normal * far_corner;
                near_sum = axis == 0 ? normal * near_corner : near_sum + normal * near_corner;
            }
            if (far_sum + planes.offset[i] < 0)
                verdicts.outside |= 1u << lane;
            if (near_sum + planes.inside[i] < 0)
                verdicts.crossing[lane] |= 1u << i;
        }
    }
}

#if ANTUMBRA_X86_KERNELS
namespace {

ANTUMBRA_TARGET_AVX2 void test_boxes_avx2(const EightBoxes& boxes, const FrustumPlanes& planes,
                                          std::uint32_t active, BoxVerdicts& verdicts) {
    __m256 outside = _mm256_setzero_ps();
    __m256i crossing = _mm256_setzero_si256();
    for (std::uint32_t rest = active; rest; rest &= rest - 1) {
        int i = __builtin_ctz(rest);
        __m256 nx = _mm256_set1_ps(planes.normal[i][0]);
        __m256 ny = _mm256_set1_ps(planes.normal[i][1]);
        __m256 nz = _mm256_set1_ps(planes.normal[i][2]);
        bool x = planes.normal[i][0] >= 0, y = planes.normal[i][1] >= 0, z = planes.normal[i][2] >= 0;
        auto sum = [&](const float* px, const float* py, const float* pz) ANTUMBRA_TARGET_AVX2 {
            return _mm256_add_ps(_mm256_add_ps(_mm256_mul_ps(nx, _mm256_loadu_ps(px)),
                                               _mm256_mul_ps(ny, _mm256_loadu_ps(py))),
                                 _mm256_mul_ps(nz, _mm256_loadu_ps(pz)));
        };
        __m256 far_sum = sum(x ? boxes.max[0] : boxes.min[0], y ? boxes.max[1] : boxes.min[1],
                             z ? boxes.max[2] : boxes.min[2]);
        __m256 near_sum = sum(x ? boxes.min[0] : boxes.max[0], y ? boxes.min[1] : boxes.max[1],
                              z ? boxes.min[2] : boxes.max[2]);
        __m256 zero = _mm256_setzero_ps();
        outside = _mm256_or_ps(outside, _mm256_cmp_ps(_mm256_add_ps(far_sum, _mm256_set1_ps(planes.offset[i])), zero,
                                                      _CMP_LT_OQ));
        __m256 across = _mm256_cmp_ps(_mm256_add_ps(near_sum, _mm256_set1_ps(planes.inside[i])), zero, _CMP_LT_OQ);
        crossing = _mm256_or_si256(
            crossing, _mm256_and_si256(_mm256_castps_si256(across), _mm256_set1_epi32(1 << i)));
    }
    verdicts.outside = static_cast<std::uint32_t>(_mm256_movemask_ps(outside));
    _mm256_storeu_si256(reinterpret_cast<__m256i*>(verdicts.crossing), crossing);
}

} // namespace
#endif

BoxKernel box_kernel(InstructionSet instruction_set) {
    switch (instruction_set) {
    case InstructionSet::scalar: return test_boxes_scalar;
#if ANTUMBRA_X86_KERNELS
    case InstructionSet::automatic: return cpu_has_avx2() ? test_boxes_avx2 : test_boxes_scalar;
    case InstructionSet::avx2: return cpu_has_avx2() ? test_boxes_avx2 : nullptr;
    case InstructionSet::avx512: return cpu_has_avx512() ? test_boxes_avx2 : nullptr; // eight boxes fill one register
#else
    case InstructionSet::automatic: return test_boxes_scalar;
    case InstructionSet::avx2:
    case InstructionSet::avx512: return nullptr;
#endif
    }
    return nullptr;
}

} // namespace antumbra
