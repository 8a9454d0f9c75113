#include "raster/patch_raster.hpp"

#include "base/cpu.hpp"
#include "raster/patch_raster.inl"

#include <algorithm>

namespace antumbra {

void draw_patch_scalar(const PatchStore& store, std::uint32_t patch, const Screen& screen, PatchCoverage& coverage) {
    draw_patch_body(store, patch, screen, coverage);
}

#if ANTUMBRA_X86_KERNELS
namespace {
ANTUMBRA_TARGET_AVX2 void draw_avx2(const PatchStore& store, std::uint32_t patch, const Screen& screen,
                                    PatchCoverage& coverage) {
    draw_patch_body(store, patch, screen, coverage);
}
ANTUMBRA_TARGET_AVX512 void draw_avx512(const PatchStore& store, std::uint32_t patch, const Screen& screen,
                                        PatchCoverage& coverage) {
    draw_patch_body(store, patch, screen, coverage);
}
} // namespace
DrawPatch draw_patch_avx2() { return cpu_has_avx2() ? draw_avx2 : nullptr; }
DrawPatch draw_patch_avx512() { return cpu_has_avx512() ? draw_avx512 : nullptr; }
#else
DrawPatch draw_patch_avx2() { return nullptr; }
DrawPatch draw_patch_avx512() { return nullptr; }
#endif

void PatchCoverage::fit(const Screen& screen, const PatchStore& store) {
    words = (screen.width + 63) / 64;
    auto bits = static_cast<std::size_t>(words) * static_cast<std::size_t>(screen.height);
    auto tiles = static_cast<std::size_t>(screen.tiles_x) * static_cast<std::size_t>(screen.tiles_y);
    covered.assign(bits, 0);
    silhouette.assign(bits, 0);
    nearness.assign(tiles, std::numeric_limits<float>::infinity());
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

std::uint64_t PatchCoverage::tile(int tile_x, int tile_y) const {
    std::uint64_t mask = 0;
    std::size_t word = static_cast<std::size_t>(tile_x / 8);
    for (std::size_t row = 0; row < kTile; ++row) {
        std::size_t at = (static_cast<std::size_t>(tile_y) * kTile + row) * static_cast<std::size_t>(words) + word;
        std::uint64_t bits = covered[at] & ~silhouette[at];
        mask |= (bits >> (8 * (tile_x % 8)) & 0xFF) << (8 * row);
    }
    return mask;
}

void PatchCoverage::clear(const Screen& screen) {
    if (touched.empty())
        return;
    for (int ty = touched.y0; ty < touched.y1; ++ty)
        std::fill_n(nearness.begin() + ty * screen.tiles_x + touched.x0, touched.x1 - touched.x0,
                    std::numeric_limits<float>::infinity());
    int first = touched.x0 / 8, count = (touched.x1 + 7) / 8 - first;
    for (int row = touched.y0 * kTile; row < touched.y1 * kTile; ++row) {
        std::fill_n(covered.begin() + row * words + first, count, 0);
        std::fill_n(silhouette.begin() + row * words + first, count, 0);
    }
}

} // namespace antumbra
