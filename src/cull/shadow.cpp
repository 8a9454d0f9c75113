#include "cull/shadow.hpp"

#include "base/cpu.hpp"

#if ANTUMBRA_X86_KERNELS
#include <immintrin.h>
#endif

#include <algorithm>

namespace antumbra {
namespace {

constexpr int kMostClipped = 40;

struct Corner {
    Vec3d p;
    bool silhouette; ///< the edge that starts here
};

/// Adds one half-space, inward normal of length `size`, through `point`; padded for every box with |p| <= reach.
bool add_plane(Shadow& shadow, const Vec3d& normal, double size, const Vec3d& point, const Vec3d& reach, double slack) {
    if (!(size > 0) || shadow.count == kMostShadowPlanes)
        return false;
    Vec3d unit = normal * (1 / size);
    double offset = -dot(unit, point);
    double magnitude = std::abs(offset) + std::abs(unit.x) * reach.x + std::abs(unit.y) * reach.y + std::abs(unit.z) * reach.z;
    for (int axis = 0; axis < 3; ++axis)
        shadow.normal[shadow.count][axis] = static_cast<float>(unit[axis]);
    // As in frustum_planes(): seven roundings, eight for good measure; and one more for rounding the sum below.
    double pad = 9 * 0x1p-24 * magnitude + slack + 0x1p-120;
    shadow.certainly[shadow.count] = static_cast<float>(offset - pad);
    shadow.possibly[shadow.count] = static_cast<float>(offset + pad);
    ++shadow.count;
    return true;
}

bool reaches_beyond(const OccluderSet& set, const OccluderPolygon& polygon, const Camera& camera, double depth) {
    for (std::uint32_t v : set.loop(polygon))
        if (dot(to_double(set.vertices[v]) - camera.eye, camera.forward) > depth)
            return true;
    return false;
}

/// The part beyond the near depth; nothing nearer is drawn, so nothing nearer hides. Returns the number of corners.
int clip_near(Corner* corners, int count, const Camera& camera, double near_depth, double tolerance, Corner* out) {
    int kept = 0;
    for (int i = 0; i < count; ++i) {
        const Corner &a = corners[i], &b = corners[i + 1 == count ? 0 : i + 1];
        double va = dot(a.p - camera.eye, camera.forward) - near_depth;
        double vb = dot(b.p - camera.eye, camera.forward) - near_depth;
        // An edge in the clip plane has its other side clipped away.
        bool lies_in = va <= tolerance && vb <= tolerance;
        if (va >= 0)
            out[kept++] = {a.p, a.silhouette || lies_in};
        if ((va >= 0) != (vb >= 0))
            out[kept++] = {a.p + (b.p - a.p) * (va / (va - vb)), va >= 0 ? true : a.silhouette};
    }
    return kept;
}

/// How large the polygon looks, roughly.
double apparent_area(const OccluderPolygon& polygon, const Camera& camera) {
    if (camera.orthographic)
        return polygon.area * std::abs(dot(polygon.normal, camera.forward));
    Vec3d sight = polygon.centre - camera.eye;
    double squared = dot(sight, sight) + 0.05 * polygon.area;
    return polygon.area * std::abs(dot(polygon.normal, sight)) / (squared * std::sqrt(squared));
}

/// Of a closed double-sided group the near half shows its fronts and the far half its backs: both have the same outline,
/// and a box would have to be inside of it twice, behind both. The half that looks larger is enough.
void keep_one_side(const OccluderSet& set, std::span<const std::uint32_t> members, const Camera& camera, int* sides) {
    double area[2] = {0, 0};
    for (std::size_t m = 0; m < members.size(); ++m)
        if (sides[m] != 0)
            area[sides[m] > 0] += apparent_area(set.polygons[members[m]], camera);
    int kept = area[1] >= area[0] ? 1 : -1;
    for (std::size_t m = 0; m < members.size(); ++m)
        if (sides[m] == -kept)
            sides[m] = 0;
}

} // namespace

int facing(const OccluderPolygon& polygon, const Camera& camera) {
    double towards, scale = 1;
    if (camera.orthographic) {
        towards = -dot(polygon.normal, camera.forward);
    } else {
        towards = dot(polygon.normal, camera.eye) + polygon.offset;
        scale = std::abs(camera.eye.x) + std::abs(camera.eye.y) + std::abs(camera.eye.z) + std::abs(polygon.offset);
    }
    if (towards > 1e-9 * scale)
        return 1;
    return polygon.double_sided && towards < -1e-9 * scale ? -1 : 0;
}

SightStart sight_start(const Camera& camera, const Box3f& domain) {
    SightStart start;
    start.camera = camera;
    start.domain = domain;
    double size = domain.empty() ? 1 : length(to_double(domain.max) - to_double(domain.min));
    double smallest = 1e-7 * (size + length(camera.eye));
    start.near_depth = camera.orthographic ? camera.near_plane : std::max(camera.near_plane, smallest);
    double reach = camera.orthographic ? 1 : start.near_depth;
    Vec3d middle = camera.eye + camera.forward * start.near_depth;
    for (int i = 0; i < 4; ++i)
        start.corners[i] = middle + camera.right * ((i & 1 ? reach : -reach) * camera.half_width) +
                           camera.up * ((i & 2 ? reach : -reach) * camera.half_height);
    start.corners[4] = camera.orthographic ? start.corners[0] : camera.eye;
    return start;
}

bool is_beyond_near(const OccluderPolygon& polygon, int side, const SightStart& start) {
    for (const Vec3d& corner : start.corners) {
        double scale = std::abs(corner.x) + std::abs(corner.y) + std::abs(corner.z) + std::abs(polygon.offset);
        if (!((dot(polygon.normal, corner) + polygon.offset) * side > 1e-9 * scale))
            return false;
    }
    return true;
}

bool cast_shadow(const OccluderSet& set, std::span<const std::uint32_t> members, const SightStart& start,
                 Shadow& shadow) {
    const Camera& camera = start.camera;
    const Box3f& domain = start.domain;
    const double near_depth = start.near_depth;
    int sides[16];
    bool whole[16]; // needs no clipping
    auto count = std::min<std::size_t>(members.size(), std::size(sides));
    Vec3d farthest;
    for (int axis = 0; axis < 3; ++axis)
        farthest[axis] = std::max(std::abs(double(domain.min[axis])), std::abs(double(domain.max[axis])));
    double domain_reach = farthest.x + farthest.y + farthest.z;
    double reach = std::abs(camera.eye.x) + std::abs(camera.eye.y) + std::abs(camera.eye.z);
    double tolerance = 1e-9 * (reach + domain_reach + std::abs(near_depth));
    for (std::size_t m = 0; m < count; ++m) {
        sides[m] = facing(set.polygons[members[m]], camera);
        whole[m] = sides[m] != 0 && is_beyond_near(set.polygons[members[m]], sides[m], start);
        if (sides[m] != 0 && !whole[m] && !reaches_beyond(set, set.polygons[members[m]], camera, near_depth + tolerance))
            sides[m] = 0; // not drawn at all
    }
    keep_one_side(set, members.first(count), camera, sides);
    auto side_of = [&](std::uint32_t polygon) {
        for (std::size_t m = 0; m < count; ++m)
            if (members[m] == polygon)
                return sides[m];
        return 0;
    };
    shadow.count = 0;
    for (std::size_t m = 0; m < count; ++m) {
        if (sides[m] == 0)
            continue;
        const OccluderPolygon& polygon = set.polygons[members[m]];
        int corners = static_cast<int>(polygon.count);
        if (corners + 2 > kMostClipped)
            return false;
        Corner loop[kMostClipped], clipped[kMostClipped];
        for (int i = 0; i < corners; ++i) {
            int from = sides[m] > 0 ? i : corners - 1 - i; // seen from the back the loop runs the other way
            int edge = sides[m] > 0 ? i : (from + corners - 1) % corners;
            std::uint32_t neighbour = set.neighbours[polygon.first + static_cast<std::uint32_t>(edge)];
            int other = side_of(neighbour & ~kSameDirection);
            bool silhouette = other == 0 || (other == sides[m]) == ((neighbour & kSameDirection) != 0);
            loop[i] = {to_double(set.vertices[set.loops[polygon.first + static_cast<std::uint32_t>(from)]]), silhouette};
        }
        int kept = whole[m] ? corners : clip_near(loop, corners, camera, near_depth, tolerance, clipped);
        if (kept < 3)
            return false;
        const Corner* drawn = whole[m] ? loop : clipped;
        for (int i = 0; i < kept; ++i) {
            if (!drawn[i].silhouette)
                continue;
            Vec3d a = drawn[i].p, b = drawn[i + 1 == kept ? 0 : i + 1].p;
            Vec3d sight = camera.orthographic ? camera.forward : a - camera.eye;
            Vec3d inward = cross(b - a, sight);
            // The line of sight is known to about 1e-15 of the coordinates; seen from `distance` away that turns
            // the plane, and at the far end of the domain moves it. Planes that are quite uncertain hide nothing.
            double size = length(inward), size_a = std::abs(a.x) + std::abs(a.y) + std::abs(a.z);
            double unsure = camera.orthographic ? camera.turn : 1e-14 * (reach + size_a) * length(b - a) / size;
            if (!(unsure < 1e-5))
                return false;
            if (!add_plane(shadow, inward, size, a, farthest, unsure * (domain_reach + size_a)))
                return false;
        }
        if (!add_plane(shadow, polygon.normal * -double(sides[m]), 1, polygon.centre, farthest, 0))
            return false;
    }
    return shadow.count >= 4;
}

ShadowVerdicts test_shadow_scalar(const EightBoxes& boxes, const Shadow& shadow, std::uint32_t alive) {
    ShadowVerdicts verdicts;
    verdicts.hidden = alive;
    for (int i = 0; i < shadow.count; ++i)
        for (int lane = 0; lane < kWidth; ++lane) {
            if (!(alive >> lane & 1))
                continue;
            float far_sum = 0, near_sum = 0;
            for (int axis = 0; axis < 3; ++axis) {
                float normal = shadow.normal[i][axis];
                float far_corner = normal >= 0 ? boxes.max[axis][lane] : boxes.min[axis][lane];
                float near_corner = normal >= 0 ? boxes.min[axis][lane] : boxes.max[axis][lane];
                far_sum = axis == 0 ? normal * far_corner : far_sum + normal * far_corner;
                near_sum = axis == 0 ? normal * near_corner : near_sum + normal * near_corner;
            }
            if (!(near_sum + shadow.certainly[i] > 0))
                verdicts.hidden &= ~(1u << lane);
            if (far_sum + shadow.possibly[i] < 0)
                verdicts.outside |= 1u << lane;
        }
    return verdicts;
}

#if ANTUMBRA_X86_KERNELS
namespace {

ANTUMBRA_TARGET_AVX2 ShadowVerdicts test_shadow_avx2(const EightBoxes& boxes, const Shadow& shadow,
                                                     std::uint32_t alive) {
    ShadowVerdicts verdicts;
    std::uint32_t hidden = alive, outside = 0;
    const __m256 zero = _mm256_setzero_ps();
    for (int i = 0; i < shadow.count; ++i) {
        __m256 nx = _mm256_set1_ps(shadow.normal[i][0]);
        __m256 ny = _mm256_set1_ps(shadow.normal[i][1]);
        __m256 nz = _mm256_set1_ps(shadow.normal[i][2]);
        bool x = shadow.normal[i][0] >= 0, y = shadow.normal[i][1] >= 0, z = shadow.normal[i][2] >= 0;
        auto sum = [&](const float* px, const float* py, const float* pz) ANTUMBRA_TARGET_AVX2 {
            return _mm256_add_ps(_mm256_add_ps(_mm256_mul_ps(nx, _mm256_loadu_ps(px)),
                                               _mm256_mul_ps(ny, _mm256_loadu_ps(py))),
                                 _mm256_mul_ps(nz, _mm256_loadu_ps(pz)));
        };
        __m256 far_sum = sum(x ? boxes.max[0] : boxes.min[0], y ? boxes.max[1] : boxes.min[1],
                             z ? boxes.max[2] : boxes.min[2]);
        __m256 beyond = _mm256_cmp_ps(_mm256_add_ps(far_sum, _mm256_set1_ps(shadow.possibly[i])), zero, _CMP_LT_OQ);
        outside |= static_cast<std::uint32_t>(_mm256_movemask_ps(beyond));
        // All lanes outside: no plane can change anything that is asked for.
        if (!(alive & ~outside)) {
            hidden = 0;
            break;
        }
        if (!hidden)
            continue;
        __m256 near_sum = sum(x ? boxes.min[0] : boxes.max[0], y ? boxes.min[1] : boxes.max[1],
                              z ? boxes.min[2] : boxes.max[2]);
        __m256 inside = _mm256_cmp_ps(_mm256_add_ps(near_sum, _mm256_set1_ps(shadow.certainly[i])), zero, _CMP_GT_OQ);
        hidden &= static_cast<std::uint32_t>(_mm256_movemask_ps(inside));
    }
    verdicts.hidden = hidden;
    verdicts.outside = outside & alive;
    return verdicts;
}

} // namespace
#endif

ShadowKernel shadow_kernel(InstructionSet instruction_set) {
    switch (instruction_set) {
    case InstructionSet::scalar: return test_shadow_scalar;
#if ANTUMBRA_X86_KERNELS
    case InstructionSet::automatic: return cpu_has_avx2() ? test_shadow_avx2 : test_shadow_scalar;
    case InstructionSet::avx2: return cpu_has_avx2() ? test_shadow_avx2 : nullptr;
    case InstructionSet::avx512: return cpu_has_avx512() ? test_shadow_avx2 : nullptr;
#else
    case InstructionSet::automatic: return test_shadow_scalar;
    case InstructionSet::avx2:
    case InstructionSet::avx512: return nullptr;
#endif
    }
    return nullptr;
}

} // namespace antumbra
