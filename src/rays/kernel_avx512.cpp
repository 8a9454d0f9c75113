#include "rays/kernel.hpp"

#include <limits>

#if defined(__x86_64__)

#include <immintrin.h>

// Everything below may use AVX-512; nothing below has a name outside of this file but avx512_kernel().
#if defined(__clang__)
#pragma clang attribute push(__attribute__((target("avx2,bmi,avx512f,avx512vl,avx512dq"))), apply_to = function)
#else
#pragma GCC target("avx2,bmi,avx512f,avx512vl,avx512dq")
#endif

namespace antumbra::rays {
namespace {

#include "rays/kernel.inl"
#include "rays/kernel_avx.inl"

} // namespace

const Kernel* avx512_kernel() {
    static constexpr Kernel kernel = make_kernel<Avx>("avx512");
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
const Kernel* avx512_kernel() { return nullptr; }
} // namespace antumbra::rays

#endif
