#include "raster/opacity_map.hpp"

#include <algorithm>

namespace antumbra {

void OpacityMap::build(const OccluderImage& image) {
    width = image.width;
    height = image.height;
    auto stride = static_cast<std::size_t>(width + 1);
    table.resize(stride * static_cast<std::size_t>(height + 1));
    std::fill_n(table.begin(), stride, 0u);
    for (int y = 0; y < height; ++y) {
        const std::uint32_t* below = table.data() + static_cast<std::size_t>(y) * stride;
        std::uint32_t* row = table.data() + static_cast<std::size_t>(y + 1) * stride;
        if (!image.row_used[static_cast<std::size_t>(y)]) { // as the row below: nothing is added
            std::copy_n(below, stride, row);
            continue;
        }
        row[0] = 0;
        const std::uint64_t* bits = image.bits.data() + y * image.words;
        std::uint32_t sum = 0;
        for (int x = 0; x < width; ++x) {
            sum += static_cast<std::uint32_t>(bits[x >> 6] >> (x & 63) & 1);
            row[x + 1] = below[x + 1] + sum;
        }
    }
}

bool overlaps_pixel_wise(const OccluderImage& image, const PixelRect& rect) {
    for (int y = rect.y0; y <= rect.y1; ++y)
        for (int x = rect.x0; x <= rect.x1; ++x)
            if (!image.is_covered(x, y))
                return false;
    return true;
}

bool is_behind_pixel_wise(const OccluderImage& image, const PixelRect& rect, float nearness) {
    for (int y = rect.y0; y <= rect.y1; ++y)
        for (int x = rect.x0; x <= rect.x1; ++x)
            if (image.is_covered(x, y) && !(image.nearness[static_cast<std::size_t>(y * image.stride + x)] > nearness))
                return false;
    return true;
}

} // namespace antumbra
