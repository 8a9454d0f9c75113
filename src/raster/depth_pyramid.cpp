#include "raster/depth_pyramid.hpp"

#include <algorithm>
#include <bit>

namespace antumbra {

void DepthPyramid::reset(const Screen& screen) {
    int width = screen.width, height = screen.height;
    std::size_t used = 0;
    for (;; ++used) {
        if (used == levels.size())
            levels.emplace_back();
        Level& level = levels[used];
        level.width = width;
        level.height = height;
        level.nearness.assign(static_cast<std::size_t>(width) * static_cast<std::size_t>(height),
                              -std::numeric_limits<float>::infinity());
        if (width == 1 && height == 1)
            break;
        width = (width + 1) / 2;
        height = (height + 1) / 2;
    }
    levels.resize(used + 1);
}

void DepthPyramid::merge(const PatchCoverage& coverage) {
    const TileRect& rect = coverage.touched;
    std::uint64_t bits[kTile];
    for (int ty = rect.y0; ty < rect.y1; ++ty)
        for (int block = rect.x0 / kTile; block * kTile < rect.x1; ++block) {
            if (!coverage.tiles(block, ty, bits))
                continue;
            for (int tx = 0; tx < kTile; ++tx)
                if (bits[tx])
                    raise(block * kTile + tx, ty, bits[tx], coverage.nearness[coverage.tile_of(block * kTile + tx, ty)]);
        }
}

void DepthPyramid::raise(int tile_x, int tile_y, std::uint64_t mask, float nearness) {
    if (nearness == std::numeric_limits<float>::infinity())
        return;
    Level& pixels = levels[0];
    float* row = pixels.nearness.data() + tile_y * kTile * pixels.width + tile_x * kTile;
    for (; mask; mask >>= 8, row += pixels.width) {
        if ((mask & 255) == 255)
            for (int x = 0; x < kTile; ++x)
                row[x] = row[x] < nearness ? nearness : row[x];
        else
            for (std::uint64_t bits = mask & 255; bits; bits &= bits - 1) {
                float& pixel = row[std::countr_zero(bits)];
                pixel = pixel < nearness ? nearness : pixel;
            }
    }
}

void DepthPyramid::build() {
    for (std::size_t l = 1; l < levels.size(); ++l) {
        const Level& fine = levels[l - 1];
        Level& coarse = levels[l];
        for (int y = 0; y < coarse.height; ++y)
            for (int x = 0; x < coarse.width; ++x) {
                float least = std::numeric_limits<float>::infinity();
                for (int dy = 0; dy < 2; ++dy)
                    for (int dx = 0; dx < 2; ++dx) {
                        int fx = std::min(2 * x + dx, fine.width - 1), fy = std::min(2 * y + dy, fine.height - 1);
                        least = std::min(least, fine.nearness[static_cast<std::size_t>(fy * fine.width + fx)]);
                    }
                coarse.nearness[static_cast<std::size_t>(y * coarse.width + x)] = least;
            }
    }
}

bool DepthPyramid::is_hidden(const PixelRect& rect, float nearness) const {
    if (rect.empty())
        return false;
    std::size_t l = 0;
    while (l + 1 < levels.size() && std::max((rect.x1 >> l) - (rect.x0 >> l), (rect.y1 >> l) - (rect.y0 >> l)) > 3)
        ++l;
    const Level& level = levels[l];
    for (int y = rect.y0 >> l; y <= rect.y1 >> l; ++y)
        for (int x = rect.x0 >> l; x <= rect.x1 >> l; ++x)
            if (!(level.nearness[static_cast<std::size_t>(y * level.width + x)] > nearness))
                return false;
    return true;
}

} // namespace antumbra
