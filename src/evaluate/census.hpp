// What the cells of a .pvs see, counted.
#pragma once

#include <antumbra/pvs.hpp>

#include <cstdint>
#include <vector>

namespace antumbra {

/// A cell of the grid, or a leaf of the view tree.
struct CensusCell {
    std::uint64_t index = 0; ///< of the cell, or of the leaf's node
    Box3d box;               ///< world
    ViewRegion region;       ///< of a leaf, in steps; whole in a grid
    std::uint32_t row = 0;   ///< or kCellSolid, kCellNotBaked
    std::uint32_t visible = 0; ///< objects seen, where there is a row
    bool baked() const { return row < kCellSolid; }
};

struct CensusObject {
    std::uint32_t object = 0;
    std::uint64_t cells = 0; ///< that see it
    std::uint64_t cost = 0;  ///< triangles drawn for it over all cells
};

struct Census {
    std::vector<CensusCell> cells; ///< in the order of the file
    std::uint64_t baked = 0, solid = 0, not_baked = 0;
    double mean_visible = 0;           ///< objects, over baked cells
    double mean_visible_triangles = 0; ///< triangles of those objects

    /// The `count` baked cells that see most, then by index.
    std::vector<CensusCell> worst(std::size_t count) const;
};

/// O(cells + rows * objects).
Census take_census(const Pvs& pvs);

/// The `count` objects that cost most: triangles times cells that see them; then by index.
std::vector<CensusObject> costliest_objects(const Pvs& pvs, const Census& census, std::size_t count);

/// A page of its own: the cells from above, coloured by how much they see, with the tables of both.
std::string census_page(const Pvs& pvs, const Census& census, const std::string& title);

} // namespace antumbra
