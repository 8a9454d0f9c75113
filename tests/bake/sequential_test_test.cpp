#include "bake/sampled/sequential_test.hpp"

#include <gtest/gtest.h>

#include <string_view>

namespace antumbra {
namespace {

SprtOptions reading(SprtReading which) { return {.reading = which}; }

// The ratios along the paper's example 00001000011 (s_t = 0.01, s_1 = 0.1).
TEST(SequentialTest, RatiosOfTheThreeReadings) {
    struct Row {
        std::uint32_t rays, hits;
        double printed, normalised, wald;
    };
    for (const Row& row : {Row{4, 0, 19.40, 0.1960, 0.6830}, Row{5, 1, 683.7, 6.906, 6.830},
                           Row{9, 1, 233.4, 2.358, 4.665}, Row{10, 2, 6435, 65.00, 46.65},
                           Row{11, 3, 2.154e5, 2175.9, 466.5}}) {
        auto near = [](double value, double expected) { EXPECT_NEAR(value / expected, 1, 5e-4) << expected; };
        near(sprt_ratio(reading(SprtReading::printed), row.hits, row.rays), row.printed);
        near(sprt_ratio(reading(SprtReading::normalised), row.hits, row.rays), row.normalised);
        near(sprt_ratio(reading(SprtReading::wald), row.hits, row.rays), row.wald);
    }
}

TEST(SequentialTest, PrintedReadingStartsAt99AndNeeds178Misses) {
    SprtOptions options = reading(SprtReading::printed);
    EXPECT_NEAR(sprt_ratio(options, 0, 0), 99, 1e-9);
    EXPECT_EQ(SequentialTest(options).misses_to_give_up(), 178u);
    EXPECT_EQ(SequentialTest(options).decide(0, 0), SprtDecision::go_on); // 99 > A, but visible needs a hit
}

TEST(SequentialTest, NormalisedReadingGivesUpAfterFourMisses) {
    SequentialTest test(reading(SprtReading::normalised));
    EXPECT_EQ(test.misses_to_give_up(), 4u);
    EXPECT_NEAR(SequentialTest::miss_probability(0.1, test.misses_to_give_up()), 0.6561, 1e-12);
}

TEST(SequentialTest, WaldStopsThePapersExampleAtSampleEleven) {
    SequentialTest test(reading(SprtReading::wald));
    std::uint32_t hits = 0, rays = 0;
    SprtDecision decision = SprtDecision::go_on;
    for (char sample : std::string_view("00001000011")) {
        ASSERT_EQ(decision, SprtDecision::go_on) << "stopped after " << rays;
        hits += sample == '1';
        decision = test.decide(hits, ++rays);
    }
    EXPECT_EQ(rays, 11u);
    EXPECT_EQ(decision, SprtDecision::visible);
}

// (0.9/0.99)^r < 0.2 first at r = 17.
TEST(SequentialTest, WaldGivesUpAfterSeventeenMisses) {
    SequentialTest test(reading(SprtReading::wald));
    EXPECT_EQ(test.misses_to_give_up(), 17u);
    EXPECT_EQ(test.decide(0, 16), SprtDecision::go_on);
    EXPECT_EQ(test.decide(0, 17), SprtDecision::invisible);
    EXPECT_NEAR(SequentialTest::miss_probability(0.1, test.misses_to_give_up()), 0.16677181699666569, 1e-15);
}

// Even odds change nothing; odds of 1:5 give up at once, of 5:1 after (0.9/0.99)^r < 0.04.
TEST(SequentialTest, PriorOddsShiftTheEnd) {
    SequentialTest test(reading(SprtReading::wald));
    EXPECT_EQ(test.misses_to_give_up(1), 17u);
    EXPECT_EQ(test.misses_to_give_up(0.19), 0u);
    EXPECT_EQ(test.misses_to_give_up(5), 34u);
}

TEST(SequentialTest, TableAgreesWithTheRatio) {
    for (SprtReading which : {SprtReading::wald, SprtReading::printed, SprtReading::normalised}) {
        SprtOptions options = reading(which);
        options.most_rays = 400;
        SequentialTest test(options);
        for (std::uint32_t rays = 0; rays < test.misses_to_give_up() + 200 && rays < 390; ++rays)
            for (std::uint32_t hits = 0; hits <= rays && hits < 20; ++hits) {
                double ratio = sprt_ratio(options, hits, rays);
                SprtDecision expected = ratio < options.b                ? SprtDecision::invisible
                                        : ratio > options.a && hits > 0 ? SprtDecision::visible
                                                                         : SprtDecision::go_on;
                ASSERT_EQ(test.decide(hits, rays), expected) << hits << " of " << rays;
            }
    }
}

// Wald's thresholds keep the stated error rates (checked by exact propagation of the hit count).
TEST(SequentialTest, StatedErrorRatesAreKept) {
    double alpha = 0.01, beta = 0.05;
    WaldThresholds thresholds = wald_thresholds(alpha, beta);
    SprtOptions options{.a = thresholds.a, .b = thresholds.b, .most_rays = 2000};
    SequentialTest test(options);
    for (double s : {options.s_t, options.s_1}) {
        std::vector<double> going(1, 1.0); // probability of going on with so many hits
        double visible = 0, invisible = 0;
        for (std::uint32_t rays = 1; rays <= 2000; ++rays) {
            std::vector<double> next(going.size() + 1, 0.0);
            for (std::size_t h = 0; h < going.size(); ++h) {
                next[h] += going[h] * (1 - s);
                next[h + 1] += going[h] * s;
            }
            for (std::uint32_t h = 0; h < next.size(); ++h) {
                SprtDecision decision = test.decide(h, rays);
                (decision == SprtDecision::visible ? visible : invisible) +=
                    decision == SprtDecision::go_on ? 0 : next[h];
                if (decision != SprtDecision::go_on)
                    next[h] = 0;
            }
            while (next.size() > 1 && next.back() == 0)
                next.pop_back();
            going = std::move(next);
        }
        EXPECT_GT(visible + invisible, 0.999);
        if (s == options.s_1)
            EXPECT_LE(invisible, beta / (1 - alpha));
        else
            EXPECT_LE(visible, alpha / (1 - beta));
    }
}

} // namespace
} // namespace antumbra
