#include "bake/exact/quadric.hpp"
#include "bake/exact/residues.hpp"
#include "base/random.hpp"

#include <boost/multiprecision/miller_rabin.hpp>
#include <gtest/gtest.h>
#include <rapidcheck.h>

namespace antumbra::exact {
namespace {

Integer random_integer(Random& random, int bits) {
    Integer value = 0;
    for (int k = 0; k < bits; k += 32)
        value = (value << 32) + random.next_u32();
    value >>= static_cast<unsigned>((bits + 31) / 32 * 32 - bits);
    return random.below(2) ? value : Integer(-value);
}

Six random_six(Random& random, int bits) {
    Six x;
    for (Integer& c : x)
        c = random_integer(random, bits);
    return x;
}

TEST(Pluecker, LinesLieOnTheQuadricAndMeetingLinesHaveNoSide) {
    Vec3<std::int64_t> a{1, 2, 3}, b{-4, 5, 7}, c{9, -8, 2};
    EXPECT_EQ(quadric(pluecker_through(a, b)), 0);
    EXPECT_EQ(side(pluecker_through(a, b), pluecker_through(c, b)), 0);
}

TEST(Pluecker, ALineAlongTheNormalHasPositiveSidesToCounterClockwiseEdges) {
    Vec3<std::int64_t> corners[3] = {{0, 0, 0}, {4, 0, 0}, {0, 4, 0}};
    auto up = pluecker_through<std::int64_t>({1, 1, -1}, {1, 1, 1});
    for (int k = 0; k < 3; ++k)
        EXPECT_GT(side(pluecker_through(corners[k], corners[(k + 1) % 3]), up), 0);
}

TEST(Residues, ThePrimesArePrimeDistinctAndTheirProductExceedsTheStatedBound) {
    Integer product = 1;
    for (std::uint64_t p : residue_primes()) {
        EXPECT_TRUE(boost::multiprecision::miller_rabin_test(boost::multiprecision::cpp_int(p), 30));
        EXPECT_LT(p, std::uint64_t(1) << 49);
        EXPECT_NE(product % p, 0);
        product *= p;
    }
    EXPECT_GT(product, Integer(1) << kProvenBits);
}

TEST(Residues, DotAgreesWithItsPlainTwinAndWithIntegers) {
    rc::check([](std::uint64_t seed) {
        Random random(seed);
        Six h = random_six(random, 1 + static_cast<int>(random.below(400)));
        Six x = random_six(random, 1 + static_cast<int>(random.below(400)));
        ResidueSix rh, rx;
        Integer sum = 0;
        for (std::size_t k = 0; k < 6; ++k) {
            reduce(h[k], rh[k]);
            reduce(x[k], rx[k]);
            sum += h[k] * x[k];
        }
        Residue fast, plain, expected;
        residue_dot(rh, rx, fast);
        residue_dot_plain(rh, rx, plain);
        reduce(sum, expected);
        RC_ASSERT(fast == plain);
        RC_ASSERT(fast == expected);
    });
}

TEST(Residues, ExtremeResiduesMultiplyExactly) {
    ResidueSix all;
    for (auto& row : all)
        for (std::size_t k = 0; k < kPrimes; ++k)
            row[k] = residue_primes()[k] - 1; // -1: six products of (-1)(-1)
    Residue out;
    residue_dot(all, all, out);
    for (std::uint64_t r : out)
        EXPECT_EQ(r, 6u);
}

TEST(Residues, CombineIsADifferenceOfProducts) {
    Random random(5);
    Six x = random_six(random, 200), y = random_six(random, 200);
    Integer a = random_integer(random, 90), b = random_integer(random, 90);
    ResidueSix rx, ry, out;
    Residue ra, rb, expected;
    for (std::size_t k = 0; k < 6; ++k) {
        reduce(x[k], rx[k]);
        reduce(y[k], ry[k]);
    }
    reduce(a, ra);
    reduce(b, rb);
    residue_combine(ra, rx, rb, ry, out);
    for (std::size_t k = 0; k < 6; ++k) {
        reduce(Integer(a * x[k] - b * y[k]), expected);
        EXPECT_EQ(out[k], expected);
    }
}

TEST(Residues, AZeroModuloEveryPrimeIsRefusedAsAVector) {
    ResidueSix x{};
    for (std::size_t k = 0; k < kPrimes; ++k)
        x[2][k] = 1;
    EXPECT_TRUE(nonzero_everywhere(x));
    x[2][7] = 0;
    EXPECT_FALSE(nonzero_everywhere(x));
}

/// Fills two stores with the same lines and hyperplanes and cuts them alike, over and over; small coordinates make
/// true zeros frequent.
void compare_stores(std::uint64_t seed, int magnitude, int cuts) {
    Random random(seed);
    LineStore<true> fast;
    LineStore<false> plain;
    fast.reset(8);
    plain.reset(8);
    auto coordinate = [&] { return static_cast<std::int64_t>(random.below(static_cast<std::uint32_t>(2 * magnitude + 1))) - magnitude; };
    auto point = [&] { return GridPoint{coordinate(), coordinate(), coordinate()}; };
    std::vector<VertexId> vertices;
    std::vector<HyperplaneId> planes;
    for (int k = 0; k < 12; ++k) {
        GridPoint a = point(), b = point();
        if (a == b)
            continue;
        vertices.push_back(fast.line(pluecker_through(a, b), -1, -1));
        plain.line(pluecker_through(a, b), -1, -1);
    }
    for (int k = 0; k < 12; ++k) {
        GridPoint a = point(), b = point();
        if (a == b)
            continue;
        HalfSpace h = fast.edge(a, b);
        RC_ASSERT(plain.edge(a, b).hyperplane == h.hyperplane);
        planes.push_back(h.hyperplane);
    }
    for (int c = 0; c < cuts; ++c) {
        VertexId v = vertices[random.below(static_cast<std::uint32_t>(vertices.size()))];
        VertexId w = vertices[random.below(static_cast<std::uint32_t>(vertices.size()))];
        HyperplaneId h = planes[random.below(static_cast<std::uint32_t>(planes.size()))];
        int at_v = plain.sign(h, v), at_w = plain.sign(h, w);
        RC_ASSERT(fast.sign(h, v) == at_v);
        RC_ASSERT(fast.sign(h, w) == at_w);
        RC_ASSERT(fast.quadric_sign(v) == plain.quadric_sign(v));
        RC_ASSERT(fast.side_sign(v, w) == plain.side_sign(v, w));
        if (plain.quadric_sign(v) * plain.quadric_sign(w) > 0) {
            RC_ASSERT(fast.discriminant_positive(v, w) == plain.discriminant_positive(v, w));
        }
        if (at_v * at_w < 0) {
            VertexId cut = fast.cut(v, w, h);
            RC_ASSERT(plain.cut(v, w, h) == cut);
            RC_ASSERT(fast.sign(h, cut) == 0);
            vertices.push_back(cut);
        }
    }
}

TEST(LineStore, EveryFilteredSignEqualsTheIntegerOneOnTinyGrids) {
    rc::check([](std::uint64_t seed) { compare_stores(seed, 3, 150); });
}

TEST(LineStore, EveryFilteredSignEqualsTheIntegerOneOnLargeGrids) {
    rc::check([](std::uint64_t seed) { compare_stores(seed, 1 << 23, 60); });
}

TEST(LineStore, CollinearEdgesShareOneHyperplane) {
    LineStore<true> store;
    store.reset(10);
    HalfSpace a = store.edge({0, 0, 5}, {3, 6, 5}), b = store.edge({10, 20, 5}, {9, 18, 5});
    EXPECT_EQ(a.hyperplane, b.hyperplane);
    EXPECT_EQ(a.sign, -b.sign);
    EXPECT_NE(store.edge({0, 0, 6}, {3, 6, 6}).hyperplane, a.hyperplane);
}

/// x_i = (e_i, row i of m / 2): then side(x_i, x_j) = m_ij for a symmetric m with even entries.
std::array<VertexId, 3> vertices_with_sides(LineStore<false>& store, const int (&m)[3][3]) {
    std::array<VertexId, 3> v;
    for (std::size_t i = 0; i < 3; ++i) {
        SmallSix x{};
        x[i] = 1;
        for (std::size_t j = 0; j < 3; ++j)
            x[3 + j] = m[i][j] / 2;
        v[i] = store.line(x, -1, -1);
    }
    return v;
}

TEST(QuadricTest, ATriangleCanHoldLinesThatNoneOfItsEdgesHolds) {
    LineStore<false> store;
    store.reset(4);
    auto v = vertices_with_sides(store, {{10, -8, -8}, {-8, 10, -8}, {-8, -8, 10}});
    for (int i = 0; i < 3; ++i) {
        EXPECT_EQ(store.quadric_sign(v[static_cast<std::size_t>(i)]), 1);
        EXPECT_FALSE(store.discriminant_positive(v[static_cast<std::size_t>(i)], v[static_cast<std::size_t>((i + 1) % 3)]));
    }
    EXPECT_TRUE(triple_dips(store, {v[0], v[1], v[2]}, 1)); // the sum of the three has 2 Q = 30 - 48 < 0
}

TEST(QuadricTest, ATriangleThatTouchesZeroInsideDoesNotDip) {
    LineStore<false> store;
    store.reset(4);
    auto v = vertices_with_sides(store, {{8, -4, -4}, {-4, 8, -4}, {-4, -4, 8}}); // the sum lies on the quadric
    EXPECT_FALSE(triple_dips(store, {v[0], v[1], v[2]}, 1));
}

TEST(QuadricTest, ThePairDiscriminantIsStrict) {
    LineStore<false> store;
    store.reset(4);
    auto v = vertices_with_sides(store, {{2, -2, 0}, {-2, 2, 0}, {0, 0, 2}});
    EXPECT_FALSE(store.discriminant_positive(v[0], v[1])); // touches
    auto w = vertices_with_sides(store, {{2, -4, 0}, {-4, 2, 0}, {0, 0, 2}});
    EXPECT_TRUE(store.discriminant_positive(w[0], w[1]));
}

} // namespace
} // namespace antumbra::exact
