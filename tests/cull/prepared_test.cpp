// A prepared file holds the same CullScene, bit for bit; a damaged or hostile one is refused or culls safely.
#include "cull/proof.hpp"
#include "cull/scene_data.hpp"
#include "pvs/reseal.hpp"
#include "support/make_scene.hpp"

#include <antumbra/bake.hpp>
#include <antumbra/generate.hpp>

#include <algorithm>
#include <map>
#include <set>

namespace antumbra {
namespace {

using test::Stage;
using Bytes = std::vector<std::byte>;

Stage office() {
    GenerateOptions options;
    options.triangles = 20000;
    Result<Scene> scene = Scene::create(*generate("office", options));
    return Stage(std::move(*scene));
}

constexpr PrepareOptions kFew{.per_set = 64, .first_hit_leaves = 4};

Bytes prepared(const Stage& stage, const PrepareOptions& options = kFew) {
    return *add_pvs_chunks(*encode_pvs(describe_scene(*stage.scene)), *prepare_chunks(stage.cull_scene, options));
}

/// A few walls and a box: a file of some kilobytes.
Stage small_stage() {
    test::SceneMaker maker;
    maker.object("floor").quad({0, 0, 0}, {0, 0, 8}, {8, 0, 8}, {8, 0, 0});
    for (int i = 0; i < 5; ++i)
        maker.object("box").box({i * 1.5, 0, i * 1.0}, {i * 1.5 + 1, 1.0 + i, i + 0.5});
    maker.object("curtain", kOccludes | kDoubleSided).quad({0, 0, 5}, {3, 0, 5}, {3, 3, 5}, {0, 3, 5});
    maker.object("sky", kAlwaysVisible).quad({0, 9, 0}, {0, 9, 9}, {9, 9, 9}, {9, 9, 0});
    return Stage(maker.scene());
}

void expect_same(const CullScene& a, const CullScene& b, std::uint64_t seed, double size) {
    for (std::string_view name : culler_names()) {
        if (name == "pvs")
            continue;
        auto first = make_culler(name, a), second = make_culler(name, b);
        ViewState first_state, second_state;
        CullResult first_result, second_result;
        Random random(seed, 3);
        for (int i = 0; i < 20; ++i) {
            View view = test::random_view(random, {0, 0, 0}, size);
            (*first)->cull(view, first_state, first_result);
            (*second)->cull(view, second_state, second_result);
            ASSERT_EQ(first_result.visible, second_result.visible) << name;
            ASSERT_EQ(first_result.counters.boxes_tested, second_result.counters.boxes_tested) << name;
            ASSERT_EQ(first_result.counters.polygons_drawn, second_result.counters.polygons_drawn) << name;
            ASSERT_EQ(first_result.counters.shadow_tests, second_result.counters.shadow_tests) << name;
            ASSERT_EQ(first_result.counters.hidden_by_planes, second_result.counters.hidden_by_planes) << name;
        }
    }
}

TEST(Prepared, AFileHoldsTheSameSceneBitForBit) {
    Stage stage = office();
    Bytes bytes = prepared(stage);
    Result<CullScene> opened = CullScene::open(*Pvs::open(bytes));
    ASSERT_TRUE(opened.ok()) << opened.status().message();
    const CullScene::Data &a = stage.cull_scene.data(), &b = opened->data();
    EXPECT_GT(a.occluders.polygons.size(), 100u);
    ASSERT_EQ(a.occluders.polygons.size(), b.occluders.polygons.size());
    for (std::size_t p = 0; p < a.occluders.polygons.size(); ++p) {
        ASSERT_EQ(a.occluders.polygons[p].normal.x, b.occluders.polygons[p].normal.x);
        ASSERT_EQ(a.occluders.polygons[p].offset, b.occluders.polygons[p].offset);
        ASSERT_EQ(a.occluders.polygons[p].area, b.occluders.polygons[p].area);
    }
    EXPECT_EQ(a.occluders.neighbours, b.occluders.neighbours);
    EXPECT_EQ(a.order, b.order);
    EXPECT_EQ(a.patches.order, b.patches.order);
    EXPECT_EQ(encode_groups(a.groups), encode_groups(b.groups));
    ASSERT_EQ(a.groups.groups.size(), b.groups.groups.size());
    for (std::size_t g = 0; g < a.groups.groups.size(); ++g)
        ASSERT_EQ(a.groups.groups[g].area, b.groups.groups[g].area);
    EXPECT_FALSE(b.front_sets.empty());
    expect_same(stage.cull_scene, *opened, 1, 20);
}

/// The size that form 0 of chunk OCCL has.
std::size_t wide_bytes(const OccluderSet& set) {
    return 32 + 12 * set.vertices.size() + 8 * set.loops.size() + 16 * set.polygons.size() + 24 * set.solids.size() +
           8 * set.patches.size() + 4 * set.patch_polygons.size();
}

void expect_back(const OccluderSet& set) {
    Result<Bytes> bytes = encode_occluders(set);
    ASSERT_TRUE(bytes) << bytes.status().message();
    Result<OccluderSet> again = decode_occluders(*bytes);
    ASSERT_TRUE(again) << again.status().message();
    EXPECT_EQ(again->vertices, set.vertices);
    EXPECT_EQ(again->loops, set.loops);
    EXPECT_EQ(again->neighbours, set.neighbours);
    EXPECT_EQ(again->patch_polygons, set.patch_polygons);
    ASSERT_EQ(again->polygons.size(), set.polygons.size());
    for (std::size_t p = 0; p < set.polygons.size(); ++p)
        ASSERT_TRUE(again->polygons[p].object == set.polygons[p].object && again->polygons[p].solid == set.polygons[p].solid &&
                    again->polygons[p].double_sided == set.polygons[p].double_sided &&
                    again->polygons[p].synthetic == set.polygons[p].synthetic);
}

TEST(Prepared, OccludersTakeAThirdOfTheirBytesAndComeBackOffTheGridToo) {
    OccluderSet set = office().occluders;
    expect_back(set);
    EXPECT_LT(encode_occluders(set)->size() * 3, wide_bytes(set));
    for (Vec3f& vertex : set.vertices) // of all magnitudes: no 32-bit grid holds them
        vertex = {vertex.x / 3, vertex.y * 1e-9f, vertex.z * 1e9f};
    for (OccluderPolygon& polygon : set.polygons)
        measure_occluder(set, polygon);
    expect_back(set);
    EXPECT_LT(encode_occluders(set)->size() * 2, wide_bytes(set));
    OccluderSet corners; // the largest numbers that a grid may have
    corners.vertices = {{1073741696.0f, 0, 0}, {-1073741696.0f, 1, 0}, {0, 0, 1}};
    corners.loops = {0, 1, 2};
    corners.neighbours.assign(3, kNoPolygon);
    corners.polygons.resize(1);
    corners.polygons[0].count = 3;
    measure_occluder(corners, corners.polygons[0]);
    expect_back(corners);
}

OccluderSets random_sets(Random& random, std::uint32_t items) {
    SpaceCells cells = SpaceCells::of_grid({{0, 0, 0}, {8, 4, 2}}, {4, 2, 2});
    std::vector<std::vector<std::uint32_t>> members(cells.leaves * OccluderSets::kDirections);
    std::uint32_t density = 0;
    for (std::size_t set = 0; set < members.size(); ++set) {
        if (set % OccluderSets::kDirections == 0)
            density = random.below(4);
        for (std::uint32_t item = 0; item < items; ++item)
            if (set >= OccluderSets::kDirections && random.below(8) ? std::binary_search(members[set - 14].begin(), members[set - 14].end(), item)
                                                                    : random.below(8) < density)
                members[set].push_back(item);
    }
    return OccluderSets::of_members(cells, members);
}

TEST(Prepared, SetsStoredAsChangesComeBackAndHostileOnesAreSafe) {
    Random random(41);
    for (int round = 0; round < 200; ++round) {
        std::uint32_t items = 1 + random.below(60);
        OccluderSets sets = random_sets(random, items);
        ByteWriter out;
        sets.encode_changes(out);
        std::size_t at = 0;
        Result<OccluderSets> again = OccluderSets::decode_changes(out.bytes, at, items);
        ASSERT_TRUE(again) << again.status().message();
        EXPECT_EQ(at, out.bytes.size());
        ASSERT_EQ(again->cells().leaves, sets.cells().leaves);
        for (std::size_t leaf = 0; leaf < sets.cells().leaves; ++leaf)
            for (std::size_t d = 0; d < OccluderSets::kDirections; ++d)
                ASSERT_TRUE(std::ranges::equal(again->of_leaf(leaf, d), sets.of_leaf(leaf, d)));
        for (int harm = 0; harm < 20; ++harm) {
            Bytes bytes = out.bytes;
            bytes[random.below(std::uint32_t(bytes.size()))] = std::byte(random.below(256));
            if (random.below(2))
                bytes.resize(random.below(std::uint32_t(bytes.size())));
            at = 0;
            Result<OccluderSets> read = OccluderSets::decode_changes(bytes, at, items);
            if (!read) {
                EXPECT_EQ(read.status().code(), ErrorCode::corrupt);
                continue;
            }
            for (std::uint32_t member : read->members())
                ASSERT_LT(member, items);
        }
    }
}

TEST(Prepared, PreparingTwiceGivesTheSameBytes) {
    Stage stage = small_stage();
    Bytes bytes = prepared(stage);
    EXPECT_EQ(prepared(small_stage()), bytes);
    CullScene opened = *CullScene::open(*Pvs::open(bytes));
    EXPECT_EQ(*add_pvs_chunks(bytes, *prepare_chunks(opened, kFew)), bytes) << "from what was read back, into the same file";
}

TEST(Prepared, ABakeKeepsItsAnswers) {
    Stage stage = small_stage();
    PvsData data = describe_scene(*stage.scene);
    data.grid = {{{0, 0, 0}, {8, 4, 8}}, {1, 1, 1}};
    data.cell_row = {0};
    data.row_count = 1;
    data.rows = {0b101};
    Bytes baked = *encode_pvs(data, PvsCoding::references);
    Bytes bytes = *add_pvs_chunks(baked, *prepare_chunks(stage.cull_scene, kFew));
    Pvs pvs = *Pvs::open(bytes);
    PvsCursor cursor;
    pvs.query({1, 1, 1}, cursor);
    EXPECT_EQ(cursor.visible[0], 0b10000101u) << "and what is always visible";
    EXPECT_TRUE(CullScene::open(pvs).ok());
}

TEST(Prepared, WhatAFileLacksIsMadeAnewOrLeftOut) {
    Stage stage = small_stage();
    std::vector<PvsChunk> chunks = *prepare_chunks(stage.cull_scene, kFew);
    Bytes plain = *encode_pvs(describe_scene(*stage.scene));
    Bytes occluders_alone = *add_pvs_chunks(plain, std::span(chunks).first(1));
    expect_same(stage.cull_scene, *CullScene::open(*Pvs::open(occluders_alone)), 2, 8);
    CullScene without = *CullScene::open(*Pvs::open(plain));
    EXPECT_TRUE(without.data().occluders.polygons.empty());
    EXPECT_EQ(without.data().order, stage.cull_scene.data().order);
}

TEST(Prepared, ASceneWithoutObjectsOrOccludersWorks) {
    CullSceneInput input;
    CullScene empty = CullScene::create(input);
    Bytes bytes = *add_pvs_chunks(*encode_pvs(PvsData{}), *prepare_chunks(empty));
    EXPECT_TRUE(CullScene::open(*Pvs::open(bytes)).ok());
    Box3f box{{0, 0, 0}, {1, 1, 1}};
    input.bounds = {&box, 1};
    PvsData one;
    one.objects.resize(1);
    one.objects[0].bounds = box;
    bytes = *add_pvs_chunks(*encode_pvs(one), *prepare_chunks(CullScene::create(input)));
    EXPECT_TRUE(CullScene::open(*Pvs::open(bytes)).ok());
}

TEST(Prepared, ChunksOfAnotherSceneAreRefused) {
    Stage stage = small_stage();
    PvsData other = describe_scene(*stage.scene);
    other.objects.pop_back();
    other.objects.pop_back(); // the last one is in no tree
    Bytes bytes = *add_pvs_chunks(*encode_pvs(other), *prepare_chunks(stage.cull_scene, kFew));
    Status status = CullScene::open(*Pvs::open(bytes)).status();
    EXPECT_EQ(status.code(), ErrorCode::corrupt);
    EXPECT_NE(status.message().find("'CTRE'"), std::string::npos) << status.message();
}

TEST(Prepared, NamesOfChunksAreChecked) {
    Bytes plain = *encode_pvs(PvsData{});
    for (const char* name : {"", "ROWS", "abcd", "TOOLONG", "A-BC"}) {
        PvsChunk chunk{name, {}};
        EXPECT_EQ(add_pvs_chunks(plain, {&chunk, 1}).status().code(), ErrorCode::usage) << name;
    }
    PvsChunk twice[] = {{"NEW1", {}}, {"NEW1", {}}};
    EXPECT_EQ(add_pvs_chunks(plain, twice).status().code(), ErrorCode::usage);
    PvsChunk fine{"NEW1", Bytes(5, std::byte(7))};
    Bytes bytes = *add_pvs_chunks(plain, {&fine, 1});
    Pvs pvs = *Pvs::open(bytes);
    EXPECT_EQ(pvs.chunk("NEW1").size(), 5u);
    EXPECT_FALSE(pvs.has_chunk("NEW2"));
    EXPECT_FALSE(pvs.has_chunk("META"));
}

/// Every method once, so that a sanitizer sees what it reads.
void cull_with_everything(const CullScene& scene, Random& random) {
    for (std::string_view name : culler_names()) {
        auto culler = make_culler(name, scene);
        if (!culler)
            continue;
        ViewState state;
        CullResult result;
        for (int i = 0; i < 2; ++i)
            (*culler)->cull(test::random_view(random, {4, 1, 4}, 8), state, result);
        ASSERT_LE(result.visible_count, scene.object_count());
    }
}

bool is_prepared_chunk(ChunkId id) {
    for (const char* name : {"OCCL", "OGRP", "CTRE", "OSET"})
        if (to_string(id) == "'" + std::string(name) + "'")
            return true;
    return false;
}

TEST(Prepared, HostileContentWithRightChecksumsIsRefusedOrCulledSafely) {
    PrepareOptions small;
    small.leaves = 4;
    small.per_set = 3;
    small.first_hit_leaves = 2;
    const Bytes file = prepared(small_stage(), small);
    Random random(23);
    int opened = 0, refused = 0;
    const std::uint32_t telling[] = {0, 1, 2, 0x7FFFFFFF, 0x80000000, 0xFFFFFFFE, 0xFFFFFFFF, 0x7F800000, 0x7FC00000};
    for (int round = 0; round < 1500; ++round) {
        Bytes hostile = file;
        for (const test::TableEntry& entry : test::table_of(file)) {
            if (!is_prepared_chunk(entry.id) || random.below(3))
                continue;
            auto words = static_cast<std::uint32_t>(entry.bytes / 4);
            std::size_t at = std::size_t(entry.offset) + 4 * random.below(words);
            if (random.below(2))
                hostile[at] = std::byte(random.below(256));
            else
                test::store_u32(hostile, at, telling[random.below(9)]);
        }
        test::reseal(hostile);
        Result<Pvs> pvs = Pvs::open(hostile);
        ASSERT_TRUE(pvs.ok()) << "these chunks are not the bake's";
        Result<CullScene> scene = CullScene::open(*pvs);
        ++(scene ? opened : refused);
        if (scene)
            cull_with_everything(*scene, random);
        else
            ASSERT_EQ(scene.status().code(), ErrorCode::corrupt) << scene.status().message();
    }
    EXPECT_GT(opened, 150);
    EXPECT_GT(refused, 150);
}

TEST(Prepared, EveryFlippedBitAndEveryTruncationIsNoticed) {
    PrepareOptions none;
    none.per_set = 0;
    Bytes file = prepared(small_stage(), none);
    for (std::size_t at = 0; at < file.size(); ++at) {
        file[at] ^= std::byte(1u << (at % 8));
        ASSERT_FALSE(Pvs::open(file).ok()) << at;
        file[at] ^= std::byte(1u << (at % 8));
    }
    for (std::size_t size = 0; size < file.size(); size += 7)
        ASSERT_FALSE(Pvs::open(Bytes(file.begin(), file.begin() + std::ptrdiff_t(size))).ok()) << size;
}

TEST(Prepared, AChunkCutShortWithARightChecksumIsCorrupt) {
    Stage stage = small_stage();
    PrepareOptions small;
    small.leaves = 2;
    small.per_set = 2;
    small.first_hit_leaves = 1;
    std::vector<PvsChunk> chunks = *prepare_chunks(stage.cull_scene, small);
    Bytes plain = *encode_pvs(describe_scene(*stage.scene));
    for (std::size_t c = 0; c < chunks.size(); ++c) {
        std::vector<PvsChunk> damaged = chunks;
        for (std::size_t size = 0; size < chunks[c].bytes.size(); ++size) {
            damaged[c].bytes.assign(chunks[c].bytes.begin(), chunks[c].bytes.begin() + std::ptrdiff_t(size));
            Bytes bytes = *add_pvs_chunks(plain, damaged);
            Status status = CullScene::open(*Pvs::open(bytes)).status();
            ASSERT_EQ(status.code(), ErrorCode::corrupt) << chunks[c].name << " " << size;
            ASSERT_NE(status.message().find(chunks[c].name), std::string::npos) << status.message();
        }
        damaged[c].bytes = chunks[c].bytes;
        damaged[c].bytes.resize(chunks[c].bytes.size() + 4);
        Bytes bytes = *add_pvs_chunks(plain, damaged);
        EXPECT_EQ(CullScene::open(*Pvs::open(bytes)).status().code(), ErrorCode::corrupt) << chunks[c].name;
    }
}

TEST(Prepared, SetsByFirstHitDoNotDependOnThreadsAndHoldWhatIsSeen) {
    Stage stage = small_stage();
    Job one, four;
    one.threads = 1;
    four.threads = 4;
    PrepareOptions options;
    options.first_hit_leaves = 8;
    std::vector<PvsChunk> a = *prepare_chunks(stage.cull_scene, options, one);
    std::vector<PvsChunk> b = *prepare_chunks(stage.cull_scene, options, four);
    EXPECT_EQ(a.back().bytes, b.back().bytes);
    Bytes bytes = *add_pvs_chunks(*encode_pvs(describe_scene(*stage.scene)), a);
    CullScene opened = *CullScene::open(*Pvs::open(bytes));
    EXPECT_GT(opened.data().first_hit_sets.members().size(), 8u);
}

/// Every choice of occluders is only a choice: nothing that is seen is hidden.
TEST(Prepared, EveryChoiceOfOccludersIsSafeAndHides) {
    Stage stage = office();
    Bytes bytes = prepared(stage);
    stage.cull_scene = *CullScene::open(*Pvs::open(bytes));
    std::map<std::string_view, std::set<std::uint64_t>> reported;
    for (int number = 0; number < 24; ++number) {
        const auto choice = OccluderChoice(number % 3);
        const char* const method = std::array{"planes", "planes-published", "tree", "tree-fse", "tree-fme", "tree-fmc", "opacity", "opacity-published"}[std::size_t(number / 3)];
        Random random(31);
        CullerOptions options;
        options.occluder_choice = choice;
        options.occluders = options.opacity.occluders = 12; // so that it matters which
        options.opacity.adaptive = false;
        auto culler = make_culler(method, stage.cull_scene, options);
        test::ProofCounts counts;
        ViewState state;
        Box3d bounds = to_double(stage.scene->local_bounds());
        for (int f = 0; f < 25; ++f) {
            View view;
            for (int axis = 0; axis < 3; ++axis)
                view.eye[axis] = random.uniform(bounds.min[axis], bounds.max[axis]);
            view.target = view.eye + Vec3d{random.uniform(-1, 1), random.uniform(-0.3, 0.3), random.uniform(-1, 1)};
            view.near_plane = 0.05;
            test::prove(stage, **culler, view, state, 16, 16, random, counts);
        }
        EXPECT_GT(counts.hidden * 50, counts.in_frustum) << method << ' ' << int(choice) << " hides next to nothing";
        reported[method].insert(counts.hidden);
    }
    for (const auto& [method, counts] : reported)
        EXPECT_EQ(counts.size(), 3u) << method << ": some choices are the same";
}

// A silhouette leaves an edge out because a neighbour goes on there: a file must not claim one that does not.
TEST(Prepared, ANeighbourThatSharesNoEdgeIsRefused) {
    Stage stage = small_stage();
    OccluderSet set = stage.occluders;
    auto lonely = std::find(set.neighbours.begin(), set.neighbours.end(), kNoPolygon);
    ASSERT_NE(lonely, set.neighbours.end());
    *lonely = 0;
    EXPECT_TRUE(check_occluders(set).ok());
    EXPECT_EQ(decode_occluders(*encode_occluders(set)).status().code(), ErrorCode::corrupt);
}

} // namespace
} // namespace antumbra
