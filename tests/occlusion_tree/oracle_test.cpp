// The tree against brute force in rational arithmetic, state by state.
#include "occlusion_tree/configurations.hpp"

#include <gtest/gtest.h>

#include <chrono>
#include <cstdlib>
#include <numeric>

namespace antumbra {
namespace {

using namespace test;

struct Counts {
    std::uint64_t boxes = 0, invisible = 0, partial = 0, full = 0, pyramid_invisible = 0, conservative_invisible = 0, from_reached = 0;
    std::uint64_t extra_invisible = 0, hull_invisible = 0, ball_invisible = 0;
    std::uint64_t filtered = 0, exact = 0, undecided = 0;
};

/// One configuration: FSE equal to the oracle in both orders and forms, FME and FMC never below it nor each other.
void compare(const Configuration& made, Counts& counts, const std::string& what) {
    TreeOccluders occluders = TreeOccluders::build(made.set);
    std::vector<std::uint32_t> all(made.set.polygons.size());
    std::iota(all.begin(), all.end(), 0u);
    TreeBuilder builder(occluders, std::uint32_t(all.size()) * 8 + 8);
    constexpr OcclusionTreeLimits kLimits{1u << 12, 1u << 13, 1u << 11};
    static OcclusionTree plain(kLimits), modified(kLimits), any_order(kLimits), extra(kLimits);
    plain.begin(made.eye, 10, TreeForm::plain);
    builder.insert(plain, all, TreeBuilder::Order::binary_space_partition);
    modified.begin(made.eye, 10, TreeForm::modified);
    builder.insert(modified, all, TreeBuilder::Order::binary_space_partition);
    any_order.begin(made.eye, 10, TreeForm::modified);
    builder.insert(any_order, all, TreeBuilder::Order::as_given);
    ASSERT_FALSE(plain.ran_out() || modified.ran_out() || any_order.ran_out()) << what;
    ASSERT_LE(modified.node_count(), plain.node_count()) << what;
    extra.begin(made.eye, 10, TreeForm::modified, ExtraNodes::at_sharp_angles);
    builder.insert(extra, all, TreeBuilder::Order::binary_space_partition);
    ASSERT_EQ(extra.node_count(), modified.node_count()) << what;
    auto shadows = shadows_of(made);
    for (const Box3d& box : made.boxes) {
        OracleAnswer truth = ask_oracle(box, made.eye, shadows);
        ++counts.boxes;
        counts.invisible += truth.visibility == Visibility::invisible;
        counts.partial += truth.visibility == Visibility::partial;
        counts.full += truth.visibility == Visibility::full;
        for (OcclusionTree* tree : {&plain, &modified, &any_order})
            ASSERT_EQ(int(tree->visibility_by_faces(box)), int(truth.visibility))
                << what << (tree == &plain ? " plain" : tree == &modified ? " modified" : " as given");
        // The modern query, from the root and from what larger boxes have reached.
        bool invisible = truth.visibility == Visibility::invisible;
        Vec3d seen{NAN, NAN, NAN};
        Box3d around = box, farther = box;
        around.extend(made.boxes[&box == &made.boxes.back() ? 0 : 1].min);
        farther.extend(around);
        farther.extend(made.boxes[0].max);
        for (OcclusionTree* tree : {&plain, &modified, &any_order}) {
            ASSERT_EQ(tree->hides(box, tree->root(), &seen), invisible) << what;
            ASSERT_EQ(tree->hides(box, tree->descend(box, tree->root()), &seen), invisible) << what;
            ASSERT_FALSE(invisible && box.contains(seen) && tree->is_seen(seen, tree->root())) << what;
            OcclusionTree::Reach whole = tree->whole_picture(), first, second;
            if (!truth.has_faces) // a point or a line within a hidden box: nothing is known of it alone
                continue;
            bool whole_hidden = tree->hides(farther, whole, nullptr, &first);
            ASSERT_TRUE(!whole_hidden || invisible) << what;
            bool half = tree->hides(around, first, nullptr, &second);
            ASSERT_EQ(half || whole_hidden, tree->hides(around, whole, nullptr, nullptr)) << what;
            bool first_says = half || whole_hidden;
            ASSERT_TRUE(!first_says || invisible) << what;
            ASSERT_EQ(first_says || tree->hides(box, second, &seen, nullptr), invisible) << what;
            ASSERT_EQ(half || whole_hidden || tree->hides(box, tree->narrow(box, first), nullptr, nullptr), invisible) << what;
            ASSERT_FALSE(invisible && !whole_hidden && box.contains(seen) && tree->is_seen(seen, first)) << what;
            counts.from_reached += !half && !whole_hidden && invisible;
            tree->release(whole);
        }
        Visibility e = modified.visibility_unsplit(box, LeafTest::pyramid);
        Visibility c = modified.visibility_unsplit(box, LeafTest::conservative);
        // Tests at inner nodes make it exact; extra nodes only help, and never too much.
        for (OcclusionTree* tree : {&plain, &modified, &any_order}) {
            Visibility exact = tree->visibility_unsplit(box, LeafTest::pyramid, InnerTest::region);
            ASSERT_TRUE(tree == &any_order ? exact != Visibility::invisible || invisible : exact == truth.visibility)
                << what << " " << int(exact) << " for " << int(truth.visibility);
        }
        Visibility better = extra.visibility_unsplit(box, LeafTest::pyramid);
        ASSERT_TRUE(better != Visibility::invisible || invisible) << what;
        ASSERT_TRUE(better == Visibility::invisible || e != Visibility::invisible) << what;
        counts.extra_invisible += better == Visibility::invisible;
        // Other shapes: the corners of the box, and balls within and around it.
        Vec3d corners[8];
        for (int k = 0; k < 8; ++k)
            corners[k] = {k & 1 ? box.max.x : box.min.x, k & 2 ? box.max.y : box.min.y, k & 4 ? box.max.z : box.min.z};
        Ball ball{box.centre(), length(box.size()) / 2 * (1 + 1e-12)};
        bool hull_hidden = modified.visibility_unsplit(std::span<const Vec3d>(corners)) == Visibility::invisible;
        bool ball_hidden = modified.visibility_unsplit(ball) == Visibility::invisible;
        if (truth.has_faces) {
            ASSERT_TRUE(!hull_hidden || invisible) << what;
            ASSERT_TRUE(!ball_hidden || invisible) << what;
        }
        ASSERT_TRUE(!ball_hidden || hull_hidden) << what;
        counts.hull_invisible += hull_hidden && invisible;
        counts.ball_invisible += ball_hidden;
        counts.pyramid_invisible += e == Visibility::invisible;
        counts.conservative_invisible += c == Visibility::invisible;
        if (e == Visibility::invisible) {
            ASSERT_EQ(int(truth.visibility), int(Visibility::invisible)) << what;
        }
        if (c == Visibility::invisible) {
            ASSERT_EQ(int(e), int(Visibility::invisible)) << what;
        }
    }
    for (OcclusionTree* tree : {&plain, &modified, &any_order}) {
        counts.filtered += tree->sight().tally().filtered();
        counts.exact += tree->sight().tally().exact;
        counts.undecided += tree->sight().tally().undecided;
    }
}

void random_round(std::uint64_t seed, std::uint64_t trial, Counts& counts) {
    Random random(seed, trial, 0x6f627370);
    std::uint32_t occluders = 1 + random.below(10);
    std::string what = "seed " + std::to_string(seed) + " trial " + std::to_string(trial);
    switch (trial % 4) {
    case 0: return compare(lattice_configuration(random, occluders, 12), counts, what + " lattice");
    case 1: return compare(general_configuration(random, occluders, 12, false), counts, what + " general");
    case 2: return compare(general_configuration(random, occluders, 12, true), counts, what + " crowded");
    default: return compare(wall_configuration(random, 12), counts, what + " wall");
    }
}

void print(const Counts& counts) {
    std::printf("%llu boxes: %llu invisible, %llu partial, %llu full; unsplit: E hides %llu, with extra nodes %llu, C %llu, as hulls %llu, as balls %llu; from what others reached %llu; signs: %llu filtered, "
                "%llu exact, %llu undecided\n",
                (unsigned long long)counts.boxes, (unsigned long long)counts.invisible,
                (unsigned long long)counts.partial, (unsigned long long)counts.full,
                (unsigned long long)counts.pyramid_invisible, (unsigned long long)counts.extra_invisible,
                (unsigned long long)counts.conservative_invisible, (unsigned long long)counts.hull_invisible,
                (unsigned long long)counts.ball_invisible, (unsigned long long)counts.from_reached,
                (unsigned long long)counts.filtered, (unsigned long long)counts.exact,
                (unsigned long long)counts.undecided);
}

TEST(OcclusionTreeOracle, random_boxes_and_occluders) {
    Counts counts;
    for (std::uint64_t trial = 0; trial < 400 && !HasFatalFailure(); ++trial)
        random_round(1, trial, counts);
    print(counts);
    EXPECT_GT(counts.invisible * 25, counts.boxes) << "hardly anything is hidden: the comparison says little";
    EXPECT_GT(counts.partial * 10, counts.boxes);
    EXPECT_GT(counts.full * 20, counts.boxes);
    EXPECT_GT(counts.pyramid_invisible, counts.conservative_invisible);
    EXPECT_GE(counts.extra_invisible, counts.pyramid_invisible);
    EXPECT_GT(counts.hull_invisible * 2, counts.conservative_invisible);
    EXPECT_GT(counts.ball_invisible, 20u);
    EXPECT_GT(counts.exact, 1000u) << "degenerate positions are meant to be among them";
    EXPECT_EQ(counts.undecided, 0u);
}

/// ANTUMBRA_SOAK=SECONDS compares for that long, and prints its counts; ANTUMBRA_SOAK_SEED=NUMBER does so again.
TEST(OcclusionTreeOracle, soak) {
    const char* seconds = std::getenv("ANTUMBRA_SOAK");
    if (!seconds)
        GTEST_SKIP() << "set ANTUMBRA_SOAK to a number of seconds";
    auto now = std::chrono::steady_clock::now();
    auto end = now + std::chrono::duration<double>(std::atof(seconds));
    const char* again = std::getenv("ANTUMBRA_SOAK_SEED");
    auto seed = again ? std::uint64_t(std::strtoull(again, nullptr, 10)) : std::uint64_t(now.time_since_epoch().count());
    Counts counts;
    for (std::uint64_t trial = 0; std::chrono::steady_clock::now() < end && !HasFatalFailure(); ++trial)
        random_round(seed, trial, counts);
    print(counts);
    // A row of bench/results/occlusion_tree_soak.csv.
    std::printf("seed,boxes,invisible,partial,full,e,extra_nodes,c,hulls,balls,from_reached,signs_filtered,signs_exact,undecided,disagreements\n"
                "%llu,%llu,%llu,%llu,%llu,%llu,%llu,%llu,%llu,%llu,%llu,%llu,%llu,%llu,%d\n",
                (unsigned long long)seed, (unsigned long long)counts.boxes, (unsigned long long)counts.invisible,
                (unsigned long long)counts.partial, (unsigned long long)counts.full, (unsigned long long)counts.pyramid_invisible,
                (unsigned long long)counts.extra_invisible, (unsigned long long)counts.conservative_invisible,
                (unsigned long long)counts.hull_invisible, (unsigned long long)counts.ball_invisible,
                (unsigned long long)counts.from_reached, (unsigned long long)counts.filtered, (unsigned long long)counts.exact,
                (unsigned long long)counts.undecided, HasFatalFailure() ? 1 : 0);
}

} // namespace
} // namespace antumbra
