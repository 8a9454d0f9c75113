// Coverage of a patch of polygons, inner-conservative for the patch as a whole.
//
// A pixel counts as covered when its centre is covered by a member and no silhouette edge of the patch comes within
// kEdgeSlack of its square, or when a single member covers the square and kEdgeSlack around it: then it does not matter what
// crosses it before or behind that member. Members are the polygons that certainly show the eye a side that blocks. An edge is
// silhouette unless a second member lies on its other side as seen from the eye; edges made by clipping always are.
//
// Why the whole square is then covered: coverage by the union of the members can only change across an edge that has
// no member on its other side, and no such edge is in the square; hence the square is covered where its centre is.
// Computed corners and crossings are within kEdgeSlack / 2 of the true ones, so the marked pixels include all that
// true silhouettes cross; and a centre which only seems covered lies so close to an edge that either the neighbour
// covers it or its pixel is marked. Of a single member the square is covered where its borders, which are within
// kEdgeSlack / 2 of the true ones, stay clear of it by kEdgeSlack. What the patch hides in a pixel it hides at least from its farthest member on:
// every tile gets the farthest nearness of all members that come near it.
#pragma once

#include "raster/patch.hpp"
#include "raster/screen.hpp"

namespace antumbra {

inline constexpr float kEdgeSlack = 1.0f / 64; ///< pixels

/// A rectangle of tiles, half open.
struct TileRect {
    int x0 = 0, y0 = 0, x1 = 0, y1 = 0;
    bool empty() const { return x0 >= x1 || y0 >= y1; }
};

/// One patch at a time: what draw_patch() leaves. Sized once per (screen, store).
struct PatchCoverage {
    /// One bit per pixel, in blocks of eight rows by 64 columns: see word_of(). Centres; squares that silhouettes cross; squares
    /// that single members cover.
    std::vector<std::uint64_t> covered, silhouette, inner;
    /// Per tile, rows of words * 8: farthest of the members near it; +infinity where there is none.
    std::vector<float> nearness;
    int words = 0;               ///< per row of pixels
    TileRect touched;            ///< the only tiles with anything in them
    std::uint32_t polygons = 0;  ///< members that were drawn
    // Working memory.
    std::vector<float> left, right;
    std::vector<int> begin, end;
    std::vector<float> vertex_x, vertex_y;
    std::vector<double> camera_x, camera_y, camera_z;
    std::vector<signed char> side;

    void fit(const Screen& screen, const PatchStore& store);
    /// Pixel (x, y) is bit x % 64 of this word of `covered` and `silhouette`.
    std::size_t word_of(int x, int y) const {
        return static_cast<std::size_t>((y / kTile * words + x / 64) * kTile + y % kTile);
    }
    std::size_t tile_of(int tile_x, int tile_y) const {
        return static_cast<std::size_t>(tile_y * words * kTile + tile_x);
    }
    /// Bits of the eight tiles of a block of 64 columns: bit (x % 8) + 8 * (y % 8) of tile x / 8 % 8. Covered, and clear of
    /// silhouettes or by a single member. False if none is.
    bool tiles(int block_x, int tile_y, std::uint64_t (&bits)[kTile]) const;
    /// Empties the touched tiles.
    void clear(const Screen& screen);
};

/// Draws one patch into `coverage`, which must be clear. All kernels give the same bits.
using DrawPatch = void (*)(const PatchStore& store, std::uint32_t patch, const Screen& screen,
                           PatchCoverage& coverage);
void draw_patch_scalar(const PatchStore& store, std::uint32_t patch, const Screen& screen, PatchCoverage& coverage);
/// The kernels for AVX2 and AVX-512; nullptr where the compiler or the processor lacks them.
DrawPatch draw_patch_avx2();
DrawPatch draw_patch_avx512();

} // namespace antumbra
