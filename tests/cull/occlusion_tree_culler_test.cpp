// Laws of the methods with occlusion trees. That they lose nothing is for occlusion_proof_test and safety_test.
#include "cull/proof.hpp"

#include "cull/scene_data.hpp"
#include "support/count_allocations.hpp"

#include <limits>

namespace antumbra {
namespace {

using test::allocations;
using test::Stage;

Stage soup(std::uint64_t seed, int objects = 80) {
    Random random(seed);
    Result<Scene> scene = Scene::create(test::random_soup(random, objects, 4));
    EXPECT_TRUE(scene.ok());
    return Stage(std::move(*scene));
}

/// Small steps and turns through the middle of the soup.
std::vector<View> stroll(std::uint64_t seed, int frames) {
    Random random(seed, 1);
    View view;
    view.eye = {random.uniform(-3, 3), random.uniform(-3, 3), random.uniform(-3, 3)};
    view.near_plane = 0.001;
    Vec3d way{random.uniform(-1, 1), random.uniform(-0.3, 0.3), random.uniform(-1, 1)};
    std::vector<View> views;
    for (int f = 0; f < frames; ++f) {
        view.eye += way * 0.01;
        view.target = view.eye + way + Vec3d{0.01 * f, 0, 0};
        views.push_back(view);
    }
    return views;
}

std::unique_ptr<Culler> make(const char* name, const Stage& stage, CullerOptions options = {}) {
    auto culler = make_culler(name, stage.cull_scene, options);
    EXPECT_TRUE(culler.ok()) << culler.status().message();
    return std::move(culler).value();
}

CullerOptions thorough() {
    CullerOptions options;
    options.tree.minimum_cost = 0;
    options.tree.retest = Retest::always;
    return options;
}

bool is_subset(const CullResult& a, const CullResult& b) {
    for (std::size_t word = 0; word < a.visible.size(); ++word)
        if (a.visible[word] & ~b.visible[word])
            return false;
    return true;
}

TEST(OcclusionTreeCuller, tree_never_reports_what_planes_hides) {
    std::uint64_t by_tree = 0;
    for (std::uint64_t seed = 0; seed < 12; ++seed) {
        Stage stage = soup(100 + seed);
        auto planes = make("planes", stage), tree = make("tree", stage);
        ViewState a, b;
        CullResult planes_result, tree_result;
        for (const View& view : stroll(seed, 20)) {
            planes->cull(view, a, planes_result);
            tree->cull(view, b, tree_result);
            ASSERT_TRUE(is_subset(tree_result, planes_result)) << "seed " << seed;
            by_tree += planes_result.visible_count - tree_result.visible_count;
        }
    }
    EXPECT_GT(by_tree, 0u) << "the tree adds nothing: the law says little";
}

/// The exact tree in object space against pixels that are counted only where they are wholly covered: with the same occluders
/// it hides whatever they hide.
TEST(OcclusionTreeCuller, tree_hides_what_masked_hides_with_the_same_occluders) {
    CullerOptions options;
    options.occluders = options.polygon_budget = 512; // all that there are
    options.pixels_per_polygon = 0;
    options.tree.object_worth = std::numeric_limits<double>::infinity();
    std::uint64_t masked_sum = 0, tree_sum = 0, frames = 0;
    for (std::uint64_t seed = 0; seed < 12; ++seed) {
        Stage stage = soup(500 + seed, 60);
        ASSERT_LT(stage.cull_scene.data().occluders.polygons.size(), 512u);
        for (const View& view : stroll(seed, 6)) {
            CullerOptions planes = options;
            planes.occluders = 64;
            ViewState a, b; // fresh: what was hidden before says nothing
            CullResult masked, tree;
            make("masked", stage, planes)->cull(view, a, masked);
            make("tree", stage, options)->cull(view, b, tree);
            ASSERT_TRUE(is_subset(tree, masked)) << "seed " << seed;
            masked_sum += masked.visible_count;
            tree_sum += tree.visible_count;
            ++frames;
        }
    }
    EXPECT_LT(tree_sum, masked_sum) << "over " << frames << " frames";
}

/// Starting at the leaves that a parent reached, or at the deepest node, is a matter of speed alone.
TEST(OcclusionTreeCuller, the_start_changes_no_answer) {
    CullerOptions reached = thorough(), deepest = thorough();
    reached.tree.object_worth = deepest.tree.object_worth = std::numeric_limits<double>::infinity();
    deepest.tree.start = TreeStart::deepest_node;
    std::uint64_t hidden = 0;
    for (std::uint64_t seed = 0; seed < 6; ++seed) {
        Stage stage = soup(600 + seed, 150);
        auto a = make("tree", stage, reached), b = make("tree", stage, deepest);
        for (const View& view : stroll(seed, 10)) {
            ViewState fresh_a, fresh_b;
            CullResult first, second;
            a->cull(view, fresh_a, first);
            b->cull(view, fresh_b, second);
            ASSERT_EQ(first.visible, second.visible) << "seed " << seed;
            hidden += first.counters.hidden_by_tree;
        }
    }
    EXPECT_GT(hidden, 50u);
}

TEST(OcclusionTreeCuller, tests_at_inner_nodes_make_fme_hide_what_fse_hides) {
    std::uint64_t more = 0;
    for (std::uint64_t seed = 0; seed < 12; ++seed) {
        Stage stage = soup(700 + seed);
        CullerOptions inner = thorough(), extra = thorough();
        inner.tree.inner_tests = true;
        extra.tree.extra_nodes = true;
        for (const View& view : stroll(seed, 2)) {
            CullResult fse, fme, exact, sharp;
            ViewState states[4];
            make("tree-fse", stage, thorough())->cull(view, states[0], fse);
            make("tree-fme", stage, thorough())->cull(view, states[1], fme);
            make("tree-fme", stage, inner)->cull(view, states[2], exact);
            make("tree-fme", stage, extra)->cull(view, states[3], sharp);
            ASSERT_EQ(exact.visible, fse.visible) << "seed " << seed;
            ASSERT_TRUE(is_subset(fse, sharp) && is_subset(sharp, fme)) << "seed " << seed;
            more += fme.visible_count - exact.visible_count;
        }
    }
    EXPECT_GT(more, 0u);
}

TEST(OcclusionTreeCuller, exact_hides_most_then_the_pyramid_test_then_none) {
    std::uint64_t fewer = 0;
    for (std::uint64_t seed = 0; seed < 20; ++seed) {
        Stage stage = soup(200 + seed);
        for (const View& view : stroll(seed, 3)) {
            CullResult f, fse, fme, fmc;
            ViewState states[4]; // fresh ones choose the same occluders
            make("tree-f", stage, thorough())->cull(view, states[0], f);
            make("tree-fse", stage, thorough())->cull(view, states[1], fse);
            make("tree-fme", stage, thorough())->cull(view, states[2], fme);
            make("tree-fmc", stage, thorough())->cull(view, states[3], fmc);
            ASSERT_TRUE(is_subset(fse, fme) && is_subset(fme, fmc) && is_subset(fmc, f)) << "seed " << seed;
            fewer += f.visible_count - fse.visible_count;
        }
    }
    EXPECT_GT(fewer, 100u);
}

TEST(OcclusionTreeCuller, nodes_cheaper_than_the_minimum_are_not_tested) {
    Stage stage = soup(7);
    CullerOptions options;
    options.tree.minimum_cost = 1'000'000;
    CullResult plain, result;
    ViewState a, b;
    for (const View& view : stroll(7, 3)) {
        make("tree-f", stage)->cull(view, a, plain);
        make("tree-fse", stage, options)->cull(view, b, result);
        EXPECT_EQ(plain.visible, result.visible);
        EXPECT_EQ(result.counters.tree_tests, 0u);
    }
}

TEST(OcclusionTreeCuller, marks_save_tests_of_inner_nodes_and_lose_only_those) {
    std::uint64_t saved = 0, tests_with = 0, tests_without = 0;
    for (std::uint64_t seed = 0; seed < 8; ++seed) {
        Stage stage = soup(300 + seed, 150);
        CullerOptions marking = thorough();
        marking.tree.retest = Retest::when_unmarked;
        auto with = make("tree-fse", stage, marking), without = make("tree-fse", stage, thorough());
        ViewState a, b;
        CullResult marked, plain;
        View view = stroll(seed, 1)[0];
        for (int frame = 0; frame < 6; ++frame) {
            with->cull(view, a, marked);
            without->cull(view, b, plain);
            // Leaves are tested in each frame: what is reported does not change.
            EXPECT_EQ(marked.visible, plain.visible) << "seed " << seed << " frame " << frame;
            saved += marked.counters.tests_saved;
            tests_with += marked.counters.tree_tests;
            tests_without += plain.counters.tree_tests;
        }
    }
    EXPECT_GT(saved, 0u);
    EXPECT_LT(tests_with, tests_without);
}

TEST(OcclusionTreeCuller, the_same_views_give_the_same_answers) {
    Stage stage = soup(9);
    for (const char* name : {"tree-fse", "tree-fme", "tree-fmc", "tree"}) {
        auto culler = make(name, stage);
        ViewState a, b;
        CullResult first, second;
        for (const View& view : stroll(9, 30)) {
            culler->cull(view, a, first);
            culler->cull(view, b, second);
            EXPECT_EQ(first.visible, second.visible) << name;
            EXPECT_EQ(first.counters.tree_planes_tested, second.counters.tree_planes_tested) << name;
        }
    }
}

TEST(OcclusionTreeCuller, nothing_is_allocated_after_the_first_frames) {
    Stage stage = soup(10);
    std::vector<View> views = stroll(10, 40);
    for (const char* name : {"tree-f", "tree-fse", "tree-fme", "tree-fmc", "tree"}) {
        auto culler = make(name, stage, thorough());
        ViewState state;
        CullResult result;
        for (const View& view : views)
            culler->cull(view, state, result);
        std::uint64_t before = allocations;
        for (const View& view : views)
            culler->cull(view, state, result);
        EXPECT_EQ(allocations, before) << name;
    }
}

TEST(OcclusionTreeCuller, too_many_occluders_are_wrong_usage) {
    Stage stage = soup(11, 10);
    CullerOptions options;
    options.occluders = 257;
    EXPECT_EQ(make_culler("tree-fse", stage.cull_scene, options).status().code(), ErrorCode::usage);
    EXPECT_TRUE(make_culler("tree", stage.cull_scene, options).ok());
    options.occluders = 513;
    EXPECT_EQ(make_culler("tree", stage.cull_scene, options).status().code(), ErrorCode::usage);
    options.occluders = 256;
    EXPECT_TRUE(make_culler("tree-fme", stage.cull_scene, options).ok());
}

} // namespace
} // namespace antumbra
