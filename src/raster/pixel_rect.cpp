#include "raster/pixel_rect.hpp"

#include "base/cpu.hpp"

#include <cstring>

namespace antumbra {
namespace {

constexpr int kLanes = EightOnScreen::kLanes;
#define ANTUMBRA_INLINE __attribute__((always_inline)) inline

#if defined(__SSE2__) || defined(__ARM_NEON) || defined(__wasm_simd128__)
/// Eight lanes at once, whatever the registers are: plain loops of this length are not always made vector code.
constexpr int kWide = kLanes;
using Floats = float __attribute__((vector_size(4 * kLanes)));
using Ints = int __attribute__((vector_size(4 * kLanes)));
ANTUMBRA_INLINE void truncate(const Floats& values, Ints& out) { out = __builtin_convertvector(values, Ints); }
ANTUMBRA_INLINE std::uint32_t bits_of(Ints& truths, int) {
    const Ints bit{1, 2, 4, 8, 16, 32, 64, 128};
    truths &= bit;
    std::uint32_t bits = 0;
    for (int lane = 0; lane < kLanes; ++lane)
        bits |= static_cast<std::uint32_t>(truths[lane]);
    return bits;
}
#else
/// One after the other: eight at once would only be eight times the code.
constexpr int kWide = 1;
using Floats = float;
using Ints = int;
ANTUMBRA_INLINE void truncate(Floats value, Ints& out) { out = static_cast<int>(value); }
ANTUMBRA_INLINE std::uint32_t bits_of(Ints& truth, int lane) { return std::uint32_t(truth != 0) << lane; }
#endif

ANTUMBRA_INLINE void load(const float* from, Floats& to) { std::memcpy(&to, from, sizeof to); }
ANTUMBRA_INLINE void narrow(Floats& to, const Floats& by) { to = by < to ? by : to; }
ANTUMBRA_INLINE void widen(Floats& to, const Floats& by) { to = to < by ? by : to; }
ANTUMBRA_INLINE void magnitude(const Floats& of, Floats& out) { out = of < 0 ? -of : of; }

/// The column or row of a coordinate.
ANTUMBRA_INLINE int column(float value, int most) {
    float inside = !(value >= 0) ? 0.0f : float(most) < value ? float(most) : value; // not a number: 0
    int whole = static_cast<int>(inside);
    return whole > most - 1 ? most - 1 : whole;
}
ANTUMBRA_INLINE void columns(const Floats& values, int most, int* out) {
    const Floats zero{}, end = zero + float(most);
    Floats inside = values >= 0 ? values : zero;
    inside = inside > end ? end : inside;
    Ints whole;
    truncate(inside, whole);
    const Ints last = Ints{} + (most - 1);
    whole = whole > last ? last : whole;
    std::memcpy(out, &whole, sizeof whole);
}

/// A share of a box's reach (the sum of its farthest offsets from the eye along the axes) that bounds the error of a
/// coordinate in camera space. With u = 2^-24 there are, per axis: two roundings of the offset, one of the camera's
/// axis, one of the product; two of the sum: 6 u; what is lost of the eye's own last bits adds less than 2.1 u, as
/// kEyeShare puts it into the reach. 16 u is nearly twice as much.
constexpr float kErrorShare = 0x1p-20f;
constexpr float kEyeShare = 0x1p-20f;
/// Beyond this error (times one over depth) a box counts as untestable. Nothing that hides is lost by it: so close to
/// the eye, compared with its size, is only what is seen.
constexpr float kMostError = 0x1p-6f;
/// Pixels. Coordinates below 8192 in magnitude are off by at most four roundings, 2^-9; what lies farther out is beyond
/// the screen either way.
constexpr float kOutward = 0x1p-8f;

/// Of the camera and the screen, rounded to floats once.
struct FloatScreen {
    float eye[3], eye_rest[3], right[3], up[3], forward[3];
    float scale_x, scale_y, centre_x, centre_y, clip, slack, eye_reach;

