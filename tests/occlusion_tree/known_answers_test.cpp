// Answers that can be checked by hand, and the leaf test of the paper that hides what can be seen.
#include "occlusion_tree/configurations.hpp"

#include <gtest/gtest.h>

namespace antumbra {
namespace {

using namespace test;

/// Rectangles x0..x1, y0..y1 at depth z, seen from the origin.
struct Walls {
    Configuration made;
    void add(double x0, double x1, double y0, double y1, double z) {
        add_polygon(made.set, {{x0, y0, z}, {x1, y0, z}, {x1, y1, z}, {x0, y1, z}}, true);
    }
    OcclusionTree tree(TreeForm form) const {
        OcclusionTree tree({256, 512, 128});
        TreeOccluders occluders = TreeOccluders::build(made.set);
        TreeBuilder builder(occluders, 64);
        std::vector<std::uint32_t> all;
        for (std::uint32_t p = 0; p < made.set.polygons.size(); ++p)
            all.push_back(p);
        tree.begin(made.eye, 10, form);
        builder.insert(tree, all, TreeBuilder::Order::binary_space_partition);
        return tree;
    }
};

/// The test of the paper's section 6.2 as printed: "If they do not intersect, the region is classified invisible with
/// respect to the current leaf." For rectangles at constant z.
bool published_rule_hides(const Walls& walls, const Box3d& box) {
    for (const OccluderPolygon& polygon : walls.made.set.polygons) {
        Box3d fragment;
        for (std::uint32_t v : walls.made.set.loop(polygon))
            fragment.extend(to_double(walls.made.set.vertices[v]));
        double z = fragment.min.z;
        bool wholly_behind = box.min.z > z, crosses = box.min.z <= z && z <= box.max.z;
        if (!wholly_behind && !(crosses && !fragment.overlaps(box)))
            return false;
    }
    return true;
}

TEST(OcclusionTreeKnownAnswers, the_intersection_test_of_the_paper_hides_what_can_be_seen) {
    Walls walls;
    walls.add(-3, 1.5, -3, 3, 3);
    walls.add(2.1, 6, -3, 3, 3);
    walls.add(5, 7, -10, 10, 10);
    Box3d box{{2, -0.3, 4}, {4.9, 0.3, 11}};
    // Seen through the gap: the sight line to (3, 0, 5) crosses z = 3 at x = 1.8, between the walls.
    OracleAnswer truth = ask_oracle(box, walls.made.eye, shadows_of(walls.made));
    ASSERT_EQ(int(truth.visibility), int(Visibility::partial));
    // Where the box is on both sides of a plane and misses the fragment, the paper calls it invisible.
    EXPECT_TRUE(published_rule_hides(walls, box)) << "this box is the counter-example to the published rule";
    for (TreeForm form : {TreeForm::plain, TreeForm::modified})
        EXPECT_EQ(int(walls.tree(form).visibility_by_faces(box)), int(Visibility::partial));
    OcclusionTree tree = walls.tree(TreeForm::modified);
    EXPECT_NE(int(tree.visibility_unsplit(box, LeafTest::pyramid)), int(Visibility::invisible));
    EXPECT_NE(int(tree.visibility_unsplit(box, LeafTest::conservative)), int(Visibility::invisible));
}

TEST(OcclusionTreeKnownAnswers, the_pyramid_test_hides_what_two_walls_hide_together) {
    // Behind the near wall, whose far neighbour begins where the near one ends; the box crosses the far one's plane.
    Walls walls;
    walls.add(-4, 1, -4, 4, 4);
    walls.add(2, 8, -8, 8, 8); // both edges lie on the sight line x : z = 1 : 4
    Box3d box{{0, -1, 7}, {1.5, 1, 8.5}};
    ASSERT_EQ(int(ask_oracle(box, walls.made.eye, shadows_of(walls.made)).visibility), int(Visibility::invisible));
    OcclusionTree tree = walls.tree(TreeForm::modified);
    EXPECT_EQ(int(tree.visibility_by_faces(box)), int(Visibility::invisible));
    EXPECT_EQ(int(tree.visibility_unsplit(box, LeafTest::pyramid)), int(Visibility::invisible));
    EXPECT_NE(int(tree.visibility_unsplit({{0, -1, 7}, {3, 1, 8.5}}, LeafTest::pyramid)), int(Visibility::invisible));
}

TEST(OcclusionTreeKnownAnswers, states) {
    Walls walls;
    walls.add(-2, 2, -2, 2, 4);
    OcclusionTree tree = walls.tree(TreeForm::plain);
    EXPECT_EQ(int(tree.visibility_by_faces({{-1, -1, 6}, {1, 1, 7}})), int(Visibility::invisible));
    EXPECT_EQ(int(tree.visibility_by_faces({{-1, -1, 2}, {1, 1, 3}})), int(Visibility::full)) << "in front";
    EXPECT_EQ(int(tree.visibility_by_faces({{5, -1, 4}, {6, 1, 5}})), int(Visibility::full)) << "beside";
    EXPECT_EQ(int(tree.visibility_by_faces({{1, -1, 5}, {4, 1, 6}})), int(Visibility::partial)) << "round the edge";
    EXPECT_EQ(int(tree.visibility_by_faces({{-1, -1, 4}, {1, 1, 4}})), int(Visibility::full)) << "in the wall's plane";
    EXPECT_EQ(int(tree.visibility_by_faces({{-1, -1, 4}, {1, 1, 9}})), int(Visibility::full)) << "touching from behind";
    EXPECT_EQ(int(tree.visibility_by_faces({{-1, -1, -1}, {1, 1, 9}})), int(Visibility::partial)) << "round the eye";
    EXPECT_EQ(int(tree.visibility_by_faces({{0, 0, 9}, {0, 0, 9}})), int(Visibility::partial)) << "a point";
    EXPECT_EQ(int(tree.visibility_by_faces({{0, -1, 6}, {1, 1, 6}})), int(Visibility::invisible)) << "a sheet";
}

TEST(OcclusionTreeKnownAnswers, the_modified_tree_leaves_out_shared_edges) {
    // Four quads round a corner, and T-junctions: every inner edge is in the tree once.
    Walls walls;
    walls.add(-2, 0, -2, 0, 4);
    walls.add(0, 2, -2, 0, 4);
    walls.add(-2, 0, 0, 2, 4);
    walls.add(0, 2, 0, 2, 4);
    OcclusionTree plain = walls.tree(TreeForm::plain), modified = walls.tree(TreeForm::modified);
    EXPECT_EQ(plain.fragment_count(), 4u);
    EXPECT_EQ(plain.node_count(), 16u);
    // First quad 4; its two neighbours flag one edge each; the last one lies beyond two planes that hold its edges.
    EXPECT_LT(modified.node_count(), 13u);
    for (OcclusionTree* tree : {&plain, &modified})
        EXPECT_EQ(int(tree->visibility_by_faces({{-1, -1, 5}, {1, 1, 6}})), int(Visibility::invisible)) << "no cracks";
}

TEST(OcclusionTreeKnownAnswers, memory_that_runs_out_hides_less_but_nothing_wrong) {
    Random random(5);
    for (int trial = 0; trial < 40; ++trial) {
        Configuration made = general_configuration(random, 12, 20, true);
        TreeOccluders occluders = TreeOccluders::build(made.set);
        TreeBuilder builder(occluders, 12);
        std::vector<std::uint32_t> all{0, 1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11};
        OcclusionTree tree({16, 60, 8});
        tree.begin(made.eye, 10, TreeForm::plain);
        builder.insert(tree, all, TreeBuilder::Order::binary_space_partition);
        EXPECT_LE(tree.node_count(), 16u);
        auto shadows = shadows_of(made);
        for (const Box3d& box : made.boxes) {
            if (tree.visibility_by_faces(box) == Visibility::invisible) {
                EXPECT_EQ(int(ask_oracle(box, made.eye, shadows).visibility), int(Visibility::invisible));
            }
        }
    }
}

} // namespace
} // namespace antumbra
