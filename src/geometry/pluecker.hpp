// Directed lines of space as points of Pluecker space.
//
// The line through p and then q is the six-tuple (d, m) with direction d = q - p and moment m = p x q, up to a
// positive factor. Two lines meet (or are parallel) iff side() is zero; else its sign says on which side one
// passes the other. Six-tuples that are lines satisfy quadric() == 0. Nirenstein, Blake, Gain 2002, section 2.1.
#pragma once

#include <antumbra/math.hpp>

#include <array>
#include <cstdint>

namespace antumbra {

/// A point of the scene's grid: local coordinates divided by Scene::step(). Magnitudes up to 2^24 everywhere.
using GridPoint = Vec3<std::int64_t>;

/// Direction in [0..2], moment in [3..5]. With grid points of magnitude 2^24 a direction needs 26 bits and a
/// moment 50, signs included: int64 holds every line through grid points exactly.
template <class T>
using Pluecker = std::array<T, 6>;

template <class T>
constexpr Pluecker<T> pluecker_through(const Vec3<T>& p, const Vec3<T>& q) {
    Vec3<T> d = q - p, m = cross(p, q);
    return {d.x, d.y, d.z, m.x, m.y, m.z};
}

/// The permuted inner product. Positive for lines that cross a polygon, counter-clockwise about n, along +n, when
/// `a` runs along the polygon's edges; negative when they cross it along -n.
template <class T>
constexpr T side(const Pluecker<T>& a, const Pluecker<T>& b) {
    return a[0] * b[3] + a[1] * b[4] + a[2] * b[5] + a[3] * b[0] + a[4] * b[1] + a[5] * b[2];
}

/// Zero exactly for lines; side(a, a) == 2 * quadric(a).
template <class T>
constexpr T quadric(const Pluecker<T>& a) {
    return a[0] * a[3] + a[1] * a[4] + a[2] * a[5];
}

/// The hyperplane h of lines that meet `a`: h . x == side(a, x).
template <class T>
constexpr Pluecker<T> dual(const Pluecker<T>& a) {
    return {a[3], a[4], a[5], a[0], a[1], a[2]};
}

} // namespace antumbra
