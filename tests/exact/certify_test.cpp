// The verifier must refuse what is not proved.
#include "exact/families.hpp"

namespace antumbra::exact::testing {
namespace {

Case covered() {
    Case c;
    c.s = {{0, 0, 0}, {4, 0, 0}, {0, 4, 0}};
    c.t = {{0, 0, 8}, {0, 4, 8}, {4, 0, 8}};
    add_triangle(c, {-9, -9, 4}, {30, -9, 4}, {-9, 30, 4});
    return c;
}

certify::WitnessSegment segment(Vec3<int> p, Vec3<int> q, int scale = 1) {
    auto part = [&](int v) { return certify::Rational(v, scale); };
    return {{part(p.x), part(p.y), part(p.z)}, {part(q.x), part(q.y), part(q.z)}};
}

bool accepts(const Case& c, const certify::WitnessSegment& w) {
    return certify::verify_witness({c.s, true}, {c.t, true}, c.occluders, w).ok();
}

TEST(VerifyWitness, AcceptsAClearSegmentAndRefusesABlockedOne) {
    Case c = covered();
    EXPECT_FALSE(accepts(c, segment({1, 1, 0}, {1, 1, 8})));
    c.occluders.clear();
    EXPECT_TRUE(accepts(c, segment({1, 1, 0}, {1, 1, 8})));
}

TEST(VerifyWitness, RefusesEndsOnTheRimOrOffTheFace) {
    Case c = covered();
    c.occluders.clear();
    EXPECT_FALSE(accepts(c, segment({0, 1, 0}, {1, 1, 8})));
    EXPECT_FALSE(accepts(c, segment({1, 1, 0}, {2, 2, 8})));
    EXPECT_FALSE(accepts(c, segment({1, 1, 1}, {1, 1, 8})));
    EXPECT_FALSE(accepts(c, segment({5, 5, 0}, {1, 1, 8})));
}

TEST(VerifyWitness, RefusesASegmentThatTouchesAnEdgeOrACorner) {
    Case c = covered();
    c.occluders.clear();
    add_triangle(c, {1, 0, 4}, {1, 4, 4}, {-3, 2, 4}); // its edge x = 1
    EXPECT_FALSE(accepts(c, segment({1, 1, 0}, {1, 1, 8})));
    EXPECT_TRUE(accepts(c, segment({5, 4, 0}, {5, 4, 32}, 4)));
    c.occluders.clear();
    add_triangle(c, {1, 1, 4}, {-1, 0, 4}, {-1, 2, 5});
    EXPECT_FALSE(accepts(c, segment({1, 1, 0}, {1, 1, 8})));
}

TEST(VerifyWitness, TellsWhetherAnOccluderInWhosePlaneTheSegmentLiesIsInTheWay) {
    auto beside = [](Vec3<int> a, Vec3<int> b, Vec3<int> d) {
        Case c = covered();
        c.occluders.clear();
        auto corner = [](Vec3<int> p) { return GridPoint{p.x, p.y, p.z}; };
        c.occluders.push_back({{corner(a), corner(b), corner(d)}, true});
        return accepts(c, segment({1, 1, 0}, {1, 1, 8}));
    };
    EXPECT_TRUE(beside({1, 2, 2}, {1, 4, 2}, {1, 2, 6}));   // all on one side of the segment
    EXPECT_TRUE(beside({1, -3, 2}, {1, 0, 2}, {1, 0, 6}));
    EXPECT_FALSE(beside({1, 1, 2}, {1, 4, 2}, {1, 2, 6}));  // a corner on it
    EXPECT_FALSE(beside({1, 1, 2}, {1, 4, 2}, {1, 1, 6}));  // an edge along it
    EXPECT_FALSE(beside({1, 0, 2}, {1, 4, 2}, {1, 2, 6}));  // across it
    EXPECT_FALSE(beside({1, -9, 1}, {1, 9, 1}, {1, 0, 7})); // most of it inside
    // Clipped to the fronts of both planes a wall ends where the segment does: the end of one lies in the other's.
    EXPECT_FALSE(beside({1, 1, -3}, {1, 4, -3}, {1, 1, 1}));
}

TEST(VerifyWitness, LooksAtTheSidesOfOccluders) {
    Case c = covered();
    c.occluders[0].both_sides = false; // counter-clockwise from above: its front looks at T
    EXPECT_TRUE(accepts(c, segment({1, 1, 0}, {1, 1, 8})));
    std::swap(c.occluders[0].corners[0], c.occluders[0].corners[1]);
    EXPECT_FALSE(accepts(c, segment({1, 1, 0}, {1, 1, 8})));
}

TEST(VerifyWitness, RefusesBacks) {
    Case c = covered();
    c.occluders.clear();
    std::swap(c.t[0], c.t[1]);
    EXPECT_FALSE(accepts(c, segment({1, 1, 0}, {1, 1, 8})));
}

Status judge(const Case& c, const certify::HiddenTree& tree) {
    return certify::verify_hidden({c.s, true}, {c.t, true}, c.occluders, tree);
}

certify::HiddenTree one_leaf(int crossing) {
    certify::HiddenTree tree;
    tree.nodes.resize(1);
    tree.nodes[0].kind = certify::HiddenTree::Kind::blocked;
    tree.nodes[0].crossing = static_cast<std::int8_t>(crossing);
    return tree;
}

TEST(VerifyHidden, AcceptsASingleCoverInItsDirectionOnly) {
    EXPECT_TRUE(judge(covered(), one_leaf(1)).ok());
    EXPECT_FALSE(judge(covered(), one_leaf(-1)).ok());
}

TEST(VerifyHidden, RefusesACoverFromTheSideThatDoesNotBlock) {
    Case c = covered();
    c.occluders[0].both_sides = false;
    EXPECT_FALSE(judge(c, one_leaf(1)).ok());
}

TEST(VerifyHidden, RefusesAnOccluderThatLeavesAGap) {
    Case c = covered();
    c.occluders[0].corners[0] = {1, 1, 4};
    EXPECT_FALSE(judge(c, one_leaf(1)).ok());
}

TEST(VerifyHidden, RefusesAnOccluderBehindTheTarget) {
    Case c = covered();
    for (GridPoint& p : c.occluders[0].corners)
        p.z = 9;
    EXPECT_FALSE(judge(c, one_leaf(1)).ok());
}

TEST(VerifyHidden, RefusesAnEmptyTreeAndAFalseEmptyLeaf) {
    certify::HiddenTree tree;
    EXPECT_FALSE(judge(covered(), tree).ok());
    tree.nodes.resize(1);
    EXPECT_FALSE(judge(covered(), tree).ok());
}

TEST(VerifyHidden, RefusesTamperedTreesOfRealProofs) {
    Random random(21);
    int refused = 0, tampered = 0;
    for (int k = 0; k < 12; ++k) {
        Case c = square_and_triangle(random);
        add_wall(c, random, 2, 0.6);
        QueryOptions options = with_certificate();
        options.rays = 0;
        QueryResult result = ask(c, options);
        ASSERT_EQ(result.answer, Answer::hidden);
        Case named = c;
        named.occluders.clear();
        for (OccluderId id : result.blockers)
            named.occluders.push_back(c.occluders[id]);
        ASSERT_TRUE(judge(named, result.tree).ok());
        for (std::size_t n = 0; n < result.tree.nodes.size(); ++n) {
            certify::HiddenTree tree = result.tree;
            if (tree.nodes[n].kind != certify::HiddenTree::Kind::blocked)
                continue;
            tree.nodes[n].kind = certify::HiddenTree::Kind::empty; // real lines run through a piece that was blocked
            ++tampered;
            refused += !judge(named, tree).ok();
            tree = result.tree;
            named.occluders[tree.nodes[n].occluder].corners[0] = {0, 0, -kOne}; // move a blocker behind S
            ++tampered;
            refused += !judge(named, tree).ok();
            named.occluders[tree.nodes[n].occluder].corners[0] = c.occluders[result.blockers[tree.nodes[n].occluder]].corners[0];
        }
    }
    EXPECT_EQ(refused, tampered);
    EXPECT_GT(tampered, 20);
}

TEST(VerifyHidden, RefusesLoopsAndMissingChildren) {
    certify::HiddenTree tree;
    tree.nodes.resize(1);
    tree.nodes[0].kind = certify::HiddenTree::Kind::split;
    tree.nodes[0].hyperplane[0] = 1;
    EXPECT_FALSE(judge(covered(), tree).ok());
    tree.nodes[0].child[0] = tree.nodes[0].child[1] = 0;
    EXPECT_FALSE(judge(covered(), tree).ok());
}

} // namespace
} // namespace antumbra::exact::testing
