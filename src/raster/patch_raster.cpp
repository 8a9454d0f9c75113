#include "raster/patch_raster.hpp"

#include "base/cpu.hpp"
#include "raster/patch_raster.inl"

#include <algorithm>

namespace antumbra {

void draw_patch_scalar(const PatchStore& store, std::uint32_t patch, const Screen& screen, PatchCoverage& coverage) {
    draw_patch_body(store, patch, screen, coverage);
}

#if !ANTUMBRA_X86_KERNELS
DrawPatch draw_patch_avx2() { return nullptr; }
DrawPatch draw_patch_avx512() { return nullptr; }
#endif

void PatchCoverage::fit(const Screen& screen, const PatchStore& store) {
    words = (screen.width + 63) / 64;
    auto bits = static_cast<std::size_t>(words) * static_cast<std::size_t>(screen.height);
    covered.assign(bits, 0);
    silhouette.assign(bits, 0);
    inner.assign(bits, 0);
    nearness.assign(static_cast<std::size_t>(words * kTile * screen.tiles_y), std::numeric_limits<float>::infinity());
    left.resize(static_cast<std::size_t>(screen.height));
    right.resize(static_cast<std::size_t>(screen.height));
    begin.resize(static_cast<std::size_t>(screen.height));
    end.resize(static_cast<std::size_t>(screen.height));
    for (std::vector<float>* list : {&vertex_x, &vertex_y})
        list->resize(store.most_vertices);
    for (std::vector<double>* list : {&camera_x, &camera_y, &camera_z})
        list->resize(store.most_vertices);
    side.resize(store.most_polygons);
}

namespace {

/// Swaps the bits of `high` that `mask` names, shifted, with those of `low`.
inline void swap_bits(std::uint64_t& low, std::uint64_t& high, int shift, std::uint64_t mask) {
    std::uint64_t differing = (low >> shift ^ high) & mask;
    high ^= differing;
    low ^= differing << shift;
}

/// Byte j of word i becomes byte i of word j.
inline void transpose_bytes(std::uint64_t (&w)[kTile]) {
    for (int i = 0; i < 4; ++i)
        swap_bits(w[i], w[i + 4], 32, 0x00000000FFFFFFFFull);
    for (int i : {0, 1, 4, 5})
        swap_bits(w[i], w[i + 2], 16, 0x0000FFFF0000FFFFull);
    for (int i : {0, 2, 4, 6})
        swap_bits(w[i], w[i + 1], 8, 0x00FF00FF00FF00FFull);
}

} // namespace

bool PatchCoverage::tiles(int block_x, int tile_y, std::uint64_t (&bits)[kTile]) const {
    const std::uint64_t* cover = covered.data() + (tile_y * words + block_x) * kTile;
    const std::uint64_t* edges = silhouette.data() + (tile_y * words + block_x) * kTile;
    const std::uint64_t* within = inner.data() + (tile_y * words + block_x) * kTile;
    std::uint64_t any = 0;
    for (int row = 0; row < kTile; ++row) {
        bits[row] = (cover[row] & ~edges[row]) | within[row];
        any |= bits[row];
    }
    if (any == 0)
        return false;
    transpose_bytes(bits);
    return true;
}

void PatchCoverage::clear(const Screen&) {
    if (touched.empty())
        return;
    const int first = touched.x0 / kTile, count = (touched.x1 + kTile - 1) / kTile - first;
    for (int ty = touched.y0; ty < touched.y1; ++ty) {
        const std::ptrdiff_t at = (ty * words + first) * kTile;
        std::fill_n(nearness.begin() + at, count * kTile, std::numeric_limits<float>::infinity());
        std::fill_n(covered.begin() + at, count * kTile, 0);
        std::fill_n(silhouette.begin() + at, count * kTile, 0);
        std::fill_n(inner.begin() + at, count * kTile, 0);
    }
}

} // namespace antumbra
