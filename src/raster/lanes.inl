// Eight lanes side by side, in the vector extensions of GCC and Clang: what the processor lacks they make of what it has,
// with the same results. A file that is compiled for an instruction set may define ANTUMBRA_SHIFTED_ONES(counts) before
// it includes this.

namespace antumbra {
namespace {

#define ANTUMBRA_INLINE __attribute__((always_inline)) inline
#if defined(__GNUC__) && !defined(__clang__)
#pragma GCC diagnostic ignored "-Wpsabi" // all of this is inlined: there is no interface
#endif

constexpr int kLanes = 8;
typedef float Floats __attribute__((vector_size(32)));
typedef int Ints __attribute__((vector_size(32)));
typedef std::uint64_t Words __attribute__((vector_size(64)));

constexpr Ints kCount = {0, 1, 2, 3, 4, 5, 6, 7};

ANTUMBRA_INLINE Floats splat(float value) { return value - Floats{}; }
ANTUMBRA_INLINE Ints splat(int value) { return value - Ints{}; }

template <class Vector, class T>
ANTUMBRA_INLINE Vector load(const T* from) {
    Vector value;
    __builtin_memcpy(&value, from, sizeof value);
    return value;
}
ANTUMBRA_INLINE Floats load_floats(const float* from) { return load<Floats>(from); }
ANTUMBRA_INLINE Words load_words(const std::uint64_t* from) { return load<Words>(from); }
template <class Vector, class T>
ANTUMBRA_INLINE void store(T* to, const Vector& value) {
    __builtin_memcpy(to, &value, sizeof value);
}

ANTUMBRA_INLINE Floats to_floats(const Ints& value) { return __builtin_convertvector(value, Floats); }
/// floor and ceil for values that fit.
ANTUMBRA_INLINE Ints floor_ints(const Floats& value) {
    Ints whole = __builtin_convertvector(value, Ints);
    return whole + (to_floats(whole) > value); // true is -1
}
ANTUMBRA_INLINE Ints ceil_ints(const Floats& value) {
    Ints whole = __builtin_convertvector(value, Ints);
    return whole - (to_floats(whole) < value);
}
ANTUMBRA_INLINE Floats clamp(Floats value, float low, float high) {
    value = value < low ? splat(low) : value;
    return value > high ? splat(high) : value;
}

/// Of each lane the bits from n on, for any n.
ANTUMBRA_INLINE Words bits_from(const Ints& n) {
    const Words counts = __builtin_convertvector(n > 0 ? n : splat(0), Words);
#if defined(ANTUMBRA_SHIFTED_ONES)
    return ANTUMBRA_SHIFTED_ONES(counts);
#else
    // Shifts of 64 and more are not defined: in two halves, and never more than 64.
    const Words most = 64 - Words{}, limited = counts > most ? most : counts, half = limited >> 1;
    return (~Words{} << half) << (limited - half);
#endif
}

} // namespace
} // namespace antumbra
