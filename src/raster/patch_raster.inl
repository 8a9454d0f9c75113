// The body of draw_patch, compiled once per instruction set. Plain loops; nothing here may depend on the width of
// the registers or on fused operations.

namespace antumbra {
namespace {

#define ANTUMBRA_INLINE __attribute__((always_inline)) inline

constexpr float kGuard = 8192;         ///< pixels from the centre: farther corners are clipped first
constexpr int kMostCorners = 64;       ///< of a polygon, clipping included; larger ones are not drawn

struct ClipCorner {
    double x, y, z;
    bool silhouette; ///< the edge that starts here
};

struct EdgeLoop {
    float x[kMostCorners], y[kMostCorners];
    bool silhouette[kMostCorners];
    int count = 0;
    double least_nearness = 0; ///< of its corners, rounded farther
};

ANTUMBRA_INLINE int clamp_int(int value, int low, int high) { return value < low ? low : value > high ? high : value; }
/// floor and ceil for values that fit; written out so that every compiler can vectorise them alike.
ANTUMBRA_INLINE int floor_int(float value) {
    int whole = static_cast<int>(value);
    return whole - (float(whole) > value);
}
ANTUMBRA_INLINE int ceil_int(float value) {
    int whole = static_cast<int>(value);
    return whole + (float(whole) < value);
}
ANTUMBRA_INLINE float clamp_float(float value, float low, float high) {
    value = value < low ? low : value;
    return value > high ? high : value;
}

ANTUMBRA_INLINE void transform(const PatchStore& store, const PatchRange& patch, const Screen& screen,
                               PatchCoverage& out) {
    const Camera& camera = screen.camera;
    const float* px = store.x.data() + patch.first_vertex;
    const float* py = store.y.data() + patch.first_vertex;
    const float* pz = store.z.data() + patch.first_vertex;
    double* __restrict cx = out.camera_x.data();
    double* __restrict cy = out.camera_y.data();
    double* __restrict cz = out.camera_z.data();
    float* __restrict sx = out.vertex_x.data();
    float* __restrict sy = out.vertex_y.data();
    const double ex = camera.eye.x, ey = camera.eye.y, ez = camera.eye.z;
    const Vec3d r = camera.right, u = camera.up, f = camera.forward;
    const double scale_x = screen.scale_x, scale_y = screen.scale_y;
    const double centre_x = screen.centre_x, centre_y = screen.centre_y, clip = screen.clip_depth;
    const bool flat = camera.orthographic;
    for (std::uint32_t v = 0; v < patch.vertex_count; ++v) {
        double x = double(px[v]) - ex, y = double(py[v]) - ey, z = double(pz[v]) - ez;
        double a = r.x * x + r.y * y + r.z * z, b = u.x * x + u.y * y + u.z * z, c = f.x * x + f.y * y + f.z * z;
        cx[v] = a;
        cy[v] = b;
        cz[v] = c;
    }
    // Corners nearer than the clip depth get some finite place; they are never used.
    const double least = flat ? 1.0 : clip, most = flat ? 1.0 : 1e300;
    for (std::uint32_t v = 0; v < patch.vertex_count; ++v) {
        double depth = cz[v] > least ? cz[v] : least;
        depth = depth < most ? depth : most;
        sx[v] = static_cast<float>(centre_x + cx[v] / depth * scale_x);
        sy[v] = static_cast<float>(centre_y + cy[v] / depth * scale_y);
    }
}

/// 1: certainly shows its front, -1: certainly its back and blocks there too, 0: no member. Edge-on polygons, and
/// those that look edge-on within rounding, are no members.
ANTUMBRA_INLINE signed char facing(const PatchPolygon& polygon, const Camera& camera) {
    if (polygon.count + 8 > kMostCorners)
        return 0;
    double towards, scale;
    if (camera.orthographic) {
        towards = -dot(polygon.normal, camera.forward);
        scale = 1;
    } else {
        towards = dot(polygon.normal, camera.eye) + polygon.offset;
        scale = std::abs(camera.eye.x) + std::abs(camera.eye.y) + std::abs(camera.eye.z) + std::abs(polygon.offset);
    }
    double margin = 1e-9 * scale;
    if (towards > margin)
        return 1;
    return polygon.double_sided && towards < -margin ? -1 : 0;
}

/// Cuts away where `value` of a corner is negative. The cut is a silhouette.
template <class Value>
ANTUMBRA_INLINE int clip_by(const ClipCorner* in, int count, ClipCorner* out, Value value) {
    int kept = 0;
    for (int i = 0; i < count; ++i) {
        const ClipCorner &a = in[i], &b = in[i + 1 == count ? 0 : i + 1];
        double va = value(a), vb = value(b);
        if (va >= 0)
            out[kept++] = a;
        if ((va >= 0) != (vb >= 0)) {
            double t = va / (va - vb);
            ClipCorner cut{a.x + (b.x - a.x) * t, a.y + (b.y - a.y) * t, a.z + (b.z - a.z) * t, a.silhouette};
            cut.silhouette = va >= 0 ? true : a.silhouette;
            out[kept++] = cut;
        }
    }
    return kept;
}

/// The polygon on the screen, clipped only if it must be.
ANTUMBRA_INLINE bool make_loop(const PatchStore& store, const PatchPolygon& polygon, const Screen& screen,
                               const PatchCoverage& work, signed char side, EdgeLoop& loop) {
    bool needs_clip = false;
    double farthest = -1e300;
    ClipCorner corners[kMostCorners], clipped[kMostCorners];
    loop.count = polygon.count;
    for (int i = 0; i < loop.count; ++i) {
        // Seen from the back the corners run clockwise: take them in reverse.
        int from = side > 0 ? i : loop.count - 1 - i;
        int edge = side > 0 ? i : (from + loop.count - 1) % loop.count;
        std::uint32_t corner = store.corners[polygon.first + static_cast<std::uint32_t>(from)];
        std::uint16_t neighbour = store.neighbours[polygon.first + static_cast<std::uint32_t>(edge)];
        bool silhouette = true;
        if (neighbour != kNoLocal) {
            signed char other = work.side[neighbour & ~kLocalSameDirection];
            silhouette = other == 0 || (other == side) == ((neighbour & kLocalSameDirection) != 0);
        }
        // An edge on the clip plane: whatever is on its other side is clipped away.
        int to = side > 0 ? (i + 1 == loop.count ? 0 : i + 1) : edge;
        std::uint32_t next = store.corners[polygon.first + static_cast<std::uint32_t>(to)];
        double z = work.camera_z[corner], z_next = work.camera_z[next];
        if ((z > z_next ? z : z_next) <= screen.clip_depth + screen.depth_slack)
            silhouette = true;
        loop.x[i] = work.vertex_x[corner];
        loop.y[i] = work.vertex_y[corner];
        loop.silhouette[i] = silhouette;
        farthest = z > farthest ? z : farthest;
        corners[i] = {work.camera_x[corner], work.camera_y[corner], z, silhouette};
        float off_x = loop.x[i] - float(screen.centre_x), off_y = loop.y[i] - float(screen.centre_y);
        needs_clip = needs_clip || !(z >= screen.clip_depth) ||
                     !(off_x < kGuard && off_x > -kGuard && off_y < kGuard && off_y > -kGuard);
    }
    loop.least_nearness = farthest > screen.clip_depth ? screen.nearness(farthest) : 0;
    if (!needs_clip)
        return true;
    double clip = screen.clip_depth, guard_x = kGuard / screen.scale_x, guard_y = kGuard / screen.scale_y;
    bool flat = screen.camera.orthographic;
    int count = loop.count;
    count = clip_by(corners, count, clipped, [=](const ClipCorner& p) { return p.z - clip; });
    count = clip_by(clipped, count, corners, [=](const ClipCorner& p) { return guard_x * (flat ? 1 : p.z) - p.x; });
    count = clip_by(corners, count, clipped, [=](const ClipCorner& p) { return guard_x * (flat ? 1 : p.z) + p.x; });
    count = clip_by(clipped, count, corners, [=](const ClipCorner& p) { return guard_y * (flat ? 1 : p.z) - p.y; });
    count = clip_by(corners, count, clipped, [=](const ClipCorner& p) { return guard_y * (flat ? 1 : p.z) + p.y; });
    farthest = -1e300;
    for (int i = 0; i < count; ++i) {
        double depth = flat ? 1.0 : clipped[i].z;
        loop.x[i] = static_cast<float>(screen.centre_x + clipped[i].x / depth * screen.scale_x);
        loop.y[i] = static_cast<float>(screen.centre_y + clipped[i].y / depth * screen.scale_y);
        loop.silhouette[i] = clipped[i].silhouette;
        farthest = clipped[i].z > farthest ? clipped[i].z : farthest;
    }
    loop.count = count;
    if (count >= 3)
        loop.least_nearness = screen.nearness(farthest);
    return count >= 3;
}

ANTUMBRA_INLINE void set_bits(std::uint64_t* row, int from, int to) { // columns from .. to, inclusive
    int first = from >> 6, last = to >> 6;
    std::uint64_t low = ~std::uint64_t(0) << (from & 63), high = ~std::uint64_t(0) >> (63 - (to & 63));
    if (first == last) {
        row[first] |= low & high;
        return;
    }
    row[first] |= low;
    for (int word = first + 1; word < last; ++word)
        row[word] = ~std::uint64_t(0);
    row[last] |= high;
}

/// Marks every pixel whose square comes within kEdgeSlack of the edge.
ANTUMBRA_INLINE void mark_silhouette(const Screen& screen, PatchCoverage& out, float x0, float y0, float x1, float y1) {
    if (y0 > y1) {
        float x = x0, y = y0;
        x0 = x1, y0 = y1, x1 = x, y1 = y;
    }
    const float width = float(screen.width), height = float(screen.height);
    float low = x0 < x1 ? x0 : x1, high = x0 < x1 ? x1 : x0;
    if (y1 < -kEdgeSlack || y0 > height + kEdgeSlack || high < -kEdgeSlack || low > width + kEdgeSlack)
        return;
    int first = clamp_int(floor_int(clamp_float(y0 - kEdgeSlack, -1, height)), 0, screen.height - 1);
    int last = clamp_int(floor_int(clamp_float(y1 + kEdgeSlack, -1, height)), 0, screen.height - 1);
    // First all columns (this loop becomes vector code), then the bits.
    const bool level = !(y1 > y0);
    const float slope = level ? 0 : (x1 - x0) / (y1 - y0);
    const float base = level ? low : x0, spread = level ? high - low : 0;
    const int last_column = screen.width - 1;
    int* __restrict begin = out.begin.data();
    int* __restrict end = out.end.data();
    for (int row = first; row <= last; ++row) {
        float from = clamp_float(float(row) - kEdgeSlack, y0, y1);
        float to = clamp_float(float(row + 1) + kEdgeSlack, y0, y1);
        float a = base + (from - y0) * slope, b = base + (to - y0) * slope;
        float left = (a < b ? a : b) - kEdgeSlack, right = (a < b ? b : a) + spread + kEdgeSlack;
        // Off the left side end becomes -1, off the right side begin becomes width: an empty range.
        int begin_column = floor_int(clamp_float(left, 0, width)), end_column = floor_int(clamp_float(right, -1, width));
        begin[row] = begin_column;
        end[row] = end_column < last_column ? end_column : last_column;
    }
    std::uint64_t* bits = out.silhouette.data() + first * out.words;
    for (int row = first; row <= last; ++row, bits += out.words)
        if (begin[row] <= end[row])
            set_bits(bits, begin[row], end[row]);
}

/// Writes the crossings of an edge with the centre lines of rows first..last - 1 to its side.
ANTUMBRA_INLINE void cross_rows(float x0, float y0, float x1, float y1, int first, int last, float* side) {
    float slope = (x1 - x0) / (y1 - y0);
    for (int row = first; row < last; ++row)
        side[row] = x0 + (float(row) + 0.5f - y0) * slope;
}

ANTUMBRA_INLINE void fill_centres(const Screen& screen, PatchCoverage& out, const EdgeLoop& loop, int first, int last) {
    float* __restrict left = out.left.data();
    float* __restrict right = out.right.data();
    for (int row = first; row < last; ++row) {
        left[row] = 1e9f;
        right[row] = -1e9f;
    }
    const float height = float(screen.height);
    for (int i = 0; i < loop.count; ++i) {
        int j = i + 1 == loop.count ? 0 : i + 1;
        bool up = loop.y[j] > loop.y[i]; // counter-clockwise: the inside is to the left of an edge that goes up
        float x0 = up ? loop.x[i] : loop.x[j], y0 = up ? loop.y[i] : loop.y[j];
        float x1 = up ? loop.x[j] : loop.x[i], y1 = up ? loop.y[j] : loop.y[i];
        int begin = clamp_int(ceil_int(clamp_float(y0 - 0.5f, -1, height)), first, last);
        int end = clamp_int(ceil_int(clamp_float(y1 - 0.5f, -1, height)), first, last);
        if (begin < end)
            cross_rows(x0, y0, x1, y1, begin, end, up ? right : left);
    }
    const float width = float(screen.width);
    int* __restrict begin = out.begin.data();
    int* __restrict end = out.end.data();
    for (int row = first; row < last; ++row) {
        begin[row] = ceil_int(clamp_float(left[row] - 0.5f, 0, width));
        end[row] = floor_int(clamp_float(right[row] - 0.5f, -1, width - 1));
    }
    std::uint64_t* bits = out.covered.data() + first * out.words;
    for (int row = first; row < last; ++row, bits += out.words)
        if (begin[row] <= end[row])
            set_bits(bits, begin[row], end[row]);
}

/// Lowers the nearness of every tile that the polygon comes near.
ANTUMBRA_INLINE void lower_tiles(const Screen& screen, PatchCoverage& out, const EdgeLoop& loop,
                                 const PatchPolygon& polygon, int first_tile, int last_tile) {
    // nearness = at_zero + along_x * x + along_y * y over the screen, from the plane n . p = c in camera space.
    const Camera& camera = screen.camera;
    double nx = dot(polygon.normal, camera.right), ny = dot(polygon.normal, camera.up);
    double nz = dot(polygon.normal, camera.forward);
    double c = -(dot(polygon.normal, camera.eye) + polygon.offset);
    double at_zero, along_x, along_y;
    if (camera.orthographic) { // - z = (nx x + ny y - c) / nz
        along_x = nx / nz / screen.scale_x;
        along_y = ny / nz / screen.scale_y;
        at_zero = -c / nz;
    } else { // 1 / z = (nx x/z + ny y/z + nz) / c
        along_x = nx / c / screen.scale_x;
        along_y = ny / c / screen.scale_y;
        at_zero = nz / c;
    }
    at_zero -= along_x * screen.centre_x + along_y * screen.centre_y;
    double corner_x = along_x < 0 ? kTile : 0, corner_y = along_y < 0 ? kTile : 0;
    at_zero += along_x * corner_x + along_y * corner_y;
    double magnitude = std::abs(at_zero) + std::abs(along_x) * screen.width + std::abs(along_y) * screen.height;
    double slack = 1e-6 * magnitude;
    if (camera.orthographic) // c may be a small difference of large numbers
        slack += 1e-12 * (std::abs(polygon.offset) + screen.orthographic_slack) / std::abs(nz);
    auto least = static_cast<float>(screen.surely_below(loop.least_nearness));
    // First how far every row of tiles reaches, edge by edge, then the tiles.
    float* __restrict lows = out.left.data();
    float* __restrict highs = out.right.data();
    for (int ty = first_tile; ty < last_tile; ++ty) {
        lows[ty] = 1e9f;
        highs[ty] = -1e9f;
    }
    for (int i = 0; i < loop.count; ++i) {
        int j = i + 1 == loop.count ? 0 : i + 1;
        bool up = loop.y[j] > loop.y[i];
        float x0 = up ? loop.x[i] : loop.x[j], y0 = up ? loop.y[i] : loop.y[j];
        float x1 = up ? loop.x[j] : loop.x[i], y1 = up ? loop.y[j] : loop.y[i];
        float slope = y1 > y0 ? (x1 - x0) / (y1 - y0) : 0, level_x = y1 > y0 ? 0 : x1 - x0;
        float rows = float(screen.tiles_y);
        int begin = clamp_int(floor_int(clamp_float((y0 - 1) / kTile, -1, rows)), first_tile, last_tile);
        int end = clamp_int(floor_int(clamp_float((y1 + 1) / kTile, -1, rows)) + 1, first_tile, last_tile);
        for (int ty = begin; ty < end; ++ty) {
            float band_low = float(ty * kTile) - kEdgeSlack, band_high = float(ty * kTile + kTile) + kEdgeSlack;
            float a = x0 + (clamp_float(band_low, y0, y1) - y0) * slope;
            float b = x0 + level_x + (clamp_float(band_high, y0, y1) - y0) * slope;
            float least_x = a < b ? a : b, most_x = a < b ? b : a;
            bool near = (y1 >= band_low) & (y0 <= band_high);
            least_x = near ? least_x : 1e9f;
            most_x = near ? most_x : -1e9f;
            lows[ty] = least_x < lows[ty] ? least_x : lows[ty];
            highs[ty] = most_x > highs[ty] ? most_x : highs[ty];
        }
    }
    for (int ty = first_tile; ty < last_tile; ++ty) {
        float low = lows[ty], high = highs[ty];
        int begin = clamp_int(floor_int(clamp_float((low - kEdgeSlack) / kTile, -1, float(screen.tiles_x))), 0, screen.tiles_x);
        int end = clamp_int(floor_int(clamp_float((high + kEdgeSlack) / kTile, -1, float(screen.tiles_x))) + 1, 0, screen.tiles_x);
        if (begin >= end)
            continue;
        float* row = out.nearness.data() + ty * screen.tiles_x;
        double base = at_zero + along_y * (ty * kTile) - slack;
        for (int tx = begin; tx < end; ++tx) {
            auto value = static_cast<float>(base + along_x * (tx * kTile));
            value = value > least ? value : least;
            row[tx] = value < row[tx] ? value : row[tx];
        }
    }
}

ANTUMBRA_INLINE void draw_polygon(const PatchPolygon& polygon, const Screen& screen, PatchCoverage& out,
                                  const EdgeLoop& loop) {
    float low_x = 1e9f, high_x = -1e9f, low_y = 1e9f, high_y = -1e9f;
    for (int i = 0; i < loop.count; ++i) {
        low_x = loop.x[i] < low_x ? loop.x[i] : low_x;
        high_x = loop.x[i] > high_x ? loop.x[i] : high_x;
        low_y = loop.y[i] < low_y ? loop.y[i] : low_y;
        high_y = loop.y[i] > high_y ? loop.y[i] : high_y;
    }
    const float width = float(screen.width), height = float(screen.height);
    if (high_x < -kEdgeSlack || low_x > width + kEdgeSlack || high_y < -kEdgeSlack || low_y > height + kEdgeSlack)
        return;
    ++out.polygons;
    int first_tile = clamp_int(floor_int(clamp_float(low_y - kEdgeSlack, -1, height)), 0, screen.height - 1) / kTile;
    int last_tile = clamp_int(floor_int(clamp_float(high_y + kEdgeSlack, -1, height)), 0, screen.height - 1) / kTile + 1;
    out.touched.y0 = first_tile < out.touched.y0 ? first_tile : out.touched.y0;
    out.touched.y1 = last_tile > out.touched.y1 ? last_tile : out.touched.y1;
    int begin = clamp_int(floor_int(clamp_float(low_x - 1, -1, width)), 0, screen.width - 1) / kTile;
    int end = clamp_int(floor_int(clamp_float(high_x + 1, -1, width)), 0, screen.width - 1) / kTile + 1;
    out.touched.x0 = begin < out.touched.x0 ? begin : out.touched.x0;
    out.touched.x1 = end > out.touched.x1 ? end : out.touched.x1;
    lower_tiles(screen, out, loop, polygon, first_tile, last_tile);
    int first = clamp_int(ceil_int(clamp_float(low_y - 0.5f, -1, height)), 0, screen.height);
    int last = clamp_int(floor_int(clamp_float(high_y - 0.5f, -1, height)) + 1, 0, screen.height);
    if (first < last)
        fill_centres(screen, out, loop, first, last);
    for (int i = 0; i < loop.count; ++i) {
        int j = i + 1 == loop.count ? 0 : i + 1;
        if (loop.silhouette[i])
            mark_silhouette(screen, out, loop.x[i], loop.y[i], loop.x[j], loop.y[j]);
    }
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
    transform(store, patch, screen, out);
    EdgeLoop loop;
    for (std::uint32_t p = 0; p < patch.polygon_count; ++p)
        if (out.side[p] != 0) {
            if (make_loop(store, polygons[p], screen, out, out.side[p], loop))
                draw_polygon(polygons[p], screen, out, loop);
        }
}

} // namespace
} // namespace antumbra
