// The opacity map for today's processors: rows of 64-bit words, one bit per pixel, and the farthest depth per span of
// a row. No table is built; an overlap test is a few masked comparisons with all ones.
#pragma once

#include "raster/occluder_image.hpp"
#include "raster/pixel_rect.hpp"

namespace antumbra {

/// Of one image, which must outlive it unchanged. Hides exactly what the opacity map of the same image and a pixel-wise
/// comparison of depths hide.
struct OpacityRows {
    static constexpr int kSpan = 16; ///< pixels with one depth between them

    /// Per row, stride / kSpan: the farthest covered pixel of the span. Open pixels do not count: the bits tell.
    std::vector<float> span_nearness;
    int spans = 0;

    /// Only the spans; the bits are the image's own. All kernels give the same bits.
    void build(const OccluderImage& image);

    /// Are all pixels of the rectangle covered?
    static bool overlaps(const OccluderImage& image, const PixelRect& rect) {
        const int first = rect.x0 >> 6, last = rect.x1 >> 6;
        const std::uint64_t low = ~std::uint64_t(0) << (rect.x0 & 63), high = ~std::uint64_t(0) >> (63 - (rect.x1 & 63));
        const std::uint64_t* row = image.bits.data() + rect.y0 * image.words + first;
        if (first == last) {
            const std::uint64_t mask = low & high;
            for (int y = rect.y0; y <= rect.y1; ++y, row += image.words)
                if (~*row & mask)
                    return false;
            return true;
        }
        for (int y = rect.y0; y <= rect.y1; ++y, row += image.words) {
            std::uint64_t open = (~row[0] & low) | (~row[last - first] & high);
            for (int word = 1; word < last - first; ++word)
                open |= ~row[word];
            if (open)
                return false;
        }
        return true;
    }
    /// Covered pixels of the rectangle.
    static std::uint32_t covered(const OccluderImage& image, const PixelRect& rect);

    /// Is `nearness` (of a box's nearest point) behind every pixel of the rectangle? All of them must be covered.
    bool is_behind(const OccluderImage& image, const PixelRect& rect, float nearness) const {
        const int first = rect.x0 / kSpan, last = rect.x1 / kSpan;
        for (int y = rect.y0; y <= rect.y1; ++y) {
            const float* row = span_nearness.data() + y * spans;
            for (int span = first; span <= last; ++span)
                if (!(row[span] > nearness) && !pixels_behind(image, rect, y, span, nearness))
                    return false;
        }
        return true;
    }

  private:
    static bool pixels_behind(const OccluderImage& image, const PixelRect& rect, int y, int span, float nearness);
};

} // namespace antumbra
