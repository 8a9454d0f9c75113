// Masked depth: per tile of 8 x 8 pixels one nearness for all of it and one for the pixels of a mask, in the manner
// of masked software occlusion culling (Hasselgren, Andersson, Akenine-Moeller 2016), but fed with coverage that is
// inner-conservative (patch_raster.hpp).
#pragma once

#include "raster/patch_raster.hpp"

#include <algorithm>

namespace antumbra {

/// Every pixel of a tile is covered by something at least as near as `whole`; those of `mask` by something at least
/// as near as `part`.
struct TileBuffer {
    int tiles_x = 0, tiles_y = 0;
    std::vector<float> whole, part;
    std::vector<std::uint64_t> mask;
    std::vector<std::uint32_t> owner; ///< the patch that changed the tile last

    /// Empty, for that screen. Allocates only when the screen grows.
    void reset(const Screen& screen);
    /// Takes in a drawn patch. Whatever the order, the promise above holds.
    void merge(const PatchCoverage& coverage, std::uint32_t patch = 0);

    /// Calls use(patch) for the owners of the tiles that the box touches, of at most about 16 of them.
    template <class Use>
    void for_owners(const BoxOnScreen& box, Use&& use) const {
        auto tile = [](float value, int tiles) {
            return std::clamp(static_cast<int>(std::clamp(value, 0.0f, float(tiles * kTile))) / kTile, 0, tiles - 1);
        };
        int x0 = tile(box.min_x, tiles_x), x1 = tile(box.max_x, tiles_x);
        int y0 = tile(box.min_y, tiles_y), y1 = tile(box.max_y, tiles_y);
        int step_x = 1 + (x1 - x0) / 4, step_y = 1 + (y1 - y0) / 4;
        for (int y = y0; y <= y1; y += step_y)
            for (int x = x0; x <= x1; x += step_x)
                use(owner[static_cast<std::size_t>(y * tiles_x + x)]);
    }
};

/// Is the box certainly hidden: every pixel that its rectangle touches is covered by something strictly nearer?
/// All kernels agree.
using IsHidden = bool (*)(const TileBuffer& buffer, const Screen& screen, const BoxOnScreen& box);
bool is_hidden_scalar(const TileBuffer& buffer, const Screen& screen, const BoxOnScreen& box);
IsHidden is_hidden_avx2(); ///< nullptr where it is not available
IsHidden is_hidden_avx512();

} // namespace antumbra
