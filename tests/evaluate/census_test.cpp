#include "evaluate/census.hpp"

#include <gtest/gtest.h>

namespace antumbra {
namespace {

/// Three objects of 10, 1 and 5 triangles; four cells: sees 0 and 1, sees 1, solid, not baked.
PvsData four_cells() {
    PvsData data;
    data.guarantee = Guarantee::exact;
    data.method = "test";
    data.grid = {{{0, 0, 0}, {4, 1, 1}}, {4, 1, 1}};
    for (std::uint32_t triangles : {10u, 1u, 5u}) {
        PvsObject object;
        object.triangle_count = triangles;
        object.bounds = {{0, 0, 0}, {1, 1, 1}};
        object.name = "</script>";
        data.objects.push_back(object);
    }
    data.cell_row = {0, 1, kCellSolid, kCellNotBaked};
    data.row_count = 2;
    data.rows = {0b011, 0b010};
    return data;
}

TEST(Census, CountsCellsAndObjects) {
    std::vector<std::byte> bytes = encode_pvs(four_cells()).value();
    Pvs pvs = Pvs::open(bytes).value();
    Census census = take_census(pvs);
    EXPECT_EQ(census.cells.size(), 4u);
    EXPECT_EQ(census.baked, 2u);
    EXPECT_EQ(census.solid, 1u);
    EXPECT_EQ(census.not_baked, 1u);
    EXPECT_EQ(census.mean_visible, 1.5);
    EXPECT_EQ(census.mean_visible_triangles, 6);
    ASSERT_EQ(census.worst(1).size(), 1u);
    EXPECT_EQ(census.worst(1)[0].index, 0u);
    EXPECT_EQ(census.worst(9).size(), 2u);
}

TEST(Census, CostliestObjectsByTrianglesTimesCells) {
    std::vector<std::byte> bytes = encode_pvs(four_cells()).value();
    Pvs pvs = Pvs::open(bytes).value();
    std::vector<CensusObject> costliest = costliest_objects(pvs, take_census(pvs), 2);
    ASSERT_EQ(costliest.size(), 2u);
    EXPECT_EQ(costliest[0].object, 0u);
    EXPECT_EQ(costliest[0].cost, 10u);
    EXPECT_EQ(costliest[1].object, 1u);
    EXPECT_EQ(costliest[1].cells, 2u);
}

TEST(Census, LeavesOfATreeAreItsCells) {
    PvsData data = four_cells();
    data.grid = {};
    data.cell_row = {};
    data.tree.bounds = {{0, 0, 0}, {4, 1, 1}};
    data.tree.nodes = {{0, 16384, 2}, {ViewNode::kLeaf, 0, 1}, {3, 32768, 4}, {ViewNode::kLeaf, 0, 0},
                       {ViewNode::kLeaf, 0, kCellSolid}};
    std::vector<std::byte> bytes = encode_pvs(data).value();
    Pvs pvs = Pvs::open(bytes).value();
    Census census = take_census(pvs);
    ASSERT_EQ(census.cells.size(), 3u);
    EXPECT_EQ(census.cells[0].box.max.x, 1);
    EXPECT_EQ(census.cells[0].visible, 1u);
    EXPECT_EQ(census.cells[1].region.high[3], 32768u);
    EXPECT_EQ(census.solid, 1u);
}

// A hostile name cannot end the script.
TEST(Census, PageStandsAlone) {
    std::vector<std::byte> bytes = encode_pvs(four_cells()).value();
    Pvs pvs = Pvs::open(bytes).value();
    std::string page = census_page(pvs, take_census(pvs), "a <b> title");
    EXPECT_EQ(page.find("</script>"), page.rfind("</script>"));
    EXPECT_EQ(page.find("http"), std::string::npos);
    EXPECT_NE(page.find("\\u003cb> title"), std::string::npos);
}

} // namespace
} // namespace antumbra
