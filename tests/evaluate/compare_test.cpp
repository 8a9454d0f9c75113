#include "evaluate/spatial_cells.hpp"
#include "evaluate/two_rooms.hpp"

#include <antumbra/bake.hpp>
#include <antumbra/compare.hpp>

namespace antumbra {
namespace {

using test::OpenFile;
using test::two_cells;
using test::two_rooms;

struct Two {
    Scene scene = two_rooms().scene();
    PvsData a = two_cells(scene, Guarantee::exact), b = two_cells(scene, Guarantee::exact);
    CompareResult compare(CompareOptions options = {}) {
        OpenFile file_a(a), file_b(b);
        Result<CompareResult> result = antumbra::compare(scene, *file_a.pvs, *file_b.pvs, options);
        EXPECT_TRUE(result) << result.status().message();
        return result ? *result : CompareResult();
    }
};

TEST(Compare, AFileWithItselfHasNoDifference) {
    CompareResult result = Two().compare();
    EXPECT_TRUE(result.same_cells);
    EXPECT_EQ(result.pieces, 2u);
    EXPECT_EQ(result.pieces_bound, 2u);
    EXPECT_EQ(result.pairs_both, 4u);
    EXPECT_EQ(result.a.pairs_only + result.b.pairs_only + result.contradictions, 0u);
    EXPECT_DOUBLE_EQ(result.common_of_a, 1);
    EXPECT_DOUBLE_EQ(result.a.mean_objects, 2);
    EXPECT_EQ(result.viewpoints, 64u);
    EXPECT_EQ(result.pixels, 64u * 6 * 32 * 32);
    EXPECT_EQ(result.a.pixels_only + result.b.pixels_only, 0u);
}

TEST(Compare, AnExactSetMustLieWithinAConservativeOne) {
    Two two;
    two.b.guarantee = Guarantee::conservative;
    two.b.rows = {0b1111, 0b1110};
    CompareResult result = two.compare();
    EXPECT_EQ(result.contradictions, 0u);
    EXPECT_EQ(result.b.pairs_only, 3u);
    EXPECT_EQ(result.b.objects_only, 0u); // each is seen from its own room in A
    two.b.rows = {0b0111, 0b0010}; // the right crate is lost
    result = two.compare();
    EXPECT_EQ(result.contradictions, 1u);
    ASSERT_EQ(result.first.size(), 1u);
    EXPECT_EQ(result.first[0].object, 3u);
    EXPECT_EQ(result.first[0].cell_b, 1u);
    EXPECT_TRUE(result.first[0].a_sees);
    EXPECT_EQ(result.a.objects_only, 1u);
    EXPECT_GT(result.a.pixels_only, 100u);
    ASSERT_EQ(result.only_a.size(), 1u);
    EXPECT_EQ(result.only_a[0].object, 3u);
    EXPECT_EQ(result.only_a[0].pixels, result.a.pixels_only);
    EXPECT_DOUBLE_EQ(result.only_a[0].volume, 0.5);
}

TEST(Compare, ASamplerMayMissAndAnAggressiveListMayNotAdd) {
    Two two;
    two.b.guarantee = Guarantee::aggressive;
    two.b.rows = {0b0001, 0b1010};
    EXPECT_EQ(two.compare().contradictions, 0u);
    two.b.rows = {0b1101, 0b1010};
    CompareResult result = two.compare();
    EXPECT_EQ(result.contradictions, 1u);
    EXPECT_FALSE(result.first[0].a_sees);
    two.a.guarantee = two.b.guarantee; // two samplers owe each other nothing
    EXPECT_EQ(two.compare().contradictions, 0u);
    two.a.guarantee = two.b.guarantee = Guarantee::conservative;
    EXPECT_EQ(two.compare().contradictions, 0u);
}

TEST(Compare, DifferentGridsMeetInPieces) {
    Two two;
    two.b.grid.bounds = {{-4, 0, 0}, {8, 3, 4}};
    two.b.grid.count = {4, 1, 1}; // edges at -1, 2, 5
    two.b.cell_row = {0, 0, 1, kCellNotBaked};
    CompareResult result = two.compare();
    EXPECT_FALSE(result.same_cells);
    EXPECT_EQ(result.pieces, 4u); // [-4,-1] [-1,0] | [0,2] [2,4]
    EXPECT_DOUBLE_EQ(result.common_of_a, 1);
    EXPECT_DOUBLE_EQ(result.common_of_b, 8.0 / 9);
    EXPECT_EQ(result.b.cells, 3u);
    // [0,2]: A says right, B says left.
    EXPECT_EQ(result.a.pairs_only, 2u);
    EXPECT_EQ(result.b.pairs_only, 2u);
    EXPECT_DOUBLE_EQ(result.a.mean_only, 2 * 0.25);
    // Only [-4,-1] of B lies within a cell of A; B's cell [-1,2] sees more than A's [0,4].
    EXPECT_EQ(result.pieces_bound, 1u);
    EXPECT_EQ(result.contradictions, 0u);
}

TEST(Compare, NothingInCommonOrAnotherSceneIsAnError) {
    Two two;
    two.b.grid.bounds = {{100, 0, 0}, {104, 3, 4}};
    OpenFile a(two.a), b(two.b);
    EXPECT_EQ(compare(two.scene, *a.pvs, *b.pvs).status().code(), ErrorCode::usage);
    two.b.scene_fingerprint[0] ^= 1;
    OpenFile other(two.b);
    EXPECT_EQ(compare(two.scene, *a.pvs, *other.pvs).status().code(), ErrorCode::mismatch);
}

TEST(SpatialCells, OfATreeAreThePiecesBetweenItsSpatialSplits) {
    Two two;
    PvsData& data = two.a;
    data.tree.bounds = data.grid.bounds;
    data.grid = {};
    data.cell_row.clear();
    // First a split of directions, below it one of x, above it one of z: four pieces of space, two leaves each.
    data.tree.nodes = {{3, kViewSteps / 2, 4},         {0, kViewSteps / 2, 3},        {ViewNode::kLeaf, 0, 0},
                       {ViewNode::kLeaf, 0, 1},        {2, kViewSteps / 4, 6},        {ViewNode::kLeaf, 0, 2},
                       {ViewNode::kLeaf, 0, 3}};
    data.row_count = 4;
    data.rows = {1, 2, 4, 8};
    OpenFile file(data);
    std::vector<SpatialCell> cells = spatial_cells(*file.pvs);
    ASSERT_EQ(cells.size(), 4u);
    double sum = 0;
    for (const SpatialCell& cell : cells) {
        sum += volume(cell.box);
        ASSERT_EQ(cell.rows.size(), 2u);
        std::vector<std::uint64_t> bits;
        unite_rows(*file.pvs, cell, bits);
        Vec3d middle = cell.box.centre();
        EXPECT_EQ(bits[0], (middle.x < 0 ? 1u : 2u) | (middle.z < 1 ? 4u : 8u));
        // The cell's own pieces: half of x and all of z, all of x and part of z.
        EXPECT_EQ(cell.inner, cell.box);
        EXPECT_EQ(cell.outer, data.tree.bounds);
    }
    EXPECT_DOUBLE_EQ(sum, volume(data.tree.bounds));
}

TEST(SpatialCells, OfATreeAgreeWithItsQueries) {
    Scene scene = two_rooms().scene();
    BakeOptions options;
    options.tree.subdivision = Subdivision::five;
    options.tree.tile_depth = 1;
    options.tree.node_rays = 256;
    options.rays_per_cell = 64;
    options.holdout_rays = 0;
    options.sequential.most_rays = 16;
    Result<BakeResult> baked = bake(scene, options);
    ASSERT_TRUE(baked) << baked.status().message();
    OpenFile file(baked->pvs);
    std::vector<std::uint64_t> bits;
    PvsCursor cursor;
    std::size_t compared = 0;
    for (const SpatialCell& cell : spatial_cells(*file.pvs)) {
        unite_rows(*file.pvs, cell, bits);
        file.pvs->query(cell.box.centre(), cursor);
        if (!cursor.everything) {
            EXPECT_EQ(bits, cursor.visible);
            ++compared;
        }
    }
    EXPECT_GT(compared, 2u);
}

} // namespace
} // namespace antumbra
