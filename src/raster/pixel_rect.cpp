#include "raster/pixel_rect.hpp"

#include "base/cpu.hpp"

#include <algorithm>

namespace antumbra {
namespace {

constexpr int kLanes = EightOnScreen::kLanes;
#define ANTUMBRA_INLINE __attribute__((always_inline)) inline

template <class T>
ANTUMBRA_INLINE T lesser(T a, T b) { return b < a ? b : a; } // as std::min and std::max, NaN included
template <class T>
ANTUMBRA_INLINE T greater(T a, T b) { return a < b ? b : a; }
ANTUMBRA_INLINE double bounded(double value, double low, double high) {
    return value < low ? low : high < value ? high : value;
}
ANTUMBRA_INLINE double magnitude(double value) { return value < 0 ? -value : value; }

/// The column or row of a coordinate, as in pixel_rect.
ANTUMBRA_INLINE int column(float value, int most) {
    float inside = value < 0 ? 0.0f : float(most) < value ? float(most) : value;
    int whole = static_cast<int>(inside);
    return whole > most - 1 ? most - 1 : whole;
}

/// The steps of project_box, in the same order, eight boxes at a time.
ANTUMBRA_INLINE void project_eight_body(const Screen& screen, const float (*min)[kLanes], const float (*max)[kLanes],
                                        EightOnScreen& out) {
    const Camera& camera = screen.camera;
    double x[2][3][kLanes], y[2][3][kLanes], z[2][3][kLanes];
    for (int axis = 0; axis < 3; ++axis) {
        const double eye = camera.eye[axis], r = camera.right[axis], u = camera.up[axis], f = camera.forward[axis];
        for (int side = 0; side < 2; ++side) {
            const float* from = side ? max[axis] : min[axis];
            for (int lane = 0; lane < kLanes; ++lane) {
                double offset = double(from[lane]) - eye;
                x[side][axis][lane] = r * offset;
                y[side][axis][lane] = u * offset;
                z[side][axis][lane] = f * offset;
            }
        }
    }
    double nearest[kLanes], min_x[kLanes], max_x[kLanes], min_y[kLanes], max_y[kLanes];
    for (int lane = 0; lane < kLanes; ++lane) {
        double sum = 0, reach = 0;
        sum = lesser(z[0][0][lane], z[1][0][lane]) + lesser(z[0][1][lane], z[1][1][lane]) +
              lesser(z[0][2][lane], z[1][2][lane]);
        for (int axis = 0; axis < 3; ++axis)
            reach += greater(magnitude(z[0][axis][lane]), magnitude(z[1][axis][lane]));
        nearest[lane] = sum - 1e-13 * reach;
        min_x[lane] = min_y[lane] = 1e300;
        max_x[lane] = max_y[lane] = -1e300;
    }
    const bool flat = camera.orthographic;
    for (int corner = 0; corner < 8; ++corner) {
        const int a = corner & 1, b = corner >> 1 & 1, c = corner >> 2;
        for (int lane = 0; lane < kLanes; ++lane) {
            double depth = flat ? 1.0 : z[a][0][lane] + z[b][1][lane] + z[c][2][lane];
            double scale = 1 / depth;
            double sx = (x[a][0][lane] + x[b][1][lane] + x[c][2][lane]) * scale;
            double sy = (y[a][0][lane] + y[b][1][lane] + y[c][2][lane]) * scale;
            min_x[lane] = lesser(min_x[lane], sx);
            max_x[lane] = greater(max_x[lane], sx);
            min_y[lane] = lesser(min_y[lane], sy);
            max_y[lane] = greater(max_y[lane], sy);
        }
    }
    constexpr double kOutward = 0x1p-8; // as in project_box
    const double scale_x = screen.scale_x, scale_y = screen.scale_y;
    const double centre_x = screen.centre_x, centre_y = screen.centre_y;
    const double slack = screen.orthographic_slack, clip = screen.clip_depth;
    const int width = screen.width, height = screen.height;
    int usable[kLanes];
    for (int lane = 0; lane < kLanes; ++lane) {
        auto left = static_cast<float>(bounded(centre_x + min_x[lane] * scale_x - kOutward, -1e6, 1e6));
        auto right = static_cast<float>(bounded(centre_x + max_x[lane] * scale_x + kOutward, -1e6, 1e6));
        auto bottom = static_cast<float>(bounded(centre_y + min_y[lane] * scale_y - kOutward, -1e6, 1e6));
        auto top = static_cast<float>(bounded(centre_y + max_y[lane] * scale_y + kOutward, -1e6, 1e6));
        bool ahead = nearest[lane] > clip;
        usable[lane] = int(ahead) & int(right >= 0) & int(top >= 0) & int(left <= float(width)) &
                       int(bottom <= float(height));
        out.x0[lane] = column(left, width);
        out.x1[lane] = column(right, width);
        out.y0[lane] = column(bottom, height);
        out.y1[lane] = column(top, height);
        double near = flat ? -nearest[lane] : 1 / (ahead ? nearest[lane] : 1.0);
        out.nearness[lane] = static_cast<float>(near + 1e-5 * (magnitude(near) + slack));
    }
    std::uint32_t mask = 0;
    for (int lane = 0; lane < kLanes; ++lane)
        mask |= std::uint32_t(usable[lane]) << lane;
    out.testable = mask;
}

#if ANTUMBRA_X86_KERNELS
ANTUMBRA_TARGET_AVX2 void eight_avx2(const Screen& screen, const float (*min)[kLanes], const float (*max)[kLanes],
                                     EightOnScreen& out) {
    project_eight_body(screen, min, max, out);
}
ANTUMBRA_TARGET_AVX512 void eight_avx512(const Screen& screen, const float (*min)[kLanes], const float (*max)[kLanes],
                                         EightOnScreen& out) {
    project_eight_body(screen, min, max, out);
}
#endif

} // namespace

PixelRect pixel_rect(const Screen& screen, const BoxOnScreen& box) {
    float width = float(screen.width), height = float(screen.height);
    if (!box.testable || !(box.max_x >= 0 && box.max_y >= 0 && box.min_x <= width && box.min_y <= height))
        return {};
    return {column(box.min_x, screen.width), column(box.min_y, screen.height), column(box.max_x, screen.width),
            column(box.max_y, screen.height)};
}

void project_eight_scalar(const Screen& screen, const float (*min)[kLanes], const float (*max)[kLanes],
                          EightOnScreen& out) {
    project_eight_body(screen, min, max, out);
}

#if ANTUMBRA_X86_KERNELS
ProjectEight project_eight_avx2() { return cpu_has_avx2() ? eight_avx2 : nullptr; }
ProjectEight project_eight_avx512() { return cpu_has_avx512() ? eight_avx512 : nullptr; }
#else
ProjectEight project_eight_avx2() { return nullptr; }
ProjectEight project_eight_avx512() { return nullptr; }
#endif

} // namespace antumbra
