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
    Level& pixels = levels[0];
    int tiles_x = pixels.width / kTile;
    for (int ty = coverage.touched.y0; ty < coverage.touched.y1; ++ty)
        for (int tx = coverage.touched.x0; tx < coverage.touched.x1; ++tx) {
            float nearness = coverage.nearness[static_cast<std::size_t>(ty * tiles_x + tx)];
            if (nearness == std::numeric_limits<float>::infinity())
                continue;
            std::uint64_t mask = coverage.tile(tx, ty);
            float* row = pixels.nearness.data() + ty * kTile * pixels.width + tx * kTile;
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

bool DepthPyramid::is_hidden(const Screen& screen, const BoxOnScreen& box) const {
    float width = float(screen.width), height = float(screen.height);
    if (!box.testable || !(box.max_x >= 0 && box.max_y >= 0 && box.min_x <= width && box.min_y <= height))
        return false;
    auto pixel = [](float value, int most) {
        return std::clamp(static_cast<int>(std::clamp(value, 0.0f, float(most))), 0, most - 1);
    };
    int x0 = pixel(box.min_x, screen.width), x1 = pixel(box.max_x, screen.width);
    int y0 = pixel(box.min_y, screen.height), y1 = pixel(box.max_y, screen.height);
    std::size_t l = 0;
    while (l + 1 < levels.size() && std::max((x1 >> l) - (x0 >> l), (y1 >> l) - (y0 >> l)) > 3)
        ++l;
    const Level& level = levels[l];
    for (int y = y0 >> l; y <= y1 >> l; ++y)
        for (int x = x0 >> l; x <= x1 >> l; ++x)
            if (!(level.nearness[static_cast<std::size_t>(y * level.width + x)] > box.nearness))
                return false;
    return true;
}

} // namespace antumbra