    explicit FloatScreen(const Screen& screen) {
        const Camera& camera = screen.camera;
        double sum = 0;
        for (int axis = 0; axis < 3; ++axis) {
            eye[axis] = static_cast<float>(camera.eye[axis]);
            eye_rest[axis] = static_cast<float>(camera.eye[axis] - double(eye[axis]));
            right[axis] = static_cast<float>(camera.right[axis]);
            up[axis] = static_cast<float>(camera.up[axis]);
            forward[axis] = static_cast<float>(camera.forward[axis]);
            sum += camera.eye[axis] < 0 ? -camera.eye[axis] : camera.eye[axis];
        }
        scale_x = static_cast<float>(screen.scale_x);
        scale_y = static_cast<float>(screen.scale_y);
        centre_x = static_cast<float>(screen.centre_x);
        centre_y = static_cast<float>(screen.centre_y);
        clip = static_cast<float>(screen.clip_depth) * (screen.clip_depth > 0 ? 1 + 0x1p-20f : 1 - 0x1p-20f);
        slack = static_cast<float>(screen.orthographic_slack);
        eye_reach = static_cast<float>(sum) * kEyeShare;
    }
};

/// Where the corners of eight boxes lie: least and greatest column and row before scaling, depth and error.
struct Extremes {
    Floats left, right, bottom, top, nearest, error;
};

ANTUMBRA_INLINE void find_extremes(const FloatScreen& screen, bool flat, const float (*min)[kLanes],
                                   const float (*max)[kLanes], int first, Extremes& out) {
    // Corner coordinates are sums of one term per axis; each term has two values.
    Floats x[2][3], y[2][3], z[2][3], reach = Floats{} + screen.eye_reach;
    for (int axis = 0; axis < 3; ++axis) {
        Floats offset[2], farthest;
        load(min[axis] + first, offset[0]);
        load(max[axis] + first, offset[1]);
        for (int side = 0; side < 2; ++side) {
            offset[side] = (offset[side] - screen.eye[axis]) - screen.eye_rest[axis];
            x[side][axis] = offset[side] * screen.right[axis];
            y[side][axis] = offset[side] * screen.up[axis];
            z[side][axis] = offset[side] * screen.forward[axis];
            magnitude(offset[side], offset[side]);
        }
        farthest = offset[0];
        widen(farthest, offset[1]);
        reach += farthest;
    }
    out.error = reach * kErrorShare;
    Floats nearest[3];
    for (int axis = 0; axis < 3; ++axis) {
        nearest[axis] = z[0][axis];
        narrow(nearest[axis], z[1][axis]);
    }
    out.nearest = nearest[0] + nearest[1] + nearest[2] - out.error;
    for (int corner = 0; corner < 8; ++corner) {
        const int a = corner & 1, b = corner >> 1 & 1, c = corner >> 2;
        Floats sx = x[a][0] + x[b][1] + x[c][2], sy = y[a][0] + y[b][1] + y[c][2];
        if (!flat) {
            Floats scale = 1 / (z[a][0] + z[b][1] + z[c][2]);
            sx *= scale;
            sy *= scale;
        }
        if (corner == 0) {
            out.left = out.right = sx;
            out.bottom = out.top = sy;
            continue;
        }
        narrow(out.left, sx);
        widen(out.right, sx);
        narrow(out.bottom, sy);
        widen(out.top, sy);
    }
}

/// kWide boxes from `first` on, in floats; their bits of what is testable.
ANTUMBRA_INLINE std::uint32_t project_lanes(const Screen& exact, const FloatScreen& screen, const float (*min)[kLanes],
                                            const float (*max)[kLanes], int first, EightOnScreen& out) {
    const bool flat = exact.camera.orthographic;
    Extremes at;
    find_extremes(screen, flat, min, max, first, at);
    const Floats one = Floats{} + 1.0f;
    Ints usable = at.nearest > screen.clip;
    Floats inverse = 1 / (usable ? at.nearest : one);
    // t - e (1 + |t|) grows with t: the least corner gives the least bound.
    Floats e = flat ? at.error : at.error * inverse, grows = flat ? Floats{} : e;
    auto move = [&](Floats& t, float sign, float scale, float centre) __attribute__((always_inline)) {
        Floats size;
        magnitude(t, size);
        t = (t + sign * (e + grows * size)) * scale + centre + sign * kOutward;
    };
    move(at.left, -1, screen.scale_x, screen.centre_x);
    move(at.right, 1, screen.scale_x, screen.centre_x);
    move(at.bottom, -1, screen.scale_y, screen.centre_y);
    move(at.top, 1, screen.scale_y, screen.centre_y);
    const float width = float(exact.width), height = float(exact.height);
    // Whatever is not a number fails a comparison.
    usable &= (grows < kMostError) & (at.right >= 0) & (at.top >= 0) & (at.left <= width) & (at.bottom <= height);
    columns(at.left, exact.width, out.x0 + first);
    columns(at.right, exact.width, out.x1 + first);
    columns(at.bottom, exact.height, out.y0 + first);
    columns(at.top, exact.height, out.y1 + first);
    Floats near = flat ? -at.nearest : inverse, size;
    magnitude(near, size);
    near += 1e-5f * (size + screen.slack);
    std::memcpy(out.nearness + first, &near, sizeof near);
    return bits_of(usable, first);
}

ANTUMBRA_INLINE void project_eight_body(const Screen& exact, const float (*min)[kLanes], const float (*max)[kLanes],
                                        EightOnScreen& out) {
    const FloatScreen screen(exact);
    out.testable = 0;
    for (int first = 0; first < kLanes; first += kWide)
        out.testable |= project_lanes(exact, screen, min, max, first, out);
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
