#include "rays/arbiter.hpp"

#include "reference.hpp"
#include "soups.hpp"

#include <gtest/gtest.h>

#include <utility>

using namespace antumbra;
using soups::Soup;

namespace {

struct Counts {
    int clear = 0, blocked = 0, degenerate = 0;
    void add(Verdict verdict) {
        ++(verdict == Verdict::clear ? clear : verdict == Verdict::blocked ? blocked : degenerate);
    }
};

/// All kinds of ends: on the grid, on half steps, anywhere.
Vec3d any_point(Random& random, std::uint32_t size) {
    Vec3d p = soups::grid_point(random, size);
    switch (random.below(4)) {
    case 0:
        return p;
    case 1:
        return (p + soups::grid_point(random, size)) * 0.5;
    default:
        return {random.uniform(0, size), random.uniform(0, size), random.uniform(0, size)};
    }
}

void compare_with_reference(std::uint32_t size, std::uint32_t triangles, int scenes, int sights, bool mixed) {
    Counts counts;
    PredicateTally tally;
    for (int s = 0; s < scenes; ++s) {
        Random random(7, std::uint64_t(s), size);
        Scene scene = soups::grid_soup(random, size, triangles, mixed);
        Tracer tracer = Tracer::build(scene, {});
        Arbiter arbiter(tracer);
        reference::Judge judge(scene);
        for (int i = 0; i < sights; ++i) {
            Vec3d p = scene.to_local(any_point(random, size)), q = scene.to_local(any_point(random, size));
            if (p == q)
                continue;
            auto target = random.below(std::uint32_t(scene.triangles().size()));
            if (random.below(2)) // aim at the target, so that misses do not drown everything
                q = (scene.vertex(target, 0) * 0.5 + scene.vertex(target, 1) * 0.25) +
                    scene.vertex(target, 2) * 0.25;
            if (p == q)
                continue;
            Verdict seen = arbiter.sees(p, q, target, &tally);
            ASSERT_EQ(seen, judge.sees(p, q, target)) << "scene " << s << " sight " << i;
            counts.add(seen);
            Verdict open = arbiter.segment(p, q, &tally);
            ASSERT_EQ(open, judge.segment(p, q)) << "scene " << s << " segment " << i;
            counts.add(open);
        }
    }
    // The test is only worth something if all verdicts and both levels occur often.
    EXPECT_GT(counts.clear, scenes * sights / 50);
    EXPECT_GT(counts.blocked, scenes * sights / 50);
    EXPECT_GT(counts.degenerate, scenes * sights / 50);
    EXPECT_GT(tally.exact, std::uint64_t(scenes));
}

TEST(Arbiter, agrees_with_brute_force_on_a_grid_of_4) {
    compare_with_reference(4, 8, 1000, 30, false);
}
TEST(Arbiter, agrees_with_brute_force_on_a_grid_of_8) {
    compare_with_reference(8, 12, 1000, 30, false);
}
TEST(Arbiter, agrees_with_brute_force_on_a_grid_of_16) {
    compare_with_reference(16, 20, 500, 30, true);
}
TEST(Arbiter, agrees_with_brute_force_with_all_flags_on_a_grid_of_4) {
    compare_with_reference(4, 8, 1000, 30, true);
}

// Lattice points far from the origin: local coordinates stay small, but the snapped step grows.
TEST(Arbiter, agrees_with_brute_force_far_from_the_origin) {
    for (double far : {1e6, 1e10, 1e14}) {
        for (int s = 0; s < 30; ++s) {
            Random random(13, std::uint64_t(s));
            Scene scene = soups::small_soup(random, 10, 30, 8, {far, -far, far}, true);
            Tracer tracer = Tracer::build(scene);
            Arbiter arbiter(tracer);
            reference::Judge judge(scene);
            for (int i = 0; i < 50; ++i) {
                auto target = random.below(std::uint32_t(scene.triangles().size()));
                auto other = random.below(std::uint32_t(scene.triangles().size()));
                Vec3d p = i % 2 ? scene.vertex(other, 0) : soups::random_point(random, 12);
                Vec3d q =
                    i % 3
                        ? (scene.vertex(target, 0) + scene.vertex(target, 1) * 2 + scene.vertex(target, 2)) *
                              0.25
                        : scene.vertex(target, 1);
                if (p == q)
                    continue;
                ASSERT_EQ(arbiter.sees(p, q, target), judge.sees(p, q, target))
                    << far << " " << s << " " << i;
                ASSERT_EQ(arbiter.segment(p, q), judge.segment(p, q)) << far << " " << s << " " << i;
            }
        }
    }
}

/// A scene with a target in the plane z = 0, triangle 0, seen from above, and what stands in between.
class Stage {
  public:
    Stage(std::uint32_t target_flags = kOccludes | kDoubleSided) {
        soup_.add({-8, -8, 0}, {8, -8, 0}, {0, 8, 0}, target_flags);
    }
    Stage& with(const Vec3d& a, const Vec3d& b, const Vec3d& c,
                std::uint32_t flags = kOccludes | kDoubleSided) {
        soup_.add(a, b, c, flags);
        return *this;
    }
    Verdict sees(const Vec3d& eye, const Vec3d& toward) const {
        Scene scene = soup_.scene();
        Tracer tracer = Tracer::build(scene);
        Verdict verdict = Arbiter(tracer).sees(scene.to_local(eye), scene.to_local(toward), 0);
        EXPECT_EQ(verdict, reference::Judge(scene).sees(scene.to_local(eye), scene.to_local(toward), 0));
        return verdict;
    }
    Verdict segment(const Vec3d& p, const Vec3d& q) const {
        Scene scene = soup_.scene();
        Tracer tracer = Tracer::build(scene);
        Verdict verdict = Arbiter(tracer).segment(scene.to_local(p), scene.to_local(q));
        EXPECT_EQ(verdict, reference::Judge(scene).segment(scene.to_local(p), scene.to_local(q)));
        return verdict;
    }

