// What a patch covers, against the polygons themselves.
#include "base/random.hpp"
#include "cull/patch_layout.hpp"
#include "cull/view_planes.hpp"
#include "raster/patch_raster.hpp"

#include <antumbra/cull.hpp>

#include <gtest/gtest.h>

#include <bit>
#include <numeric>

namespace antumbra {
namespace {

void add_polygon(OccluderSet& set, const std::vector<std::uint32_t>& loop) {
    OccluderPolygon polygon;
    polygon.first = static_cast<std::uint32_t>(set.loops.size());
    polygon.count = static_cast<std::uint32_t>(loop.size());
    set.loops.insert(set.loops.end(), loop.begin(), loop.end());
    measure_occluder(set, polygon);
    set.polygons.push_back(polygon);
}

/// All polygons of the set as one patch.
PatchStore one_patch(OccluderSet& set) {
    connect_occluders(set);
    std::vector<std::uint32_t> all(set.polygons.size());
    std::iota(all.begin(), all.end(), 0u);
    PatchStore store;
    PatchLayout(set).add(set, all, store);
    return store;
}

/// From the origin towards -z.
Screen screen_of(int width) {
    View view;
    view.aspect = 1;
    return make_screen(camera_of(view), width, 100);
}

bool hides(const PatchCoverage& coverage, int x, int y) {
    std::uint64_t bits[kTile];
    return coverage.tiles(x / 64, y / kTile, bits) && (bits[x / kTile % kTile] >> (x % kTile + y % kTile * kTile) & 1);
}

/// Corners of a convex polygon, counter-clockwise for the eye at the origin.
std::vector<Vec3f> random_polygon(Random& random) {
    const double distance = random.uniform(2, 20), reach = distance * random.uniform(0.05, 0.8);
    const Vec3d centre{random.uniform(-1, 1) * reach, random.uniform(-1, 1) * reach, -distance};
    const Vec3d along = normalized(Vec3d{random.uniform(-1, 1), random.uniform(-1, 1), random.uniform(-1.5, 1.5)});
    const Vec3d across = normalized(cross(along, normalized(Vec3d{random.uniform(-1, 1), random.uniform(-1, 1), 1})));
    const double flat = random.uniform() < 0.3 ? random.uniform(0.001, 0.05) : random.uniform(0.2, 1);
    std::vector<Vec3f> corners;
    const int count = 3 + static_cast<int>(random.uniform(0, 6));
    for (int i = 0; i < count; ++i) {
        const double angle = 6.283185307179586 * (i + random.uniform(0, 0.8)) / count;
        const Vec3d corner = centre + along * (std::cos(angle) * reach) + across * (std::sin(angle) * reach * flat);
        corners.push_back({float(corner.x), float(corner.y), float(corner.z)});
    }
    const Vec3d normal = cross(to_double(corners[1]) - to_double(corners[0]), to_double(corners[2]) - to_double(corners[0]));
    if (dot(normal, to_double(corners[0])) > 0)
        std::reverse(corners.begin(), corners.end());
    return corners;
}

/// Is the place on the screen within the polygon as the eye at the origin sees it?
bool covers(const std::vector<Vec3f>& corners, const Screen& screen, double x, double y) {
    const Vec3d ray = screen.camera.right * ((x - screen.centre_x) / screen.scale_x) +
                      screen.camera.up * ((y - screen.centre_y) / screen.scale_y) + screen.camera.forward;
    for (std::size_t i = 0; i < corners.size(); ++i)
        if (dot(cross(to_double(corners[i]), to_double(corners[(i + 1) % corners.size()])), ray) > 0)
            return false;
    return true;
}

TEST(PatchRaster, pixels_of_a_single_polygon_lie_within_it_and_leave_out_next_to_none) {
    const Screen screen = screen_of(128);
    std::uint64_t hidden = 0, whole = 0;
    for (std::uint32_t trial = 0; trial < 400; ++trial) {
        Random random(61, trial);
        OccluderSet set;
        set.vertices = random_polygon(random);
        std::vector<std::uint32_t> loop(set.vertices.size());
        std::iota(loop.begin(), loop.end(), 0u);
        add_polygon(set, loop);
        PatchStore store = one_patch(set);
        PatchCoverage coverage;
        coverage.fit(screen, store);
        draw_patch_scalar(store, 0, screen, coverage);
        for (int y = 0; y < screen.height; ++y)
            for (int x = 0; x < screen.width; ++x) {
                bool within = true;
                for (int corner = 0; corner < 4; ++corner)
                    within = within && covers(set.vertices, screen, x + corner % 2, y + corner / 2);
                const bool hid = hides(coverage, x, y);
                const bool alone = coverage.inner[coverage.word_of(x, y)] >> (x % 64) & 1;
                ASSERT_TRUE(within || (!hid && !alone)) << "trial " << trial << " pixel " << x << ", " << y;
                hidden += hid;
                whole += within;
            }
    }
    EXPECT_GT(whole, 100000u);
    EXPECT_GT(double(hidden), 0.97 * double(whole));
}

// A strip that turns away and comes back far behind itself: the silhouettes of what lies behind cross what lies in front.
TEST(PatchRaster, silhouettes_behind_a_member_leave_no_crack_in_it) {
    OccluderSet set;
    set.vertices = {{-3, -3, -6}, {3, -3, -6}, {3, 3, -6}, {-3, 3, -6}, // near wall
                    {3.5f, -3, -20}, {3.5f, 3, -20},                    // to the back, along its right side
                    {0, -2.5f, -21}, {0, 2.5f, -21}};                   // and back behind its middle
    add_polygon(set, {0, 1, 2, 3});
    add_polygon(set, {1, 4, 5, 2});
    add_polygon(set, {6, 4, 5, 7});
    set.polygons[1].double_sided = set.polygons[2].double_sided = true;
    PatchStore store = one_patch(set);
    const Screen screen = screen_of(128);
    PatchCoverage coverage;
    coverage.fit(screen, store);
    draw_patch_scalar(store, 0, screen, coverage);
    ASSERT_GE(coverage.polygons, 2u);
    std::uint64_t crossed = 0;
    const auto pixel = [&](double x) { return screen.centre_x + x / 6 * screen.scale_x; };
    for (int y = int(pixel(-3)) + 2; y < int(pixel(3)) - 2; ++y)
        for (int x = int(pixel(-3)) + 2; x < int(pixel(3)) - 2; ++x) {
            ASSERT_TRUE(hides(coverage, x, y)) << x << ", " << y;
            crossed += coverage.silhouette[coverage.word_of(x, y)] >> (x % 64) & 1;
        }
    EXPECT_GT(crossed, 20u); // else this tests nothing
}

} // namespace
} // namespace antumbra
