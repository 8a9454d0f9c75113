#include "occluder_finding/free_boxes.hpp"

#include "occluder_finding/inside_tests.hpp"

#include <algorithm>
#include <optional>

namespace antumbra {
namespace {

using grid::Point;
using grid::Triangle;

/// Cells times triangles that are tried one by one.
constexpr std::size_t kMostCellTests = 1 << 18;

/// Distinct coordinates of the vertices along one axis, ascending.
std::vector<std::int64_t> coordinates(const GridMesh& mesh, std::size_t axis) {
    std::vector<std::int64_t> values;
    for (const Triangle& triangle : mesh.triangles)
        for (const Point& corner : triangle)
            values.push_back(corner[axis]);
    std::sort(values.begin(), values.end());
    values.erase(std::unique(values.begin(), values.end()), values.end());
    return values;
}

/// The bounds of a mesh cut into cells; a cell is free if it lies inside. Meshes made of few planes along the axes are
/// cut at their own coordinates, others evenly.
class Cells {
  public:
    Cells(const GridMesh& mesh, std::uint32_t resolution, bool any_winding) : mesh_(mesh), any_winding_(any_winding) {
        std::int64_t longest = 1;
        for (std::size_t k = 0; k < 3; ++k)
            longest = std::max(longest, mesh.max[k] - mesh.min[k]);
        bool exact = true;
        for (std::size_t k = 0; k < 3; ++k) {
            borders_[k] = coordinates(mesh, k);
            exact = exact && borders_[k].size() <= resolution + 1;
        }
        std::size_t cells = (borders_[0].size() - 1) * (borders_[1].size() - 1) * (borders_[2].size() - 1);
        if (!exact || cells * mesh.triangles.size() > kMostCellTests)
            for (std::size_t k = 0; k < 3; ++k)
                cut_evenly(k, resolution, longest);
        for (std::size_t k = 0; k < 3; ++k)
            count_[k] = static_cast<int>(borders_[k].size()) - 1;
        exact_ = exact && cells * mesh.triangles.size() <= kMostCellTests;
        free_.assign(static_cast<std::size_t>(count_[0]) * static_cast<std::size_t>(count_[1]) *
                         static_cast<std::size_t>(count_[2]), 1);
        for (const Triangle& triangle : mesh.triangles)
            mark_touched(triangle);
        if (exact_)
            keep_inside_each();
        else
            keep_inside();
    }

    /// The free box of cells with the largest surface; worth 0 if there is none. Its cells are free no more.
    GridBox take_largest() {
        GridBox best{};
        std::array<int, 3> low{}, high{};
        for (low[0] = 0; low[0] < count_[0]; ++low[0])
            for (high[0] = low[0]; high[0] < count_[0]; ++high[0])
                for (low[1] = 0; low[1] < count_[1]; ++low[1])
                    for (high[1] = low[1]; high[1] < count_[1]; ++high[1])
                        longest_run(low, high, best);
        for (int k = 0; best.worth() > 0 && k < count_[2]; ++k)
            for (int j = 0; j < count_[1]; ++j)
                for (int i = 0; i < count_[0]; ++i)
                    if (GridBox cell = cell_box({i, j, k}, {i, j, k}); holds(best, cell))
                        free_[index(i, j, k)] = 0;
        return best;
    }

