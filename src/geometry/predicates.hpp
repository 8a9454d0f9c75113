// Signs of geometric determinants, right for every input: a filter in doubles first, exact expansions where
// it cannot decide. Same answer on every machine (no FMA, no extended precision, nothing but IEEE doubles).
//
// Exact as long as every coordinate is zero or has all its bits between 2^-150 and 2^150: see
// in_exact_range(). Thread-safe; a filtered call costs about 10 ns, an exact one a few microseconds.
#pragma once

#include <antumbra/math.hpp>

#include <cstdint>

namespace antumbra {

/// How often each level decided. Owned by the caller; the calls below add to it when it is given.
struct PredicateTally {
    std::uint64_t filtered = 0; ///< decided by doubles and a proven error bound
    std::uint64_t exact = 0;    ///< decided by expansion arithmetic
    PredicateTally& operator+=(const PredicateTally& other) {
        filtered += other.filtered;
        exact += other.exact;
        return *this;
    }
};

/// Whether the predicates are proven for this point.
bool in_exact_range(const Vec3d& p);

/// Sign of ((b - a) x (c - a)) . (d - a): 1 if d lies in front of the triangle abc (counter-clockwise seen
/// from d), -1 behind, 0 in its plane.
int orient3d(const Vec3d& a, const Vec3d& b, const Vec3d& c, const Vec3d& d, PredicateTally* tally = nullptr);

/// Sign of (b - a) x (c - a) in the plane left when the coordinate `axis` is dropped (the next two, in cyclic
/// order, stay).
int orient2d(const Vec3d& a, const Vec3d& b, const Vec3d& c, int axis, PredicateTally* tally = nullptr);

struct TrianglePoints {
    Vec3d a, b, c;
};

/// Compares where the line p + t (q - p) meets the planes of two triangles: sign of t(first) - t(second). The
/// line must not be parallel to either plane.
int compare_crossings(const Vec3d& p, const Vec3d& q, const TrianglePoints& first,
                      const TrianglePoints& second, PredicateTally* tally = nullptr);

/// The same for a plane and the point where the line, which lies in the plane of a, b and of coordinate axis
/// `axis`, meets the line ab there: sign of t(edge ab, seen along `axis`) - t(triangle). The line must not be
/// parallel to the plane, nor, seen along `axis`, to ab.
int compare_edge_crossing(const Vec3d& p, const Vec3d& q, const Vec3d& a, const Vec3d& b, int axis,
                          const TrianglePoints& triangle, PredicateTally* tally = nullptr);

/// The exact level alone, for tests of agreement.
namespace exact {
int orient3d(const Vec3d& a, const Vec3d& b, const Vec3d& c, const Vec3d& d);
int orient2d(const Vec3d& a, const Vec3d& b, const Vec3d& c, int axis);
int compare_crossings(const Vec3d& p, const Vec3d& q, const TrianglePoints& first,
                      const TrianglePoints& second);
} // namespace exact

} // namespace antumbra