  private:
    Soup soup_;
};

constexpr Vec3d kEye{0, 0, 8};

TEST(Arbiter, clear_needs_a_proper_crossing_of_the_target) {
    Stage stage;
    EXPECT_EQ(stage.sees(kEye, {0, 0, 4}), Verdict::clear);
    EXPECT_EQ(stage.sees(kEye, {0, 0, -4}), Verdict::clear);          // `toward` may lie beyond
    EXPECT_EQ(stage.sees(kEye, {0, 0, 9}), Verdict::blocked);         // looks away
    EXPECT_EQ(stage.sees(kEye, {7, 7, 0}), Verdict::blocked);         // misses
    EXPECT_EQ(stage.sees(kEye, {0, 8, 0}), Verdict::degenerate);      // a vertex
    EXPECT_EQ(stage.sees(kEye, {1, -8, 0}), Verdict::degenerate);     // an edge
    EXPECT_EQ(stage.sees({0, 0, 0}, {1, 0, 0}), Verdict::degenerate); // in its plane
    EXPECT_EQ(stage.sees({0, 0, 0}, {0, 0, 1}), Verdict::degenerate); // from a point on it
}

TEST(Arbiter, targets_are_seen_from_drawn_sides_only) {
    EXPECT_EQ(Stage(kOccludes).sees(kEye, {0, 0, 0}), Verdict::clear);
    EXPECT_EQ(Stage(kOccludes).sees({0, 0, -8}, {0, 0, 0}), Verdict::blocked);
    EXPECT_EQ(Stage(0).sees(kEye, {0, 0, 0}), Verdict::clear);
    EXPECT_EQ(Stage(kDoubleSided).sees({0, 0, -8}, {0, 0, 0}), Verdict::clear);
}

TEST(Arbiter, blockers_block_from_drawn_sides_only) {
    Vec3d a{-2, -2, 4}, b{2, -2, 4}, c{0, 2, 4};
    EXPECT_EQ(Stage().with(a, b, c).sees(kEye, {0, 0, 0}), Verdict::blocked);
    EXPECT_EQ(Stage().with(a, b, c, kOccludes).sees(kEye, {0, 0, 0}), Verdict::blocked);
    EXPECT_EQ(Stage().with(a, c, b, kOccludes).sees(kEye, {0, 0, 0}), Verdict::clear);
    EXPECT_EQ(Stage().with(a, b, c, kDoubleSided).sees(kEye, {0, 0, 0}), Verdict::clear);
    // An edge of a back that is not drawn touches nothing.
    EXPECT_EQ(Stage().with(a, c, b, kOccludes).sees({0, -2, 8}, {0, -2, 0}), Verdict::clear);
    EXPECT_EQ(Stage().with(a, b, c, kOccludes).sees({0, -2, 8}, {0, -2, 0}), Verdict::degenerate);
}

TEST(Arbiter, only_what_lies_between_blocks) {
    Vec3d a{-2, -2, 0}, b{2, -2, 0}, c{0, 2, 0}, up{0, 0, 1};
    for (auto [z, expected] : {std::pair{9.0, Verdict::clear},
                               {8.0, Verdict::degenerate},
                               {4.0, Verdict::blocked},
                               {0x1p-16, Verdict::blocked},
                               {-1.0, Verdict::clear}})
        EXPECT_EQ(Stage().with(a + up * z, b + up * z, c + up * z).sees(kEye, {0, 0, 0}), expected) << z;
}

TEST(Arbiter, coplanar_surfaces_do_not_block_the_target) {
    EXPECT_EQ(Stage().with({-8, -8, 0}, {8, -8, 0}, {0, 8, 0}).sees(kEye, {0, 0, 0}),
              Verdict::clear); // duplicate
    EXPECT_EQ(Stage().with({-8, -8, 0}, {0, 8, 0}, {8, -8, 0}).sees(kEye, {0, 0, 0}),
              Verdict::clear); // turned over
    EXPECT_EQ(Stage().with({-1, -1, 0}, {1, -1, 0}, {0, 1, 0}).sees(kEye, {0, 0, 0}),
              Verdict::clear); // a decal
    EXPECT_EQ(Stage().with({0, 0, 0}, {1, -1, 0}, {0, 1, 0}).sees(kEye, {0, 0, 0}),
              Verdict::clear); // its corner
}

TEST(Arbiter, surfaces_that_meet_the_target_at_the_point_itself_are_degenerate) {
    // A wall through the floor, and one that stands on it.
    EXPECT_EQ(Stage().with({0, -2, -2}, {0, 2, -2}, {0, 0, 4}).sees({4, 0, 4}, {0, 0, 0}),
              Verdict::degenerate);
    EXPECT_EQ(Stage().with({0, -2, 0}, {0, 2, 0}, {0, 0, 4}).sees({4, 0, 4}, {0, 0, 0}), Verdict::degenerate);
    // A step of 2^-40 decides.
    EXPECT_EQ(Stage().with({0, -2, 0}, {0, 2, 0}, {0, 0, 4}).sees({4, 0, 4}, {0x1p-40, 0, 0}),
              Verdict::clear);
    EXPECT_EQ(Stage().with({0, -2, 0}, {0, 2, 0}, {0, 0, 4}).sees({4, 0, 4}, {-0x1p-40, 0, 0}),
              Verdict::blocked);
}

// The target touches the crease of a valley that covers it: hidden but for a line without area.
TEST(Arbiter, a_valley_that_touches_the_target_is_not_seen_through) {
    Stage stage;
    stage.with({0, -4, 0}, {0, 4, 0}, {4, 0, 2}).with({0, -4, 0}, {0, 4, 0}, {-4, 0, 2});
    EXPECT_EQ(stage.sees(kEye, {0, 0, 0}), Verdict::degenerate);
    EXPECT_EQ(stage.sees(kEye, {0x1p-30, 0, 0}), Verdict::blocked);
}

TEST(Arbiter, edges_and_vertices_in_the_way_are_degenerate) {
    Stage fan; // a wall in two halves
    fan.with({-2, -2, 4}, {0, -2, 4}, {0, 2, 4}).with({0, -2, 4}, {2, -2, 4}, {0, 2, 4});
    EXPECT_EQ(fan.sees(kEye, {0, 0, 0}), Verdict::degenerate);
    EXPECT_EQ(fan.sees({0x1p-50, 0, 8}, {0x1p-50, 0, 0}), Verdict::blocked);
    Stage vertex;
    vertex.with({0, 0, 4}, {4, 1, 4}, {4, -1, 5});
    EXPECT_EQ(vertex.sees(kEye, {0, 0, 0}), Verdict::degenerate);
    EXPECT_EQ(vertex.sees({-0x1p-50, 0, 8}, {-0x1p-50, 0, 0}), Verdict::clear);
    Stage junction; // the corner of two small halves on the long edge of a big one
    junction.with({-4, 0, 4}, {4, 0, 4}, {0, -4, 4})
        .with({-4, 0, 4}, {0, 0, 4}, {0, 4, 4})
        .with({0, 0, 4}, {4, 0, 4}, {0, 4, 4});
    EXPECT_EQ(junction.sees(kEye, {0, 0, 0}), Verdict::degenerate);
}

TEST(Arbiter, a_gap_of_one_grid_step_is_seen_through) {
    const double step = 0x1p-19; // of this scene: 16 units in 2^23 steps
    Stage wall;
    wall.with({0, -4, 4}, {0, 4, 4}, {-4, 0, 4}).with({step, -4, 4}, {step, 4, 4}, {4, 0, 4});
    auto through = [&](double x) { return wall.sees({x, 0, 8}, {x, 0, 0}); };
    EXPECT_EQ(through(step / 2), Verdict::clear);
    EXPECT_EQ(through(step * 0x1p-20), Verdict::clear);
    EXPECT_EQ(through(0), Verdict::degenerate);
    EXPECT_EQ(through(step), Verdict::degenerate);
    EXPECT_EQ(through(-step * 0x1p-20), Verdict::blocked);
    EXPECT_EQ(through(step * (1 + 0x1p-20)), Verdict::blocked);
}

TEST(Arbiter, a_line_in_the_plane_of_a_triangle_is_degenerate_where_it_touches) {
    Vec3d eye{5, 0, 8}, at{-3, 0, 0}; // in the plane y = 0, along z = x + 3
    EXPECT_EQ(Stage().with({-1, 0, 1}, {1, 0, 1}, {0, 0, 6}).sees(eye, at),
              Verdict::degenerate);                                                              // through it
    EXPECT_EQ(Stage().with({0, 0, 3}, {3, 0, 3}, {3, 0, 2}).sees(eye, at), Verdict::degenerate); // its corner
    EXPECT_EQ(Stage().with({2, 0, 1}, {4, 0, 1}, {3, 0, 2}).sees(eye, at), Verdict::clear);      // beside it
    EXPECT_EQ(Stage().with({5, 0, 9}, {7, 0, 9}, {7, 0, 12}).sees(eye, at), Verdict::clear); // behind the eye
    EXPECT_EQ(Stage().with({-5, 0, -1}, {-6, 0, -1}, {-7, 0, -4}).sees(eye, at),
              Verdict::clear); // beyond the target
    EXPECT_EQ(Stage().with({-4, 0, -2}, {-1, 0, -2}, {-3, 0, 1}).sees(eye, at),
              Verdict::degenerate); // holds the end
    EXPECT_EQ(Stage().with({-9, 0, -9}, {-9, 0, 30}, {30, 0, 30}).sees(eye, at),
              Verdict::degenerate); // holds it all
}

TEST(Arbiter, blocked_beats_degenerate) {
    Stage stage;
    stage.with({0, 0, 6}, {4, 1, 6}, {4, -1, 6})
        .with({-2, -2, 4}, {2, -2, 4}, {0, 2, 4})
        .with({0, 0, 2}, {4, 1, 2}, {4, -1, 2});
    EXPECT_EQ(stage.sees(kEye, {0, 0, 0}), Verdict::blocked);
}

TEST(Arbiter, open_segments_are_judged_like_sights) {
    Stage stage;
    EXPECT_EQ(stage.segment(kEye, {0, 0, 4}), Verdict::clear);
    EXPECT_EQ(stage.segment(kEye, {0, 0, 0x1p-60}), Verdict::clear);
    EXPECT_EQ(stage.segment(kEye, {0, 0, -0x1p-60}), Verdict::blocked);
    EXPECT_EQ(stage.segment(kEye, {0, 0, 0}), Verdict::degenerate); // ends on the triangle
    EXPECT_EQ(stage.segment({0, 0, 0}, {1, 0, 0}), Verdict::degenerate);
    EXPECT_EQ(stage.segment({9, 0, 0}, {9, 9, 0}), Verdict::clear); // in the plane, but outside
}

TEST(Arbiter, points_that_arithmetic_cannot_hold_prove_nothing) {
    Soup soup;
    soup.add({-8, -8, 0}, {8, -8, 0}, {0, 8, 0});
    Scene scene = soup.scene();
    Tracer tracer = Tracer::build(scene);
    Arbiter arbiter(tracer);
    const double nan = std::numeric_limits<double>::quiet_NaN();
    for (const Vec3d& eye : {Vec3d{nan, 0, 8}, Vec3d{1e-300, 0, 8}, Vec3d{0, 0, 1e300}}) {
        EXPECT_EQ(arbiter.sees(eye, {0, 0, 0}, 0), Verdict::degenerate);
        EXPECT_EQ(arbiter.segment(eye, {0, 0, 4}), Verdict::degenerate);
    }
    EXPECT_EQ(arbiter.sees(kEye, kEye, 0), Verdict::degenerate); // no direction
    EXPECT_EQ(arbiter.segment(kEye, kEye), Verdict::degenerate);
}

// The law that ties the two together. Disagreement is possible only where rounding moves the ray across an
// edge.
TEST(Arbiter, confirms_what_the_tracer_sees) {
    Counts counts;
    PredicateTally tally;
    for (int s = 0; s < 20; ++s) {
        Random random(41, std::uint64_t(s));
        Scene scene = soups::small_soup(random, 10, 500, 2, {}, true);
        Tracer tracer = Tracer::build(scene);
        Arbiter arbiter(tracer);
        for (int i = 0; i < 2000; ++i) {
            Vec3d p = soups::random_point(random, 10), q = soups::random_point(random, 10);
            std::vector<std::uint32_t> seen;
            tracer.seen({p, q - p}, seen);
            for (std::uint32_t triangle : seen)
                counts.add(arbiter.sees(p, q, triangle, &tally));
        }
    }
    EXPECT_GT(counts.clear, 20000);
    EXPECT_EQ(counts.degenerate, 0);
    EXPECT_LE(counts.blocked, 1);
    EXPECT_LT(tally.exact, tally.filtered / 10000); // the filter nearly always suffices
}

// The same where edges, vertices and planes are hit all the time: what is clear for one must be seen by the
// other.
TEST(Arbiter, clear_means_that_the_tracer_meets_nothing_before) {
    int clear = 0;
    for (int s = 0; s < 200; ++s) {
        Random random(43, std::uint64_t(s));
        Scene scene = soups::grid_soup(random, 16, 30, true);
        Tracer tracer = Tracer::build(scene);
        Arbiter arbiter(tracer);
        for (int i = 0; i < 100; ++i) {
            Vec3d p = scene.to_local(soups::grid_point(random, 16));
            auto target = random.below(std::uint32_t(scene.triangles().size()));
            Vec3d q =
                (scene.vertex(target, 0) * 2 + scene.vertex(target, 1) + scene.vertex(target, 2)) * 0.25;
            if (p == q || arbiter.sees(p, q, target) != Verdict::clear)
                continue;
            ++clear;
            Hit hit = tracer.first_hit({p, q - p});
            ASSERT_GE(hit.t, 1 - 1e-12) << "scene " << s << " sight " << i;
        }
    }
    EXPECT_GT(clear, 1000);
}

} // namespace
