#include "cull/tangent_table.hpp"

#include "base/random.hpp"

#include <gtest/gtest.h>

#include <set>

namespace antumbra {
namespace {

TEST(TangentTable, agrees_with_trying_all_vertices) {
    Random random(41);
    int valid = 0;
    std::set<int> regions;
    for (int trial = 0; trial < 200000; ++trial) {
        Box3d box;
        Vec3d origin, direction;
        for (int k = 0; k < 3; ++k) {
            box.min[k] = random.uniform(-1, 0);
            box.max[k] = random.uniform(0, 1);
            origin[k] = random.uniform(-3, 3);
            direction[k] = random.uniform(-1, 1);
        }
        Tangents table = find_tangents(box, origin, direction), naive = find_tangents_naive(box, origin, direction);
        ASSERT_EQ(table.valid, naive.valid) << trial;
        if (!table.valid)
            continue;
        ++valid;
        int region = 0;
        for (int k = 0; k < 3; ++k)
            region = region * 3 + (origin[k] < box.min[k] ? 0 : origin[k] > box.max[k] ? 2 : 1);
        regions.insert(region);
        ASSERT_EQ((std::set<int>{table.first, table.second}), (std::set<int>{naive.first, naive.second})) << trial;
    }
    EXPECT_GT(valid, 50000);
    EXPECT_EQ(regions.size(), 26u);
}

TEST(TangentTable, a_line_through_the_box_or_an_origin_inside_has_no_tangents) {
    Box3d box{{0, 0, 0}, {1, 1, 1}};
    EXPECT_FALSE(find_tangents(box, {0.5, 0.5, 0.5}, {1, 2, 3}).valid);
    EXPECT_FALSE(find_tangents(box, {-1, 0.5, 0.5}, {1, 0, 0}).valid);
    EXPECT_FALSE(find_tangents(box, {-1, 0.5, 0.5}, {-1, 0, 0}).valid); // the line, not the half-line
    EXPECT_TRUE(find_tangents(box, {-1, 0.5, 0.5}, {0, 1, 0}).valid);
}

} // namespace
} // namespace antumbra
