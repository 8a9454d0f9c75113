// Masked depth: per tile of 8 x 8 pixels one nearness for all of it and one for the pixels of a mask, in the manner
// of masked software occlusion culling (Hasselgren, Andersson, Akenine-Moeller 2016), but fed with coverage that is
// inner-conservative (patch_raster.hpp).
#pragma once

#include "raster/patch_raster.hpp"
#include "raster/pixel_rect.hpp"

namespace antumbra {

inline constexpr std::uint32_t kMostOwners = 16;

/// Every pixel of a tile is covered by something at least as near as `whole`; those of `mask` by something at least
/// as near as `part`.
struct TileBuffer {
    int tiles_x = 0, tiles_y = 0;
    int stride = 0; ///< tiles from one row to the next: whole blocks of eight, as in PatchCoverage
    std::vector<float> whole, part;
    std::vector<std::uint64_t> mask;
    std::vector<std::uint32_t> owner; ///< the patch that changed the tile last

    /// Empty, for that screen. Allocates only when the screen grows.
    void reset(const Screen& screen);
    /// Takes in a drawn patch. Whatever the order, the promise above holds.
    void merge(const PatchCoverage& coverage, std::uint32_t patch = 0);

    /// Calls use(patch) for the owners of the tiles that the rectangle touches, of at most kMostOwners of them.
    template <class Use>
    void for_owners(const PixelRect& rect, Use&& use) const {
        int x0 = rect.x0 / kTile, x1 = rect.x1 / kTile, y0 = rect.y0 / kTile, y1 = rect.y1 / kTile;
        int step_x = 1 + (x1 - x0) / 4, step_y = 1 + (y1 - y0) / 4;
        for (int y = y0; y <= y1; y += step_y)
            for (int x = x0; x <= x1; x += step_x)
                use(owner[static_cast<std::size_t>(y * stride + x)]);
    }
};

/// Is what touches these pixels and is nowhere nearer than `nearness` certainly hidden: is every one of them covered by
/// something strictly nearer? Never if the rectangle is empty. All kernels agree.
using IsHidden = bool (*)(const TileBuffer& buffer, const PixelRect& rect, float nearness);
bool is_hidden_scalar(const TileBuffer& buffer, const PixelRect& rect, float nearness);
IsHidden is_hidden_avx2(); ///< nullptr where it is not available
IsHidden is_hidden_avx512();

} // namespace antumbra
