// The opacity map for today's processors: rows of 64-bit words, one bit per pixel, and the farthest depth per span of
// a row, both for blocks of 1, 2, 4 .. rows. Any rectangle's rows are two such blocks, which may overlap: a test reads
// two rows of words and two rows of spans, however high the rectangle is.
#pragma once

#include "raster/occluder_image.hpp"
#include "raster/pixel_rect.hpp"

#include <bit>

namespace antumbra {

/// Of one image, which must outlive it unchanged. Hides exactly what the opacity map of the same image and a pixel-wise
/// comparison of depths hide.
struct OpacityRows {
    static constexpr int kSpan = 16; ///< pixels with one depth between them

    int height = 0, words = 0, spans = 0;
    /// Level k, row y at (k * height + y) * words: the columns that are covered in all rows y .. y + 2^k - 1.
    std::vector<std::uint64_t> covered_rows;
    /// Level k, row y at (k * height + y) * spans: the farthest covered pixel of the span in these rows. Open pixels do
    /// not count: the bits tell.
    std::vector<float> farthest;

    /// O(pixels + rows * log(rows) * (words + spans)): no sums, only ands and minima, whole registers at a time. All
    /// instruction sets give the same bits.
    void build(const OccluderImage& image);

    /// Are all pixels of the rectangle covered?
    bool overlaps(const PixelRect& rect) const {
        const Blocks at = blocks(rect);
        const std::uint64_t* a = covered_rows.data() + at.first * words;
        const std::uint64_t* b = covered_rows.data() + at.last * words;
        const int first = rect.x0 >> 6, last = rect.x1 >> 6;
        const std::uint64_t low = ~std::uint64_t(0) << (rect.x0 & 63), high = ~std::uint64_t(0) >> (63 - (rect.x1 & 63));
        if (first == last)
            return (~(a[first] & b[first]) & low & high) == 0;
        std::uint64_t open = (~(a[first] & b[first]) & low) | (~(a[last] & b[last]) & high);
        for (int word = first + 1; word < last; ++word)
            open |= ~(a[word] & b[word]);
        return open == 0;
    }

    /// Is `nearness` (of a box's nearest point) behind every pixel of the rectangle? All of them must be covered.
    bool is_behind(const OccluderImage& image, const PixelRect& rect, float nearness) const {
        const Blocks at = blocks(rect);
        const float* a = farthest.data() + at.first * spans;
        const float* b = farthest.data() + at.last * spans;
        const int first = rect.x0 / kSpan, last = rect.x1 / kSpan;
        for (int span = first; span <= last; ++span)
            if (!(a[span] > nearness && b[span] > nearness) &&
                !(reaches_beyond(rect, span) && pixels_behind(image, rect, span, nearness)))
                return false;
        return true;
    }

    /// Covered pixels of the rectangle.
    static std::uint32_t covered(const OccluderImage& image, const PixelRect& rect) {
        return covered(image, rect, 1);
    }
    /// The share of covered pixels in some rows of the rectangle, at most nine: what an adaptive stop needs.
    static float covered_share(const OccluderImage& image, const PixelRect& rect) {
        const int rows = rect.y1 - rect.y0 + 1, step = (rows + 7) / 8, looked_at = (rows + step - 1) / step;
        return float(covered(image, rect, step)) / float(looked_at * (rect.x1 - rect.x0 + 1));
    }

  private:
    struct Blocks {
        std::ptrdiff_t first, last; ///< rows in the levels: block at the bottom, block at the top
    };
    Blocks blocks(const PixelRect& rect) const {
        const auto rows = static_cast<std::uint32_t>(rect.y1 - rect.y0 + 1);
        const int level = std::bit_width(rows) - 1;
        const std::ptrdiff_t base = static_cast<std::ptrdiff_t>(level) * height;
        return {base + rect.y0, base + rect.y1 + 1 - (1 << level)};
    }
    /// Spans that the rectangle holds only a part of.
    static bool reaches_beyond(const PixelRect& rect, int span) {
        return span * kSpan < rect.x0 || span * kSpan + kSpan - 1 > rect.x1;
    }
    static bool pixels_behind(const OccluderImage& image, const PixelRect& rect, int span, float nearness);
    static std::uint32_t covered(const OccluderImage& image, const PixelRect& rect, int step);
};

/// Are all pixels of the rectangle covered? Row by row, of an image that is still being drawn; an open row ends it.
inline bool overlaps_by_rows(const OccluderImage& image, const PixelRect& rect) {
    const int first = rect.x0 >> 6, last = rect.x1 >> 6;
    const std::uint64_t low = ~std::uint64_t(0) << (rect.x0 & 63), high = ~std::uint64_t(0) >> (63 - (rect.x1 & 63));
    const std::uint64_t* row = image.bits.data() + rect.y0 * image.words;
    for (int y = rect.y0; y <= rect.y1; ++y, row += image.words)
        for (int word = first; word <= last; ++word) {
            std::uint64_t open = ~row[word] & (word == first ? low : ~std::uint64_t(0));
            if (open & (word == last ? high : ~std::uint64_t(0)))
                return false;
        }
    return true;
}

/// Of the boxes in `wanted` (bits; all testable), those that are hidden: covered, and behind.
std::uint32_t hidden_of_eight(const OpacityRows& rows, const OccluderImage& image, const EightOnScreen& boxes,
                              std::uint32_t wanted);

} // namespace antumbra
