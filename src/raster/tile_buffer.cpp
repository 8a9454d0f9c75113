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

/// The bits of a tile within the rectangle.
__attribute__((always_inline)) inline std::uint64_t rect_mask(const PixelRect& rect, int tile_x, int tile_y) {
    int x0 = std::max(rect.x0 - tile_x * kTile, 0), x1 = std::min(rect.x1 - tile_x * kTile, kTile - 1);
    int y0 = std::max(rect.y0 - tile_y * kTile, 0), y1 = std::min(rect.y1 - tile_y * kTile, kTile - 1);
    std::uint64_t columns = (0xFFu << x0) & (0xFFu >> (7 - x1));
    std::uint64_t rows = (kFull << (8 * y0)) & (kFull >> (8 * (7 - y1)));
    return columns * 0x0101010101010101ull & rows;
}

__attribute__((always_inline)) inline bool is_hidden_body(const TileBuffer& buffer, const PixelRect& rect,
                                                          float nearness) {
    if (rect.empty())
        return false;
    const int first = rect.x0 / kTile, last = rect.x1 / kTile;
    for (int ty = rect.y0 / kTile; ty <= rect.y1 / kTile; ++ty) {
        const float* whole = buffer.whole.data() + ty * buffer.stride;
        for (int tx = first; tx <= last; ++tx) {
            if (whole[tx] > nearness)
                continue;
            auto tile = static_cast<std::size_t>(ty * buffer.stride + tx);
            if (!(buffer.part[tile] > nearness) || (rect_mask(rect, tx, ty) & ~buffer.mask[tile]))
                return false;
        }
    }
    return true;
}

#if ANTUMBRA_X86_KERNELS
ANTUMBRA_TARGET_AVX2 bool hidden_avx2(const TileBuffer& buffer, const PixelRect& rect, float nearness) {
    return is_hidden_body(buffer, rect, nearness);
}
ANTUMBRA_TARGET_AVX512 bool hidden_avx512(const TileBuffer& buffer, const PixelRect& rect, float nearness) {
    return is_hidden_body(buffer, rect, nearness);
}
#endif

} // namespace

void TileBuffer::reset(const Screen& screen) {
    tiles_x = screen.tiles_x;
    tiles_y = screen.tiles_y;
    stride = (screen.width + 63) / 64 * kTile;
    auto tiles = static_cast<std::size_t>(stride) * static_cast<std::size_t>(tiles_y);
    whole.assign(tiles, kNothing);
    part.assign(tiles, kNothing);
    mask.assign(tiles, 0);
    owner.assign(tiles, 0);
}

void TileBuffer::merge(const PatchCoverage& coverage, std::uint32_t patch) {
    const TileRect& rect = coverage.touched;
    std::uint64_t bits[kTile];
    for (int ty = rect.y0; ty < rect.y1; ++ty)
        for (int block = rect.x0 / kTile; block * kTile < rect.x1; ++block) {
            const std::size_t first = coverage.tile_of(block * kTile, ty);
            bool nearer = false;
            for (std::size_t i = 0; i < kTile; ++i)
                nearer |= coverage.nearness[first + i] > whole[first + i];
            if (!nearer || !coverage.tiles(block, ty, bits))
                continue;
            for (std::size_t i = 0; i < kTile; ++i)
                if (bits[i] && merge_tile(whole[first + i], part[first + i], mask[first + i], bits[i],
                                          coverage.nearness[first + i]))
                    owner[first + i] = patch;
        }
}

bool is_hidden_scalar(const TileBuffer& buffer, const PixelRect& rect, float nearness) {
    return is_hidden_body(buffer, rect, nearness);
}

#if ANTUMBRA_X86_KERNELS
IsHidden is_hidden_avx2() { return cpu_has_avx2() ? hidden_avx2 : nullptr; }
IsHidden is_hidden_avx512() { return cpu_has_avx512() ? hidden_avx512 : nullptr; }
#else
IsHidden is_hidden_avx2() { return nullptr; }
IsHidden is_hidden_avx512() { return nullptr; }
#endif

} // namespace antumbra
