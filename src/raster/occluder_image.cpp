#include "raster/occluder_image.hpp"

#include "base/cpu.hpp"
#include "raster/patch_raster.inl"

#include <algorithm>
#include <bit>

namespace antumbra {
namespace {

constexpr float kOpen = -std::numeric_limits<float>::infinity();
constexpr float kNoMember = std::numeric_limits<float>::infinity();

struct PixelRows {
    int first, last; ///< half open
};

/// Rows that the loop comes within kEdgeSlack of.
ANTUMBRA_INLINE PixelRows rows_of(const Screen& screen, const EdgeLoop& loop) {
    float low = 1e9f, high = -1e9f;
    for (int i = 0; i < loop.count; ++i) {
        low = loop.y[i] < low ? loop.y[i] : low;
        high = loop.y[i] > high ? loop.y[i] : high;
    }
    const float height = float(screen.height);
    if (high < -kEdgeSlack || low > height + kEdgeSlack)
        return {0, 0};
    return {clamp_int(floor_int(clamp_float(low - kEdgeSlack, -1, height)), 0, screen.height - 1),
            clamp_int(floor_int(clamp_float(high + kEdgeSlack, -1, height)), 0, screen.height - 1) + 1};
}

ANTUMBRA_INLINE bool misses_columns(const Screen& screen, const EdgeLoop& loop) {
    float low = 1e9f, high = -1e9f;
    for (int i = 0; i < loop.count; ++i) {
        low = loop.x[i] < low ? loop.x[i] : low;
        high = loop.x[i] > high ? loop.x[i] : high;
    }
    return high < -kEdgeSlack || low > float(screen.width) + kEdgeSlack;
}

/// Per row, from where to where the polygon reaches within kEdgeSlack of the row's band.
ANTUMBRA_INLINE void reach_of_rows(const EdgeLoop& loop, PixelRows rows, float* low, float* high) {
    for (int row = rows.first; row < rows.last; ++row) {
        low[row] = 1e9f;
        high[row] = -1e9f;
    }
    for (int i = 0; i < loop.count; ++i) {
        int j = i + 1 == loop.count ? 0 : i + 1;
        bool up = loop.y[j] > loop.y[i];
        float x0 = up ? loop.x[i] : loop.x[j], y0 = up ? loop.y[i] : loop.y[j];
        float x1 = up ? loop.x[j] : loop.x[i], y1 = up ? loop.y[j] : loop.y[i];
        int begin = clamp_int(floor_int(clamp_float(y0 - kEdgeSlack, -1, 1e6f)), rows.first, rows.last);
        int end = clamp_int(floor_int(clamp_float(y1 + kEdgeSlack, -1, 1e6f)) + 1, rows.first, rows.last);
        const bool level = !(y1 > y0);
        const float slope = level ? 0 : (x1 - x0) / (y1 - y0);
        const float spread = level ? x1 - x0 : 0;
        for (int row = begin; row < end; ++row) {
            float from = clamp_float(float(row) - kEdgeSlack, y0, y1);
            float to = clamp_float(float(row + 1) + kEdgeSlack, y0, y1);
            float a = x0 + (from - y0) * slope, b = x0 + (to - y0) * slope + spread;
            float least = a < b ? a : b, most = a < b ? b : a;
            low[row] = least < low[row] ? least : low[row];
            high[row] = most > high[row] ? most : high[row];
        }
    }
}

ANTUMBRA_INLINE void lower_span(float* pixels, int begin, int end, float base, float along, float least) {
    for (int x = begin; x < end; ++x) {
        float value = base + along * float(x);
        value = value > least ? value : least;
        pixels[x] = value < pixels[x] ? value : pixels[x];
    }
}

/// Lowers the nearness of every pixel whose square the polygon comes near, and widens `touched` (pixels).
ANTUMBRA_INLINE void lower_pixels(const Screen& screen, OccluderBrush& brush, int stride, const EdgeLoop& loop,
                                  const PatchPolygon& polygon, PixelRows rows, TileRect& touched) {
    NearnessPlane plane = plane_of(polygon, screen);
    // The least of a square is at the corner where the plane falls towards.
    double corner = (plane.along_x < 0 ? plane.along_x : 0) + (plane.along_y < 0 ? plane.along_y : 0);
    auto least = static_cast<float>(screen.surely_below(loop.least_nearness));
    reach_of_rows(loop, rows, brush.low.data(), brush.high.data());
    const float width = float(screen.width);
    for (int row = rows.first; row < rows.last; ++row) {
        int begin = clamp_int(floor_int(clamp_float(brush.low[row] - kEdgeSlack, -1, width)), 0, screen.width);
        int end = clamp_int(floor_int(clamp_float(brush.high[row] + kEdgeSlack, -1, width)) + 1, 0, screen.width);
        if (begin >= end)
            continue;
        touched.x0 = begin < touched.x0 ? begin : touched.x0;
        touched.x1 = end > touched.x1 ? end : touched.x1;
        auto base = static_cast<float>(plane.at_zero + corner + plane.along_y * row - plane.slack);
        lower_span(brush.nearness.data() + row * stride, begin, end, base, static_cast<float>(plane.along_x), least);
    }
    touched.y0 = rows.first < touched.y0 ? rows.first : touched.y0;
    touched.y1 = rows.last > touched.y1 ? rows.last : touched.y1;
}

/// Rows whose centre line the loop reaches.
ANTUMBRA_INLINE PixelRows centre_rows(const Screen& screen, const EdgeLoop& loop) {
    float low = 1e9f, high = -1e9f;
    for (int i = 0; i < loop.count; ++i) {
        low = loop.y[i] < low ? loop.y[i] : low;
        high = loop.y[i] > high ? loop.y[i] : high;
    }
    const float height = float(screen.height);
    return {clamp_int(ceil_int(clamp_float(low - 0.5f, -1, height)), 0, screen.height),
            clamp_int(floor_int(clamp_float(high - 0.5f, -1, height)) + 1, 0, screen.height)};
}

ANTUMBRA_INLINE void raise_span(float* pixels, const float* by, int begin, int end) {
    for (int x = begin; x < end; ++x) {
        float value = by[x] < kNoMember ? by[x] : kOpen; // covered without a member: cannot be, and must not hide
        pixels[x] = value > pixels[x] ? value : pixels[x];
    }
}

/// Hands the covered pixels of the patch to the image and empties the brush.
ANTUMBRA_INLINE void merge(OccluderBrush& brush, const TileRect& touched, OccluderImage& image) {
    if (touched.empty())
        return;
    int first = touched.x0 >> 6, last = (touched.x1 - 1) >> 6;
    for (int row = touched.y0; row < touched.y1; ++row) {
        std::uint64_t* covered = brush.coverage.covered.data() + brush.coverage.word_of(0, row);
        std::uint64_t* silhouette = brush.coverage.silhouette.data() + brush.coverage.word_of(0, row);
        float* from = brush.nearness.data() + row * image.stride;
        float* to = image.nearness.data() + row * image.stride;
        std::uint64_t any = 0;
        for (int word = first; word <= last; ++word) {
            std::uint64_t rest = covered[word * kTile] & ~silhouette[word * kTile];
            image.bits[static_cast<std::size_t>(row * image.words + word)] |= rest;
            any |= rest;
            covered[word * kTile] = silhouette[word * kTile] = 0;
            while (rest) { // run by run
                int begin = std::countr_zero(rest);
                int end = begin + std::countr_one(rest >> begin);
                raise_span(to, from, word * 64 + begin, word * 64 + end);
                rest = end == 64 ? 0 : rest & (~std::uint64_t(0) << end);
            }
        }
        image.row_used[static_cast<std::size_t>(row)] |= any != 0;
        for (int x = touched.x0; x < touched.x1; ++x)
            from[x] = kNoMember;
    }
}

ANTUMBRA_INLINE void draw_inner(const PatchPolygon& polygon, const Screen& screen, OccluderBrush& brush,
                                EdgeLoop& loop, int stride, TileRect& touched) {
    find_edges(loop);
    PixelRows rows = rows_of(screen, loop);
    if (rows.first >= rows.last || misses_columns(screen, loop))
        return;
    lower_pixels(screen, brush, stride, loop, polygon, rows, touched);
    PixelRows centres = centre_rows(screen, loop);
    if (centres.first < centres.last)
        fill_centres(screen, brush.coverage, loop, centres.first, centres.last);
    for (int i = 0; i < loop.count; ++i)
        if (loop.silhouette[i])
            mark_silhouette(screen, brush.coverage, loop, i);
    // Edges reach a little farther than what they bound.
    touched.x0 = clamp_int(touched.x0 - 1, 0, screen.width);
    touched.x1 = clamp_int(touched.x1 + 1, 0, screen.width);
}

/// Columns begin .. end - 1 of those of a word, wherever they are.
ANTUMBRA_INLINE std::uint64_t columns_of_word(int begin, int end) {
    auto from = [](int n) { return n > 63 ? 0 : ~std::uint64_t(0) << clamp_int(n, 0, 63); };
    return from(begin) & ~from(end);
}

ANTUMBRA_INLINE void draw_centres(const PatchPolygon& polygon, const Screen& screen, OccluderBrush& brush,
                                  EdgeLoop& loop, OccluderImage& image) {
    PixelRows rows = centre_rows(screen, loop);
    if (rows.first >= rows.last || misses_columns(screen, loop))
        return;
    find_edges(loop);
    for (int strip = rows.first / kTile; strip * kTile < rows.last; ++strip) {
        RowSpans spans = find_centres(screen, loop, strip);
        std::copy(spans.begin, spans.begin + kTile, brush.coverage.begin.begin() + strip * kTile);
        std::copy(spans.end, spans.end + kTile, brush.coverage.end.begin() + strip * kTile);
    }
    NearnessPlane plane = plane_of(polygon, screen);
    auto least = static_cast<float>(loop.least_nearness), along = static_cast<float>(plane.along_x);
    for (int row = rows.first; row < rows.last; ++row) {
        int begin = brush.coverage.begin[static_cast<std::size_t>(row)];
        int end = brush.coverage.end[static_cast<std::size_t>(row)];
        if (begin >= end)
            continue;
        auto base = static_cast<float>(plane.at_zero + plane.along_x * 0.5 + plane.along_y * (row + 0.5));
        float* pixels = image.nearness.data() + row * image.stride;
        for (int x = begin; x < end; ++x) {
            float value = base + along * float(x);
            value = value > least ? value : least;
            pixels[x] = value > pixels[x] ? value : pixels[x];
        }
        for (int word = begin >> 6; word * 64 < end; ++word)
            image.bits[static_cast<std::size_t>(row * image.words + word)] |=
                columns_of_word(begin - word * 64, end - word * 64);
        image.row_used[static_cast<std::size_t>(row)] = 1;
    }
}

ANTUMBRA_INLINE std::uint32_t draw_occluder_body(const PatchStore& store, std::uint32_t index, const Screen& screen,
                                                 PixelCoverage kind, OccluderBrush& brush, OccluderImage& image) {
    const PatchRange& patch = store.patches[index];
    const PatchPolygon* polygons = store.polygons.data() + patch.first_polygon;
    PatchCoverage& work = brush.coverage;
    std::uint32_t members = 0;
    for (std::uint32_t p = 0; p < patch.polygon_count; ++p) {
        work.side[p] = facing(polygons[p], screen.camera);
        members += work.side[p] != 0;
    }
    if (members == 0)
        return 0;
    const bool may_clip = transform(store, patch, screen, work);
    TileRect touched{screen.width, screen.height, 0, 0};
    EdgeLoop loop;
    for (std::uint32_t p = 0; p < patch.polygon_count; ++p) {
        if (work.side[p] == 0 || !make_loop(store, polygons[p], screen, work, work.side[p], may_clip, loop))
            continue;
        if (kind == PixelCoverage::centre)
            draw_centres(polygons[p], screen, brush, loop, image);
        else
            draw_inner(polygons[p], screen, brush, loop, image.stride, touched);
    }
    merge(brush, touched, image);
    return members;
}

#if ANTUMBRA_X86_KERNELS
ANTUMBRA_TARGET_AVX2 std::uint32_t draw_image_avx2(const PatchStore& store, std::uint32_t patch, const Screen& screen,
                                                   PixelCoverage coverage, OccluderBrush& brush,
                                                   OccluderImage& image) {
    return draw_occluder_body(store, patch, screen, coverage, brush, image);
}
ANTUMBRA_TARGET_AVX512 std::uint32_t draw_image_avx512(const PatchStore& store, std::uint32_t patch,
                                                       const Screen& screen, PixelCoverage coverage,
                                                       OccluderBrush& brush, OccluderImage& image) {
    return draw_occluder_body(store, patch, screen, coverage, brush, image);
}
#endif

} // namespace

void OccluderImage::reset(const Screen& screen) {
    width = screen.width;
    height = screen.height;
    words = (width + 63) / 64;
    stride = words * 64;
    auto rows = static_cast<std::size_t>(height);
    bits.assign(rows * static_cast<std::size_t>(words), 0);
    nearness.assign(rows * static_cast<std::size_t>(stride), kOpen);
    row_used.assign(rows, 0);
}

void OccluderBrush::fit(const Screen& screen, const PatchStore& store) {
    if (width != screen.width || height != screen.height) {
        width = screen.width;
        height = screen.height;
        coverage.fit(screen, store);
        nearness.assign(static_cast<std::size_t>(coverage.words * 64 * height), kNoMember);
        low.resize(static_cast<std::size_t>(height));
        high.resize(static_cast<std::size_t>(height));
    }
    for (std::vector<float>* list : {&coverage.vertex_x, &coverage.vertex_y})
        if (list->size() < store.most_vertices)
            list->resize(store.most_vertices);
    for (std::vector<double>* list : {&coverage.camera_x, &coverage.camera_y, &coverage.camera_z})
        if (list->size() < store.most_vertices)
            list->resize(store.most_vertices);
    if (coverage.side.size() < store.most_polygons)
        coverage.side.resize(store.most_polygons);
}

std::uint32_t draw_occluder_scalar(const PatchStore& store, std::uint32_t patch, const Screen& screen,
                                   PixelCoverage coverage, OccluderBrush& brush, OccluderImage& image) {
    return draw_occluder_body(store, patch, screen, coverage, brush, image);
}

#if ANTUMBRA_X86_KERNELS
DrawOccluder draw_occluder_avx2() { return cpu_has_avx2() ? draw_image_avx2 : nullptr; }
DrawOccluder draw_occluder_avx512() { return cpu_has_avx512() ? draw_image_avx512 : nullptr; }
#else
DrawOccluder draw_occluder_avx2() { return nullptr; }
DrawOccluder draw_occluder_avx512() { return nullptr; }
#endif

} // namespace antumbra
