#include "raster/tile_buffer.hpp"

#include "base/cpu.hpp"

#include <algorithm>

namespace antumbra {
namespace {

constexpr float kNothing = -std::numeric_limits<float>::infinity();
constexpr std::uint64_t kFull = ~std::uint64_t(0);

/// True if the tile has changed.
bool merge_tile(float& whole, float& part, std::uint64_t& mask, std::uint64_t covered, float nearness) {
    if (!(nearness > whole) || nearness == std::numeric_limits<float>::infinity())
        return false;
    if (covered == kFull) {
        whole = nearness;
        if (!(part > whole)) {
            mask = 0;
            part = kNothing;
        }
        return true;
    }
    if (mask == 0) {
        mask = covered;
        part = nearness;
        return true;
    }
    // One of two must be given up when they do not fit together: keep what is near. Taking both means the farther
    // nearness for all; do that unless the newcomer lies much farther than the layer already there, or in front.
    if (nearness > part && part - whole < nearness - part && covered != mask && !(covered & ~mask)) {
        // Lies within the layer and nearer: the layer as it is hides the same pixels, only later.
        return false;
    }
    std::uint64_t both = mask | covered;
    float farther = std::min(part, nearness);
    if (both == kFull) {
        float nearer_part = std::max(part, nearness);
        std::uint64_t nearer_mask = part > nearness ? mask : covered;
        whole = std::max(whole, farther);
        bool worth = nearer_part > whole && nearer_mask != kFull;
        mask = worth ? nearer_mask : 0;
        part = worth ? nearer_part : kNothing;
        return true;
    }
    // How much nearness would be lost on the old layer, against what the newcomer adds.
    if (nearness < part && (part - nearness) > (nearness - whole))
        return false;
    if (nearness > part && (nearness - part) > (part - whole)) {
        mask = covered;
        part = nearness;
        return true;
    }
    mask = both;
    part = farther;
    return true;
}

struct PixelRect {
    int x0, y0, x1, y1; ///< inclusive
};

__attribute__((always_inline)) inline bool pixels_of(const Screen& screen, const BoxOnScreen& box, PixelRect& rect) {
    // Closed rectangle: a box that touches a pixel's border counts for both pixels.
    float width = float(screen.width), height = float(screen.height);
    if (!(box.max_x >= 0 && box.max_y >= 0 && box.min_x <= width && box.min_y <= height))
        return false;
    auto column = [](float value, int most) {
        return std::clamp(static_cast<int>(std::clamp(value, 0.0f, float(most))), 0, most - 1);
    };
    rect = {column(box.min_x, screen.width), column(box.min_y, screen.height), column(box.max_x, screen.width),
            column(box.max_y, screen.height)};
    return true;
}

/// The bits of a tile within the rectangle.
std::uint64_t rect_mask(const PixelRect& rect, int tile_x, int tile_y) {
    int x0 = std::max(rect.x0 - tile_x * kTile, 0), x1 = std::min(rect.x1 - tile_x * kTile, kTile - 1);
    int y0 = std::max(rect.y0 - tile_y * kTile, 0), y1 = std::min(rect.y1 - tile_y * kTile, kTile - 1);
    std::uint64_t row = (0xFFu << x0) & (0xFFu >> (7 - x1));
    std::uint64_t mask = 0;
    for (int y = y0; y <= y1; ++y)
        mask |= row << (8 * y);
    return mask;
}

__attribute__((always_inline)) inline bool is_hidden_body(const TileBuffer& buffer, const Screen& screen,
                                                          const BoxOnScreen& box) {
    PixelRect rect;
    if (!box.testable || !pixels_of(screen, box, rect))
        return false;
    const float nearness = box.nearness;
    for (int ty = rect.y0 / kTile; ty <= rect.y1 / kTile; ++ty) {
        int first = rect.x0 / kTile, last = rect.x1 / kTile;
        const float* whole = buffer.whole.data() + ty * buffer.tiles_x;
        int open = 0;
        for (int tx = first; tx <= last; ++tx)
            open += !(whole[tx] > nearness);
        for (int tx = first; open > 0 && tx <= last; ++tx) {
            if (whole[tx] > nearness)
                continue;
            --open;
            auto tile = static_cast<std::size_t>(ty * buffer.tiles_x + tx);
            if (!(buffer.part[tile] > nearness) || (rect_mask(rect, tx, ty) & ~buffer.mask[tile]))
                return false;
        }
    }
    return true;
}

#if ANTUMBRA_X86_KERNELS
ANTUMBRA_TARGET_AVX2 bool hidden_avx2(const TileBuffer& buffer, const Screen& screen, const BoxOnScreen& box) {
    return is_hidden_body(buffer, screen, box);
}
ANTUMBRA_TARGET_AVX512 bool hidden_avx512(const TileBuffer& buffer, const Screen& screen, const BoxOnScreen& box) {
    return is_hidden_body(buffer, screen, box);
}
#endif

} // namespace

void TileBuffer::reset(const Screen& screen) {
    tiles_x = screen.tiles_x;
    tiles_y = screen.tiles_y;
    auto tiles = static_cast<std::size_t>(tiles_x) * static_cast<std::size_t>(tiles_y);
    whole.assign(tiles, kNothing);
    part.assign(tiles, kNothing);
    mask.assign(tiles, 0);
    owner.assign(tiles, 0);
}

void TileBuffer::merge(const PatchCoverage& coverage, std::uint32_t patch) {
    const TileRect& rect = coverage.touched;
    for (int ty = rect.y0; ty < rect.y1; ++ty)
        for (int tx = rect.x0; tx < rect.x1; ++tx) {
            auto tile = static_cast<std::size_t>(ty * tiles_x + tx);
            float nearness = coverage.nearness[tile];
            if (!(nearness > whole[tile]) || nearness == std::numeric_limits<float>::infinity())
                continue;
            if (std::uint64_t covered = coverage.tile(tx, ty))
                if (merge_tile(whole[tile], part[tile], mask[tile], covered, nearness))
                    owner[tile] = patch;
        }
}

bool is_hidden_scalar(const TileBuffer& buffer, const Screen& screen, const BoxOnScreen& box) {
    return is_hidden_body(buffer, screen, box);
}

#if ANTUMBRA_X86_KERNELS
IsHidden is_hidden_avx2() { return cpu_has_avx2() ? hidden_avx2 : nullptr; }
IsHidden is_hidden_avx512() { return cpu_has_avx512() ? hidden_avx512 : nullptr; }
#else
IsHidden is_hidden_avx2() { return nullptr; }
IsHidden is_hidden_avx512() { return nullptr; }
#endif

} // namespace antumbra
