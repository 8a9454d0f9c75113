// What the processor can do, asked once.
#pragma once

/// Kernels with run-time dispatch exist for x86 with GCC or Clang; elsewhere their scalar twins run.
#if defined(__x86_64__) && (defined(__GNUC__) || defined(__clang__))
#define ANTUMBRA_X86_KERNELS 1
#define ANTUMBRA_TARGET_AVX2 __attribute__((target("avx2")))
#define ANTUMBRA_TARGET_AVX512 __attribute__((target("avx512f,avx512bw,avx512dq,avx512vl")))
#else
#define ANTUMBRA_X86_KERNELS 0
#endif

namespace antumbra {

bool cpu_has_avx2();
/// F, BW, DQ and VL together.
bool cpu_has_avx512();

} // namespace antumbra
