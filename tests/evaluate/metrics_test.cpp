#include "evaluate/metrics.hpp"

#include <gtest/gtest.h>
#include <rapidcheck/gtest.h>

#include <algorithm>

namespace antumbra {
namespace {

TEST(Metrics, MedianOfOddIsTheMiddle) {
    EXPECT_EQ(median({9, 1, 4}), 4);
}
TEST(Metrics, MedianOfEvenIsTheMeanOfTheMiddleTwo) {
    EXPECT_EQ(median({9, 1, 4, 6}), 5);
}
TEST(Metrics, MedianOfNothingIsNotMeasured) {
    EXPECT_EQ(median({}), -1);
}
TEST(Metrics, PercentileIsAValueThatOccurred) {
    EXPECT_EQ(percentile({10, 20, 30, 40}, 0.5), 20);
    EXPECT_EQ(percentile({10, 20, 30, 40}, 0.99), 40);
    EXPECT_EQ(percentile({}, 0.99), -1);
}

RC_GTEST_PROP(Metrics, AtLeastTheShareIsNotAboveThePercentile, (std::vector<double> values)) {
    RC_PRE(!values.empty());
    double p = percentile(values, 0.9);
    auto below = std::count_if(values.begin(), values.end(), [&](double v) { return v <= p; });
    RC_ASSERT(double(below) >= 0.9 * double(values.size()));
}

WalkSample sample(double cull, double draw, std::uint32_t reported, std::uint32_t culled, std::uint64_t pixels) {
    WalkSample s;
    s.cull_ms = cull;
    s.draw_ms = draw;
    s.objects_reported = reported;
    s.triangles_drawn = reported * 10;
    s.culled_of_frustum = culled;
    s.false_visible_objects = reported / 2;
    s.false_invisible_pixels = pixels;
    s.false_invisible_objects = pixels > 0;
    return s;
}

/// Two methods over three frames; the third frame lies in matter.
WalkResult by_hand() {
    WalkResult result;
    result.methods.resize(2);
    result.methods[0].name = "frustum";
    result.methods[0].guarantee = Guarantee::conservative;
    result.methods[1].name = "pvs";
    result.methods[1].from_region = true;
    result.frames.resize(3);
    const double cull[2][3] = {{1, 2, 6}, {0.5, 0.5, 2}}, draw[2][3] = {{9, 18, 14}, {3.5, 4.5, 9}};
    const std::uint32_t reported[2][3] = {{10, 20, 0}, {4, 10, 0}}, culled[2][3] = {{0, 0, 0}, {6, 10, 0}};
    const std::uint64_t pixels[2][3] = {{0, 0, 0}, {7, 0, 100}};
    for (std::size_t f = 0; f < 3; ++f) {
        for (std::size_t m = 0; m < 2; ++m)
            result.frames[f].methods.push_back(
                sample(cull[m][f], draw[m][f], reported[m][f], culled[m][f], pixels[m][f]));
        result.frames[f].objects_in_frustum = reported[0][f];
        result.frames[f].objects_true = 3;
        result.frames[f].ceiling_ms = double(f + 1);
    }
    result.frames[2].in_matter = true;
    return result;
}

TEST(Metrics, TableOfAWalkComputedByHand) {
    WalkResult result = by_hand();
    summarise(result);
    const WalkMethod& frustum = result.methods[0];
    const WalkMethod& pvs = result.methods[1];
    EXPECT_EQ(frustum.cull_ms_median, 2);
    EXPECT_EQ(frustum.cull_ms_p99, 6);
    EXPECT_EQ(frustum.draw_ms_median, 14);
    EXPECT_EQ(frustum.frame_ms_median, 20); // of 10, 20, 20: not the sum of the medians
    EXPECT_EQ(pvs.frame_ms_median, 5);      // of 4, 5, 11
    EXPECT_EQ(frustum.speedup_over_frustum, 1);
    EXPECT_EQ(pvs.speedup_over_frustum, 4);
    EXPECT_EQ(frustum.objects_reported, 10);
    EXPECT_EQ(frustum.triangles_drawn, 100);
    EXPECT_NEAR(pvs.culled_of_frustum, (0.6 + 0.5 + 0) / 3, 1e-15); // nothing in view: a share of 0
    EXPECT_NEAR(pvs.false_visible_objects, 7.0 / 3, 1e-15);
    EXPECT_EQ(result.objects_true, 3);
    EXPECT_EQ(result.ceiling_ms_median, 2);
    EXPECT_EQ(result.ceiling_speedup, 10);
}

TEST(Metrics, FramesInMatterAreLeftOutOfBakedAnswersOnly) {
    WalkResult result = by_hand();
    result.frames[2].methods[0].false_invisible_pixels = 5;
    summarise(result);
    EXPECT_EQ(result.methods[1].false_invisible_pixels, 7u);
    EXPECT_EQ(result.methods[0].false_invisible_pixels, 5u);
    EXPECT_EQ(result.frames_in_matter, 1u);
}

TEST(Metrics, OnlyPromisesCanBeBroken) {
    WalkResult result = by_hand();
    summarise(result);
    EXPECT_EQ(find_broken_promise(result), nullptr); // the lossy method is approximate
    result.methods[0].false_invisible_pixels = 1;
    EXPECT_EQ(find_broken_promise(result), &result.methods[0]);
}

TEST(Metrics, WithoutDrawingThereIsNoSpeedUp) {
    WalkResult result = by_hand();
    for (WalkFrame& frame : result.frames)
        for (WalkSample& one : frame.methods)
            one.draw_ms = -1;
    summarise(result);
    EXPECT_EQ(result.methods[1].cull_ms_median, 0.5);
    EXPECT_EQ(result.methods[1].frame_ms_median, -1);
    EXPECT_EQ(result.methods[1].speedup_over_frustum, -1);
}

} // namespace
} // namespace antumbra
