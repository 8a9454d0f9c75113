#include "raster/patch_raster.hpp"

#include "base/cpu.hpp"

#if ANTUMBRA_X86_KERNELS

#include <immintrin.h>

// Everything below may use AVX2; nothing below has a name outside of this file but draw_patch_avx2().
#if defined(__clang__)
#pragma clang attribute push(__attribute__((target("avx2"))), apply_to = function)
#else
#pragma GCC diagnostic ignored "-Wpsabi"
#pragma GCC diagnostic ignored "-Wuninitialized" // GCC 12 warns about its own header
#pragma GCC diagnostic ignored "-Wmaybe-uninitialized"
#pragma GCC target("avx2")
#endif

namespace antumbra {
namespace {

typedef std::uint64_t EightWords __attribute__((vector_size(64)));
#define ANTUMBRA_EIGHT_LANES 1
#define ANTUMBRA_SHIFTED_ONES(counts) shifted_ones(counts)

/// Counts of 64 and more leave nothing.
__attribute__((always_inline)) inline EightWords shifted_ones(const EightWords& counts) {
    EightWords result;
    for (int half = 0; half < 2; ++half) {
        __m256i count;
        __builtin_memcpy(&count, reinterpret_cast<const char*>(&counts) + 32 * half, sizeof count);
        count = _mm256_sllv_epi64(_mm256_set1_epi64x(-1), count);
        __builtin_memcpy(reinterpret_cast<char*>(&result) + 32 * half, &count, sizeof count);
    }
    return result;
}

} // namespace
} // namespace antumbra

#include "raster/patch_raster.inl"

namespace antumbra {
namespace {

void draw(const PatchStore& store, std::uint32_t patch, const Screen& screen, PatchCoverage& coverage) {
    draw_patch_body(store, patch, screen, coverage);
}

} // namespace

DrawPatch draw_patch_avx2() { return cpu_has_avx2() ? draw : nullptr; }

} // namespace antumbra

#if defined(__clang__)
#pragma clang attribute pop
#endif

#endif
