#include "rays/arbiter.hpp"

#include "reference.hpp"
#include "soups.hpp"

#include <gtest/gtest.h>

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
    case 0: return p;
    case 1: return (p + soups::grid_point(random, size)) * 0.5;
    default: return {random.uniform(0, size), random.uniform(0, size), random.uniform(0, size)};
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
        for (int i = 0; i < sights; ++i) {
            Vec3d p = scene.to_local(any_point(random, size)), q = scene.to_local(any_point(random, size));
            if (p == q)
                continue;
            auto target = random.below(std::uint32_t(scene.triangles().size()));
            if (random.below(2)) // aim at the target, so that misses do not drown everything
                q = (scene.vertex(target, 0) * 0.5 + scene.vertex(target, 1) * 0.25) + scene.vertex(target, 2) * 0.25;
            if (p == q)
                continue;
            Verdict seen = arbiter.sees(p, q, target, &tally);
            ASSERT_EQ(seen, reference::sees(scene, p, q, target)) << "scene " << s << " sight " << i;
            counts.add(seen);
            Verdict open = arbiter.segment(p, q, &tally);
            ASSERT_EQ(open, reference::segment(scene, p, q)) << "scene " << s << " segment " << i;
            counts.add(open);
        }
    }
    // The test is only worth something if all verdicts and both levels occur often.
    EXPECT_GT(counts.clear, scenes * sights / 50);
    EXPECT_GT(counts.blocked, scenes * sights / 50);
    EXPECT_GT(counts.degenerate, scenes * sights / 50);
    EXPECT_GT(tally.exact, std::uint64_t(scenes));
}

TEST(Arbiter, agrees_with_brute_force_on_a_grid_of_4) { compare_with_reference(4, 8, 400, 20, false); }
TEST(Arbiter, agrees_with_brute_force_on_a_grid_of_8) { compare_with_reference(8, 12, 300, 20, false); }
TEST(Arbiter, agrees_with_brute_force_on_a_grid_of_16) { compare_with_reference(16, 20, 200, 20, true); }
TEST(Arbiter, agrees_with_brute_force_with_all_flags_on_a_grid_of_4) { compare_with_reference(4, 8, 400, 20, true); }

} // namespace
