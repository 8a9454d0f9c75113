// Proofs that an integer is zero: its residues modulo sixteen primes below 2^49. If all are zero, the integer is a
// multiple of their product, which exceeds 2^783; if its magnitude is known to be below 2^783, it is zero.
#pragma once

#include "bake/exact/integer.hpp"

namespace antumbra::exact {

inline constexpr int kPrimes = 16;
/// An integer of magnitude below 2^kProvenBits with all residues zero is zero.
inline constexpr int kProvenBits = 783;

using Residue = std::array<std::uint64_t, kPrimes>;
using ResidueSix = std::array<Residue, 6>;

/// The primes, each in (2^48.99, 2^49).
const Residue& residue_primes();

void reduce(std::int64_t value, Residue& out);
void reduce(const Integer& value, Residue& out);

/// out = sum of h[k] * x[k] modulo each prime. The same result on every machine: one source, compiled for the wide
/// registers too where the system can choose at load time.
void residue_dot(const ResidueSix& h, const ResidueSix& x, Residue& out);
/// out = a * x - b * y modulo each prime.
void residue_combine(const Residue& a, const ResidueSix& x, const Residue& b, const ResidueSix& y,
                     ResidueSix& out);
/// The plain twin of residue_dot, with 128-bit products: what the tests compare it with.
void residue_dot_plain(const ResidueSix& h, const ResidueSix& x, Residue& out);

bool all_zero(const Residue& value);
/// Is the vector non-zero modulo every prime? Only then does a zero residue of a product with it speak of the
/// primitive vector behind it (the computed one is a multiple of it, and the multiple must not hide the prime).
bool nonzero_everywhere(const ResidueSix& x);

/// (d, m) <-> (m, d), for side products.
ResidueSix exchanged(const ResidueSix& x);

} // namespace antumbra::exact
