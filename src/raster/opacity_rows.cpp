#include "raster/opacity_rows.hpp"

#include "base/cpu.hpp"

#include <algorithm>
#include <cstring>

namespace antumbra {
namespace {

#define ANTUMBRA_INLINE __attribute__((always_inline)) inline

constexpr float kOpen = -std::numeric_limits<float>::infinity(), kNone = std::numeric_limits<float>::infinity();
constexpr int kSpan = OpacityRows::kSpan;

ANTUMBRA_INLINE float lesser(float a, float b) { return b < a ? b : a; }

using Floats = float __attribute__((vector_size(32)));
ANTUMBRA_INLINE void load_covered(const float* from, Floats& to) {
    std::memcpy(&to, from, sizeof to);
    to = to == kOpen ? Floats{} + kNone : to;
}

/// The farthest covered pixel of each span. Minima: the order does not matter.
ANTUMBRA_INLINE void spans_of_row(const float* pixels, float* spans, int count) {
    for (int span = 0; span < count; ++span) {
        Floats a, b;
        load_covered(pixels + span * kSpan, a);
        load_covered(pixels + span * kSpan + 8, b);
        a = b < a ? b : a;
        b = __builtin_shufflevector(a, a, 4, 5, 6, 7, 0, 1, 2, 3);
        a = b < a ? b : a;
        b = __builtin_shufflevector(a, a, 2, 3, 0, 1, 6, 7, 4, 5);
        a = b < a ? b : a;
        spans[span] = lesser(a[0], a[1]);
    }
}

ANTUMBRA_INLINE void and_rows(const std::uint64_t* a, const std::uint64_t* b, std::uint64_t* out, std::ptrdiff_t count) {
    for (std::ptrdiff_t i = 0; i < count; ++i)
        out[i] = a[i] & b[i];
}
ANTUMBRA_INLINE void lesser_rows(const float* a, const float* b, float* out, std::ptrdiff_t count) {
    for (std::ptrdiff_t i = 0; i < count; ++i)
        out[i] = lesser(a[i], b[i]);
}

/// `rows` has the room.
ANTUMBRA_INLINE void build_body(const OccluderImage& image, OpacityRows& rows) {
    const std::ptrdiff_t words = rows.words, spans = rows.spans, height = rows.height;
    std::copy(image.bits.begin(), image.bits.end(), rows.covered_rows.begin());
    for (int y = 0; y < rows.height; ++y) {
        float* row = rows.farthest.data() + y * spans;
        if (image.row_used[static_cast<std::size_t>(y)])
            spans_of_row(image.nearness.data() + y * image.stride, row, rows.spans);
        else
            std::fill_n(row, spans, kNone);
    }
    for (int level = 1; (1 << level) <= rows.height; ++level) {
        const std::ptrdiff_t half = 1 << (level - 1), count = height - (1 << level) + 1;
        const std::uint64_t* bits = rows.covered_rows.data() + (level - 1) * height * words;
        and_rows(bits, bits + half * words, rows.covered_rows.data() + level * height * words, count * words);
        const float* depths = rows.farthest.data() + (level - 1) * height * spans;
        lesser_rows(depths, depths + half * spans, rows.farthest.data() + level * height * spans, count * spans);
    }
}

using Build = void (*)(const OccluderImage& image, OpacityRows& rows);
void build_scalar(const OccluderImage& image, OpacityRows& rows) { build_body(image, rows); }
#if ANTUMBRA_X86_KERNELS
ANTUMBRA_TARGET_AVX2 void build_avx2(const OccluderImage& image, OpacityRows& rows) { build_body(image, rows); }
ANTUMBRA_TARGET_AVX512 void build_avx512(const OccluderImage& image, OpacityRows& rows) { build_body(image, rows); }
Build fastest_build() { return cpu_has_avx512() ? build_avx512 : cpu_has_avx2() ? build_avx2 : build_scalar; }
#else
Build fastest_build() { return build_scalar; }
#endif

} // namespace

void OpacityRows::build(const OccluderImage& image) {
    static const Build fastest = fastest_build();
    height = image.height;
    words = image.words;
    spans = image.stride / kSpan;
    auto all = static_cast<std::size_t>(std::bit_width(static_cast<std::uint32_t>(height))) * static_cast<std::size_t>(height);
    covered_rows.resize(all * static_cast<std::size_t>(words));
    farthest.resize(all * static_cast<std::size_t>(spans));
    fastest(image, *this);
}

std::uint32_t OpacityRows::covered(const OccluderImage& image, const PixelRect& rect, int step) {
    const int first = rect.x0 >> 6, last = rect.x1 >> 6;
    const std::uint64_t low = ~std::uint64_t(0) << (rect.x0 & 63), high = ~std::uint64_t(0) >> (63 - (rect.x1 & 63));
    std::uint32_t sum = 0;
    for (int y = rect.y0; y <= rect.y1; y += step)
        for (int word = first; word <= last; ++word) {
            std::uint64_t mask = (word == first ? low : ~std::uint64_t(0)) & (word == last ? high : ~std::uint64_t(0));
            sum += static_cast<std::uint32_t>(
                std::popcount(image.bits[static_cast<std::size_t>(y * image.words + word)] & mask));
        }
    return sum;
}

bool OpacityRows::pixels_behind(const OccluderImage& image, const PixelRect& rect, int span, float nearness) {
    int begin = std::max(rect.x0, span * kSpan), end = std::min(rect.x1 + 1, span * kSpan + kSpan);
    for (int y = rect.y0; y <= rect.y1; ++y) {
        const float* pixels = image.nearness.data() + y * image.stride;
        bool behind = true;
        for (int x = begin; x < end; ++x)
            behind &= pixels[x] > nearness;
        if (!behind)
            return false;
    }
    return true;
}

std::uint32_t hidden_of_eight(const OpacityRows& rows, const OccluderImage& image, const EightOnScreen& boxes,
                              std::uint32_t wanted) {
    std::uint32_t hidden = 0;
    for (; wanted; wanted &= wanted - 1) {
        const int lane = std::countr_zero(wanted);
        const PixelRect rect = boxes.rect(lane);
        if (rows.overlaps(rect) && rows.is_behind(image, rect, boxes.nearness[lane]))
            hidden |= 1u << lane;
    }
    return hidden;
}

} // namespace antumbra
