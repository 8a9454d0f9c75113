// The opacity map (Poon, Wang 1999, 5.1 and 5.2): how many pixels of any rectangle occluders cover, by four look-ups.
#pragma once

#include "raster/occluder_image.hpp"
#include "raster/pixel_rect.hpp"

namespace antumbra {

/// at(x, y) is the number of covered pixels in columns 1..x and rows 1..y, counted from the lower left corner; an extra
/// column and row of zeros (x = 0, y = 0) do away with the cases at the border.
struct OpacityMap {
    int width = 0, height = 0;
    std::vector<std::uint32_t> table; ///< (height + 1) rows of width + 1

    /// O(pixels).
    void build(const OccluderImage& image);

    std::uint32_t at(int x, int y) const {
        return table[static_cast<std::size_t>(y) * static_cast<std::size_t>(width + 1) + static_cast<std::size_t>(x)];
    }
    /// The paper's opacity function OPF: covered pixels with x1 < x <= x2 and y1 < y <= y2. Three integer operations.
    std::uint32_t covered(int x1, int x2, int y1, int y2) const {
        return at(x1, y1) - at(x1, y2) - at(x2, y1) + at(x2, y2);
    }
    /// Of a rectangle of pixels counted from zero, borders included.
    std::uint32_t covered(const PixelRect& rect) const {
        return covered(rect.x0, rect.x1 + 1, rect.y0, rect.y1 + 1);
    }
    /// The overlap test: at most `tolerance` of the rectangle's pixels are open. Anything but 0 is approximate: what
    /// shows through the holes is lost.
    bool overlaps(const PixelRect& rect, float tolerance = 0) const {
        auto area = static_cast<std::uint32_t>(rect.area());
        return area - covered(rect) <= static_cast<std::uint32_t>(tolerance * static_cast<float>(area));
    }
};

/// What the paper measures against: every pixel is looked at.
bool overlaps_pixel_wise(const OccluderImage& image, const PixelRect& rect);
/// Is `nearness` (of a box's nearest point) behind every covered pixel of the rectangle?
bool is_behind_pixel_wise(const OccluderImage& image, const PixelRect& rect, float nearness);

} // namespace antumbra
