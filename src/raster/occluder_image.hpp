// What chosen occluders look like: one bit and one depth per pixel. Both forms of the opacity map are made of it.
//
// `inner`: a bit is set only where a connected patch covers the whole square of the pixel (see patch_raster.hpp), and
// the depth is the farthest that any member of the patch has in that square. `centre`: a bit is set where a polygon
// covers the centre of the pixel, and the depth is that of the nearest polygon there, as graphics hardware does it:
// what shows through the rest of the pixel is lost.
#pragma once

#include "raster/patch_raster.hpp"

namespace antumbra {

enum class PixelCoverage : std::uint8_t { inner, centre };

/// Row y starts at word y * words and at depth y * stride; columns beyond `width` are open.
struct OccluderImage {
    int width = 0, height = 0;
    int words = 0, stride = 0;
    std::vector<std::uint64_t> bits;
    std::vector<float> nearness;          ///< of the nearest cover of the pixel; -infinity where it is open
    std::vector<std::uint8_t> row_used;   ///< rows with a bit

    /// Empty, for that screen. Allocates only when the screen grows.
    void reset(const Screen& screen);
    bool is_covered(int x, int y) const {
        return bits[static_cast<std::size_t>(y * words + (x >> 6))] >> (x & 63) & 1;
    }
};

/// Working memory of draw_occluder(); clear between calls.
struct OccluderBrush {
    PatchCoverage coverage;
    std::vector<float> nearness;     ///< per pixel, farthest of the members near it; +infinity where there is none
    std::vector<float> low, high;    ///< per row, from where to where a polygon comes near
    int width = 0, height = 0;

    /// Before a frame: the store may have grown, the screen may have changed.
    void fit(const Screen& screen, const PatchStore& store);
};

/// Adds one patch. Whatever the order of the patches, the image is the same. Returns the number of members drawn.
/// All kernels give the same bits.
using DrawOccluder = std::uint32_t (*)(const PatchStore& store, std::uint32_t patch, const Screen& screen,
                                       PixelCoverage coverage, OccluderBrush& brush, OccluderImage& image);
std::uint32_t draw_occluder_scalar(const PatchStore& store, std::uint32_t patch, const Screen& screen,
                                   PixelCoverage coverage, OccluderBrush& brush, OccluderImage& image);
DrawOccluder draw_occluder_avx2(); ///< nullptr where it is not available
DrawOccluder draw_occluder_avx512();

} // namespace antumbra
