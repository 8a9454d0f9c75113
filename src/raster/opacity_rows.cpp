#include "raster/opacity_rows.hpp"

#include <algorithm>
#include <bit>

namespace antumbra {

void OpacityRows::build(const OccluderImage& image) {
    constexpr float kOpen = -std::numeric_limits<float>::infinity(), kNone = std::numeric_limits<float>::infinity();
    spans = image.stride / kSpan;
    span_nearness.resize(static_cast<std::size_t>(spans) * static_cast<std::size_t>(image.height));
    for (int y = 0; y < image.height; ++y) {
        float* row = span_nearness.data() + y * spans;
        if (!image.row_used[static_cast<std::size_t>(y)]) {
            std::fill_n(row, spans, kNone);
            continue;
        }
        const float* pixels = image.nearness.data() + y * image.stride;
        for (int span = 0; span < spans; ++span) {
            float lanes[4] = {kNone, kNone, kNone, kNone}; // four chains: the loop becomes vector code
            for (int i = 0; i < kSpan; i += 4)
                for (int k = 0; k < 4; ++k) {
                    float value = pixels[span * kSpan + i + k];
                    value = value == kOpen ? kNone : value;
                    lanes[k] = value < lanes[k] ? value : lanes[k];
                }
            row[span] = std::min(std::min(lanes[0], lanes[1]), std::min(lanes[2], lanes[3]));
        }
    }
}

std::uint32_t OpacityRows::covered(const OccluderImage& image, const PixelRect& rect) {
    const int first = rect.x0 >> 6, last = rect.x1 >> 6;
    const std::uint64_t low = ~std::uint64_t(0) << (rect.x0 & 63), high = ~std::uint64_t(0) >> (63 - (rect.x1 & 63));
    std::uint32_t sum = 0;
    for (int y = rect.y0; y <= rect.y1; ++y)
        for (int word = first; word <= last; ++word) {
            std::uint64_t mask = (word == first ? low : ~std::uint64_t(0)) & (word == last ? high : ~std::uint64_t(0));
            sum += static_cast<std::uint32_t>(
                std::popcount(image.bits[static_cast<std::size_t>(y * image.words + word)] & mask));
        }
    return sum;
}

bool OpacityRows::pixels_behind(const OccluderImage& image, const PixelRect& rect, int y, int span, float nearness) {
    const float* pixels = image.nearness.data() + y * image.stride;
    int begin = std::max(rect.x0, span * kSpan), end = std::min(rect.x1 + 1, span * kSpan + kSpan);
    bool behind = true;
    for (int x = begin; x < end; ++x)
        behind &= pixels[x] > nearness;
    return behind;
}

} // namespace antumbra
