// What is found along a segment, against every triangle asked alone in integers; and what rays do not change.
#include "bake/exact/cell.hpp"
#include "bake/exact/occluders_along.hpp"
#include "base/random.hpp"

#include <gtest/gtest.h>

#include <algorithm>

namespace antumbra::exact {
namespace {

/// Random triangles on the whole grid, some small, some large, some across axes.
Scene soup(std::uint64_t seed, int count) {
    Random random(seed, 0x736F7570);
    RawScene raw;
    raw.source = "soup";
    RawObject object;
    object.name = "soup";
    object.flags = kOccludes | kDoubleSided;
    for (int t = 0; t < count; ++t) {
        Vec3d centre{random.uniform(-100, 100), random.uniform(-100, 100), random.uniform(-100, 100)};
        double size = t % 3 == 0 ? 0.01 : t % 3 == 1 ? 2 : 60;
        auto first = static_cast<std::uint32_t>(raw.positions.size());
        for (int c = 0; c < 3; ++c)
            raw.positions.push_back(centre + Vec3d{random.uniform(-size, size), random.uniform(-size, size),
                                                   t % 5 == 0 ? 0 : random.uniform(-size, size)});
        raw.triangles.push_back({first, first + 1, first + 2});
        ++object.triangle_count;
    }
    raw.objects.push_back(object);
    Result<Scene> scene = Scene::create(std::move(raw));
    EXPECT_TRUE(scene.ok()) << scene.status().message();
    return std::move(*scene);
}

Int128 volume(const GridPoint& a, const GridPoint& b, const GridPoint& c, const GridPoint& d) {
    GridPoint n = cross(b - a, c - a), e = d - a;
    return static_cast<Int128>(n.x) * e.x + static_cast<Int128>(n.y) * e.y + static_cast<Int128>(n.z) * e.z;
}

/// Does the closed segment meet the closed triangle? Ends in its plane are left out.
bool meets(const GridPoint& p, const GridPoint& q, const std::array<GridPoint, 3>& v) {
    Int128 at_p = volume(v[0], v[1], v[2], p), at_q = volume(v[0], v[1], v[2], q);
    if (at_p == 0 || at_q == 0 || (at_p > 0) == (at_q > 0))
        return false;
    bool left = false, right = false;
    for (std::size_t k = 0; k < 3; ++k) {
        Int128 side = volume(p, q, v[k], v[(k + 1) % 3]);
        left |= side > 0;
        right |= side < 0;
    }
    return !(left && right);
}

Vec3d to_vector(const GridPoint& p) { return {static_cast<double>(p.x), static_cast<double>(p.y), static_cast<double>(p.z)}; }

TEST(OccludersAlong, EveryTriangleThatASegmentMeetsIsFoundFromEitherEnd) {
    std::uint64_t met = 0;
    for (std::uint64_t seed = 1; seed <= 6; ++seed) {
        Scene scene = soup(seed, 400);
        SceneTree tree = SceneTree::build(scene);
        OccludersAlong along(tree);
        GridBox box = tree.nodes()[0].box;
        Random random(seed);
        auto coordinate = [&](int k) { return box.min[k] + static_cast<std::int64_t>(random.uniform() * static_cast<double>(box.max[k] - box.min[k])); };
        for (int s = 0; s < 400; ++s) {
            GridPoint p, q;
            for (int k = 0; k < 3; ++k) {
                p[k] = coordinate(k);
                q[k] = coordinate(k);
            }
            if (s % 4 == 0)
                q[s / 4 % 3] = p[s / 4 % 3]; // in a plane across an axis
            if (s % 16 == 0)
                q[(s / 16 + 1) % 3] = p[(s / 16 + 1) % 3];
            if (s % 7 == 0) { // ends beside a corner: boxes are touched at an end
                const auto& corners = tree.corners(random.below(400));
                q = corners[0] + corners[1] - corners[2];
                for (int k = 0; k < 3; ++k)
                    q[k] = std::clamp(q[k], box.min[k], box.max[k]);
            }
            for (bool from_end : {false, true}) {
                std::vector<OccluderId> found;
                along.look_from_end(from_end);
                ASSERT_FALSE(along.near_segment(to_vector(p), to_vector(q), SIZE_MAX, found));
                for (std::uint32_t t = 0; t < 400; ++t)
                    if (meets(p, q, tree.corners(t))) {
                        ++met;
                        ASSERT_NE(std::find(found.begin(), found.end(), t), found.end()) << "seed " << seed << " segment " << s;
                    }
            }
        }
    }
    EXPECT_GT(met, 5000u);
}

/// Much or little sampled, windows or none: the same triangles.
TEST(OccludersAlong, WhatRaysAndWindowsFindDoesNotChangeTheAnswer) {
    Scene scene = soup(11, 600);
    SceneTree tree = SceneTree::build(scene, Units::triangles(scene));
    Tracer tracer = Tracer::build(scene);
    std::vector<std::uint64_t> answers[4];
    for (int way = 0; way < 4; ++way) {
        CellOptions options;
        options.windows = way != 1;
        if (way >= 2) {
            options.look_around = 1000;
            options.follow = way == 2 ? 5000 : 400000;
            options.sample_between = true;
            options.seed = static_cast<std::uint64_t>(way);
        }
        answers[way].assign((tree.units().count() + 63) / 64, 0);
        CellSolver solver(tree, tracer, options);
        CellCounters counters;
        GridBox cell{tree.to_grid(scene.to_local({-4, -2, -4})), tree.to_grid(scene.to_local({4, 2, 4}))};
        ASSERT_TRUE(solver.solve(cell, answers[way], counters));
        EXPECT_EQ(counters.undecided, 0u);
        EXPECT_EQ(answers[way], answers[0]) << way;
        if (way == 3) {
            EXPECT_LT(counters.sampler.rays, 400000u); // it stops where rays find little
        }
    }
}

} // namespace
} // namespace antumbra::exact
