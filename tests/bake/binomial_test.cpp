#include "bake/binomial.hpp"

#include <gtest/gtest.h>

#include <cmath>

namespace antumbra {

// With no event the bound has a closed form: (1-p)^n = 1 - confidence.
TEST(ClopperPearson, ClosedFormWithoutEvents) {
    for (std::uint64_t n : {1u, 10u, 1000u, 1000000u})
        EXPECT_NEAR(clopper_pearson_upper(0, n, 0.95) / (1 - std::pow(0.05, 1.0 / double(n))), 1, 1e-9);
}

// Values of the beta quantile function, from tables.
TEST(ClopperPearson, TableValues) {
    EXPECT_NEAR(clopper_pearson_upper(1, 10, 0.95), 0.39416, 5e-6);
    EXPECT_NEAR(clopper_pearson_upper(5, 10, 0.95), 0.77756, 5e-6);
    EXPECT_NEAR(clopper_pearson_upper(10, 100, 0.975), 0.17622, 5e-6);
}

TEST(ClopperPearson, NothingKnownWithoutTrials) {
    EXPECT_EQ(clopper_pearson_upper(0, 0, 0.95), 1);
    EXPECT_EQ(clopper_pearson_upper(3, 3, 0.95), 1);
}

TEST(ClopperPearson, LargeCountsApproachTheNormalBound) {
    double p = 0.3, n = 1e6;
    double expected = p + 1.6448536 * std::sqrt(p * (1 - p) / n);
    EXPECT_NEAR(clopper_pearson_upper(300000, 1000000, 0.95), expected, 2e-6);
}

} // namespace antumbra
