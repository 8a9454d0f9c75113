// Equal slabs along an axis, shared by cell grids and view trees.
#pragma once

#include <antumbra/pvs.hpp>

namespace antumbra {

/// Coordinate where slab `i` of `count` equal ones between `low` and `high` begins; i >= count gives `high`. Never
/// decreases with i.
double slab_start(double low, double high, std::uint64_t count, std::uint64_t i);

/// The last slab that begins at or below `x`, for low <= x <= high and count > 0: agrees with slab_start to the last
/// bit.
std::uint64_t find_slab(double low, double high, std::uint64_t count, double x);

/// Whether slab_start gives finite numbers between these bounds, for counts below 2^32.
bool are_usable_bounds(const Box3d& bounds);

/// Whether a grid can be asked: all counts zero (no cells), or all positive, their product at most 2^48 and the bounds
/// usable. `cells` becomes their product.
bool is_usable(const CellGrid& grid, std::uint64_t& cells);

/// First and last slab on each axis of the cells that a box inside the grid's bounds touches.
struct SlabRange {
    std::array<std::uint64_t, 3> first, last;
};
/// The cells that the points of `box` belong to (a point on a common face: to the cell above).
SlabRange slabs_of(const CellGrid& grid, const Box3d& box);

} // namespace antumbra
