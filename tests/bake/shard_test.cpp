// A bake in parts, united: the same bytes as in one go.
#include "support/make_scene.hpp"

#include <antumbra/bake.hpp>

#include <nlohmann/json.hpp>

namespace antumbra {
namespace {

Scene yard() {
    test::SceneMaker maker;
    for (int k = 0; k < 6; ++k) {
        double x = 4.0 * k;
        maker.object("house " + std::to_string(k)).box({x, 0, k % 2 * 3.0}, {x + 3, 2, k % 2 * 3.0 + 2});
        maker.object("bin " + std::to_string(k)).box({x + 3.2, 0, 1}, {x + 3.6, 0.7, 1.5});
    }
    return maker.scene();
}

BakeOptions options(const std::string& method) {
    BakeOptions o;
    o.method = method;
    o.cells = {5, 1, 3};
    o.rays_per_cell = 500;
    o.holdout_rays = 50;
    o.sequential.most_rays = 64;
    return o;
}

/// `pvs` reads from `bytes`: a part may move, but a copy would read what belongs to another.
struct Part {
    Part() = default;
    Part(Part&&) = default;
    Part& operator=(Part&&) = default;
    std::vector<std::byte> bytes;
    std::optional<Pvs> pvs;
};

std::vector<std::byte> encoded(const Scene& scene, const BakeOptions& o) {
    Result<BakeResult> result = bake(scene, o);
    EXPECT_TRUE(result) << result.status().message();
    return *encode_pvs(result->pvs);
}

std::vector<Part> parts_of(const Scene& scene, BakeOptions o, std::uint32_t count) {
    std::vector<Part> parts(count);
    for (std::uint32_t k = 0; k < count; ++k) {
        o.shard = {k, count};
        parts[k].bytes = encoded(scene, o);
        parts[k].pvs.emplace(*Pvs::open(parts[k].bytes));
    }
    return parts;
}

Part part_of(const Scene& scene, const BakeOptions& o, std::uint32_t count, std::uint32_t k) {
    return std::move(parts_of(scene, o, count)[k]);
}

Result<PvsData> merge(const std::vector<Part>& parts, std::vector<std::size_t> order) {
    std::vector<Pvs> pvs;
    std::vector<std::string> names;
    for (std::size_t k : order) {
        pvs.push_back(*parts[k].pvs);
        names.push_back("part" + std::to_string(k));
    }
    return merge_parts(pvs, names);
}

void expect_same_bytes(const Scene& scene, const BakeOptions& o) {
    std::vector<std::byte> whole = encoded(scene, o);
    std::vector<Part> parts = parts_of(scene, o, 3);
    for (std::vector<std::size_t> order : {std::vector<std::size_t>{0, 1, 2}, {2, 0, 1}}) {
        Result<PvsData> merged = merge(parts, order);
        ASSERT_TRUE(merged) << merged.status().message();
        EXPECT_EQ(*encode_pvs(*merged), whole);
    }
}

TEST(Shards, OfASampledGridMergeToTheSameBytes) {
    BakeOptions o = options("sampled");
    o.volumes = {3, 1, 2};
    expect_same_bytes(yard(), o);
}

TEST(Shards, OfPartOfTheSpaceMergeToTheSameBytes) {
    BakeOptions o = options("sampled");
    o.cell_size = 1.5;
    o.where = {{{0, 0, -2}, {6, 1, 0}}, {{14, 0, 3}, {18, 1, 6}}};
    expect_same_bytes(yard(), o);
}

TEST(Shards, OfAnExactGridMergeToTheSameBytes) { expect_same_bytes(yard(), options("exact")); }

TEST(Shards, OfAnExactGridWithAnExhaustedBudgetAreConservativeTogether) {
    Scene scene = yard();
    BakeOptions o = options("exact");
    o.exact.max_pieces = 1;
    expect_same_bytes(scene, o);
}

TEST(Shards, OfAViewTreeMergeToTheSameBytes) {
    for (Subdivision subdivision : {Subdivision::spatial, Subdivision::angular, Subdivision::five}) {
        BakeOptions o = options("sampled");
        o.tree.subdivision = subdivision;
        o.tree.node_rays = 200;
        o.tree.tile_depth = 3;
        o.tree.max_depth = 3;
        expect_same_bytes(yard(), o);
    }
}

TEST(Shards, MoreThanCellsMergeToo) {
    Scene scene = yard();
    BakeOptions o = options("sampled");
    o.cells = {2, 1, 1};
    std::vector<Part> parts = parts_of(scene, o, 4);
    Result<PvsData> merged = merge(parts, {0, 1, 2, 3});
    ASSERT_TRUE(merged) << merged.status().message();
    EXPECT_EQ(*encode_pvs(*merged), encoded(scene, o));
}

TEST(Shards, APartAloneSeesEverythingElsewhere) {
    std::vector<Part> parts = parts_of(yard(), options("exact"), 3);
    std::size_t baked = 0, open = 0;
    for (std::uint64_t cell = 0; cell < 15; ++cell) {
        baked += parts[1].pvs->cell_row(cell) != kCellNotBaked;
        PvsCursor cursor;
        parts[1].pvs->query(parts[1].pvs->grid().cell(cell).centre(), cursor);
        open += cursor.everything;
    }
    EXPECT_EQ(baked, 5u);
    EXPECT_GE(open, 10u);
}

TEST(Shards, MissingTwiceAndForeignPartsAreRefused) {
    Scene scene = yard();
    BakeOptions o = options("sampled");
    std::vector<Part> parts = parts_of(scene, o, 3);
    auto problem = [&](std::vector<std::size_t> order) { return merge(parts, order).status().message(); };
    EXPECT_NE(problem({0, 2}).find("missing: 2"), std::string::npos);
    EXPECT_NE(problem({0, 1, 1, 2}).find("part1: is shard 2 of 3, as is part1"), std::string::npos) << problem({0, 1, 1, 2});
    EXPECT_EQ(merge(parts, {}).status().code(), ErrorCode::usage);
    o.seed = 2;
    parts.push_back(part_of(scene, o, 3, 2));
    EXPECT_NE(problem({0, 1, 3}).find("part3: belongs to another bake than part0"), std::string::npos);
    o = options("sampled");
    parts[3] = part_of(scene, o, 4, 2);
    EXPECT_NE(problem({0, 1, 3}).find("another bake"), std::string::npos);
    parts[3].bytes = encoded(scene, o);
    parts[3].pvs.emplace(*Pvs::open(parts[3].bytes));
    EXPECT_NE(problem({0, 1, 3}).find("part3: is no part"), std::string::npos);
    o.where = {{{0, 0, 0}, {23.6, 2, 5}}, {{1, 0, 1}, {2, 1, 2}}}; // the same grid, all cells
    parts[3] = part_of(scene, o, 3, 2);
    EXPECT_TRUE(merge(parts, {0, 1, 3}).ok());
    o.where = {{{0, 0, 0}, {0, 2, 0}}, {{23.6, 0, 5}, {23.6, 2, 5}}}; // the same grid, two of its cells
    parts[3] = part_of(scene, o, 3, 1);
    parts[2] = part_of(scene, o, 3, 2);
    EXPECT_NE(problem({0, 3, 2}).find("another bake"), std::string::npos) << problem({0, 3, 2});
    o.shard = {3, 3};
    EXPECT_EQ(bake(scene, o).status().code(), ErrorCode::usage);
}

} // namespace
} // namespace antumbra
