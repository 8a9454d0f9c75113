// A plain hierarchical z-buffer (Greene, Kass, Miller 1993): nearness per pixel, and above it levels that hold the
// least of four. Scalar; the portable fallback and the twin that the masked buffer is tested against.
#pragma once

#include "raster/patch_raster.hpp"
#include "raster/pixel_rect.hpp"

namespace antumbra {

struct DepthPyramid {
    struct Level {
        int width = 0, height = 0;
        std::vector<float> nearness; ///< of everything below the texel, at least; -infinity: something is open
    };
    std::vector<Level> levels; ///< 0: the pixels

    /// Empty, for that screen.
    void reset(const Screen& screen);
    void merge(const PatchCoverage& coverage);
    /// Fills the levels above 0: after merging, before asking.
    void build();
    /// As is_hidden of tile_buffer.hpp: the level on which the box's rectangle spans at most four texels a side.
    bool is_hidden(const PixelRect& rect, float nearness) const;

  private:
    /// Raises the pixels of a tile that `mask` names to `nearness`.
    void raise(int tile_x, int tile_y, std::uint64_t mask, float nearness);
};

} // namespace antumbra
