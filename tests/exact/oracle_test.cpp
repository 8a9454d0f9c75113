// Laws with random search: the fast form against the rational oracle, three starts against each other, and answers
// that must not change when the question is asked differently.
#include "exact/families.hpp"

#include <chrono>
#include <cstdlib>

namespace antumbra::exact::testing {
namespace {

struct Tally {
    std::uint64_t queries = 0, hidden = 0, verified_witnesses = 0, verified_trees = 0, disagreements = 0;
    QueryCounters counters;
};

/// One query in all forms, each answer proved.
void compare(const Case& c, bool certificate, Tally& tally) {
    QueryResult reference = ask(c, oracle());
    QueryOptions hull = fast();
    hull.start = Start::hull;
    QueryOptions no_rays = fast();
    no_rays.rays = 0;
    ++tally.queries;
    tally.hidden += reference.answer == Answer::hidden;
    QueryOptions last = tally.queries % 3 != 0 ? fast() : as_published(tally.queries % 2 == 0 ? 0 : 60);
    for (const QueryOptions& options : {no_rays, hull, certificate ? with_certificate() : fast(), last}) {
        QueryResult result = ask(c, options);
        tally.counters.add(result.counters);
        tally.disagreements += result.answer != reference.answer;
        if (result.answer == Answer::visible) {
            Status status = certify::verify_witness({c.s, true}, {c.t, true}, c.occluders, witness_of(result));
            ++tally.verified_witnesses;
            EXPECT_TRUE(status.ok()) << status.message();
        } else if (options.certificate) {
            std::vector<Polygon> blockers;
            for (OccluderId id : result.blockers)
                blockers.push_back(c.occluders[id]);
            Status status = certify::verify_hidden({c.s, true}, {c.t, true}, blockers, result.tree);
            ++tally.verified_trees;
            EXPECT_TRUE(status.ok()) << status.message();
        }
    }
    ASSERT_EQ(tally.disagreements, 0u);
    ASSERT_EQ(tally.counters.broken, 0u);
}

/// Triangles in pairs that share an edge, the two of a pair also as one disc, bent at will.
struct BentPairs final : OccluderSource {
    std::vector<Polygon> triangles, discs;
    Polygon at;

