#pragma once

#include <antumbra/pvs.hpp>

namespace antumbra {

/// Whether a grid can be asked: all counts zero (no cells), or all positive, their product below 2^48 and the
/// bounds finite. `cells` becomes their product.
bool is_usable(const CellGrid& grid, std::uint64_t& cells);

} // namespace antumbra
