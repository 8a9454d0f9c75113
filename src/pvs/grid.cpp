// The cell grid: which box a cell is, and which cell a point is in. Both use the same boundary(), so that they
// agree to the last bit.
#include <antumbra/pvs.hpp>

#include "pvs/grid.hpp"

namespace antumbra {
namespace {

/// World coordinate where slab `i` of an axis begins; i = count is the far face. Never decreases with i.
double boundary(const CellGrid& grid, int axis, std::uint64_t i) {
    double low = grid.bounds.min[axis], high = grid.bounds.max[axis];
    std::uint32_t count = grid.count[static_cast<std::size_t>(axis)];
    if (i >= count)
        return high;
    return std::min(high, low + (high - low) * double(i) / double(count));
}

/// The last slab that begins at or below `x`, which lies between the faces.
std::uint64_t find_slab(const CellGrid& grid, int axis, double x) {
    double low = grid.bounds.min[axis], high = grid.bounds.max[axis];
    std::uint64_t count = grid.count[static_cast<std::size_t>(axis)], first = 0, last = count;
    // The quotient is right or off by one, except where slabs are thinner than the spacing of doubles.
    double guess = (x - low) / (high - low) * double(count);
    std::uint64_t slab = guess >= 0 ? std::min(count - 1, std::uint64_t(std::min(guess, 4294967295.0))) : 0;
    if (boundary(grid, axis, slab) <= x)
        first = slab;
    else
        last = slab;
    if (first == slab && (slab + 1 == count || boundary(grid, axis, slab + 1) > x))
        return slab;
    while (last - first > 1) {
        std::uint64_t middle = first + (last - first) / 2;
        (boundary(grid, axis, middle) <= x ? first : last) = middle;
    }
    return first;
}

} // namespace

Box3d CellGrid::cell(std::uint64_t index) const {
    Box3d box;
    for (int axis = 0; axis < 3; ++axis) {
        std::uint64_t n = count[static_cast<std::size_t>(axis)], slab = index % n;
        box.min[axis] = boundary(*this, axis, slab);
        box.max[axis] = boundary(*this, axis, slab + 1);
        index /= n;
    }
    return box;
}

std::int64_t CellGrid::find(const Vec3d& eye) const {
    if (!bounds.contains(eye) || count[0] == 0 || count[1] == 0 || count[2] == 0)
        return -1;
    std::uint64_t i = find_slab(*this, 0, eye.x), j = find_slab(*this, 1, eye.y), k = find_slab(*this, 2, eye.z);
    return static_cast<std::int64_t>(i + count[0] * (j + count[1] * k));
}

bool is_usable(const CellGrid& grid, std::uint64_t& cells) {
    const auto& n = grid.count;
    cells = 0;
    if (n[0] == 0 && n[1] == 0 && n[2] == 0)
        return true;
    constexpr std::uint64_t kMostCells = std::uint64_t(1) << 48;
    std::uint64_t layer = std::uint64_t(n[0]) * n[1];
    if (layer == 0 || n[2] == 0 || layer > kMostCells / n[2])
        return false;
    for (int axis = 0; axis < 3; ++axis) {
        double low = grid.bounds.min[axis], high = grid.bounds.max[axis];
        // The product inside boundary() must stay finite too.
        if (!(low <= high) || !std::isfinite(low) || !std::isfinite((high - low) * 4294967296.0))
            return false;
    }
    cells = layer * n[2];
    return true;
}

} // namespace antumbra
