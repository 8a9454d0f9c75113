// The sparse depth map (Poon, Wang 1999, 5.3 and 5.4): along a row depth falls and rises; whoever lies behind the
// peaks lies behind all. Every pixel knows how far it is to the next peak on its right.
//
// Depth is compared at the leftmost pixel, then from peak to peak. Added to the paper: when the next peak lies beyond
// the rectangle's right edge, depth may rise up to that edge, so that the last pixel inside must be compared too.
#pragma once

#include "raster/occluder_image.hpp"
#include "raster/pixel_rect.hpp"

namespace antumbra {

struct SparseDepthMap {
    int width = 0, height = 0;
    std::vector<std::uint16_t> step;   ///< pixels to the next peak on the right; past the row if there is none
    std::vector<std::uint8_t> built;   ///< rows without occluders are not built
    std::uint64_t pixels = 0, peaks = 0; ///< of the rows that were built

    /// From right to left, row by row. O(pixels).
    void build(const OccluderImage& image);
    /// Whether there is enough to skip: less than half of the pixels are peaks.
    bool is_worth_it() const { return 2 * peaks < pixels; }

    /// Is `nearness` (of a box's nearest point) behind all pixels of the rectangle that hold a depth? As
    /// is_behind_pixel_wise; exactly so where every pixel of the rectangle is covered, and where it is not (a
    /// tolerant overlap test) open pixels count as lying in front of all depths.
    bool is_behind(const OccluderImage& image, const PixelRect& rect, float nearness) const;
};

} // namespace antumbra
