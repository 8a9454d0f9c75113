// Lanes side by side, in the vector extensions of GCC and Clang: as many as the registers have room for, one where the
// processor has no vectors; eight make a tile or a block. The results never depend on how many there are. A file that is
// compiled for an instruction set with registers of 32 bytes defines ANTUMBRA_EIGHT_LANES, and ANTUMBRA_SHIFTED_ONES,
// before it includes this.

namespace antumbra {
namespace {

#if defined(ANTUMBRA_EIGHT_LANES) || defined(__SSE2__) || defined(__ARM_NEON) || defined(__wasm_simd128__)
#define ANTUMBRA_INLINE __attribute__((always_inline)) inline
#else
#define ANTUMBRA_INLINE inline // where there are no vectors, code should be small
#endif
#pragma GCC diagnostic ignored "-Wpsabi" // all of this is inlined: there is no interface

constexpr int kLanes = 8; ///< rows of a tile, tiles of a block, edges: whatever goes side by side

#if defined(ANTUMBRA_EIGHT_LANES)
constexpr int kStep = 8; ///< lanes that are computed at a time
#elif defined(__SSE2__) || defined(__ARM_NEON) || defined(__wasm_simd128__)
constexpr int kStep = 4;
#else
constexpr int kStep = 1;
#endif

#if defined(ANTUMBRA_EIGHT_LANES) || defined(__SSE2__) || defined(__ARM_NEON) || defined(__wasm_simd128__)
typedef float Floats __attribute__((vector_size(4 * kStep)));
typedef int Ints __attribute__((vector_size(4 * kStep)));
typedef std::uint64_t Words __attribute__((vector_size(8 * kStep)));
typedef Ints Mask; ///< -1 where true

ANTUMBRA_INLINE Floats to_floats(const Ints& value) { return __builtin_convertvector(value, Floats); }
ANTUMBRA_INLINE Ints truncated(const Floats& value) { return __builtin_convertvector(value, Ints); }
ANTUMBRA_INLINE Words to_words(const Ints& value) { return __builtin_convertvector(value, Words); }
ANTUMBRA_INLINE Ints ones_where(const Mask& mask) { return -mask; }
#else
typedef float Floats;
typedef int Ints;
typedef std::uint64_t Words;
typedef bool Mask;

ANTUMBRA_INLINE Floats to_floats(Ints value) { return static_cast<float>(value); }
ANTUMBRA_INLINE Ints truncated(Floats value) { return static_cast<int>(value); }
ANTUMBRA_INLINE Words to_words(Ints value) { return static_cast<Words>(value); }
ANTUMBRA_INLINE Ints ones_where(Mask mask) { return mask; }
#endif

ANTUMBRA_INLINE Floats splat(float value) { return value - Floats{}; }
ANTUMBRA_INLINE Ints splat(int value) { return value - Ints{}; }
/// first, first + 1 ..
ANTUMBRA_INLINE Ints count_from(int first) {
#if defined(ANTUMBRA_EIGHT_LANES)
    constexpr Ints kCount = {0, 1, 2, 3, 4, 5, 6, 7};
    return kCount + first;
#elif defined(__SSE2__) || defined(__ARM_NEON) || defined(__wasm_simd128__)
    constexpr Ints kCount = {0, 1, 2, 3};
    return kCount + first;
#else
    return first;
#endif
}

template <class Vector, class T>
ANTUMBRA_INLINE Vector load(const T* from) {
    Vector value;
    __builtin_memcpy(&value, from, sizeof value);
    return value;
}
ANTUMBRA_INLINE Floats load_floats(const float* from) { return load<Floats>(from); }
ANTUMBRA_INLINE Ints load_ints(const int* from) { return load<Ints>(from); }
ANTUMBRA_INLINE Words load_words(const std::uint64_t* from) { return load<Words>(from); }
template <class T, class Vector>
ANTUMBRA_INLINE void store(T* to, const Vector& value) {
    __builtin_memcpy(to, &value, sizeof value);
}

/// floor and ceil for values that fit.
ANTUMBRA_INLINE Ints floor_ints(const Floats& value) {
    Ints whole = truncated(value);
    return whole - ones_where(to_floats(whole) > value);
}
ANTUMBRA_INLINE Ints ceil_ints(const Floats& value) {
    Ints whole = truncated(value);
    return whole + ones_where(to_floats(whole) < value);
}
ANTUMBRA_INLINE Floats clamp(Floats value, float low, float high) {
    value = value < low ? splat(low) : value;
    return value > high ? splat(high) : value;
}

/// Of each lane the bits from n on, for any n.
ANTUMBRA_INLINE Words bits_from(const Ints& n) {
#if defined(ANTUMBRA_SHIFTED_ONES)
    return ANTUMBRA_SHIFTED_ONES(to_words(n > 0 ? n : splat(0)));
#else
    // Shifts of 64 are not defined: in two halves.
    Ints limited = n > 0 ? n : splat(0);
    limited = limited > 64 ? splat(64) : limited;
    const Words counts = to_words(limited), half = counts >> 1;
    return (~Words{} << half) << (counts - half);
#endif
}

} // namespace
} // namespace antumbra
