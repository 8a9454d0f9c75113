// The tests by table, by peaks and by bits against looking at every pixel.
#include "raster/opacity_map.hpp"
#include "raster/opacity_rows.hpp"
#include "raster/sparse_depth_map.hpp"

#include "base/random.hpp"

#include <gtest/gtest.h>

#include <string>

namespace antumbra {
namespace {

OccluderImage blank(int width, int height) {
    OccluderImage image;
    Screen screen;
    screen.width = width;
    screen.height = height;
    image.reset(screen);
    return image;
}

void put(OccluderImage& image, int x, int y, float nearness = 1) {
    image.bits[static_cast<std::size_t>(y * image.words + x / 64)] |= std::uint64_t(1) << (x % 64);
    image.nearness[static_cast<std::size_t>(y * image.stride + x)] = nearness;
    image.row_used[static_cast<std::size_t>(y)] = 1;
}

/// Rows of characters, the topmost first: '.' is open, a digit d is covered at depth d.
OccluderImage drawn(std::initializer_list<const char*> rows) {
    OccluderImage image = blank(int(std::string(*rows.begin()).size()), int(rows.size()));
    int y = image.height;
    for (const char* row : rows) {
        --y;
        for (int x = 0; x < image.width; ++x)
            if (row[x] != '.')
                put(image, x, y, 1.0f / float(row[x] - '0'));
    }
    return image;
}

/// Blotches and rows of smooth depth, so that large covered rectangles exist.
OccluderImage random_image(Random& random) {
    OccluderImage image = blank(8 + int(random.below(200)), 8 + int(random.below(40)));
    int blotches = int(random.below(12));
    for (int b = 0; b < blotches; ++b) {
        int x0 = int(random.below(std::uint32_t(image.width))), y0 = int(random.below(std::uint32_t(image.height)));
        int x1 = std::min(image.width, x0 + 1 + int(random.below(150)));
        int y1 = std::min(image.height, y0 + 1 + int(random.below(30)));
        float slope = random.below(3) ? float(random.uniform(-0.01, 0.01)) : 0, rough = random.below(4) ? 0 : 0.1f;
        float base = float(random.uniform(1, 3));
        for (int y = y0; y < y1; ++y)
            for (int x = x0; x < x1; ++x) {
                float value = base + slope * float(x - x0) + rough * float(random.uniform(0, 1));
                float& old = image.nearness[static_cast<std::size_t>(y * image.stride + x)];
                put(image, x, y, std::max(old, value));
            }
    }
    return image;
}

PixelRect random_rect(Random& random, const OccluderImage& image) {
    PixelRect rect;
    rect.x0 = int(random.below(std::uint32_t(image.width)));
    rect.y0 = int(random.below(std::uint32_t(image.height)));
    rect.x1 = rect.x0 + int(random.below(std::uint32_t(std::min(image.width - rect.x0, random.below(2) ? 8 : 200))));
    rect.y1 = rect.y0 + int(random.below(std::uint32_t(std::min(image.height - rect.y0, random.below(2) ? 4 : 40))));
    return rect;
}

TEST(OpacityMap, the_worked_example_of_the_paper) {
    // Its rectangle is 2 < x <= 5, 1 < y <= 5: 12 pixels.
    OccluderImage image = drawn({"1....", //
                                 "111..", //
                                 "1111.", //
                                 "11111", //
                                 "11111"});
    // 2 - 9 - 5 + 18 = 6
    OpacityMap map;
    map.build(image);
    EXPECT_EQ(map.at(2, 1), 2u);
    EXPECT_EQ(map.at(2, 5), 9u);
    EXPECT_EQ(map.at(5, 1), 5u);
    EXPECT_EQ(map.at(5, 5), 18u);
    EXPECT_EQ(map.covered(2, 5, 1, 5), 6u);
    PixelRect rect{2, 1, 4, 4};
    EXPECT_EQ(rect.area(), 12);
    EXPECT_EQ(map.covered(rect), 6u);
    EXPECT_FALSE(map.overlaps(rect));
    EXPECT_TRUE(map.overlaps(rect, 0.5f));
}

TEST(OpacityMap, the_zero_row_and_column_serve_rectangles_at_the_border) {
    OccluderImage image = drawn({"11", "11"});
    OpacityMap map;
    map.build(image);
    for (int i = 0; i <= 2; ++i) {
        EXPECT_EQ(map.at(i, 0), 0u);
        EXPECT_EQ(map.at(0, i), 0u);
    }
    EXPECT_EQ(map.covered({0, 0, 1, 1}), 4u);
    EXPECT_EQ(map.covered({0, 0, 0, 0}), 1u);
    EXPECT_EQ(map.covered({1, 1, 1, 1}), 1u);
}

TEST(OpacityMap, table_and_bits_count_what_the_pixels_count) {
    std::uint64_t covered = 0;
    for (std::uint32_t trial = 0; trial < 300; ++trial) {
        Random random(61, trial);
        OccluderImage image = random_image(random);
        OpacityMap map;
        map.build(image);
        OpacityRows rows;
        rows.build(image);
        for (int r = 0; r < 100; ++r) {
            PixelRect rect = random_rect(random, image);
            std::uint32_t count = 0;
            for (int y = rect.y0; y <= rect.y1; ++y)
                for (int x = rect.x0; x <= rect.x1; ++x)
                    count += image.is_covered(x, y);
            bool all = count == std::uint32_t(rect.area());
            ASSERT_EQ(map.covered(rect), count);
            ASSERT_EQ(OpacityRows::covered(image, rect), count);
            ASSERT_EQ(map.overlaps(rect), all);
            ASSERT_EQ(overlaps_pixel_wise(image, rect), all);
            ASSERT_EQ(rows.overlaps(rect), all);
            ASSERT_EQ(overlaps_by_rows(image, rect), all);
            float share = OpacityRows::covered_share(image, rect);
            ASSERT_TRUE(share >= 0 && share <= 1 && (share == 1 || !all) && (share == 0 || count > 0));
            covered += all;
        }
    }
    EXPECT_GT(covered, 3000u);
}

TEST(OpacityMap, a_tolerance_forgives_that_share_of_holes_and_no_more) {
    OccluderImage image = drawn({"1111111111"});
    image.bits[0] &= ~std::uint64_t(1 << 4); // one hole of ten
    OpacityMap map;
    map.build(image);
    EXPECT_FALSE(map.overlaps({0, 0, 9, 0}));
    EXPECT_TRUE(map.overlaps({0, 0, 9, 0}, 0.11f));
    EXPECT_FALSE(map.overlaps({0, 0, 9, 0}, 0.09f));
    EXPECT_FALSE(map.overlaps({2, 0, 6, 0}, 0.11f)); // one of five
}

TEST(SparseDepthMap, steps_lead_from_peak_to_peak) {
    OccluderImage image = drawn({"12321134"}); // depths; peaks at 2 (depth 3) and 7 (depth 4)
    SparseDepthMap map;
    map.build(image);
    EXPECT_EQ(map.step, (std::vector<std::uint16_t>{2, 1, 5, 4, 3, 2, 1, 1}));
    EXPECT_EQ(map.peaks, 2u);
    EXPECT_TRUE(map.is_worth_it());
}

/// Missing in the paper: the next peak lies beyond the rectangle, and depth rises up to its edge.
TEST(SparseDepthMap, depth_that_rises_up_to_the_right_edge_is_seen) {
    OccluderImage image = drawn({"12345678"});
    SparseDepthMap map;
    map.build(image);
    PixelRect rect{0, 0, 4, 0}; // depths 1..5; the only peak is the 8 outside
    EXPECT_EQ(map.step[0], 7);
    EXPECT_FALSE(map.is_behind(image, rect, 1.0f / 4.5f)); // a thing at depth 4.5 is in front of the pixel at 5
    EXPECT_TRUE(map.is_behind(image, rect, 1.0f / 5.5f));
}

TEST(SparseDepthMap, an_even_depth_has_one_peak_at_its_end) {
    OccluderImage image = drawn({"22222222"});
    SparseDepthMap map;
    map.build(image);
    EXPECT_EQ(map.peaks, 1u);
    EXPECT_TRUE(map.is_behind(image, {0, 0, 7, 0}, 1.0f / 3));
    EXPECT_FALSE(map.is_behind(image, {0, 0, 7, 0}, 1.0f / 2)); // touching is not behind
}

TEST(SparseDepthMap, where_nothing_can_be_skipped_it_says_so) {
    OccluderImage image = drawn({"12121212"});
    SparseDepthMap map;
    map.build(image);
    EXPECT_EQ(map.peaks, 4u);
    EXPECT_FALSE(map.is_worth_it());
}

TEST(SparseDepthMap, rows_without_occluders_are_not_built) {
    OccluderImage image = drawn({"1111", "....", "2222"});
    SparseDepthMap map;
    map.build(image);
    EXPECT_EQ(map.built, (std::vector<std::uint8_t>{1, 0, 1}));
    EXPECT_EQ(map.pixels, 8u);
}

TEST(SparseDepthMap, peaks_and_spans_decide_as_every_pixel_does) {
    std::uint64_t behind = 0, front = 0;
    for (std::uint32_t trial = 0; trial < 600; ++trial) {
        Random random(62, trial);
        OccluderImage image = random_image(random);
        SparseDepthMap map;
        map.build(image);
        OpacityRows rows;
        rows.build(image);
        for (int r = 0; r < 100; ++r) {
            PixelRect rect = random_rect(random, image);
            float nearness = float(random.uniform(0.5, 3.5));
            if (random.below(3) == 0) // exactly at some pixel's depth
                nearness = image.nearness[static_cast<std::size_t>(rect.y0 * image.stride + rect.x0)];
            bool expected = is_behind_pixel_wise(image, rect, nearness);
            ASSERT_EQ(map.is_behind(image, rect, nearness), expected);
            if (!overlaps_pixel_wise(image, rect))
                continue;
            ASSERT_EQ(rows.is_behind(image, rect, nearness), expected);
            behind += expected;
            front += !expected;
        }
    }
    EXPECT_GT(behind, 1000u);
    EXPECT_GT(front, 1000u);
}

} // namespace
} // namespace antumbra
