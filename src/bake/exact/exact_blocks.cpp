#include "bake/exact/exact_blocks.hpp"

#include <algorithm>
#include <map>

namespace antumbra {
namespace {

using Place = std::array<std::uint64_t, 3>;

Place place_of(const CellGrid& grid, std::uint64_t cell) {
    return {cell % grid.count[0], cell / grid.count[0] % grid.count[1], cell / grid.count[0] / grid.count[1]};
}

class BlockSolver {
  public:
    BlockSolver(const ExactCells& exact, const CellGrid& grid, const std::atomic<bool>* cancel)
        : exact_(exact), grid_(grid), cancel_(cancel) {}

    /// Cells of a cube of `edge` cells. False: cancelled.
    bool solve(std::span<const std::uint64_t> cells, std::uint32_t edge, const exact::HiddenParts& hidden) {
        if (cells.size() == 1) {
            ExactCell cell = exact_.solve(grid_.cell(cells[0]), cancel_, hidden);
            bool finished = cell.finished;
            solved_[cells[0]] = std::move(cell);
            return finished;
        }
        exact::HiddenParts proved;
        Box3d around;
        for (std::uint64_t cell : cells)
            around.extend(grid_.cell(cell));
        if (!exact_.hide(around, hidden, proved, work_, cancel_))
            return false;
        std::uint32_t half = edge / 2;
        std::map<Place, std::vector<std::uint64_t>> parts;
        for (std::uint64_t cell : cells) {
            Place place = place_of(grid_, cell);
            for (std::uint64_t& k : place)
                k /= half;
            parts[place].push_back(cell);
        }
        return std::all_of(parts.begin(), parts.end(),
                           [&](const auto& part) { return solve(part.second, half, proved); });
    }

    std::vector<ExactCell> take() {
        std::vector<ExactCell> cells;
        for (auto& [number, cell] : solved_)
            cells.push_back(std::move(cell));
        add(cells.front().work, work_);
        return cells;
    }

  private:
    const ExactCells& exact_;
    const CellGrid& grid_;
    const std::atomic<bool>* cancel_;
    std::map<std::uint64_t, ExactCell> solved_;
    ExactStatistics work_;
};

} // namespace

CellBlocks::CellBlocks(const CellGrid& grid, std::span<const std::uint64_t> cells, std::uint32_t edge) {
    std::map<std::uint64_t, std::vector<std::uint64_t>> blocks;
    std::uint64_t x = (grid.count[0] + edge - 1) / edge, y = (grid.count[1] + edge - 1) / edge;
    for (std::uint64_t cell : cells) {
        Place at = place_of(grid, cell);
        blocks[at[0] / edge + x * (at[1] / edge + y * (at[2] / edge))].push_back(cell);
    }
    for (auto& [id, members] : blocks) {
        ids_.push_back(id);
        cells_.push_back(std::move(members));
    }
}

const std::vector<std::uint64_t>& CellBlocks::cells(std::uint64_t id) const {
    return cells_[std::size_t(std::lower_bound(ids_.begin(), ids_.end(), id) - ids_.begin())];
}

std::vector<ExactCell> solve_block(const ExactCells& exact, const CellGrid& grid, std::span<const std::uint64_t> cells,
                                   std::uint32_t edge, const std::atomic<bool>* cancel) {
    BlockSolver solver(exact, grid, cancel);
    if (!solver.solve(cells, edge, {}))
        return {};
    return solver.take();
}

} // namespace antumbra
