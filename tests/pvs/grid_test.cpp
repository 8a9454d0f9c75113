#include "base/random.hpp"

#include <antumbra/pvs.hpp>

#include <gtest/gtest.h>
#include <rapidcheck.h>

#include <array>
#include <cmath>

namespace antumbra {
namespace {

CellGrid unit_grid() { return {{{0, 0, 0}, {4, 2, 1}}, {4, 2, 1}}; }

TEST(CellGrid, CellsAreCountedAlongXFirst) {
    CellGrid grid = unit_grid();
    EXPECT_EQ(grid.cell(0), (Box3d{{0, 0, 0}, {1, 1, 1}}));
    EXPECT_EQ(grid.cell(6), (Box3d{{2, 1, 0}, {3, 2, 1}}));
    EXPECT_EQ(grid.find({2.5, 1.5, 0.5}), 6);
}

TEST(CellGrid, ACommonFaceBelongsToTheCellAbove) {
    CellGrid grid = unit_grid();
    EXPECT_EQ(grid.find({1, 0.5, 0.5}), 1);
    EXPECT_EQ(grid.find({0, 0, 0}), 0);
    EXPECT_EQ(grid.find({4, 2, 1}), 7) << "except at the far face";
    EXPECT_EQ(grid.find({std::nextafter(4.0, 5.0), 2, 1}), -1);
    EXPECT_EQ(grid.find({-0.0, 0, 0}), 0);
    EXPECT_EQ(grid.find({std::nextafter(0.0, -1.0), 0, 0}), -1);
}

TEST(CellGrid, WhatIsNoPlaceIsOutside) {
    CellGrid grid = unit_grid();
    for (double x : {std::nan(""), double(INFINITY), -double(INFINITY), 1e308, -1e308})
        for (int axis = 0; axis < 3; ++axis) {
            Vec3d eye{0.5, 0.5, 0.5};
            eye[axis] = x;
            EXPECT_EQ(grid.find(eye), -1);
        }
    EXPECT_EQ(CellGrid{}.find({0, 0, 0}), -1);
}

/// The last cell, in the order of the index, whose box holds the point.
std::int64_t find_by_search(const CellGrid& grid, const Vec3d& eye) {
    for (std::uint64_t c = grid.cells(); c-- > 0;)
        if (grid.cell(c).contains(eye))
            return std::int64_t(c);
    return -1;
}

TEST(CellGrid, FindAgreesWithASearchOverTheBoxes) {
    EXPECT_TRUE(rc::check("also on borders, next to them, far from the origin and with thin cells", [](std::uint64_t seed) {
        Random random(seed);
        CellGrid grid;
        // From wide cells to some thinner than the spacing of doubles there.
        double far = random.below(2) ? 1e6 : 0, extent = std::array{100.0, 1e-3, 1e-9, 1e-10}[random.below(4)];
        for (int k = 0; k < 3; ++k) {
            grid.count[static_cast<std::size_t>(k)] = 1 + random.below(7);
            grid.bounds.min[k] = far * random.uniform(-1, 1);
            grid.bounds.max[k] = grid.bounds.min[k] + extent * random.uniform(0, 1);
        }
        for (int round = 0; round < 20; ++round) {
            Box3d box = grid.cell(random.below(std::uint32_t(grid.cells())));
            Vec3d eye;
            for (int k = 0; k < 3; ++k) {
                double border = random.below(2) ? box.min[k] : box.max[k];
                std::uint32_t how = random.below(4);
                eye[k] = how == 0   ? border
                         : how == 1 ? std::nextafter(border, -INFINITY)
                         : how == 2 ? std::nextafter(border, INFINITY)
                                    : random.uniform(box.min[k], box.max[k]);
            }
            RC_ASSERT(grid.find(eye) == find_by_search(grid, eye));
        }
    }));
}

TEST(CellGrid, ManyThinCellsAreSearchedQuickly) {
    CellGrid grid{{{1e15, 0, 0}, {1e15 + 1, 1, 1}}, {4294967295u, 1, 1}};
    std::int64_t cell = grid.find({1e15 + 0.5, 0.5, 0.5});
    ASSERT_GE(cell, 0);
    EXPECT_TRUE(grid.cell(std::uint64_t(cell)).contains({1e15 + 0.5, 0.5, 0.5}));
}

} // namespace
} // namespace antumbra
