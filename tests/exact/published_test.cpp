// The parts of the published form: faces, their splits, complete line spaces. (Its answers: oracle_test.cpp.)
#include "families.hpp"

#include "bake/exact/cell.hpp"
#include "bake/exact/complex.hpp"
#include "bake/exact/face_lattice.hpp"
#include "bake/exact/start.hpp"

#include <gtest/gtest.h>

#include <set>

namespace antumbra::exact::testing {
namespace {

Vec3d to_vector(const GridPoint& p) { return {double(p.x), double(p.y), double(p.z)}; }

constexpr std::array<std::size_t, 6> kPrismFaces = {24, 60, 62, 33, 9, 1};

Case quad_to_triangle() {
    Case c;
    c.s = {{0, 0, 0}, {100, 0, 0}, {100, 100, 0}, {0, 100, 0}};
    c.t = {{10, 20, 300}, {33, 90, 310}, {80, 17, 305}};
    face_each_other(c);
    return c;
}

struct Started {
    LineStore<true> store;
    Frame frame;
    Polytope<2> polytope;
    bool ready = false;

    explicit Started(const Case& c, bool published) {
        if (!frame.set(c.s, c.t))
            return; // nothing faces each other
        ready = true;
        store.reset(frame.scale_bits);
        frame.fill(store);
        EXPECT_EQ(published ? published_start(store, frame, polytope) : prism_start(store, frame, polytope),
                  StartResult::ready);
    }
};

TEST(FaceLattice, TheLinesFromAQuadToATriangleHave189Faces) {
    for (bool published : {false, true}) {
        Started start(quad_to_triangle(), published);
        FaceLattice lattice = enumerate_faces(start.polytope);
        for (std::size_t d = 0; d < 6; ++d)
            EXPECT_EQ(lattice.faces[d].size(), kPrismFaces[d]) << d;
        EXPECT_EQ(lattice.count(), 189u);
        EXPECT_FALSE(is_broken(lattice));
        EXPECT_EQ(start.polytope.edges.size(), 60u);
    }
}

/// Random hyperplanes split both representations; the same vertices and as many edges must come out, degenerate or not.
TEST(FaceLattice, SplitsAsTheSkeletonDoes) {
    Random random(5);
    std::uint64_t splits = 0, on_plane = 0;
    for (int k = 0; k < 150; ++k) {
        Case c = draw(random);
        Started start(c, true);
        if (!start.ready)
            continue;
        Polytope<2> skeleton = start.polytope, in, out;
        FaceLattice lattice = enumerate_faces(skeleton), lattice_in, lattice_out;
        ASSERT_FALSE(is_broken(lattice));
        std::uint64_t known = 0;
        for (const Polygon& occluder : c.occluders)
            for (std::size_t i = 0; i < occluder.corners.size(); ++i) {
                GridPoint a = occluder.corners[i] - start.frame.origin,
                          b = occluder.corners[(i + 1) % occluder.corners.size()] - start.frame.origin;
                if (a == b)
                    continue;
                HalfSpace h = start.store.edge(a, b);
                Split result = split(start.store, skeleton, h.hyperplane, h.sign, in, out, known);
                Crossing crossing = classify(start.store, lattice, h.hyperplane, h.sign);
                int side = side_of_sphere(start.store, lattice, h.hyperplane);
                ASSERT_EQ(result == Split::both, crossing.positive && crossing.negative);
                if (side != 0) {
                    ASSERT_NE(result, Split::both);
                }
                if (result != Split::both)
                    continue;
                ++splits;
                on_plane += std::count(crossing.of.begin(), crossing.of.end(), 0) > 0;
                split(start.store, lattice, h.hyperplane, crossing, lattice_in, lattice_out);
                for (auto [mine, theirs] : {std::pair(&in, &lattice_in), std::pair(&out, &lattice_out)}) {
                    ASSERT_FALSE(is_broken(*theirs));
                    ASSERT_EQ(mine->vertices.size(), theirs->vertices.size());
                    ASSERT_EQ(mine->edges.size(), theirs->faces[1].size());
                }
                bool first = random.below(2) != 0;
                skeleton = first ? in : out;
                lattice = first ? lattice_in : lattice_out;
                set_sphere(start.store, {0, 0, 0, 0, 0, 0}, lattice);
                ASSERT_LT(lattice.radius, 0); // no chart, no sphere
            }
    }
    EXPECT_GT(splits, 300u);
    EXPECT_GT(on_plane, 50u);
}

TEST(LineSpace, HoldsEveryLineThatReachesAPartOfTheTarget) {
    Random random(9);
    std::uint64_t visible_parts = 0, rejected = 0, parts = 0;
    for (int k = 0; k < 120; ++k) {
        Case c = draw(random);
        for (auto* polygon : {&c.s, &c.t})
            for (GridPoint& p : *polygon)
                p = p * 4;
        for (Polygon& o : c.occluders)
            for (GridPoint& p : o.corners)
                p = p * 4;
        QueryOptions options = as_published(0);
        options.complete = true;
        QueryResult whole = ask(c, options);
        if (whole.answer != Answer::visible)
            continue;
        ASSERT_TRUE(whole.unobstructed);
        ASSERT_GT(whole.unobstructed->size(), 0u);
        // Quarter the first triangle of the target.
        const GridPoint v[3] = {c.t[0], c.t[1], c.t[2]};
        auto middle = [](const GridPoint& a, const GridPoint& b) {
            return GridPoint{(a.x + b.x) / 2, (a.y + b.y) / 2, (a.z + b.z) / 2};
        };
        GridPoint m[3] = {middle(v[0], v[1]), middle(v[1], v[2]), middle(v[2], v[0])};
        for (const auto& t : {std::array{v[0], m[0], m[2]}, std::array{m[0], v[1], m[1]}, std::array{m[2], m[1], v[2]}, std::array{m[0], m[1], m[2]}}) {
            Case part = c;
            part.t.assign(t.begin(), t.end());
            bool visible = ask(part, oracle()).answer == Answer::visible;
            bool may = whole.unobstructed->may_cross(part.t);
            ASSERT_TRUE(may || !visible) << k;
            ++parts;
            visible_parts += visible;
            rejected += !may;
        }
    }
    EXPECT_GT(visible_parts, 50u);
    EXPECT_GT(rejected, 10u); // it is worth asking
    EXPECT_GT(parts, visible_parts + rejected);
}

TEST(LineSpace, ItsConesLieAmongTheLinesThatCrossTheSource) {
    Random random(10);
    Case c = square_and_triangle(random);
    add_wall(c, random, 4, 0.6);
    c.occluders.erase(c.occluders.begin() + 12);
    QueryOptions options = as_published(20);
    options.complete = true;
    QueryResult whole = ask(c, options);
    ASSERT_EQ(whole.answer, Answer::visible);
    for (std::size_t k = 0; k < whole.unobstructed->size(); ++k) {
        std::vector<Six> cone = whole.unobstructed->cone(k);
        EXPECT_GE(cone.size(), 6u);
        // Every vertex lies in the closed prism of lines from S to T: on the inner side of all edges of S.
        for (const Six& x : cone)
            for (std::size_t i = 0; i < c.s.size(); ++i) {
                SmallSix e = pluecker_through(c.s[i], c.s[(i + 1) % c.s.size()]);
                Integer sum = 0;
                for (std::size_t d = 0; d < 6; ++d)
                    sum += x[d] * e[(d + 3) % 6];
                EXPECT_GE(sum.sign(), 0);
            }
    }
}

/// The complex is complete and no more: a line between the polygons lies in a piece iff nothing blocks it.
TEST(LineSpace, ItsPiecesAreAllUnblockedLinesAndNoOthers) {
    Random random(12);
    int asked = 0, clear = 0, blocked = 0;
    double shares = 0;
    for (int k = 0; k < 40; ++k) {
        Case c = square_and_triangle(random);
        add_wall(c, random, 2 + int(random.below(3)), 0.6);
        for (int missing = 0; missing < 3; ++missing)
            c.occluders.erase(c.occluders.begin() + random.below(std::uint32_t(c.occluders.size())));
        QueryOptions options = as_published(k % 2 ? 20 : 0);
        options.complete = true;
        QueryResult whole = ask(c, options);
        if (whole.answer != Answer::visible)
            continue;
        std::vector<ComplexPiece> pieces = complete_complex(*whole.unobstructed);
        ASSERT_EQ(pieces.size(), whole.unobstructed->size());
        for (const ComplexPiece& piece : pieces) {
            auto f = piece.faces;
            EXPECT_EQ(std::int64_t(f[0] - f[1] + f[2] - f[3] + f[4]), 2); // Euler, dimension 5
            EXPECT_EQ(piece.facets.size(), f[4]);
            for (const ComplexFacet& facet : piece.facets) {
                EXPECT_GE(facet.vertices.size(), 5u);
                std::size_t on = 0;
                for (std::uint32_t v = 0; v < piece.vertices.size(); ++v) {
                    Integer side = 0;
                    for (std::size_t i = 0; i < 6; ++i)
                        side += facet.hyperplane[i] * piece.vertices[v][i];
                    EXPECT_GE(side.sign(), 0);
                    on += side == 0;
                }
                EXPECT_EQ(on, facet.vertices.size());
            }
        }
        auto inside = [&](const std::vector<GridPoint>& polygon) {
            double u = random.uniform(0.02, 0.98), v = random.uniform(0.02, 0.98);
            if (u + v > 1)
                u = 1 - u, v = 1 - v;
            Vec3d a = to_vector(polygon[0]), b = to_vector(polygon[1]), d = to_vector(polygon[2]);
            return a + (b - a) * u + (d - a) * v;
        };
        for (int line = 0; line < 200; ++line) {
            Vec3d p = inside(c.s), q = inside(c.t);
            bool free = true, doubtful = false;
            for (const Polygon& o : c.occluders) {
                double least = 1e300, most = -1e300;
                for (int e = 0; e < 3; ++e) {
                    Vec3d a = to_vector(o.corners[e]), b = to_vector(o.corners[(e + 1) % 3]);
                    double volume = dot(q - p, cross(a - p, b - p)) / (length(q - p) * length(b - a));
                    least = std::min(least, volume / double(kOne));
                    most = std::max(most, volume / double(kOne));
                }
                free &= !(least > 0 || most < 0);
                doubtful |= std::min(std::abs(least), std::abs(most)) < 1e-4; // near an edge: doubles do not decide
            }
            if (doubtful)
                continue;
            bool held = std::any_of(pieces.begin(), pieces.end(), [&](const ComplexPiece& piece) { return piece.holds(p, q); });
            EXPECT_EQ(held, free) << k << " " << line;
            (free ? clear : blocked) += 1;
        }
        double share = visible_share(pieces, c.s, c.t, 500, 1);
        EXPECT_LT(share, 1);
        shares += share;
        ++asked;
    }
    EXPECT_GT(asked, 20);
    EXPECT_GT(shares, 1);
    EXPECT_GT(clear, 200);
    EXPECT_GT(blocked, 200);
}

TEST(Published, AnOccluderChosenByTheRaysIsCountedOnce) {
    Random random(11);
    Case c = square_and_triangle(random);
    add_wall(c, random, 3, 0.6);
    QueryResult result = ask(c, as_published(200));
    EXPECT_EQ(result.answer, Answer::hidden);
    EXPECT_GT(result.effective, 1u);
    EXPECT_LE(result.effective, 18u);
    EXPECT_LE(std::set<OccluderId>(result.blockers.begin(), result.blockers.end()).size(), 18u);
}

} // namespace
} // namespace antumbra::exact::testing
