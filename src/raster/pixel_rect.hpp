// The pixels that boxes touch.
#pragma once

#include "raster/screen.hpp"

namespace antumbra {

struct PixelRect {
    int x0 = 0, y0 = 0, x1 = -1, y1 = -1; ///< inclusive; pixels that the closed rectangle of the box touches
    bool empty() const { return x0 > x1 || y0 > y1; }
    int area() const { return (x1 - x0 + 1) * (y1 - y0 + 1); }
};

/// Empty if the box lies beside the screen or may be anywhere.
PixelRect pixel_rect(const Screen& screen, const BoxOnScreen& box);

/// Eight boxes, structure of arrays: rectangles and nearness that contain what project_box and pixel_rect make of each,
/// found in floats with their errors bounded. Hardly ever larger: a pixel where a side lies within some 2^-7 of the
/// next. A box that comes very near the eye for its size may be called untestable.
struct EightOnScreen {
    static constexpr int kLanes = 8;
    int x0[kLanes], y0[kLanes], x1[kLanes], y1[kLanes];
    float nearness[kLanes];
    std::uint32_t testable = 0; ///< bit per box: on the screen, and beyond the clip depth

    PixelRect rect(int lane) const { return {x0[lane], y0[lane], x1[lane], y1[lane]}; }
};

/// `min`, `max`: [axis][box]. All kernels give the same bits.
using ProjectEight = void (*)(const Screen& screen, const float (*min)[EightOnScreen::kLanes],
                              const float (*max)[EightOnScreen::kLanes], EightOnScreen& out);
void project_eight_scalar(const Screen& screen, const float (*min)[EightOnScreen::kLanes],
                          const float (*max)[EightOnScreen::kLanes], EightOnScreen& out);
ProjectEight project_eight_avx2(); ///< nullptr where it is not available
ProjectEight project_eight_avx512();

} // namespace antumbra
