#include "raster/patch_raster.hpp"

#include "base/cpu.hpp"

#if ANTUMBRA_X86_KERNELS

#include <immintrin.h>

// Everything below may use AVX-512; nothing below has a name outside of this file but draw_patch_avx512().
#if defined(__clang__)
#pragma clang attribute push(__attribute__((target("avx2,avx512f,avx512bw,avx512dq,avx512vl"))), apply_to = function)
#else
#pragma GCC diagnostic ignored "-Wpsabi"
#pragma GCC diagnostic ignored "-Wuninitialized" // GCC 12 warns about its own header
#pragma GCC diagnostic ignored "-Wmaybe-uninitialized"
#pragma GCC target("avx2,avx512f,avx512bw,avx512dq,avx512vl")
#endif

namespace antumbra {
namespace {

typedef std::uint64_t EightWords __attribute__((vector_size(64)));
#define ANTUMBRA_EIGHT_LANES 1
#define ANTUMBRA_SHIFTED_ONES(counts) shifted_ones(counts)

/// Counts of 64 and more leave nothing.
__attribute__((always_inline)) inline EightWords shifted_ones(const EightWords& counts) {
    return (EightWords)_mm512_sllv_epi64(_mm512_set1_epi64(-1), (__m512i)counts);
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

DrawPatch draw_patch_avx512() { return cpu_has_avx512() ? draw : nullptr; }

} // namespace antumbra

#if defined(__clang__)
#pragma clang attribute pop
#endif

#endif
