// The common point of five hyperplanes by minors, against elimination in rationals.
#include "bake/exact/wedge.hpp"

#include "base/random.hpp"

#include <gtest/gtest.h>

#include <boost/multiprecision/cpp_int.hpp>

namespace antumbra::exact {
namespace {

using Rational = boost::multiprecision::cpp_rational;

/// The kernel of the rows by elimination; empty unless it is one line.
std::vector<Rational> kernel(const std::vector<SmallSix>& rows) {
    std::vector<std::vector<Rational>> m;
    for (const SmallSix& row : rows)
        m.emplace_back(row.begin(), row.end());
    std::size_t rank = 0;
    std::vector<std::size_t> pivots;
    for (std::size_t column = 0; column < 6 && rank < m.size(); ++column) {
        std::size_t pivot = rank;
        while (pivot < m.size() && m[pivot][column] == 0)
            ++pivot;
        if (pivot == m.size())
            continue;
        std::swap(m[rank], m[pivot]);
        for (std::size_t r = 0; r < m.size(); ++r) {
            if (r == rank || m[r][column] == 0)
                continue;
            Rational factor = m[r][column] / m[rank][column];
            for (std::size_t k = 0; k < 6; ++k)
                m[r][k] -= factor * m[rank][k];
        }
        pivots.push_back(column);
        ++rank;
    }
    if (rank != 5)
        return {};
    std::size_t free = 0;
    while (free < pivots.size() && pivots[free] == free)
        ++free;
    std::vector<Rational> x(6, 0);
    x[free] = 1;
    for (std::size_t r = 0; r < 5; ++r)
        x[pivots[r]] = -m[r][free] / m[r][pivots[r]];
    return x;
}

SmallSix draw(Random& random, std::int64_t size) {
    SmallSix row;
    for (std::int64_t& value : row)
        value = static_cast<std::int64_t>(random.uniform() * static_cast<double>(2 * size)) - size;
    return row;
}

/// Feeds rows until the wedge is complete; checks the point against the kernel.
void check(const std::vector<SmallSix>& rows) {
    Wedge wedge;
    std::vector<SmallSix> used;
    for (const SmallSix& row : rows) {
        if (wedge.complete())
            break;
        wedge.add(row);
        used.push_back(row);
    }
    std::vector<Rational> x = kernel(used);
    ASSERT_EQ(wedge.complete(), !x.empty());
    if (x.empty())
        return;
    unsigned largest = 0;
    for (unsigned k = 0; k < 6; ++k) {
        EXPECT_EQ(wedge.sign(k), sign_of(wedge.coordinate(k, false))) << k;
        EXPECT_EQ(wedge.coordinate(k, true), -wedge.coordinate(k, false)) << k;
        int exponent = 0, expected_exponent = 0;
        double rounded = wedge.coordinate(k, k % 2 == 1, exponent);
        double expected = to_double(wedge.coordinate(k, k % 2 == 1), expected_exponent);
        EXPECT_EQ(exponent, expected_exponent) << k;
        EXPECT_NEAR(rounded, expected, 0x1p-53) << k; // both are cut off at some 62 bits before they are rounded
        if (wedge.sign(k) != 0)
            largest = k;
    }
    ASSERT_NE(wedge.sign(largest), 0);
    Rational scale = x[largest] / Rational(boost::multiprecision::cpp_int(wedge.coordinate(largest, false).str()));
    for (unsigned k = 0; k < 6; ++k)
        EXPECT_EQ(Rational(boost::multiprecision::cpp_int(wedge.coordinate(k, false).str())) * scale, x[k]) << k;
}

TEST(Wedge, IsTheCommonPointOfFiveRandomHyperplanes) {
    Random random(1);
    for (int k = 0; k < 2000; ++k) {
        std::vector<SmallSix> rows;
        for (int r = 0; r < 5; ++r)
            rows.push_back(draw(random, k % 2 ? 3 : std::int64_t(1) << 60));
        check(rows);
    }
}

TEST(Wedge, PassesOverRowsThatDependOnEarlierOnes) {
    Random random(2);
    std::uint64_t complete = 0;
    for (int k = 0; k < 2000; ++k) {
        std::vector<SmallSix> rows = {draw(random, 1 << 20)};
        while (rows.size() < 9) {
            SmallSix row = draw(random, 1 << 20);
            if (rows.size() % 2 == 1) { // a sum of earlier ones
                row = rows[0];
                const SmallSix& other = rows[rows.size() - 1];
                for (std::size_t i = 0; i < 6; ++i)
                    row[i] = row[i] * 3 - other[i];
            }
            rows.push_back(row);
        }
        check(rows);
        Wedge wedge;
        for (const SmallSix& row : rows)
            if (!wedge.complete())
                wedge.add(row);
        complete += wedge.complete();
    }
    EXPECT_EQ(complete, 2000u);
}

TEST(Wedge, HoldsTheLargestMinors) {
    // Five rows of 61 bits: a minor of all largest entries is near 5! times their product, 312 bits.
    constexpr std::int64_t big = (std::int64_t(1) << 61) - 1;
    std::vector<SmallSix> rows(5);
    for (std::size_t r = 0; r < 5; ++r)
        for (std::size_t c = 0; c < 6; ++c)
            rows[r][c] = r == c ? big : (r * 7 + c * 3) % 2 ? -big : big;
    check(rows);
}

TEST(Wedge, IsNotCompleteOnAPencil) {
    Random random(3);
    SmallSix a = draw(random, 100), b = draw(random, 100);
    Wedge wedge;
    for (std::int64_t i = 1; i <= 8; ++i) {
        SmallSix row;
        for (std::size_t k = 0; k < 6; ++k)
            row[k] = a[k] * i + b[k] * (9 - i);
        wedge.add(row);
    }
    EXPECT_FALSE(wedge.complete());
}

} // namespace
} // namespace antumbra::exact
