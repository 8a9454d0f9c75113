#include "rays/kernel.hpp"

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
#include "rays/kernel_avx.inl"

} // namespace

const Kernel* avx2_kernel() {
    static constexpr Kernel kernel = make_kernel<Avx>("avx2");
    return __builtin_cpu_supports("avx2") ? &kernel : nullptr;
}

} // namespace antumbra::rays

#if defined(__clang__)
#pragma clang attribute pop
#endif

#else

namespace antumbra::rays {
const Kernel* avx2_kernel() { return nullptr; }
} // namespace antumbra::rays

#endif
