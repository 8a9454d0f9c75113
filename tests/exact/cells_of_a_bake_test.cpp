// Which cells an exact bake has: boxes that were given, adaptive ones, blocks solved from the outside in.
#include "bake/box_cells.hpp"
#include "bake/exact/adaptive_tree.hpp"
#include "village.hpp"

#include <antumbra/bake.hpp>
#include <antumbra/compare.hpp>

#include <gtest/gtest.h>

#include <cmath>
#include <filesystem>

namespace antumbra {
namespace {

/// What a file lists from a point.
std::vector<std::uint64_t> listed_from(const std::vector<std::byte>& file, const Vec3d& eye) {
    Result<Pvs> pvs = Pvs::open(file);
    EXPECT_TRUE(pvs.ok());
    PvsCursor cursor;
    pvs->query(eye, cursor);
    EXPECT_FALSE(cursor.everything);
    return cursor.visible;
}

std::vector<std::byte> encoded(const Scene& scene, const BakeOptions& options, unsigned threads = 1) {
    Job job;
    job.threads = threads;
    Result<BakeResult> baked = bake(scene, options, job);
    EXPECT_TRUE(baked.ok()) << baked.status().message();
    return baked.ok() ? *encode_pvs(baked->pvs) : std::vector<std::byte>();
}

BakeOptions with_boxes(std::vector<Box3d> boxes) {
    BakeOptions o = exact_options();
    o.tree.subdivision = Subdivision::boxes;
    o.where = std::move(boxes);
    return o;
}

/// Whole grid steps, so that no box has to be moved.
Box3d on_places(const Scene& scene, const BoxCells& cells, const Box3d& box) {
    Box3d out;
    for (int k = 0; k < 3; ++k) {
        double place = (cells.tree.bounds.max[k] - cells.tree.bounds.min[k]) / double(kViewSteps);
        auto at = [&](double x) {
            return cells.tree.bounds.min[k] + std::floor((x - cells.tree.bounds.min[k]) / place + 0.5) * place;
        };
        out.min[k] = at(box.min[k]);
        out.max[k] = at(box.max[k]);
    }
    (void)scene;
    return out;
}

TEST(BoxCells, GivenBoxesAreTheCells) {
    Scene scene = village();
    std::vector<Box3d> boxes = {{{-3, 1, -3}, {-1, 2, -1}}, {{10, 1, 5}, {12, 2, 7}}, {{12, 1, 5}, {15, 2, 7}}};
    Result<BoxCells> cells = lay_box_cells(scene, boxes);
    ASSERT_TRUE(cells.ok());
    ASSERT_EQ(cells->regions.size(), 3u);
    for (const Box3d& wanted : boxes) {
        bool found = false;
        for (const ViewRegion& region : cells->regions) {
            Box3d box = cells->tree.spatial_box(region);
            double off = 0;
            for (int k = 0; k < 3; ++k)
                off = std::max({off, std::abs(box.min[k] - wanted.min[k]), std::abs(box.max[k] - wanted.max[k])});
            found |= off <= 18.0 / 65536; // half a place, of 18 units
        }
        EXPECT_TRUE(found) << wanted.min.x;
    }
}

TEST(BoxCells, FacesLieOnTheScenesGrid) {
    Scene scene = village();
    Result<BoxCells> cells = lay_box_cells(scene, std::vector<Box3d>{{{-3.1, 1.7, -3.3}, {-1.2, 2.4, -1}}, {{10.7, 1, 5}, {12.3, 2, 7}}});
    ASSERT_TRUE(cells.ok());
    for (const ViewRegion& region : cells->regions) {
        Box3d box = cells->tree.spatial_box(region);
        for (int k = 0; k < 3; ++k)
            for (double at : {scene.to_local(box.min)[k], scene.to_local(box.max)[k]})
                EXPECT_EQ(std::floor(at / scene.step()) * scene.step(), at);
    }
}

TEST(BoxCells, OverlappingAndInterlockingBoxesAreCutAndCoverTheSameSpace) {
    Scene scene = village();
    // Two that overlap, and four that no single plane separates (a pinwheel).
    std::vector<Box3d> boxes = {{{0, 1, 0}, {4, 2, 4}},     {{2, 1, 2}, {6, 2, 6}},     {{10, 0, 10}, {13, 1, 11}},
                                {{13, 0, 10}, {14, 1, 13}}, {{11, 0, 13}, {14, 1, 14}}, {{10, 0, 11}, {11, 1, 14}}};
    Result<BoxCells> cells = lay_box_cells(scene, boxes);
    ASSERT_TRUE(cells.ok());
    EXPECT_GT(cells->regions.size(), 6u);
    ASSERT_TRUE(cells->tree.check(std::uint32_t(cells->regions.size())).ok());
    std::vector<Box3d> moved;
    for (const Box3d& box : boxes)
        moved.push_back(on_places(scene, *cells, box));
    Random random(5);
    for (int n = 0; n < 20000; ++n) {
        Vec3d p{random.uniform(-1, 15), random.uniform(-0.5, 2.5), random.uniform(-1, 15)};
        int held = 0;
        for (const ViewRegion& region : cells->regions)
            held += cells->tree.spatial_box(region).contains(p);
        bool wanted = false;
        for (const Box3d& box : moved)
            wanted |= box.contains(p);
        EXPECT_EQ(held, wanted ? 1 : 0) << p.x << " " << p.y << " " << p.z;
    }
}

TEST(BoxCells, AnAnswerIsThatOfTheSameBoxInAGrid) {
    Scene scene = village();
    BakeOptions grid = exact_options();
    grid.where = {{{4, 0.5, 5}, {12, 2.5, 9}}};
    grid.cells = {2, 1, 1};
    Result<BakeResult> as_grid = bake(scene, grid);
    ASSERT_TRUE(as_grid.ok());
    std::vector<Box3d> boxes;
    for (std::uint64_t c = 0; c < as_grid->pvs.grid.cells(); ++c)
        boxes.push_back(as_grid->pvs.grid.cell(c));
    std::vector<std::byte> given = encoded(scene, with_boxes(boxes)), file = *encode_pvs(as_grid->pvs);
    for (const Box3d& box : boxes)
        EXPECT_EQ(listed_from(file, box.centre()), listed_from(given, box.centre()));
}

TEST(BoxCells, SampledBakesTakeThemToo) {
    Scene scene = village();
    BakeOptions o = with_boxes({{{10, 1, 5}, {12, 2, 7}}, {{-3, 1, -3}, {-1, 2, -1}}});
    std::vector<std::byte> exact = encoded(scene, o);
    o.method = "sampled";
    std::vector<std::byte> sampled = encoded(scene, o);
    Result<Pvs> a = Pvs::open(exact), b = Pvs::open(sampled);
    Result<CompareResult> compared = compare(scene, *a, *b);
    ASSERT_TRUE(compared.ok()) << compared.status().message();
    EXPECT_EQ(compared->pieces, 2u);
    EXPECT_EQ(compared->pieces_bound, 2u); // the same cells, so one set holds the other
    EXPECT_EQ(compared->contradictions, 0u);
}

TEST(BoxCells, NoneAndSenselessOnesAreRefused) {
    Scene scene = village();
    EXPECT_FALSE(bake(scene, with_boxes({})).ok());
    Result<BakeResult> bad = bake(scene, with_boxes({{{0, 0, 0}, {-1, 1, 1}}}));
    ASSERT_FALSE(bad.ok());
    EXPECT_NE(bad.status().message().find("min must not exceed max"), std::string::npos);
    EXPECT_FALSE(bake(scene, with_boxes({{{0, 0, 0}, {INFINITY, 1, 1}}})).ok());
    // far outside of what the solver's integers hold
    EXPECT_FALSE(bake(scene, with_boxes({{{1e6, 0, 0}, {1e6 + 1, 1, 1}}})).ok());
}

/// For each way to cut space: the same bytes for any threads, whether resumed, and from shards.
void expect_same_bytes(const Scene& scene, BakeOptions o, const std::string& name) {
    std::vector<std::byte> one = encoded(scene, o, 1), three = encoded(scene, o, 3);
    EXPECT_EQ(one, three) << name;
    BakeOptions kept = o;
    kept.checkpoint = ::testing::TempDir() + "cells_" + name + ".part";
    std::filesystem::remove(kept.checkpoint);
    ASSERT_TRUE(bake(scene, kept).ok());
    // A torn file: what is whole is taken up, the rest is baked again.
    std::filesystem::resize_file(kept.checkpoint, std::filesystem::file_size(kept.checkpoint) * 2 / 3);
    kept.resume = true;
    Result<BakeResult> again = bake(scene, kept);
    ASSERT_TRUE(again.ok()) << again.status().message();
    EXPECT_GT(again->statistics.cells_resumed + again->statistics.tiles_resumed, 0u) << name;
    EXPECT_EQ(*encode_pvs(again->pvs), one) << name;
    std::filesystem::remove(kept.checkpoint);
    std::vector<std::vector<std::byte>> files;
    std::vector<Pvs> parts;
    std::vector<std::string> names;
    for (std::uint32_t shard = 0; shard < 3; ++shard) {
        o.shard = {shard, 3};
        files.push_back(encoded(scene, o));
        names.push_back(std::to_string(shard));
    }
    for (const std::vector<std::byte>& file : files)
        parts.push_back(*Pvs::open(file));
    Result<PvsData> merged = merge_parts(parts, names);
    ASSERT_TRUE(merged.ok()) << name << ": " << merged.status().message();
    EXPECT_EQ(*encode_pvs(*merged), one) << name;
}

TEST(ExactCellsOfABake, GiveTheSameBytesWhateverTheThreadsTheInterruptionsAndTheShards) {
    Scene scene = village();
    expect_same_bytes(scene, with_boxes({{{0, 1, 5}, {4, 2, 9}}, {{2, 1, 7}, {6, 2, 9.5}}, {{-3, 1, -3}, {-1, 2, -1}}}), "boxes");
    BakeOptions blocks = exact_options();
    blocks.cells = {6, 1, 4};
    blocks.exact.block = 2;
    expect_same_bytes(scene, blocks, "blocks");
    BakeOptions adaptive = exact_options();
    adaptive.tree.subdivision = Subdivision::spatial;
    adaptive.tree.min_extent = 1.0 / 4;
    adaptive.exact.granularity = Granularity::cluster;
    adaptive.exact.cluster_triangles = 4;
    expect_same_bytes(scene, adaptive, "adaptive");
}

TEST(ExactBlocks, ListWhatCellsAloneList) {
    Scene scene = village();
    BakeOptions o = exact_options();
    o.cells = {8, 2, 8};
    o.exact.granularity = Granularity::triangle;
    Result<BakeResult> alone = bake(scene, o);
    ASSERT_TRUE(alone.ok());
    for (std::uint32_t block : {2u, 4u, 8u}) {
        o.exact.block = block;
        Result<BakeResult> blocks = bake(scene, o);
        ASSERT_TRUE(blocks.ok());
        EXPECT_EQ(alone->pvs.rows, blocks->pvs.rows) << block;
        EXPECT_EQ(alone->pvs.cell_row, blocks->pvs.cell_row) << block;
        EXPECT_EQ(blocks->statistics.exact.undecided, 0u);
    }
    o.exact.block = 3;
    EXPECT_FALSE(bake(scene, o).ok());
}

/// Triangles that are drawn from one side only: hidden ones lie in plain sight, turned away.
Scene one_sided(std::uint64_t seed) {
    RawScene raw;
    raw.source = "one-sided";
    Random random(seed);
    for (int o = 0; o < 40; ++o) {
        RawObject object;
        object.name = std::to_string(o);
        object.flags = kOccludes;
        object.first_triangle = std::uint32_t(raw.triangles.size());
        object.triangle_count = 6;
        Vec3d at{random.uniform(-10, 10), random.uniform(-3, 3), random.uniform(-10, 10)};
        for (int t = 0; t < 6; ++t) {
            auto first = std::uint32_t(raw.positions.size());
            for (int c = 0; c < 3; ++c)
                raw.positions.push_back(at + Vec3d{random.uniform(-2, 2), random.uniform(-2, 2), random.uniform(-2, 2)});
            raw.triangles.push_back({first, first + 1, first + 2});
        }
        raw.objects.push_back(object);
    }
    Result<Scene> scene = Scene::create(std::move(raw));
    EXPECT_TRUE(scene.ok());
    return std::move(*scene);
}

TEST(ExactBlocks, AHiddenTriangleDoesNotHideWhatLiesInItsBox) {
    for (std::uint64_t seed = 1; seed <= 6; ++seed) {
        Scene scene = one_sided(seed);
        BakeOptions o = exact_options();
        o.cells = {4, 2, 4};
        o.where = {{{-4, -2, -4}, {4, 2, 4}}};
        o.exact.granularity = seed % 2 ? Granularity::triangle : Granularity::object;
        Result<BakeResult> alone = bake(scene, o);
        o.exact.block = 4;
        Result<BakeResult> blocks = bake(scene, o);
        ASSERT_TRUE(alone.ok() && blocks.ok());
        EXPECT_EQ(alone->pvs.rows, blocks->pvs.rows) << seed;
        EXPECT_EQ(alone->pvs.cell_row, blocks->pvs.cell_row) << seed;
    }
}

TEST(AdaptiveCells, EveryLeafListsWhatASoleCellOfThatBoxLists) {
    Scene scene = village();
    BakeOptions o = exact_options();
    o.tree.subdivision = Subdivision::spatial;
    o.tree.min_extent = 1.0 / 8;
    Result<BakeResult> tree = bake(scene, o);
    ASSERT_TRUE(tree.ok()) << tree.status().message();
    EXPECT_EQ(tree->pvs.guarantee, Guarantee::exact);
    std::vector<std::byte> file = *encode_pvs(tree->pvs);
    Tracer tracer = Tracer::build(scene, {});
    SamplingScene shared(tracer, o);
    ExactCells cells(shared);
    std::uint64_t leaves = 0;
    std::vector<std::pair<std::uint32_t, ViewRegion>> open = {{0, ViewRegion()}};
    while (!open.empty()) {
        auto [at, region] = open.back();
        open.pop_back();
        const ViewNode& node = tree->pvs.tree.nodes[at];
        if (node.axis != ViewNode::kLeaf) {
            ViewRegion below = region, above = region;
            below.high[node.axis] = above.low[node.axis] = node.split;
            open.push_back({at + 1, below});
            open.push_back({node.link, above});
            continue;
        }
        ++leaves;
        Box3d box = tree->pvs.tree.spatial_box(region);
        ExactCell alone = cells.solve(box);
        ASSERT_EQ(alone.sample.solid, node.link == kCellSolid);
        if (!alone.sample.solid) {
            EXPECT_EQ(alone.sample.visible, listed_from(file, box.centre()));
        }
    }
    EXPECT_EQ(leaves, tree->statistics.cells);
    EXPECT_GT(leaves, 8u);
}

TEST(AdaptiveCells, AreFineWhereItPaysAndCoarseWhereNothingChanges) {
    Scene scene = village();
    auto cells = [&](double effectiveness) {
        BakeOptions o = exact_options();
        o.tree.subdivision = Subdivision::spatial;
        o.tree.min_extent = 1.0 / 8;
        o.tree.effectiveness = effectiveness;
        Result<BakeResult> result = bake(scene, o);
        EXPECT_TRUE(result.ok());
        return result->statistics.cells;
    };
    std::uint64_t tiles = 4, all = cells(0), some = cells(0.1), none = cells(1);
    EXPECT_EQ(none, tiles);
    EXPECT_GT(some, none);
    EXPECT_GT(all, some);
}

TEST(AdaptiveCells, WhereLimitsThemToSomeSpace) {
    Scene scene = village();
    BakeOptions o = exact_options();
    o.tree.subdivision = Subdivision::spatial;
    o.tree.min_extent = 1.0 / 8;
    o.tree.tile_depth = 1;
    o.where = {{{0, 1, 5}, {4, 2, 9}}, {{20, 1, 5}, {24, 2, 9}}};
    Result<BakeResult> result = bake(scene, o);
    ASSERT_TRUE(result.ok()) << result.status().message();
    EXPECT_GT(result->statistics.cells_not_baked, 0u); // between the two
    Result<Pvs> pvs = Pvs::open(*encode_pvs(result->pvs));
    std::vector<std::byte> file = *encode_pvs(result->pvs);
    pvs = Pvs::open(file);
    PvsCursor cursor;
    pvs->query({12, 1.5, 7}, cursor);
    EXPECT_TRUE(cursor.everything);
    pvs->query({2, 1.5, 6}, cursor);
    EXPECT_FALSE(cursor.everything);
}

} // namespace
} // namespace antumbra
