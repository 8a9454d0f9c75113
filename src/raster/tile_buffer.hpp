// Masked depth: per tile of 8 x 8 pixels one nearness for all of it and one for the pixels of a mask, in the manner
// of masked software occlusion culling (Hasselgren, Andersson, Akenine-Moeller 2016), but fed with coverage that is
// inner-conservative (patch_raster.hpp).
#pragma once

#include "raster/patch_raster.hpp"

namespace antumbra {

/// Every pixel of a tile is covered by something at least as near as `whole`; those of `mask` by something at least
/// as near as `part`.
struct TileBuffer {
    int tiles_x = 0, tiles_y = 0;
    std::vector<float> whole, part;
    std::vector<std::uint64_t> mask;

    /// Empty, for that screen. Allocates only when the screen grows.
    void reset(const Screen& screen);
    /// Takes in a drawn patch. Whatever the order, the promise above holds.
    void merge(const PatchCoverage& coverage);
};

/// Is the box certainly hidden: every pixel that its rectangle touches is covered by something strictly nearer?
/// All kernels agree.
using IsHidden = bool (*)(const TileBuffer& buffer, const Screen& screen, const BoxOnScreen& box);
bool is_hidden_scalar(const TileBuffer& buffer, const Screen& screen, const BoxOnScreen& box);
IsHidden is_hidden_avx2(); ///< nullptr where it is not available
IsHidden is_hidden_avx512();

} // namespace antumbra
