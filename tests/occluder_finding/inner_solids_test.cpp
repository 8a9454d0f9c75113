// Oriented boxes, convex solids, groups of objects, shells with an opening: what is found, and that it hides nothing that a
// line of sight sees.
#include "cull/proof.hpp"
#include "occluder_finding/inner_solids.hpp"
#include "support/make_scene.hpp"

#include <numbers>

namespace antumbra {
namespace {

using test::SceneMaker;
using test::Stage;

/// Turns about the vertical, and moves.
struct Placed {
    double angle = 0;
    Vec3d at;
    Vec3d operator()(double x, double y, double z) const {
        double c = std::cos(angle), s = std::sin(angle);
        return at + Vec3d{c * x + s * z, y, c * z - s * x};
    }
};

/// A wall from a to b (seen from its front: a left) in n x m quads.
void wall(SceneMaker& maker, const Vec3d& a, const Vec3d& b, const Vec3d& up, int n, int m) {
    for (int i = 0; i < n; ++i)
        for (int j = 0; j < m; ++j) {
            Vec3d from = a + (b - a) * (double(i) / n), to = a + (b - a) * (double(i + 1) / n);
            Vec3d low = up * (double(j) / m), high = up * (double(j + 1) / m);
            maker.quad(from + low, to + low, to + high, from + high);
        }
}

struct House {
    double width = 12, depth = 8, height = 6;
    double ridge = 0; ///< a gable so much higher
    bool floor = true;
    int quads = 6;
    bool in_parts = false; ///< walls, roof and floor are objects of their own
};

void house(SceneMaker& maker, const Placed& place, const House& h) {
    double x = h.width / 2, z = h.depth / 2;
    Vec3d a = place(-x, 0, z), b = place(x, 0, z), c = place(x, 0, -z), d = place(-x, 0, -z), up{0, h.height, 0};
    maker.object("walls");
    wall(maker, a, b, up, h.quads, h.quads);
    wall(maker, b, c, up, h.quads, h.quads);
    wall(maker, c, d, up, h.quads, h.quads);
    wall(maker, d, a, up, h.quads, h.quads);
    if (h.in_parts)
        maker.object("roof");
    auto n = h.quads;
    auto fan = [&](const Vec3d& from, const Vec3d& to, const Vec3d& tip) { // along an eave that has n pieces
        for (int i = 0; i < n; ++i)
            maker.triangle(from + (to - from) * (double(i) / n), from + (to - from) * (double(i + 1) / n), tip);
    };
    Vec3d top = place(0, h.height + h.ridge, 0);
    fan(a + up, b + up, top);
    fan(b + up, c + up, top);
    fan(c + up, d + up, top);
    fan(d + up, a + up, top);
    if (!h.floor)
        return;
    if (h.in_parts)
        maker.object("floor");
    Vec3d middle = place(0, 0, 0);
    fan(b, a, middle);
    fan(c, b, middle);
    fan(d, c, middle);
    fan(a, d, middle);
}

double worth_of_largest(const OccluderSet& set) {
    std::vector<double> area(set.solids.size(), 0);
    for (const OccluderPolygon& polygon : set.polygons)
        if (polygon.synthetic)
            area[polygon.solid] += polygon.area / 2;
    return area.empty() ? 0 : *std::max_element(area.begin(), area.end());
}

TEST(InnerSolids, a_turned_house_gets_a_box_of_its_own_frame) {
    SceneMaker maker;
    house(maker, {0.5, {3, 0, 2}}, {});
    Scene scene = maker.scene();
    OccluderStatistics statistics;
    OccluderSet set = find_occluders(scene, {}, &statistics);
    EXPECT_EQ(statistics.closed_objects, 1u);
    ASSERT_GE(statistics.inner_solids, 1u);
    double whole = 12 * 8 + 8 * 6 + 12 * 6;
    EXPECT_GT(worth_of_largest(set), 0.99 * whole);
    EXPECT_LT(worth_of_largest(set), whole);
    OccluderOptions options;
    options.inner_solids = false;
    EXPECT_LT(worth_of_largest(find_occluders(scene, options)), 0.8 * whole) << "along the axes";
    for (const OccluderPolygon& polygon : set.polygons) {
        if (polygon.synthetic && polygon.solid >= statistics.inner_boxes) {
            EXPECT_EQ(polygon.count, 4u) << "upright faces stay rectangles";
        }
    }
}

TEST(InnerSolids, a_house_along_the_axes_needs_none) {
    SceneMaker maker;
    house(maker, {}, {});
    OccluderStatistics statistics;
    find_occluders(maker.scene(), {}, &statistics);
    EXPECT_EQ(statistics.inner_solids, 0u);
    EXPECT_EQ(statistics.inner_boxes, 1u);
}

TEST(InnerSolids, a_tent_roof_is_filled_up_to_its_tip) {
    SceneMaker maker;
    house(maker, {}, {.ridge = 9});
    OccluderSet set = find_occluders(maker.scene());
    double walls = 6 * (12 + 8), roof = 6 * std::hypot(9, 4) + 4 * std::hypot(9, 6);
    EXPECT_GT(worth_of_largest(set), 0.98 * (walls + roof + 48));
}

TEST(InnerSolids, objects_that_are_closed_together_are_one) {
    SceneMaker maker;
    house(maker, {0.3, {}}, {.in_parts = true});
    OccluderStatistics statistics;
    OccluderSet set = find_occluders(maker.scene(), {}, &statistics);
    EXPECT_EQ(statistics.closed_objects, 0u);
    EXPECT_EQ(statistics.enclosures, 1u);
    EXPECT_EQ(statistics.inner_solids, 1u);
    EXPECT_EQ(statistics.restricted_solids, 0u);
}

TEST(InnerSolids, a_house_without_a_floor_hides_for_who_is_above_its_opening) {
    SceneMaker maker;
    house(maker, {0.3, {0, 1, 0}}, {.floor = false});
    maker.object("terrain").quad({-60, 1.5, 60}, {60, 1.5, 60}, {60, 1.5, -60}, {-60, 1.5, -60});
    Scene scene = maker.scene();
    OccluderStatistics statistics;
    OccluderSet set = find_occluders(scene, {}, &statistics);
    ASSERT_EQ(statistics.inner_solids, 1u);
    EXPECT_EQ(statistics.restricted_solids, set.solids.size());
    for (const OccluderSolid& solid : set.solids) {
        EXPECT_NEAR(scene.to_world(to_double(solid.viewers.min)).y, 1, 1e-6);
        Vec3d above = scene.to_local({50, 1.2, 0}), below = scene.to_local({50, 0.9, 0});
        EXPECT_TRUE(solid.serves({above, above}));
        EXPECT_FALSE(solid.serves({below, below}));
    }
}

// The terrain shares the edges at the feet of the houses: one group of all, of which nothing is closed before it is out.
TEST(InnerSolids, terrain_that_houses_are_cut_out_of_is_taken_out) {
    SceneMaker maker;
    house(maker, {}, {.floor = false, .quads = 5});
    maker.object("terrain");
    Vec3d corners[4] = {{-6, 0, 4}, {6, 0, 4}, {6, 0, -4}, {-6, 0, -4}};
    for (int side = 0; side < 4; ++side)
        for (int i = 0; i < 5; ++i) {
            Vec3d from = corners[side] + (corners[(side + 1) % 4] - corners[side]) * (i / 5.0);
            Vec3d to = corners[side] + (corners[(side + 1) % 4] - corners[side]) * ((i + 1) / 5.0);
            maker.quad(from * 5.0, to * 5.0, to, from);
        }
    OccluderStatistics statistics;
    OccluderSet set = find_occluders(maker.scene(), {}, &statistics);
    EXPECT_EQ(statistics.enclosures, 1u);
    EXPECT_EQ(statistics.inner_boxes, 1u);
    EXPECT_EQ(statistics.restricted_solids, 1u);
}

TEST(InnerSolids, a_prepared_file_keeps_where_viewers_must_be) {
    SceneMaker maker;
    house(maker, {0.3, {}}, {.floor = false});
    house(maker, {0.7, {40, 0, 0}}, {});
    OccluderSet set = find_occluders(maker.scene());
    Result<OccluderSet> again = decode_occluders(*encode_occluders(set));
    ASSERT_TRUE(again) << again.status().message();
    ASSERT_EQ(again->solids.size(), set.solids.size());
    std::size_t restricted = 0;
    for (std::size_t s = 0; s < set.solids.size(); ++s) {
        EXPECT_EQ(again->solids[s].viewers, set.solids[s].viewers);
        restricted += set.solids[s].is_restricted();
    }
    EXPECT_GT(restricted, 0u);
    EXPECT_LT(restricted, set.solids.size());
}

/// Random houses at random angles, with and without floors and ridges, whole and in parts, things behind them, seen from
/// everywhere, from below the ground too.
TEST(InnerSolids, of_random_houses_lose_no_line_of_sight) {
    test::ProofCounts counts[4];
    const char* const methods[] = {"planes", "masked", "tree", "planes-published"};
    std::uint64_t solids = 0, restricted = 0;
    for (std::uint32_t trial = 0; trial < 24; ++trial) {
        Random random(93, trial);
        SceneMaker maker;
        for (int n = 0; n < 4; ++n) {
            House h{random.uniform(4, 14), random.uniform(4, 14), random.uniform(3, 12)};
            h.ridge = random.below(2) ? random.uniform(0, 6) : 0;
            h.floor = random.below(2);
            h.in_parts = random.below(2);
            h.quads = 5;
            house(maker, {random.uniform(0, 3), {random.uniform(-25, 25), random.uniform(-1, 1), random.uniform(-25, 25)}}, h);
        }
        for (int n = 0; n < 40; ++n) {
            Vec3d low{random.uniform(-40, 40), random.uniform(-4, 12), random.uniform(-40, 40)};
            maker.object("thing").box(low, low + Vec3d{0.5, 0.5, 0.5});
        }
        Scene scene = maker.scene();
        OccluderStatistics statistics;
        find_occluders(scene, {}, &statistics);
        solids += statistics.inner_solids;
        restricted += statistics.restricted_solids;
        Stage stage(std::move(scene));
        for (std::size_t m = 0; m < 4; ++m) {
            auto culler = std::move(make_culler(methods[m], stage.cull_scene)).value();
            ViewState state;
            for (int f = 0; f < 10; ++f) {
                View view;
                view.eye = stage.scene->to_local({random.uniform(-45, 45), random.uniform(-6, 14), random.uniform(-45, 45)});
                view.target = stage.scene->to_local({random.uniform(-20, 20), random.uniform(0, 6), random.uniform(-20, 20)});
                view.near_plane = random.below(2) ? 0.05 : random.uniform(0, 20);
                test::prove(stage, *culler, view, state, 24, 32, random, counts[m]);
                ASSERT_FALSE(HasFailure()) << methods[m] << " trial " << trial << " frame " << f;
            }
        }
    }
    EXPECT_GT(solids, 48u);
    EXPECT_GT(restricted, 24u);
    for (const test::ProofCounts& one : counts)
        EXPECT_GT(one.hidden * 40, one.in_frustum);
}

} // namespace
} // namespace antumbra
