// The cell grid: which box a cell is, and which cell a point is in. Both use the same slab_start(), so that they
// agree to the last bit.
#include "pvs/grid.hpp"

namespace antumbra {

double slab_start(double low, double high, std::uint64_t count, std::uint64_t i) {
    if (i >= count)
        return high;
    return std::min(high, low + (high - low) * double(i) / double(count));
}

std::uint64_t find_slab(double low, double high, std::uint64_t count, double x) {
    // The quotient is right or off by one, except where slabs are thinner than the spacing of doubles.
    double guess = (x - low) / (high - low) * double(count);
    std::uint64_t slab = guess >= 0 ? std::min(count - 1, std::uint64_t(std::min(guess, 4294967295.0))) : 0;
    std::uint64_t first = 0, last = count; // slab_start(first) <= x, and last is beyond the answer
    (slab_start(low, high, count, slab) <= x ? first : last) = slab;
    if (first == slab && (slab + 1 == count || slab_start(low, high, count, slab + 1) > x))
        return slab;
    while (last - first > 1) {
        std::uint64_t middle = first + (last - first) / 2;
        (slab_start(low, high, count, middle) <= x ? first : last) = middle;
    }
    return first;
}

bool are_usable_bounds(const Box3d& bounds) {
    for (int axis = 0; axis < 3; ++axis) {
        double low = bounds.min[axis], high = bounds.max[axis];
        // The product inside slab_start() must stay finite too.
        if (!(low <= high) || !std::isfinite(low) || !std::isfinite((high - low) * 4294967296.0))
            return false;
    }
    return true;
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
    cells = layer * n[2];
    return are_usable_bounds(grid.bounds);
}

SlabRange slabs_of(const CellGrid& grid, const Box3d& box) {
    SlabRange range{};
    for (int axis = 0; axis < 3; ++axis) {
        auto k = static_cast<std::size_t>(axis);
        double low = grid.bounds.min[axis], high = grid.bounds.max[axis];
        range.first[k] = find_slab(low, high, grid.count[k], box.min[axis]);
        range.last[k] = find_slab(low, high, grid.count[k], box.max[axis]);
    }
    return range;
}

Box3d CellGrid::cell(std::uint64_t index) const {
    Box3d box;
    for (int axis = 0; axis < 3; ++axis) {
        std::uint64_t n = count[static_cast<std::size_t>(axis)], slab = index % n;
        box.min[axis] = slab_start(bounds.min[axis], bounds.max[axis], n, slab);
        box.max[axis] = slab_start(bounds.min[axis], bounds.max[axis], n, slab + 1);
        index /= n;
    }
    return box;
}

std::int64_t CellGrid::find(const Vec3d& eye) const {
    if (!bounds.contains(eye) || count[0] == 0 || count[1] == 0 || count[2] == 0)
        return -1;
    std::uint64_t slab[3];
    for (int axis = 0; axis < 3; ++axis)
        slab[axis] = find_slab(bounds.min[axis], bounds.max[axis], count[static_cast<std::size_t>(axis)], eye[axis]);
    return static_cast<std::int64_t>(slab[0] + count[0] * (slab[1] + count[1] * slab[2]));
}

} // namespace antumbra
