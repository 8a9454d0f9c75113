// The body of draw_patch, compiled once per instruction set: eight rows of pixels, rows of tiles or tiles side by side
// (lanes.inl). Nothing here may depend on the width of the registers or on fused operations.
#include "raster/patch_loops.inl"

namespace antumbra {
namespace {

constexpr float kLeastInner = 4; ///< pixels: smaller members cover next to none by themselves

/// What rasterisation needs of every edge, eight at a time.
ANTUMBRA_INLINE void find_edges(EdgeLoop& loop) {
    loop.min_x = loop.min_y = 1e9f;
    loop.max_x = loop.max_y = -1e9f;
    for (int i = 0; i < loop.count; ++i) {
        loop.min_x = loop.x[i] < loop.min_x ? loop.x[i] : loop.min_x;
        loop.max_x = loop.x[i] > loop.max_x ? loop.x[i] : loop.max_x;
        loop.min_y = loop.y[i] < loop.min_y ? loop.y[i] : loop.min_y;
        loop.max_y = loop.y[i] > loop.max_y ? loop.y[i] : loop.max_y;
    }
    // Behind the last corner comes the first, and again, to the end of the lanes: level edges of no length.
    const int padded = (loop.count + kLanes - 1) / kLanes * kLanes;
    for (int i = loop.count; i <= padded; ++i) {
        loop.x[i] = loop.x[0];
        loop.y[i] = loop.y[0];
    }
    for (int i = 0; i < padded; i += kStep) {
        const Floats x = load_floats(loop.x + i), y = load_floats(loop.y + i);
        const Floats next_x = load_floats(loop.x + i + 1), next_y = load_floats(loop.y + i + 1);
        const Mask up = next_y > y;
        const Floats low_x = up ? x : next_x, low_y = up ? y : next_y;
        const Floats high_x = up ? next_x : x, high_y = up ? next_y : y;
        const Floats rise = high_y - low_y;
        const Mask steep = rise > kLevel;
        const Floats slope = (high_x - low_x) / (steep ? rise : splat(1.0f));
        store(loop.low_x + i, low_x);
        store(loop.low_y + i, low_y);
        store(loop.high_x + i, high_x);
        store(loop.high_y + i, high_y);
        store(loop.slope + i, steep ? slope : splat(0.0f));
        store(loop.up + i, ones_where(up));
    }
}

/// Of eight rows side by side, from which column (or tile) to which (exclusive).
struct RowSpans {
    int begin[kLanes], end[kLanes];
};

/// Sets the columns of the spans within the 64 columns of a block.
ANTUMBRA_INLINE void set_block(std::uint64_t* block, const RowSpans& spans, int first_column) {
    for (int lane = 0; lane < kLanes; lane += kStep) {
        const Ints begin = load_ints(spans.begin + lane) - first_column, end = load_ints(spans.end + lane) - first_column;
        store(block + lane, load_words(block + lane) | (bits_from(begin) & ~bits_from(end)));
    }
}

/// The words of a row of pixels that the columns from .. to (inclusive, anywhere) lie in.
struct WordRange {
    int first, last;
};
ANTUMBRA_INLINE WordRange words_of(float from, float to, const Screen& screen) {
    const float width = float(screen.width);
    return {clamp_int(static_cast<int>(clamp_float(from, 0, width)), 0, screen.width - 1) >> 6,
            clamp_int(static_cast<int>(clamp_float(to, 0, width)), 0, screen.width - 1) >> 6};
}

/// Marks every pixel whose square comes within kEdgeSlack of the edge.
ANTUMBRA_INLINE void mark_silhouette(const Screen& screen, PatchCoverage& out, const EdgeLoop& loop, int edge) {
    const float x0 = loop.low_x[edge], y0 = loop.low_y[edge], x1 = loop.high_x[edge], y1 = loop.high_y[edge];
    const float width = float(screen.width), height = float(screen.height);
    const float low = x0 < x1 ? x0 : x1, high = x0 < x1 ? x1 : x0;
    if (y1 < -kEdgeSlack || y0 > height + kEdgeSlack || high < -kEdgeSlack || low > width + kEdgeSlack)
        return;
    const int first = clamp_int(floor_int(clamp_float(y0 - kEdgeSlack, -1, height)), 0, screen.height - 1);
    const int last = clamp_int(floor_int(clamp_float(y1 + kEdgeSlack, -1, height)), 0, screen.height - 1);
    const WordRange words = words_of(low - 1, high + 1, screen);
    const bool level = !(y1 - y0 > kLevel);
    const float slope = loop.slope[edge];
    const float base = level ? low : x0, spread = level ? high - low : 0;
    for (int strip = first / kTile; strip <= last / kTile; ++strip) {
        RowSpans spans;
        for (int lane = 0; lane < kLanes; lane += kStep) {
            const Ints rows = count_from(strip * kTile + lane);
            const Floats tops = to_floats(rows);
            const Floats from = clamp(tops - kEdgeSlack, y0, y1), to = clamp(tops + (1 + kEdgeSlack), y0, y1);
            const Floats a = base + (from - y0) * slope, b = base + (to - y0) * slope;
            const Floats left = (a < b ? a : b) - kEdgeSlack, right = (a < b ? b : a) + spread + kEdgeSlack;
            // Off the left side end becomes 0, off the right side begin becomes width: an empty range.
            const Mask crossed = (rows >= first) & (rows <= last);
            store(spans.begin + lane, crossed ? floor_ints(clamp(left, 0, width)) : splat(screen.width));
            store(spans.end + lane, crossed ? floor_ints(clamp(right, -1, width - 1)) + 1 : splat(0));
        }
        std::uint64_t* bits = out.silhouette.data() + strip * out.words * kTile;
        for (int word = words.first; word <= words.last; ++word)
            set_block(bits + word * kTile, spans, word * 64);
    }
}

/// Of the eight rows of a strip, from which column to which the loop covers centres.
ANTUMBRA_INLINE RowSpans find_centres(const Screen& screen, const EdgeLoop& loop, int strip) {
    const float width = float(screen.width);
    RowSpans spans;
    for (int lane = 0; lane < kLanes; lane += kStep) {
        const Floats centres = to_floats(count_from(strip * kTile + lane)) + 0.5f;
        Floats left = splat(1e9f), right = splat(-1e9f);
        for (int i = 0; i < loop.count; ++i) {
            const Mask crossed = (centres >= loop.low_y[i]) & (centres < loop.high_y[i]);
            const Floats column = loop.low_x[i] + (centres - loop.low_y[i]) * loop.slope[i];
            // Counter-clockwise: the inside is to the left of an edge that goes up.
            if (loop.up[i])
                right = crossed ? column : right;
            else
                left = crossed ? column : left;
        }
        store(spans.begin + lane, ceil_ints(clamp(left - 0.5f, 0, width)));
        store(spans.end + lane, floor_ints(clamp(right - 0.5f, -1, width - 1)) + 1);
    }
    return spans;
}

/// Of the eight rows of a strip, from which column to which the loop by itself covers whole squares and kEdgeSlack around
/// them. The left border of a convex loop bulges to the left and the right one to the right: over the height of a row its two
/// ends decide. Only for rows that lie between the lowest and the highest corner, at least 2 kEdgeSlack away.
ANTUMBRA_INLINE RowSpans find_inner(const Screen& screen, const EdgeLoop& loop, int strip) {
    const float width = float(screen.width);
    RowSpans spans;
    for (int lane = 0; lane < kLanes; lane += kStep) {
        const Floats tops = to_floats(count_from(strip * kTile + lane));
        const Floats low = tops - kEdgeSlack, high = tops + (1 + kEdgeSlack);
        Floats left = splat(-1e9f), right = splat(1e9f);
        for (int i = 0; i < loop.count; ++i) {
            const float y0 = loop.low_y[i], y1 = loop.high_y[i], slope = loop.slope[i];
            // An edge that counts as level may be crossed anywhere on it: at its innermost end.
            const float rest = y1 - y0 > kLevel ? 0 : loop.high_x[i] - loop.low_x[i];
            const float x0 = loop.low_x[i] + ((rest > 0) == (loop.up[i] == 0) ? rest : 0);
            const Floats a = x0 + (low - y0) * slope, b = x0 + (high - y0) * slope;
            const Mask at_low = (low >= y0) & (low < y1), at_high = (high >= y0) & (high < y1);
            if (loop.up[i]) {
                right = (at_low & (a < right)) ? a : right;
                right = (at_high & (b < right)) ? b : right;
            } else {
                left = (at_low & (a > left)) ? a : left;
                left = (at_high & (b > left)) ? b : left;
            }
        }
        const Mask between = (tops >= splat(loop.min_y + 2 * kEdgeSlack)) & (tops <= splat(loop.max_y - (1 + 2 * kEdgeSlack)));
        store(spans.begin + lane, between ? ceil_ints(clamp(left + kEdgeSlack, 0, width)) : splat(screen.width));
        store(spans.end + lane, between ? floor_ints(clamp(right - kEdgeSlack, 0, width)) : splat(0));
    }
    return spans;
}

/// `first` .. `last` - 1: rows whose centres the loop reaches.
ANTUMBRA_INLINE void fill_centres(const Screen& screen, PatchCoverage& out, const EdgeLoop& loop, int first, int last) {
    const WordRange words = words_of(loop.min_x - 1, loop.max_x + 1, screen);
    for (int strip = first / kTile; strip * kTile < last; ++strip) {
        const RowSpans spans = find_centres(screen, loop, strip);
        std::uint64_t* bits = out.covered.data() + strip * out.words * kTile;
        for (int word = words.first; word <= words.last; ++word)
            set_block(bits + word * kTile, spans, word * 64);
    }
}

/// The pixels that the loop covers by itself, whatever silhouettes of other members run through them.
ANTUMBRA_INLINE void fill_inner(const Screen& screen, PatchCoverage& out, const EdgeLoop& loop, int first, int last) {
    const WordRange words = words_of(loop.min_x - 1, loop.max_x + 1, screen);
    for (int strip = first / kTile; strip * kTile < last; ++strip) {
        const RowSpans spans = find_inner(screen, loop, strip);
        std::uint64_t* bits = out.inner.data() + strip * out.words * kTile;
        for (int word = words.first; word <= words.last; ++word)
            set_block(bits + word * kTile, spans, word * 64);
    }
}

/// nearness = at_zero + along_x * x + along_y * y over the screen, from the plane of a polygon.
struct NearnessPlane {
    double at_zero, along_x, along_y, slack;
};

ANTUMBRA_INLINE NearnessPlane plane_of(const PatchPolygon& polygon, const Screen& screen) {
    const Camera& camera = screen.camera;
    double nx = dot(polygon.normal, camera.right), ny = dot(polygon.normal, camera.up);
    double nz = dot(polygon.normal, camera.forward);
    double c = -(dot(polygon.normal, camera.eye) + polygon.offset);
    NearnessPlane plane;
    if (camera.orthographic) // - z = (nx x + ny y - c) / nz
        plane = {-c / nz, nx / nz / screen.scale_x, ny / nz / screen.scale_y, 0};
    else // 1 / z = (nx x/z + ny y/z + nz) / c
        plane = {nz / c, nx / c / screen.scale_x, ny / c / screen.scale_y, 0};
    plane.at_zero -= plane.along_x * screen.centre_x + plane.along_y * screen.centre_y;
    // Padding for what follows in floats: a handful of roundings of 2^-24 each.
    plane.slack = 1e-6 * (std::abs(plane.at_zero) + std::abs(plane.along_x) * screen.width +
                          std::abs(plane.along_y) * screen.height);
    if (camera.orthographic) // c may be a small difference of large numbers
        plane.slack += 1e-12 * (std::abs(polygon.offset) + screen.orthographic_slack) / std::abs(nz);
    return plane;
}

/// Of eight rows of tiles, from which tile to which the loop reaches.
ANTUMBRA_INLINE RowSpans reach_of_tile_rows(const Screen& screen, const EdgeLoop& loop, int first_row) {
    const float columns = float(screen.tiles_x);
    RowSpans spans;
    for (int lane = 0; lane < kLanes; lane += kStep) {
        Floats lows = splat(1e9f), highs = splat(-1e9f);
        const Floats tops = to_floats(count_from(first_row + lane) * kTile);
        const Floats band_low = tops - kEdgeSlack, band_high = tops + (kTile + kEdgeSlack);
        for (int i = 0; i < loop.count; ++i) {
            const float x0 = loop.low_x[i], y0 = loop.low_y[i], y1 = loop.high_y[i], slope = loop.slope[i];
            const float level_x = y1 - y0 > kLevel ? 0 : loop.high_x[i] - x0;
            const Floats a = x0 + (clamp(band_low, y0, y1) - y0) * slope;
            const Floats b = x0 + level_x + (clamp(band_high, y0, y1) - y0) * slope;
            const Mask near = (band_low <= y1) & (band_high >= y0);
            const Floats least = a < b ? a : b, most = a < b ? b : a;
            lows = (near & (least < lows)) ? least : lows;
            highs = (near & (most > highs)) ? most : highs;
        }
        store(spans.begin + lane, floor_ints(clamp((lows - kEdgeSlack) * (1.0f / kTile), 0, columns)));
        store(spans.end + lane, floor_ints(clamp((highs + kEdgeSlack) * (1.0f / kTile), -1, columns - 1)) + 1);
    }
    return spans;
}

/// Lowers the nearness of every tile that the polygon comes near.
ANTUMBRA_INLINE void lower_tiles(const Screen& screen, PatchCoverage& out, const EdgeLoop& loop,
                                 const PatchPolygon& polygon, int first_tile, int last_tile) {
    NearnessPlane plane = plane_of(polygon, screen);
    // The least of a tile is at the corner where the plane falls towards.
    plane.at_zero += kTile * ((plane.along_x < 0 ? plane.along_x : 0) + (plane.along_y < 0 ? plane.along_y : 0));
    const auto least = static_cast<float>(screen.surely_below(loop.least_nearness));
    const auto step = static_cast<float>(plane.along_x * kTile);
    for (int block = first_tile / kLanes * kLanes; block < last_tile; block += kLanes) {
        const RowSpans reach = reach_of_tile_rows(screen, loop, block);
        const int first = block > first_tile ? block : first_tile;
        const int last = block + kLanes < last_tile ? block + kLanes : last_tile;
        for (int ty = first; ty < last; ++ty) {
            const int from = reach.begin[ty - block], to = reach.end[ty - block];
            float* row = out.nearness.data() + ty * out.words * kLanes;
            const auto base = static_cast<float>(plane.at_zero + plane.along_y * (ty * kTile) - plane.slack);
            for (int tx = from / kStep * kStep; tx < to; tx += kStep) {
                const Ints tiles = count_from(tx);
                const Floats value = base + step * to_floats(tiles), old = load_floats(row + tx);
                const Floats bound = value > least ? value : splat(least);
                const Mask lower = (tiles >= from) & (tiles < to) & (bound < old);
                store(row + tx, lower ? bound : old);
            }
        }
    }
}

ANTUMBRA_INLINE void draw_polygon(const PatchPolygon& polygon, const Screen& screen, PatchCoverage& out,
                                  EdgeLoop& loop) {
    find_edges(loop);
    const float width = float(screen.width), height = float(screen.height);
    if (loop.max_x < -kEdgeSlack || loop.min_x > width + kEdgeSlack || loop.max_y < -kEdgeSlack ||
        loop.min_y > height + kEdgeSlack)
        return;
    ++out.polygons;
    int first_tile = clamp_int(floor_int(clamp_float(loop.min_y - kEdgeSlack, -1, height)), 0, screen.height - 1) / kTile;
    int last_tile = clamp_int(floor_int(clamp_float(loop.max_y + kEdgeSlack, -1, height)), 0, screen.height - 1) / kTile + 1;
    out.touched.y0 = first_tile < out.touched.y0 ? first_tile : out.touched.y0;
    out.touched.y1 = last_tile > out.touched.y1 ? last_tile : out.touched.y1;
    int begin = clamp_int(floor_int(clamp_float(loop.min_x - 1, -1, width)), 0, screen.width - 1) / kTile;
    int end = clamp_int(floor_int(clamp_float(loop.max_x + 1, -1, width)), 0, screen.width - 1) / kTile + 1;
    out.touched.x0 = begin < out.touched.x0 ? begin : out.touched.x0;
    out.touched.x1 = end > out.touched.x1 ? end : out.touched.x1;
    lower_tiles(screen, out, loop, polygon, first_tile, last_tile);
    int first = clamp_int(ceil_int(clamp_float(loop.min_y - 0.5f, -1, height)), 0, screen.height);
    int last = clamp_int(floor_int(clamp_float(loop.max_y - 0.5f, -1, height)) + 1, 0, screen.height);
    if (first < last)
        fill_centres(screen, out, loop, first, last);
    if (first < last && loop.max_x - loop.min_x > kLeastInner && loop.max_y - loop.min_y > kLeastInner)
        fill_inner(screen, out, loop, first, last);
    for (int i = 0; i < loop.count; ++i)
        if (loop.silhouette[i])
            mark_silhouette(screen, out, loop, i);
}

ANTUMBRA_INLINE void draw_patch_body(const PatchStore& store, std::uint32_t index, const Screen& screen,
                                     PatchCoverage& out) {
    const PatchRange& patch = store.patches[index];
    out.polygons = 0;
    out.touched = {screen.tiles_x, screen.tiles_y, 0, 0};
    const PatchPolygon* polygons = store.polygons.data() + patch.first_polygon;
    bool any = false;
    for (std::uint32_t p = 0; p < patch.polygon_count; ++p) {
        out.side[p] = facing(polygons[p], screen.camera);
        any = any || out.side[p] != 0;
    }
    if (!any)
        return;
    const bool may_clip = transform(store, patch, screen, out);
    EdgeLoop loop;
    for (std::uint32_t p = 0; p < patch.polygon_count; ++p)
        if (out.side[p] != 0 && make_loop(store, polygons[p], screen, out, out.side[p], may_clip, loop))
            draw_polygon(polygons[p], screen, out, loop);
}

} // namespace
} // namespace antumbra
