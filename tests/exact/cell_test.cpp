// Whole cells: against rays, against brute force, and with answers known by construction.
#include "bake/exact/cell.hpp"

#include "bake/exact/proof.hpp"
#include "base/random.hpp"

#include <gtest/gtest.h>

#include <chrono>
#include <cstdlib>

namespace antumbra::exact {
namespace {

struct Builder {
    RawScene raw;
    std::uint32_t flags = kOccludes;

    void begin(const std::string& name) {
        RawObject object;
        object.name = name;
        object.flags = flags;
        object.first_triangle = static_cast<std::uint32_t>(raw.triangles.size());
        raw.objects.push_back(object);
    }
    void triangle(Vec3d a, Vec3d b, Vec3d c) {
        auto first = static_cast<std::uint32_t>(raw.positions.size());
        raw.positions.insert(raw.positions.end(), {a, b, c});
        raw.triangles.push_back({first, first + 1, first + 2});
        ++raw.objects.back().triangle_count;
    }
    /// Counter-clockwise seen from outside; `inward` turns it.
    void box(Vec3d a, Vec3d b, bool inward = false) {
        auto corner = [&](int i) { return Vec3d{i & 1 ? b.x : a.x, i & 2 ? b.y : a.y, i & 4 ? b.z : a.z}; };
        const int faces[6][4] = {{0, 4, 6, 2}, {1, 3, 7, 5}, {0, 1, 5, 4}, {2, 6, 7, 3}, {0, 2, 3, 1}, {4, 5, 7, 6}};
        for (const auto& f : faces)
            for (int k = 1; k < 3; ++k)
                if (inward)
                    triangle(corner(f[0]), corner(f[k + 1]), corner(f[k]));
                else
                    triangle(corner(f[0]), corner(f[k]), corner(f[k + 1]));
    }
    Scene finish() {
        raw.source = "test";
        Result<Scene> scene = Scene::create(std::move(raw));
        EXPECT_TRUE(scene.ok()) << scene.status().message();
        return std::move(*scene);
    }
};

GridBox grid_box(const SceneTree& tree, Vec3d a, Vec3d b) {
    return {tree.to_grid(tree.scene().to_local(a)), tree.to_grid(tree.scene().to_local(b))};
}

bool sees(const std::vector<std::uint64_t>& bits, std::uint32_t object) { return bits[object / 64] >> (object % 64) & 1; }

std::vector<std::uint64_t> solve(const Scene& scene, Vec3d a, Vec3d b, CellOptions options = {},
                                 CellCounters* counters = nullptr) {
    SceneTree tree = SceneTree::build(scene);
    Tracer tracer = Tracer::build(scene);
    CellSolver solver(tree, tracer, options);
    std::vector<std::uint64_t> visible((scene.objects().size() + 63) / 64, 0);
    CellCounters own;
    EXPECT_TRUE(solver.solve(grid_box(tree, a, b), visible, counters ? *counters : own));
    EXPECT_EQ((counters ? *counters : own).undecided, 0u);
    return visible;
}

TEST(GridGeometry, ATriangleTouchesABoxInAPointOrNotByOneUnit) {
    GridBox box{{0, 0, 0}, {10, 10, 10}};
    EXPECT_TRUE(touches(box, {{{10, 10, 10}, {20, 20, 11}, {20, 11, 20}}}));
    EXPECT_FALSE(touches(box, {{{11, 10, 10}, {20, 20, 11}, {20, 11, 20}}}));
    EXPECT_TRUE(touches(box, {{{30, 0, 0}, {0, 30, 0}, {0, 0, 30}}}));
    EXPECT_FALSE(touches(box, {{{31, 0, 0}, {0, 31, 0}, {0, 0, 31}}}));
    EXPECT_TRUE(touches(box, {{{-100, -100, 5}, {100, -100, 5}, {0, 200, 5}}}));
}

TEST(GridGeometry, FacesOfABoxLookOutward) {
    GridBox box{{0, 0, 0}, {4, 5, 6}};
    for (int axis = 0; axis < 3; ++axis)
        for (int side = 0; side < 2; ++side) {
            auto f = face_of(box, axis, side);
            GridPoint n = cross(f[1] - f[0], f[2] - f[0]);
            EXPECT_GT(n[axis] * (side ? 1 : -1), 0);
            EXPECT_EQ(n[(axis + 1) % 3], 0);
        }
}

TEST(Cell, WhatStandsBehindAWallIsHiddenAndWhatLooksOverItIsNot) {
    Builder b;
    b.begin("wall");
    b.box({0, -100, -100}, {1, 100, 3});
    b.begin("low");
    b.box({5, -1, -1}, {6, 1, 1});
    b.begin("high");
    b.box({5, 5, -1}, {6, 6, 9});
    Scene scene = b.finish();
    auto visible = solve(scene, {-4, -1, 0}, {-3, 1, 2});
    EXPECT_TRUE(sees(visible, 0));
    EXPECT_FALSE(sees(visible, 1));
    EXPECT_TRUE(sees(visible, 2));
}

TEST(Cell, AClosedRoomHidesTheWorldAndIsHiddenFromIt) {
    for (bool inside : {false, true}) {
        Builder b;
        b.flags = kOccludes | kDoubleSided;
        b.begin("room");
        b.box({0, 0, 0}, {10, 10, 10});
        b.begin("lamp");
        b.box({4, 4, 4}, {5, 5, 5});
        b.begin("tree");
        b.box({20, 0, 0}, {21, 1, 8});
        Scene scene = b.finish();
        auto visible = inside ? solve(scene, {1, 1, 1}, {2, 3, 2}) : solve(scene, {15, 1, 1}, {16, 3, 2});
        EXPECT_TRUE(sees(visible, 0));
        EXPECT_EQ(sees(visible, 1), inside);
        EXPECT_EQ(sees(visible, 2), !inside);
    }
}

TEST(Cell, BackFacesOfARoomLetTheViewIn) {
    Builder b;
    b.begin("room, fronts inward");
    b.box({0, 0, 0}, {10, 10, 10}, true);
    b.begin("lamp");
    b.box({4, 4, 4}, {5, 5, 5});
    b.begin("far");
    b.box({-30, 4, 4}, {-29, 5, 5});
    Scene scene = b.finish();
    auto visible = solve(scene, {15, 3.5, 3.5}, {16, 5.5, 5.5});
    EXPECT_TRUE(sees(visible, 0)); // the far walls' insides
    EXPECT_TRUE(sees(visible, 1));
    EXPECT_FALSE(sees(visible, 2)); // behind those
}

TEST(Cell, ASingleSidedSheetIsSeenFromItsFrontOnlyEvenWhereItTouchesTheCell) {
    for (bool turned : {false, true}) {
        Builder b;
        b.begin("sheet at the cell's face");
        if (turned)
            b.triangle({2, 0, 0}, {2, 0, 4}, {2, 4, 0}); // its front looks to -x
        else
            b.triangle({2, 0, 0}, {2, 4, 0}, {2, 0, 4});
        b.begin("ground");
        b.box({-50, -50, -9}, {50, 50, -8});
        Scene scene = b.finish();
        auto visible = solve(scene, {0, 0, 0}, {2, 2, 2});
        EXPECT_EQ(sees(visible, 0), turned);
        EXPECT_TRUE(sees(visible, 1));
    }
}

TEST(Cell, ObjectsThatDoNotOccludeAreSeenAndSeenThrough) {
    Builder b;
    b.flags = kDoubleSided;
    b.begin("glass");
    b.box({3, -50, -50}, {3.5, 50, 50});
    b.flags = kOccludes;
    b.begin("behind it");
    b.box({6, -1, -1}, {7, 1, 1});
    Scene scene = b.finish();
    auto visible = solve(scene, {0, -1, -1}, {1, 1, 1});
    EXPECT_TRUE(sees(visible, 0));
    EXPECT_TRUE(sees(visible, 1));
}

/// Boxes and loose triangles on a coarse lattice, so that faces and edges coincide.
Scene random_scene(std::uint64_t seed, int objects) {
    Random random(seed);
    Builder b;
    auto whole = [&](int low, int high) { return static_cast<double>(low + static_cast<int>(random.below(static_cast<std::uint32_t>(high - low + 1)))); };
    for (int k = 0; k < objects; ++k) {
        b.flags = kOccludes | (random.below(3) == 0 ? kDoubleSided : 0u);
        b.begin("object " + std::to_string(k));
        if (random.below(4) != 0) {
            Vec3d a{whole(-12, 12), whole(-12, 12), whole(-6, 6)};
            b.box(a, a + Vec3d{whole(1, 6), whole(1, 6), whole(1, 6)});
        } else {
            for (int i = 0; i < 3; ++i) {
                Vec3d p[3];
                do
                    for (Vec3d& v : p)
                        v = {whole(-12, 12), whole(-12, 12), whole(-6, 6)};
                while (cross(p[1] - p[0], p[2] - p[0]) == Vec3d{});
                b.triangle(p[0], p[1], p[2]);
            }
        }
    }
    b.flags = kOccludes | kDoubleSided;
    b.begin("hull");
    b.box({-20, -20, -9}, {20, 20, 14});
    return b.finish();
}

TEST(Cell, EqualsBruteForceInIntegers) {
    std::uint64_t hidden = 0;
    for (std::uint64_t seed = 1; seed <= 6; ++seed) {
        Scene scene = random_scene(seed, 45);
        SceneTree tree = SceneTree::build(scene);
        Tracer tracer = Tracer::build(scene);
        Vec3d a{-2, -3, -1}, b{1, 0, 2};
        auto visible = solve(scene, a, b);
        CellOptions plain;
        plain.filtered = false;
        plain.patches = false;
        plain.rays = 2;
        CellSolver oracle(tree, tracer, plain);
        GridBox cell = grid_box(tree, a, b);
        std::vector<bool> expected(scene.objects().size(), false);
        CellCounters counters;
        for (std::uint32_t t = 0; t < scene.triangles().size(); ++t) {
            std::uint32_t object = scene.triangle_objects()[t];
            if (expected[object])
                continue;
            if (touches(cell, tree.corners(t))) // visible by definition if it shows a side
                expected[object] = sees(visible, object);
            else
                expected[object] = oracle.ask_triangle(cell, t, counters) == Answer::visible;
        }
        for (std::uint32_t o = 0; o < scene.objects().size(); ++o) {
            EXPECT_EQ(sees(visible, o), expected[o]) << "seed " << seed << " object " << o;
            hidden += !expected[o];
        }
    }
    EXPECT_GT(hidden, 5u);
}

TEST(Cell, NoRayFromTheCellSeesWhatIsCalledHidden) {
    std::uint64_t rays = 0, hidden_objects = 0;
    for (std::uint64_t seed = 11; seed <= 16; ++seed) {
        Scene scene = random_scene(seed, 60);
        Tracer tracer = Tracer::build(scene);
        Arbiter arbiter(tracer);
        Vec3d a{-2, -3, -1}, b{1, 0, 2};
        auto visible = solve(scene, a, b);
        Random random(seed);
        std::vector<std::uint32_t> hit;
        std::vector<std::uint32_t> hidden;
        for (std::uint32_t t = 0; t < scene.triangles().size(); ++t)
            if (!sees(visible, scene.triangle_objects()[t]))
                hidden.push_back(t);
        hidden_objects += hidden.size();
        for (int k = 0; k < 60000 && !hidden.empty(); ++k) {
            std::uint32_t t = hidden[random.below(static_cast<std::uint32_t>(hidden.size()))];
            Vec3d eye = scene.to_local({random.uniform(a.x, b.x), random.uniform(a.y, b.y), random.uniform(a.z, b.z)});
            double u = random.uniform(), v = random.uniform();
            if (u + v > 1) {
                u = 1 - u;
                v = 1 - v;
            }
            Vec3d target = scene.vertex(t, 0) + (scene.vertex(t, 1) - scene.vertex(t, 0)) * u +
                           (scene.vertex(t, 2) - scene.vertex(t, 0)) * v;
            hit.clear();
            tracer.seen({eye, target - eye}, hit);
            ++rays;
            for (std::uint32_t h : hit)
                if (!sees(visible, scene.triangle_objects()[h])) {
                    EXPECT_NE(arbiter.sees(eye, target, h), Verdict::clear) << "seed " << seed << " triangle " << h;
                }
        }
    }
    EXPECT_GT(hidden_objects, 20u);
    EXPECT_GT(rays, 100000u);
}

/// A bumpy sheet of one connected surface, closed or with a hole, single- or double-sided, between the cell and a lamp.
TEST(Cell, ConnectedPatchesHideOnlyWhatTheyHide) {
    std::uint64_t proved = 0;
    for (int variant = 0; variant < 16; ++variant) {
        bool hole = variant & 1, both = variant & 2, turned = variant & 4;
        Random random(static_cast<std::uint64_t>(variant));
        Builder b;
        b.flags = kOccludes | (both ? std::uint32_t(kDoubleSided) : 0u);
        b.begin("sheet");
        const int n = 8;
        Vec3d p[n + 1][n + 1];
        for (int i = 0; i <= n; ++i)
            for (int j = 0; j <= n; ++j)
                p[i][j] = {4 + random.uniform(-0.5, 0.5), -8 + 2.0 * i, -8 + 2.0 * j};
        for (int i = 0; i < n; ++i)
            for (int j = 0; j < n; ++j)
                for (int half = 0; half < 2; ++half) {
                    if (hole && i == n / 2 && j == n / 2 && half)
                        continue;
                    Vec3d a = p[i][j], c = p[i + 1][j + 1], d = half ? p[i][j + 1] : p[i + 1][j];
                    if ((half == 1) != turned)
                        std::swap(c, d);
                    b.triangle(a, d, c); // turned: fronts to +x, away from the cell
                }
        b.flags = kOccludes | kDoubleSided;
        b.begin("lamp");
        b.box({7, -1, -1}, {8, 2, 2});
        Scene scene = b.finish();
        CellCounters counters;
        auto visible = solve(scene, {-2, -1, -1}, {-1, 1, 1}, {}, &counters);
        CellOptions plain;
        plain.patches = false;
        EXPECT_EQ(visible, solve(scene, {-2, -1, -1}, {-1, 1, 1}, plain)) << variant;
        EXPECT_EQ(sees(visible, 1), hole || (!both && !turned)) << variant;
        proved += counters.query.patches_proved;
    }
    EXPECT_GT(proved, 0u);
}

TEST(Cell, TheAnswerDependsNeitherOnWhatWasKnownNorOnVirtualOccludersNorOnTheSeed) {
    for (std::uint64_t seed = 21; seed <= 24; ++seed) {
        Scene scene = random_scene(seed, 60);
        SceneTree tree = SceneTree::build(scene);
        Tracer tracer = Tracer::build(scene);
        GridBox cell = grid_box(tree, {-2, -3, -1}, {1, 0, 2});
        auto first = solve(scene, {-2, -3, -1}, {1, 0, 2});
        for (int variant = 0; variant < 4; ++variant) {
            CellOptions options;
            options.virtual_occluders = variant != 0;
            options.patches = variant != 3;
            options.seed = variant == 1 ? 77 : 1;
            CellSolver solver(tree, tracer, options);
            std::vector<std::uint64_t> visible(first.size(), 0);
            if (variant == 2)
                visible = first; // everything known already
            CellCounters counters;
            solver.solve(cell, visible, counters);
            EXPECT_EQ(visible, first) << seed << " " << variant;
        }
    }
}

/// ANTUMBRA_SOAK=SECONDS: random scenes, three forms of the solver against each other, each triangle's proof checked.
TEST(Cell, Soak) {
    const char* seconds = std::getenv("ANTUMBRA_SOAK");
    if (!seconds)
        GTEST_SKIP() << "set ANTUMBRA_SOAK to a number of seconds";
    auto start = std::chrono::steady_clock::now();
    auto seed = static_cast<std::uint64_t>(start.time_since_epoch().count());
    std::printf("seed %llu\n", static_cast<unsigned long long>(seed));
    std::uint64_t scenes = 0, hidden = 0, visible_count = 0, patches = 0, trees = 0, nodes = 0, rejected = 0;
    while (std::chrono::steady_clock::now() - start < std::chrono::seconds(std::atoi(seconds))) {
        Scene scene = random_scene(seed + scenes, 20 + static_cast<int>((seed + scenes) % 60));
        SceneTree tree = SceneTree::build(scene);
        Tracer tracer = Tracer::build(scene);
        GridBox cell = grid_box(tree, {-2, -3, -1}, {1, 0, 2});
        std::vector<std::uint64_t> first;
        for (int variant = 0; variant < 3; ++variant) {
            CellOptions options;
            options.patches = variant != 1;
            options.virtual_occluders = variant != 2;
            options.seed = static_cast<std::uint64_t>(variant);
            CellSolver solver(tree, tracer, options);
            std::vector<std::uint64_t> visible((scene.objects().size() + 63) / 64, 0);
            CellCounters counters;
            solver.solve(cell, visible, counters);
            if (variant == 0)
                first = visible;
            ASSERT_EQ(visible, first) << "scene " << seed + scenes << " variant " << variant;
            ASSERT_EQ(counters.undecided, 0u);
            patches += counters.query.patches_proved;
        }
        Prover prover(tree);
        auto object = static_cast<std::uint32_t>((seed + 7 * scenes) % scene.objects().size());
        PairProof proof = prover.prove(cell, object);
        ASSERT_EQ(proof.answer == Answer::visible, sees(first, object)) << "scene " << seed + scenes;
        rejected += !verify_proof(tree, proof).ok();
        ASSERT_EQ(rejected, 0u) << "scene " << seed + scenes;
        trees += proof.parts.size();
        for (const HiddenPart& part : proof.parts)
            nodes += part.tree.nodes.size();
        for (std::uint32_t o = 0; o < scene.objects().size(); ++o)
            ++(sees(first, o) ? visible_count : hidden);
        ++scenes;
    }
    std::printf("scenes %llu objects visible %llu hidden %llu, patches %llu, trees verified %llu of %llu nodes, rejected %llu\n",
                (unsigned long long)scenes, (unsigned long long)visible_count, (unsigned long long)hidden,
                (unsigned long long)patches, (unsigned long long)trees, (unsigned long long)nodes,
                (unsigned long long)rejected);
}

TEST(Cell, ALargerCellSeesNoLess) {
    for (std::uint64_t seed = 31; seed <= 34; ++seed) {
        Scene scene = random_scene(seed, 50);
        auto small = solve(scene, {-2, -3, -1}, {-1, -1, 1}), large = solve(scene, {-2, -3, -1}, {1, 0, 2});
        for (std::size_t w = 0; w < small.size(); ++w)
            EXPECT_EQ(small[w] & ~large[w], 0u) << seed;
    }
}

TEST(Cell, IsStoppedWithinItsQueriesAndGuessesNothing) {
    Builder b;
    b.begin("wall");
    b.box({0, -100, -100}, {1, 100, 3});
    b.begin("low");
    b.box({5, -1, -1}, {6, 1, 1});
    Scene scene = b.finish();
    SceneTree tree = SceneTree::build(scene);
    Tracer tracer = Tracer::build(scene);
    CellSolver solver(tree, tracer);
    std::atomic<bool> stop{true};
    std::vector<std::uint64_t> visible(1, 0);
    CellCounters counters;
    EXPECT_FALSE(solver.solve(grid_box(tree, {-4, -1, 0}, {-3, 1, 2}), visible, counters, {}, &stop));
    EXPECT_EQ(counters.undecided, 0u);
    stop = false;
    EXPECT_TRUE(solver.solve(grid_box(tree, {-4, -1, 0}, {-3, 1, 2}), visible, counters, {}, &stop));
    EXPECT_TRUE(sees(visible, 0));
    EXPECT_FALSE(sees(visible, 1));
}

TEST(Cell, WhatIsHiddenFromACellIsHandedDownToTheCellsInside) {
    Builder b;
    b.begin("wall");
    b.box({0, -100, -100}, {1, 100, 3});
    for (int k = 0; k < 20; ++k) {
        b.begin("thing");
        b.box({5, 2.0 * k - 20, -1 + 0.35 * k}, {6, 2.0 * k - 19, 0.35 * k});
    }
    Scene scene = b.finish();
    SceneTree tree = SceneTree::build(scene);
    Tracer tracer = Tracer::build(scene);
    CellSolver solver(tree, tracer);
    std::vector<std::uint64_t> parent(1, 0);
    CellCounters counters;
    ASSERT_TRUE(solver.solve(grid_box(tree, {-6, -2, 0}, {-3, 2, 4}), parent, counters));
    HiddenParts hidden = solver.hidden_parts();
    ASSERT_FALSE(hidden.nodes.empty());
    for (int k = 0; k < 4; ++k) {
        GridBox cell = grid_box(tree, {-6, -2.0 + k, 0.0 + k % 2}, {-4, -1.0 + k, 2});
        std::vector<std::uint64_t> alone(1, 0), handed(1, 0);
        CellCounters work_alone, work_handed;
        ASSERT_TRUE(solver.solve(cell, alone, work_alone));
        ASSERT_TRUE(solver.solve(cell, handed, work_handed, hidden));
        EXPECT_EQ(alone, handed);
        EXPECT_EQ(handed[0] & ~parent[0], 0u);
        EXPECT_LE(work_handed.pairs, work_alone.pairs);
    }
}

} // namespace
} // namespace antumbra::exact
