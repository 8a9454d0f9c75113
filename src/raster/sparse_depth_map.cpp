#include "raster/sparse_depth_map.hpp"

#include <algorithm>

namespace antumbra {
namespace {

constexpr float kOpen = -std::numeric_limits<float>::infinity();

/// Larger is farther. Open pixels must not be peaks: where they matter the overlap test has decided already.
float farness(float nearness) { return nearness == kOpen ? kOpen : -nearness; }

} // namespace

void SparseDepthMap::build(const OccluderImage& image) {
    width = image.width;
    height = image.height;
    step.resize(static_cast<std::size_t>(width) * static_cast<std::size_t>(height));
    built.assign(static_cast<std::size_t>(height), 0);
    pixels = peaks = 0;
    for (int y = 0; y < height; ++y) {
        if (!image.row_used[static_cast<std::size_t>(y)])
            continue;
        built[static_cast<std::size_t>(y)] = 1;
        const float* depth = image.nearness.data() + static_cast<std::size_t>(y) * static_cast<std::size_t>(image.stride);
        std::uint16_t* steps = step.data() + static_cast<std::size_t>(y) * static_cast<std::size_t>(width);
        int next = width; // the peak to the right
        float current = farness(depth[width - 1]);
        bool falls = true; // from the current pixel to the right; beyond the row nothing is farther
        for (int x = width - 1; x >= 0; --x) {
            steps[x] = static_cast<std::uint16_t>(next - x);
            float left = x > 0 ? farness(depth[x - 1]) : kOpen;
            if (falls && (x == 0 || left <= current)) {
                next = x;
                ++peaks;
            }
            falls = left > current;
            current = left;
        }
        pixels += static_cast<std::uint64_t>(width);
    }
}

bool SparseDepthMap::is_behind(const OccluderImage& image, const PixelRect& rect, float nearness) const {
    for (int y = rect.y0; y <= rect.y1; ++y) {
        if (!built[static_cast<std::size_t>(y)])
            continue;
        const float* depth = image.nearness.data() + static_cast<std::size_t>(y) * static_cast<std::size_t>(image.stride);
        const std::uint16_t* steps = step.data() + static_cast<std::size_t>(y) * static_cast<std::size_t>(width);
        auto fails = [&](int x) { return !(depth[x] > nearness) && depth[x] != kOpen; };
        for (int x = rect.x0; x <= rect.x1; x += steps[x])
            if (fails(x))
                return false;
        if (fails(rect.x1)) // the next peak may lie beyond: depth rises up to the edge
            return false;
    }
    return true;
}

} // namespace antumbra
