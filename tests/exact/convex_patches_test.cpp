// Neighbouring triangles as one occluder: the partition, and that a disc blocks what passes its rim on one side.
#include "families.hpp"

#include "bake/exact/cell.hpp"

#include <antumbra/generate.hpp>

#include <gtest/gtest.h>

#include <set>

namespace antumbra::exact::testing {
namespace {

Scene generated(const char* kind, std::uint64_t triangles) {
    Result<RawScene> raw = generate(kind, {triangles, 3});
    EXPECT_TRUE(bool(raw)) << raw.status().message();
    return std::move(*Scene::create(std::move(*raw)));
}

TEST(ConvexPatches, AreAPartitionIntoDiscsWithoutInnerCorners) {
    for (const char* kind : {"town", "forest", "office"}) {
        Scene scene = generated(kind, 40000);
        SceneTree tree = SceneTree::build(scene, Units::triangles(scene));
        const ConvexPatches& patches = tree.patches();
        ASSERT_GT(patches.count(), 100u) << kind;
        std::set<std::uint32_t> seen;
        for (std::uint32_t p = 0; p < patches.count(); ++p) {
            std::span<const std::uint32_t> members = patches.members(p);
            ASSERT_GE(members.size(), 2u);
            // A triangulated disc without inner corner has two triangles fewer than corners.
            std::set<std::uint32_t> corners;
            for (std::uint32_t t : members) {
                EXPECT_TRUE(seen.insert(t).second);
                EXPECT_EQ(patches.of(t), p);
                EXPECT_TRUE(tree.occludes(t));
                EXPECT_EQ(tree.both_sides(t), patches.both_sides(p));
                for (std::uint32_t k = 0; k < 3; ++k)
                    corners.insert(tree.edge_start(3 * t + k));
            }
            EXPECT_EQ(corners.size(), members.size() + 2);
            EXPECT_GE(patches.rim(p).size(), 3u);
            EXPECT_LE(patches.rim(p).size(), corners.size());
        }
    }
}

int crossing(const Pluecker<std::int64_t>& line, std::span<const GridPoint> rim) {
    int all = 0;
    for (std::size_t k = 0; k < rim.size(); ++k) {
        std::int64_t at = side(pluecker_through(rim[k], rim[(k + 1) % rim.size()]), line);
        int sign = at > 0 ? 1 : at < 0 ? -1 : 0;
        if (sign == 0 || sign == -all)
            return 0;
        all = sign;
    }
    return all;
}

TEST(ConvexPatches, LinesInsideARimCrossATriangleTheSameWay) {
    Scene scene = generated("forest", 20000); // bent strips round trunks and uneven ground among them
    SceneTree tree = SceneTree::build(scene, Units::triangles(scene));
    const ConvexPatches& patches = tree.patches();
    Random random(4);
    std::uint64_t inside = 0, bent = 0;
    for (std::uint32_t p = 0; p < patches.count(); p += 3) {
        std::span<const GridPoint> rim = patches.rim(p);
        GridPoint middle{0, 0, 0};
        for (const GridPoint& corner : rim)
            middle = middle + corner;
        for (int k = 0; k < 3; ++k)
            middle[k] /= static_cast<std::int64_t>(rim.size());
        for (int k = 0; k < 40; ++k) {
            GridPoint a, b;
            for (int c = 0; c < 3; ++c) {
                a[c] = middle[c] + static_cast<std::int64_t>(random.uniform(-200000, 200000));
                b[c] = 2 * middle[c] - a[c] + static_cast<std::int64_t>(random.uniform(-20000, 20000));
            }
            // Lengths relative to a corner keep the products within 64 bits.
            std::vector<GridPoint> near;
            for (const GridPoint& corner : rim)
                near.push_back(corner - middle);
            auto line = pluecker_through(a - middle, b - middle);
            int way = crossing(line, near);
            if (way == 0)
                continue;
            ++inside;
            bent += !patches.is_flat(p);
            bool found = false;
            for (std::uint32_t t : patches.members(p)) {
                std::array<GridPoint, 3> triangle = tree.corners(t);
                int at[3] = {0, 0, 0};
                for (std::size_t e = 0; e < 3; ++e) {
                    std::int64_t value = side(pluecker_through(triangle[e] - middle, triangle[(e + 1) % 3] - middle), line);
                    at[e] = value > 0 ? 1 : value < 0 ? -1 : 0;
                }
                found |= at[0] * way >= 0 && at[1] * way >= 0 && at[2] * way >= 0;
            }
            EXPECT_TRUE(found) << p;
        }
    }
    EXPECT_GT(inside, 1000u);
    EXPECT_GT(bent, 100u);
}

TEST(ConvexPatches, ChangeNoAnswerOfACell) {
    for (const char* kind : {"town", "office"}) {
        Scene scene = generated(kind, 40000);
        SceneTree tree = SceneTree::build(scene, Units::triangles(scene));
        Tracer tracer = Tracer::build(scene);
        Box3d bounds = to_double(scene.local_bounds());
        Vec3d low = bounds.min + bounds.size() * 0.4;
        low.y = bounds.min.y + 0.6 * bounds.size().y;
        GridBox cell{tree.to_grid(low), tree.to_grid(low + Vec3d{1, 1, 1})};
        std::vector<std::uint64_t> answers[2];
        for (bool joined : {false, true}) {
            CellOptions options;
            options.joined = joined;
            options.look_around = 20000;
            options.follow = 50000;
            options.sample_between = true;
            CellSolver solver(tree, tracer, options);
            CellCounters counters;
            answers[joined].assign((scene.triangles().size() + 63) / 64, 0);
            ASSERT_TRUE(solver.solve(cell, answers[joined], counters));
            EXPECT_EQ(counters.undecided, 0u);
        }
        EXPECT_EQ(answers[0], answers[1]) << kind;
    }
}

} // namespace
} // namespace antumbra::exact::testing
