// What the pairs of a file are that proofs speak of: its cells as boxes, and its objects or clusters.
#pragma once

#include "bake/exact/units.hpp"

#include <antumbra/pvs.hpp>

namespace antumbra::exact {

struct BakedCell {
    std::uint64_t number = 0; ///< of the grid's cell, or of the leaf's node
    Box3d box;                ///< world
    std::uint32_t row = 0;
};

/// All cells with a row: of a grid, or leaves of a tree over space, by number. ErrorCode::usage where there is none, or where
/// the tree splits directions, too (such cells are no boxes).
Result<std::vector<BakedCell>> baked_cells(const Pvs& pvs);

/// What a file lists most finely: clusters, or else objects. ErrorCode::mismatch if the clusters hold other triangles than the
/// scene's. O(triangles).
Result<Units> units_of(const Scene& scene, const Pvs& pvs);
/// The bit of a unit in a row of the file.
std::size_t bit_of(const Pvs& pvs, std::uint32_t unit);
bool is_always_visible(const Scene& scene, const Pvs& pvs, const Units& units, std::uint32_t unit);
/// For messages: "object 3", "cluster 7".
std::string name_of_unit(const Pvs& pvs, std::uint32_t unit);

} // namespace antumbra::exact