  private:
    static bool holds(const GridBox& outer, const GridBox& inner) {
        for (std::size_t k = 0; k < 3; ++k)
            if (inner.min[k] < outer.min[k] || inner.max[k] > outer.max[k])
                return false;
        return true;
    }
    void cut_evenly(std::size_t axis, std::uint32_t resolution, std::int64_t longest) {
        std::int64_t size = mesh_.max[axis] - mesh_.min[axis];
        std::int64_t count = std::clamp<std::int64_t>(size * std::int64_t(resolution) / longest, 3, resolution);
        borders_[axis].clear();
        for (std::int64_t c = 0; c <= count; ++c)
            borders_[axis].push_back(mesh_.min[axis] + size * c / count);
    }
    std::int64_t border(std::size_t axis, int cell) const { return borders_[axis][static_cast<std::size_t>(cell)]; }
    std::size_t index(int i, int j, int k) const {
        return static_cast<std::size_t>(i + count_[0] * (j + count_[1] * k));
    }
    GridBox cell_box(const std::array<int, 3>& low, const std::array<int, 3>& high) const {
        GridBox box{};
        for (std::size_t axis = 0; axis < 3; ++axis) {
            box.min[axis] = border(axis, low[axis]);
            box.max[axis] = border(axis, high[axis] + 1);
        }
        return box;
    }
    /// Too thin a cell has no point strictly inside.
    static bool is_thick(const GridBox& box) {
        return box.max[0] - box.min[0] > 2 && box.max[1] - box.min[1] > 2 && box.max[2] - box.min[2] > 2;
    }

    void mark_touched(const Triangle& triangle) {
        std::array<int, 3> low{}, high{};
        for (std::size_t axis = 0; axis < 3; ++axis) {
            auto [from, to] = std::minmax({triangle[0][axis], triangle[1][axis], triangle[2][axis]});
            while (low[axis] + 1 < count_[axis] && border(axis, low[axis] + 1) < from)
                ++low[axis];
            high[axis] = low[axis];
            while (high[axis] + 1 < count_[axis] && border(axis, high[axis] + 1) <= to)
                ++high[axis];
        }
        for (int k = low[2]; k <= high[2]; ++k)
            for (int j = low[1]; j <= high[1]; ++j)
                for (int i = low[0]; i <= high[0]; ++i) {
                    char& cell = free_[index(i, j, k)];
                    GridBox box = cell_box({i, j, k}, {i, j, k});
                    // Evenly cut cells keep off the surface: neighbours then share one winding number.
                    if (cell && (!is_thick(box) || (exact_ ? enters(box.min, box.max, triangle)
                                                           : touches(box.min, box.max, triangle))))
                        cell = 0;
                }
    }

    void keep_inside_each() {
        for (int k = 0; k < count_[2]; ++k)
            for (int j = 0; j < count_[1]; ++j)
                for (int i = 0; i < count_[0]; ++i)
                    if (free_[index(i, j, k)] && !is_inside(cell_box({i, j, k}, {i, j, k})).value_or(false))
                        free_[index(i, j, k)] = 0;
    }

    /// Face-connected free cells share one winding number; only those inside stay free.
    void keep_inside() {
        std::vector<char> todo = free_;
        for (int k = 0; k < count_[2]; ++k)
            for (int j = 0; j < count_[1]; ++j)
                for (int i = 0; i < count_[0]; ++i) {
                    if (!todo[index(i, j, k)])
                        continue;
                    std::vector<std::array<int, 3>> component{{i, j, k}};
                    todo[index(i, j, k)] = 0;
                    for (std::size_t at = 0; at < component.size(); ++at)
                        for (std::size_t axis = 0; axis < 3; ++axis)
                            for (int side : {-1, 1}) {
                                std::array<int, 3> next = component[at];
                                next[axis] += side;
                                if (next[axis] < 0 || next[axis] >= count_[axis] ||
                                    !todo[index(next[0], next[1], next[2])])
                                    continue;
                                todo[index(next[0], next[1], next[2])] = 0;
                                component.push_back(next);
                            }
                    if (!is_inside(component))
                        for (const std::array<int, 3>& cell : component)
                            free_[index(cell[0], cell[1], cell[2])] = 0;
                }
    }

    bool is_inside(const std::vector<std::array<int, 3>>& component) const {
        for (std::size_t i = 0; i < component.size() && i < 8; ++i)
            if (std::optional<bool> inside = is_inside(cell_box(component[i], component[i])))
                return *inside;
        return false;
    }