    explicit BentPairs(const Case& c, Random& random) {
        for (const Polygon& o : c.occluders) {
            const std::vector<GridPoint>& v = o.corners;
            if (v.size() != 3)
                continue;
            GridPoint d = v[0] + v[2] - v[1];
            for (int k = 0; k < 3; ++k)
                d[k] += static_cast<std::int64_t>(random.below(9)) - 4;
            GridPoint normal = cross(v[2] - v[0], d - v[0]);
            if (normal.x == 0 && normal.y == 0 && normal.z == 0)
                continue;
            triangles.push_back(o);
            triangles.push_back({{v[0], v[2], d}, o.both_sides});
            discs.push_back({{v[0], v[1], v[2], d}, o.both_sides});
        }
    }
    OccluderId disc(std::size_t k) const { return static_cast<OccluderId>(triangles.size() + k); }
    bool near_segment(const Vec3d&, const Vec3d&, std::size_t, std::vector<OccluderId>& found) override {
        for (std::size_t k = 0; k < discs.size(); ++k)
            for (OccluderId id : {disc(k), static_cast<OccluderId>(2 * k), static_cast<OccluderId>(2 * k + 1)})
                found.push_back(id);
        return false;
    }
    const Polygon& polygon(OccluderId id) override { return id < triangles.size() ? triangles[id] : discs[id - triangles.size()]; }
    bool is_flat(OccluderId id) override { return id < triangles.size(); } // those that happen to be flat may be called bent
    OccluderId whole_of(OccluderId id) override { return id < triangles.size() ? disc(id / 2) : id; }
};

/// Discs against the oracle, which sees their triangles only. False: a disagreement.
bool discs_agree(Random& random, std::uint64_t& hidden, std::uint64_t& used) {
    Case c = draw(random);
    BentPairs pairs(c, random);
    OccluderList list(pairs.triangles);
    Query query;
    QueryResult reference = query.run(c.s, c.t, list, oracle()), result = query.run(c.s, c.t, pairs, fast());
    hidden += reference.answer == Answer::hidden;
    for (OccluderId id : result.blockers)
        used += id >= pairs.triangles.size();
    if (result.answer == Answer::visible) {
        EXPECT_TRUE(certify::verify_witness({c.s, true}, {c.t, true}, pairs.triangles, witness_of(result)).ok());
    }
    return result.answer == reference.answer;
}

TEST(Oracle, BentDiscsOfTrianglesAgree) {
    Random random(15);
    std::uint64_t hidden = 0, used = 0;
    for (int k = 0; k < 3000; ++k)
        ASSERT_TRUE(discs_agree(random, hidden, used)) << k;
    EXPECT_GT(hidden, 500u);
    EXPECT_GT(used, 1000u);
}

TEST(Oracle, TheFastFormAgreesOnRandomAndDegenerateQueries) {
    Tally tally;
    Random random(20261122);
    for (int k = 0; k < 2000; ++k) {
        Case c = draw(random);
        compare(c, k % 8 == 0, tally);
        if (HasFatalFailure())
            FAIL() << "case " << k;
    }
    EXPECT_GT(tally.hidden, 300u);
    EXPECT_GT(tally.verified_trees, 50u);
    EXPECT_GT(tally.counters.arithmetic.signs_residue, 100u); // the zero proofs are in use
    EXPECT_GT(tally.counters.sphere_rejected, 1000u);         // and so is the published form
}

/// ANTUMBRA_SOAK=SECONDS runs the comparison for that long with a seed from the clock, and prints the counts.
TEST(Oracle, Soak) {
    const char* seconds = std::getenv("ANTUMBRA_SOAK");
    if (!seconds)
        GTEST_SKIP() << "set ANTUMBRA_SOAK to a number of seconds";
    auto start = std::chrono::steady_clock::now();
    std::uint64_t seed = static_cast<std::uint64_t>(start.time_since_epoch().count());
    std::printf("seed %llu\n", static_cast<unsigned long long>(seed));
    Random random(seed);
    Tally tally;
    std::uint64_t discs = 0, discs_hidden = 0, discs_used = 0;
    while (std::chrono::steady_clock::now() - start < std::chrono::seconds(std::atoi(seconds))) {
        Case c = draw(random);
        compare(c, tally.queries % 16 == 0, tally);
        if (HasFatalFailure())
            FAIL() << "query " << tally.queries;
        if (tally.queries % 4 == 0) {
            ASSERT_TRUE(discs_agree(random, discs_hidden, discs_used)) << "discs beside query " << tally.queries;
            ++discs;
        }
    }
    std::printf("queries with bent discs %llu hidden %llu discs subtracted %llu\n", (unsigned long long)discs,
                (unsigned long long)discs_hidden, (unsigned long long)discs_used);
    const ArithmeticCounters& a = tally.counters.arithmetic;
    std::printf("queries %llu hidden %llu disagreements %llu witnesses verified %llu trees verified %llu\n"
                "signs %llu small %llu residue %llu exact %llu, triples %llu, exact witnesses %llu, widened %llu\n",
                (unsigned long long)tally.queries, (unsigned long long)tally.hidden,
                (unsigned long long)tally.disagreements, (unsigned long long)tally.verified_witnesses,
                (unsigned long long)tally.verified_trees, (unsigned long long)a.signs,
                (unsigned long long)a.signs_small, (unsigned long long)a.signs_residue,
                (unsigned long long)a.signs_exact, (unsigned long long)tally.counters.triples,
                (unsigned long long)tally.counters.exact_witnesses, (unsigned long long)tally.counters.widened);
}

void shuffle(std::vector<Polygon>& polygons, Random& random) {
    for (std::size_t k = polygons.size(); k > 1; --k)
        std::swap(polygons[k - 1], polygons[random.below(static_cast<std::uint32_t>(k))]);
}

TEST(Metamorphic, SwappedEndsAndShuffledOccludersGiveTheSameAnswer) {
    Random random(11);
    for (int k = 0; k < 1500; ++k) {
        Case c = draw(random), d = c;
        std::swap(d.s, d.t);
        shuffle(d.occluders, random);
        for (Polygon& o : d.occluders) // lines run the other way now
            std::reverse(o.corners.begin(), o.corners.end());
        ASSERT_EQ(ask(c, fast()).answer, ask(d, fast()).answer) << k;
    }
}

TEST(Metamorphic, CuttingOccludersInPiecesChangesNothing) {
    Random random(12);
    for (int k = 0; k < 800; ++k) {
        Case c = draw(random);
        for (auto* polygon : {&c.s, &c.t})
            for (GridPoint& p : *polygon)
                p = p * 4;
        Case d = c;
        d.occluders.clear();
        for (Polygon& o : c.occluders) {
            for (GridPoint& p : o.corners)
                p = p * 4;
            const auto& v = o.corners;
            if (v.size() != 3) {
                d.occluders.push_back(o);
                continue;
            }
            GridPoint a{(v[0].x + v[1].x) / 2, (v[0].y + v[1].y) / 2, (v[0].z + v[1].z) / 2}; // exact: multiples of 4
            d.occluders.push_back({{v[0], a, v[2]}, o.both_sides});
            GridPoint b{(a.x + v[2].x) / 2, (a.y + v[2].y) / 2, (a.z + v[2].z) / 2};
            d.occluders.push_back({{a, v[1], b}, o.both_sides});
            d.occluders.push_back({{b, v[1], v[2]}, o.both_sides});
        }
        ASSERT_EQ(ask(c, fast()).answer, ask(d, fast()).answer) << k;
    }
}

TEST(Metamorphic, MoreOccludersNeverRevealAndSmallerPolygonsNeverSeeMore) {
    Random random(13);
    for (int k = 0; k < 800; ++k) {
        Case c = draw(random);
        for (auto* polygon : {&c.s, &c.t})
            for (GridPoint& p : *polygon)
                p = p * 2;
        for (Polygon& o : c.occluders)
            for (GridPoint& p : o.corners)
                p = p * 2;
        if (ask(c, fast()).answer != Answer::hidden)
            continue;
        Case more = c;
        more.occluders.push_back(draw(random).occluders.front());
        ASSERT_EQ(ask(more, fast()).answer, Answer::hidden) << k;
        Case smaller = c;
        smaller.s[0] = {(c.s[0].x + c.s[1].x) / 2, (c.s[0].y + c.s[1].y) / 2, (c.s[0].z + c.s[1].z) / 2};
        ASSERT_EQ(ask(smaller, fast()).answer, Answer::hidden) << k;
    }
}

TEST(Metamorphic, MovingAndScalingOnTheGridChangesNothing) {
    Random random(14);
    for (int k = 0; k < 500; ++k) {
        Case c = tiny_soup(random, 16, 12, true), d = c;
        GridPoint by{1 << 22, -(1 << 21), 12345};
        auto move = [&](GridPoint& p) { p = GridPoint{p.z, p.x, p.y} * 1001 + by; };
        for (auto* polygon : {&d.s, &d.t})
            for (GridPoint& p : *polygon)
                move(p);
        for (Polygon& o : d.occluders)
            for (GridPoint& p : o.corners)
                move(p);
        ASSERT_EQ(ask(c, fast()).answer, ask(d, fast()).answer) << k;
    }
}

TEST(Query, TheSameQuestionGivesTheSameWitness) {
    Random random(15);
    for (int k = 0; k < 200; ++k) {
        Case c = draw(random);
        QueryResult a = ask(c, fast()), b = ask(c, fast());
        ASSERT_EQ(a.answer, b.answer);
        if (a.answer == Answer::visible) {
            ASSERT_EQ(a.witness.p, b.witness.p);
            ASSERT_EQ(a.witness.q, b.witness.q);
        }
        ASSERT_EQ(a.blockers, b.blockers);
    }
}

TEST(Query, ABudgetThatRunsOutIsUndecidedNotHidden) {
    Random random(16);
    Case c = square_and_triangle(random);
    add_wall(c, random, 6, 0.6);
    QueryOptions options;
    options.max_pieces = 2;
    EXPECT_EQ(ask(c, options).answer, Answer::undecided);
    EXPECT_EQ(ask(c, fast()).answer, Answer::hidden);
}

} // namespace
} // namespace antumbra::exact::testing
