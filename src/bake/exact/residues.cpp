#include "bake/exact/residues.hpp"

// The same loops once for any machine and once for AVX-512; the loader chooses. All values are integers below 2^49,
// reduced completely, so that both give the same bits.
#if defined(__x86_64__) && defined(__ELF__) && defined(__GNUC__) && !defined(__clang__) && !defined(__SANITIZE_ADDRESS__) && \
    !defined(__SANITIZE_THREAD__)
#define ANTUMBRA_WIDE __attribute__((target_clones("arch=x86-64-v4", "default")))
#else
#define ANTUMBRA_WIDE
#endif

namespace antumbra::exact {
namespace {

// The sixteen largest primes below 2^49 (tests/exact checks each).
constexpr Residue kPrimeTable = {
    562949953421231u, 562949953421201u, 562949953421189u, 562949953421173u, 562949953421131u,
    562949953421111u, 562949953421099u, 562949953421047u, 562949953421029u, 562949953420973u,
    562949953420871u, 562949953420867u, 562949953420837u, 562949953420793u, 562949953420747u,
    562949953420741u};

constexpr std::array<double, kPrimes> inverses() {
    std::array<double, kPrimes> out{};
    for (std::size_t k = 0; k < kPrimes; ++k)
        out[k] = 1.0 / static_cast<double>(kPrimeTable[k]);
    return out;
}
constexpr std::array<double, kPrimes> kInverse = inverses();

/// a * b mod p for a, b < p < 2^49. The estimate of the quotient is off by less than one (three roundings of a
/// value below 2^49), so that the remainder, taken modulo 2^64, lies in [-p, 2p).
inline std::uint64_t multiply(std::uint64_t a, std::uint64_t b, std::uint64_t p, double inverse) {
    auto quotient = static_cast<std::uint64_t>(
        static_cast<std::int64_t>(static_cast<double>(static_cast<std::int64_t>(a)) *
                                  static_cast<double>(static_cast<std::int64_t>(b)) * inverse));
    auto r = static_cast<std::int64_t>(a * b - quotient * p);
    auto q = static_cast<std::int64_t>(p);
    r += r < 0 ? q : 0;
    r -= r >= q ? q : 0;
    return static_cast<std::uint64_t>(r);
}

} // namespace

const Residue& residue_primes() { return kPrimeTable; }

void reduce(std::int64_t value, Residue& out) {
    for (std::size_t k = 0; k < kPrimes; ++k) {
        auto p = static_cast<std::int64_t>(kPrimeTable[k]);
        std::int64_t r = value % p;
        out[k] = static_cast<std::uint64_t>(r < 0 ? r + p : r);
    }
}

void reduce(const Integer& value, Residue& out) {
    Integer magnitude = abs(value);
    for (std::size_t k = 0; k < kPrimes; ++k) {
        std::uint64_t p = kPrimeTable[k];
        auto r = static_cast<std::uint64_t>(Integer(magnitude % p));
        out[k] = value.sign() < 0 && r != 0 ? p - r : r;
    }
}

ANTUMBRA_WIDE void residue_dot(const ResidueSix& h, const ResidueSix& x, Residue& out) {
    for (std::size_t k = 0; k < kPrimes; ++k) {
        std::uint64_t p = kPrimeTable[k], sum = 0;
        for (std::size_t c = 0; c < 6; ++c) {
            sum += multiply(h[c][k], x[c][k], p, kInverse[k]);
            sum -= sum >= p ? p : 0;
        }
        out[k] = sum;
    }
}

ANTUMBRA_WIDE void residue_combine(const Residue& a, const ResidueSix& x, const Residue& b, const ResidueSix& y,
                                   ResidueSix& out) {
    for (std::size_t c = 0; c < 6; ++c)
        for (std::size_t k = 0; k < kPrimes; ++k) {
            std::uint64_t p = kPrimeTable[k];
            std::uint64_t r = multiply(a[k], x[c][k], p, kInverse[k]) + p - multiply(b[k], y[c][k], p, kInverse[k]);
            out[c][k] = r >= p ? r - p : r;
        }
}

void residue_dot_plain(const ResidueSix& h, const ResidueSix& x, Residue& out) {
    for (std::size_t k = 0; k < kPrimes; ++k) {
        Unsigned128 sum = 0;
        for (std::size_t c = 0; c < 6; ++c)
            sum += static_cast<Unsigned128>(h[c][k]) * x[c][k];
        out[k] = static_cast<std::uint64_t>(sum % kPrimeTable[k]);
    }
}

bool all_zero(const Residue& value) {
    std::uint64_t any = 0;
    for (std::uint64_t r : value)
        any |= r;
    return any == 0;
}

bool nonzero_everywhere(const ResidueSix& x) {
    for (std::size_t k = 0; k < kPrimes; ++k)
        if ((x[0][k] | x[1][k] | x[2][k] | x[3][k] | x[4][k] | x[5][k]) == 0)
            return false;
    return true;
}

ResidueSix exchanged(const ResidueSix& x) { return {x[3], x[4], x[5], x[0], x[1], x[2]}; }

} // namespace antumbra::exact