    /// Nothing if no point could be decided.
    std::optional<bool> is_inside(const GridBox& box) const {
        // Any point will do; uneven shares keep the ray off the edges of regular meshes.
        constexpr std::int64_t kShares[3][3] = {{5, 4, 7}, {6, 7, 3}, {3, 8, 5}};
        for (const auto& shares : kShares) {
            Point inside;
            for (std::size_t axis = 0; axis < 3; ++axis) {
                std::int64_t size = box.max[axis] - box.min[axis];
                inside[axis] = box.min[axis] + std::clamp<std::int64_t>(size * shares[axis] / 11, 1, size - 1);
            }
            int winding = 0;
            if (winding_number(inside, mesh_.triangles, winding))
                return winding > 0 || (any_winding_ && winding != 0);
        }
        return {};
    }

    void longest_run(std::array<int, 3> low, std::array<int, 3> high, GridBox& best) const {
        for (low[2] = 0; low[2] < count_[2]; low[2] = high[2] + 1) {
            high[2] = low[2];
            while (high[2] < count_[2] && is_free_slab(low, high, high[2]))
                ++high[2];
            if (high[2] == low[2])
                continue;
            --high[2];
            GridBox box = cell_box(low, high);
            if (box.worth() > best.worth())
                best = box;
        }
    }
    bool is_free_slab(const std::array<int, 3>& low, const std::array<int, 3>& high, int k) const {
        for (int j = low[1]; j <= high[1]; ++j)
            for (int i = low[0]; i <= high[0]; ++i)
                if (!free_[index(i, j, k)])
                    return false;
        return true;
    }

    const GridMesh& mesh_;
    bool any_winding_, exact_ = false;
    std::array<std::vector<std::int64_t>, 3> borders_;
    std::array<int, 3> count_{};
    std::vector<char> free_;
};

/// Pushes each face outward while no triangle enters: nothing that the box sweeps over on the way does so either, hence
/// its winding number stays. To a vertex's coordinate if that helps, else by halving steps.
void grow(GridBox& box, const GridMesh& mesh) {
    auto is_clear = [&](const GridBox& grown) {
        return std::none_of(mesh.triangles.begin(), mesh.triangles.end(),
                            [&](const Triangle& t) { return enters(grown.min, grown.max, t); });
    };
    if (!is_clear(box)) // a box of several cells with triangles between them
        return;
    for (std::size_t axis = 0; axis < 3; ++axis) {
        std::vector<std::int64_t> stops = coordinates(mesh, axis);
        for (bool upper : {false, true}) {
            auto face = [&](GridBox& b) -> std::int64_t& { return (upper ? b.max : b.min)[axis]; };
            std::int64_t sign = upper ? 1 : -1;
            auto try_at = [&](std::int64_t at) {
                GridBox grown = box;
                face(grown) = at;
                if ((at - face(box)) * sign <= 0 || !is_clear(grown))
                    return false;
                box = grown;
                return true;
            };
            std::size_t low = 0, high = stops.size(); // bisects for the farthest stop that is clear
            while (low < high) {
                std::size_t middle = (low + high) / 2;
                std::int64_t at = upper ? stops[middle] : stops[stops.size() - 1 - middle];
                bool ahead = (at - face(box)) * sign > 0;
                if (!ahead || try_at(at))
                    low = middle + 1;
                else
                    high = middle;
            }
            std::int64_t room = upper ? mesh.max[axis] - box.max[axis] : box.min[axis] - mesh.min[axis];
            for (std::int64_t step = room / 2, i = 0; step > 0 && i < 8; step /= 2, ++i)
                try_at(face(box) + sign * step);
        }
    }
}

} // namespace

std::vector<GridBox> largest_free_boxes(const GridMesh& mesh, std::uint32_t resolution, bool any_winding,
                                        std::uint32_t most) {
    std::vector<GridBox> boxes;
    for (std::size_t k = 0; k < 3; ++k)
        if (mesh.max[k] - mesh.min[k] < 3) // a flat thing has no inside
            return boxes;
    Cells cells(mesh, resolution, any_winding);
    for (std::uint32_t n = 0; n < most; ++n) {
        GridBox box = cells.take_largest();
        if (!(box.worth() > 0) || (!boxes.empty() && box.worth() < 0.2 * boxes[0].worth()))
            break;
        grow(box, mesh);
        boxes.push_back(box);
    }
    return boxes;
}

} // namespace antumbra
