// From the polygons of a patch to loops of edges on the screen: projection, which side they show, clipping, which edges
// are silhouettes. Compiled once per instruction set, as patch_raster.inl.
#include "raster/lanes.inl"

namespace antumbra {
namespace {

constexpr float kGuard = 8192;         ///< pixels from the centre: farther corners are clipped first
constexpr float kLevel = 1e-4f;        ///< pixels: edges that rise less count as level; far below kEdgeSlack
constexpr int kMostCorners = 64;       ///< of a polygon, clipping included; larger ones are not drawn

struct ClipCorner {
    double x, y, z;
    bool silhouette; ///< the edge that starts here
};

struct EdgeLoop {
    static constexpr int kRoom = kMostCorners + kLanes; ///< whole lanes, and the first corner behind the last
    float x[kRoom], y[kRoom];
    bool silhouette[kMostCorners];
    int count = 0;
    double least_nearness = 0; ///< of its corners, rounded farther
    // Made by find_edges(): edge i from its lower to its upper end.
    float low_x[kRoom], low_y[kRoom], high_x[kRoom], high_y[kRoom];
    float slope[kRoom]; ///< columns per row; 0 for level edges
    int up[kRoom];      ///< not 0: it goes up in the order of the loop
    float min_x, max_x, min_y, max_y;
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

/// Corners to camera space and to the screen. True if some must be clipped: they are nearer than the clip depth or far
/// off the screen.
ANTUMBRA_INLINE bool transform(const PatchStore& store, const PatchRange& patch, const Screen& screen,
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
    const double guard = kGuard;
    int inside = 1;
    for (std::uint32_t v = 0; v < patch.vertex_count; ++v) {
        double depth = cz[v] > least ? cz[v] : least;
        depth = depth < most ? depth : most;
        double x = cx[v] / depth * scale_x, y = cy[v] / depth * scale_y;
        sx[v] = static_cast<float>(centre_x + x);
        sy[v] = static_cast<float>(centre_y + y);
        inside &= int(cz[v] >= clip) & int(x < guard) & int(x > -guard) & int(y < guard) & int(y > -guard);
    }
    return inside == 0;
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

/// What is kept of a loop: where x, y and z, so weighted, and `one` sum to 0 or more.
struct ClipPlane {
    double x, y, z, one;
    double at(const ClipCorner& p) const { return (z * p.z + one) + (x * p.x + y * p.y); }
};

/// The cut is a silhouette.
inline int clip_by(const ClipPlane& plane, const ClipCorner* in, int count, ClipCorner* out) {
    int kept = 0;
    for (int i = 0; i < count; ++i) {
        const ClipCorner &a = in[i], &b = in[i + 1 == count ? 0 : i + 1];
        const double va = plane.at(a), vb = plane.at(b);
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

/// Is the edge from corner to corner of a member that shows the eye `side` a silhouette of the patch?
ANTUMBRA_INLINE bool is_silhouette(std::uint16_t neighbour, signed char side, double z, double z_next,
                                   const Screen& screen, const PatchCoverage& work) {
    // An edge on the clip plane: whatever is on its other side is clipped away.
    if (neighbour == kNoLocal || (z > z_next ? z : z_next) <= screen.clip_depth + screen.depth_slack)
        return true;
    signed char other = work.side[neighbour & ~kLocalSameDirection];
    return other == 0 || (other == side) == ((neighbour & kLocalSameDirection) != 0);
}

/// The part of the polygon that can be drawn; false if none is left. Rare, so not inlined.
inline bool clip_loop(const Screen& screen, ClipCorner* corners, EdgeLoop& loop) {
    ClipCorner clipped[kMostCorners];
    const bool flat = screen.camera.orthographic;
    const double guard_x = kGuard / screen.scale_x, guard_y = kGuard / screen.scale_y;
    const ClipPlane planes[6] = {{0, 0, 1, -screen.clip_depth},
                                 {-1, 0, flat ? 0 : guard_x, flat ? guard_x : 0},
                                 {1, 0, flat ? 0 : guard_x, flat ? guard_x : 0},
                                 {0, -1, flat ? 0 : guard_y, flat ? guard_y : 0},
                                 {0, 1, flat ? 0 : guard_y, flat ? guard_y : 0},
                                 {0, 0, 0, 0}}; // keeps all
    int count = loop.count;
    for (int k = 0; k < 6; k += 2) {
        count = clip_by(planes[k], corners, count, clipped);
        count = clip_by(planes[k + 1], clipped, count, corners);
    }
    double farthest = -1e300;
    for (int i = 0; i < count; ++i) {
        double depth = flat ? 1.0 : corners[i].z;
        loop.x[i] = static_cast<float>(screen.centre_x + corners[i].x / depth * screen.scale_x);
        loop.y[i] = static_cast<float>(screen.centre_y + corners[i].y / depth * screen.scale_y);
        loop.silhouette[i] = corners[i].silhouette;
        farthest = corners[i].z > farthest ? corners[i].z : farthest;
    }
    loop.count = count;
    if (count < 3)
        return false;
    loop.least_nearness = screen.nearness(farthest);
    return true;
}

/// The polygon on the screen, clipped only if the patch may need it.
ANTUMBRA_INLINE bool make_loop(const PatchStore& store, const PatchPolygon& polygon, const Screen& screen,
                               const PatchCoverage& work, signed char side, bool may_clip, EdgeLoop& loop) {
    const int count = polygon.count;
    const std::uint16_t* corners = store.corners.data() + polygon.first;
    const std::uint16_t* neighbours = store.neighbours.data() + polygon.first;
    double farthest = -1e300;
    // Seen from the back the corners run clockwise: take them in reverse.
    const int step = side > 0 ? 1 : -1;
    int from = side > 0 ? 0 : count - 1;
    for (int i = 0; i < count; ++i) {
        int to = from + step;
        to = to == count ? 0 : to < 0 ? count - 1 : to;
        const std::uint16_t corner = corners[from];
        const double z = work.camera_z[corner];
        loop.x[i] = work.vertex_x[corner];
        loop.y[i] = work.vertex_y[corner];
        loop.silhouette[i] =
            is_silhouette(neighbours[side > 0 ? from : to], side, z, work.camera_z[corners[to]], screen, work);
        farthest = z > farthest ? z : farthest;
        from = to;
    }
    loop.count = count;
    if (!may_clip) {
        loop.least_nearness = screen.nearness(farthest);
        return true;
    }
    ClipCorner unclipped[kMostCorners];
    from = side > 0 ? 0 : count - 1;
    for (int i = 0; i < count; ++i, from += step) {
        const std::uint16_t corner = corners[from];
        unclipped[i] = {work.camera_x[corner], work.camera_y[corner], work.camera_z[corner], loop.silhouette[i]};
    }
    return clip_loop(screen, unclipped, loop);
}

} // namespace
} // namespace antumbra
