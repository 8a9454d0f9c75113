#include "bake/view_cells.hpp"

#include <cmath>

namespace antumbra {
namespace {

constexpr std::uint64_t kMostCells = std::uint64_t(1) << 28;

/// Cells along one axis, in whole steps.
struct Axis {
    double start = 0; ///< local, a multiple of the step
    double edge = 0;  ///< of a cell, a multiple of the step
    std::uint32_t count = 1;
};

Result<Axis> lay_axis(double low, double high, double step, std::uint32_t wanted, double cell_size) {
    Axis axis;
    double first = std::floor(low / step), last = std::max(std::ceil(high / step), first + 1);
    double steps = last - first;
    axis.start = first * step;
    double edge_steps = cell_size > 0 ? std::max(1.0, std::floor(cell_size / step + 0.5)) : std::ceil(steps / wanted);
    double count = std::ceil(steps / edge_steps);
    if (count > double(kMostCells))
        return Status(ErrorCode::limit, "the grid would have more than 2^28 cells along one axis; use larger cells");
    axis.edge = edge_steps * step;
    // A wanted count stays as it is even where rounding up the edge would do with fewer cells.
    axis.count = cell_size > 0 ? std::uint32_t(count) : wanted;
    return axis;
}

/// Indices of the cells whose interior a box reaches.
struct Range {
    std::uint32_t first = 0, last = 0; ///< [first, last)
};

Range reach(const Axis& axis, double low, double high) {
    double count = axis.count;
    double first = std::floor((low - axis.start) / axis.edge), last = std::ceil((high - axis.start) / axis.edge);
    if (last <= first)
        last = first + 1; // a flat box lies in the cell above it
    first = std::clamp(first, 0.0, count - 1);
    last = std::clamp(last, first + 1, count);
    return {std::uint32_t(first), std::uint32_t(last)};
}

bool sensible(const Box3d& box) { return is_finite(box.min) && is_finite(box.max) && !box.empty(); }

} // namespace

Result<ViewCells> lay_view_cells(const Scene& scene, const BakeOptions& options) {
    if (!std::isfinite(options.cell_size) || options.cell_size < 0)
        return Status(ErrorCode::usage, "the cell size must be a positive number of scene units");
    for (std::uint32_t count : options.cells)
        if (count == 0 || count > kMostCells)
            return Status(ErrorCode::usage, "each axis of the grid needs between 1 and 2^28 cells");
    Box3d bounds = to_double(scene.local_bounds());
    if (!options.where.empty()) {
        bounds = {};
        for (const Box3d& box : options.where) {
            if (!sensible(box))
                return Status(ErrorCode::usage, "a box of viewpoints is empty or not finite; min must not exceed max");
            bounds.extend(Box3d{scene.to_local(box.min), scene.to_local(box.max)});
        }
    }
    Axis axes[3];
    std::uint64_t cells = 1;
    for (int k = 0; k < 3; ++k) {
        Result<Axis> axis = lay_axis(bounds.min[k], bounds.max[k], scene.step(), options.cells[std::size_t(k)],
                                     options.cell_size);
        if (!axis)
            return axis.status();
        axes[k] = *axis;
        cells *= axes[k].count;
        if (cells > kMostCells)
            return Status(ErrorCode::limit, "the grid would have more than 2^28 cells; use larger cells or --where");
    }
    ViewCells view;
    Vec3d low, high;
    for (int k = 0; k < 3; ++k) {
        low[k] = axes[k].start;
        high[k] = axes[k].start + axes[k].edge * axes[k].count;
        view.grid.count[std::size_t(k)] = axes[k].count;
    }
    view.grid.bounds = {scene.to_world(low), scene.to_world(high)};

    std::vector<bool> touched(cells, options.where.empty());
    for (const Box3d& box : options.where) {
        Range range[3];
        Vec3d from = scene.to_local(box.min), to = scene.to_local(box.max);
        for (int k = 0; k < 3; ++k)
            range[k] = reach(axes[k], from[k], to[k]);
        for (std::uint64_t z = range[2].first; z < range[2].last; ++z)
            for (std::uint64_t y = range[1].first; y < range[1].last; ++y)
                for (std::uint64_t x = range[0].first; x < range[0].last; ++x)
                    touched[x + axes[0].count * (y + axes[1].count * z)] = true;
    }
    for (std::uint64_t cell = 0; cell < cells; ++cell)
        if (touched[cell])
            view.to_bake.push_back(cell);
    return view;
}

} // namespace antumbra
