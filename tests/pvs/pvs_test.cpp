// The file as a whole: what is written is what is read and answered.
#include "pvs/format.hpp"
#include "pvs/random_pvs.hpp"

#include <antumbra/scene.hpp>

#include <gtest/gtest.h>
#include <rapidcheck.h>

#include <cmath>
#include <optional>
#include <set>
#include <thread>

namespace antumbra {
namespace {

using test::expected_row;
using test::random_pvs;
using Words = std::vector<std::uint64_t>;

std::vector<std::byte> encoded(const PvsData& data, PvsCoding coding = PvsCoding::cheapest) {
    Result<std::vector<std::byte>> bytes = encode_pvs(data, coding);
    EXPECT_TRUE(bytes.ok()) << bytes.status().message();
    return *bytes;
}

Pvs opened(std::span<const std::byte> bytes) {
    Result<Pvs> pvs = Pvs::open(bytes);
    EXPECT_TRUE(pvs.ok()) << pvs.status().message();
    return *pvs;
}

std::set<std::uint32_t> members(const Words& words) {
    std::set<std::uint32_t> set;
    for (std::uint32_t i = 0; i < words.size() * 64; ++i)
        if (words[i / 64] >> (i % 64) & 1)
            set.insert(i);
    return set;
}

std::set<std::uint32_t> all_objects(std::size_t count) {
    std::set<std::uint32_t> set;
    for (std::uint32_t i = 0; i < count; ++i)
        set.insert(i);
    return set;
}

/// Three objects in a row of two cells: the first cell sees object 0, the second objects 0 and 2.
PvsData small_pvs() {
    PvsData data;
    data.guarantee = Guarantee::exact;
    data.method = "exact";
    data.objects.resize(3);
    data.objects[2].name = "door";
    data.grid.bounds = {{0, 0, 0}, {2, 1, 1}};
    data.grid.count = {2, 1, 1};
    data.row_count = 2;
    data.rows = {1, 5};
    data.cell_row = {0, 1};
    return data;
}

TEST(Pvs, AnswersFromTheCellOfTheEye) {
    std::vector<std::byte> bytes = encoded(small_pvs());
    Pvs pvs = opened(bytes);
    PvsCursor cursor;
    EXPECT_TRUE(pvs.query({0.5, 0.5, 0.5}, cursor));
    EXPECT_EQ(cursor.cell, 0);
    EXPECT_EQ(cursor.visible, (Words{1}));
    EXPECT_EQ(cursor.visible_count, 1u);
    EXPECT_TRUE(pvs.query({1.5, 0.5, 0.5}, cursor));
    EXPECT_EQ(cursor.visible, (Words{5}));
    EXPECT_EQ(cursor.visible_count, 2u);
    EXPECT_FALSE(cursor.everything);
}

TEST(Pvs, SaysWhetherTheAnswerChanged) {
    PvsData data = small_pvs();
    std::vector<std::byte> bytes = encoded(data);
    Pvs pvs = opened(bytes);
    PvsCursor cursor;
    EXPECT_TRUE(pvs.query({0.5, 0.5, 0.5}, cursor));
    EXPECT_FALSE(pvs.query({0.6, 0.5, 0.5}, cursor)) << "the same cell";
    EXPECT_TRUE(pvs.query({1.5, 0.5, 0.5}, cursor));
    data.cell_row = {1, 1};
    bytes = encoded(data);
    pvs = opened(bytes);
    cursor = {};
    EXPECT_TRUE(pvs.query({0.5, 0.5, 0.5}, cursor));
    EXPECT_FALSE(pvs.query({1.5, 0.5, 0.5}, cursor)) << "another cell of the same row";
    EXPECT_EQ(cursor.cell, 1);
}

TEST(Pvs, EverythingIsVisibleWhereNothingIsKnown) {
    PvsData data = small_pvs();
    data.grid.bounds.max.x = 4;
    data.grid.count = {4, 1, 1};
    data.cell_row = {0, kCellNotBaked, kCellSolid, 1};
    std::vector<std::byte> bytes = encoded(data);
    Pvs pvs = opened(bytes);
    double nan = std::nan(""), infinity = INFINITY;
    std::pair<Vec3d, std::int64_t> cases[] = {
        {{1.5, 0.5, 0.5}, 1}, {{2.5, 0.5, 0.5}, 2}, {{4.5, 0.5, 0.5}, -1}, {{-1e38, 0.5, 0.5}, -1},
        {{1e308, 1e308, 1e308}, -1}, {{nan, 0.5, 0.5}, -1}, {{0.5, 0.5, nan}, -1}, {{infinity, 0, 0}, -1},
        {{0.5, -infinity, 0.5}, -1},
    };
    for (auto [eye, cell] : cases) {
        PvsCursor cursor;
        EXPECT_TRUE(pvs.query(eye, cursor));
        EXPECT_EQ(cursor.cell, cell) << eye.x;
        EXPECT_TRUE(cursor.everything);
        EXPECT_EQ(cursor.visible_count, 3u);
        EXPECT_EQ(cursor.visible, (Words{7}));
    }
}

TEST(Pvs, ObjectsThatAreNeverCulledAreInEveryRow) {
    PvsData data = small_pvs();
    data.objects[1].flags = kAlwaysVisible;
    std::vector<std::byte> bytes = encoded(data);
    Pvs pvs = opened(bytes);
    PvsCursor cursor;
    (void)pvs.query({0.5, 0.5, 0.5}, cursor);
    EXPECT_EQ(cursor.visible, (Words{3}));
    static_assert(kAlwaysVisibleFlag == kAlwaysVisible);
}

TEST(Pvs, KeepsEverythingThatItWasGiven) {
    EXPECT_TRUE(rc::check("encode, open, decode is the identity", [](std::uint64_t seed) {
        PvsData data = random_pvs(seed);
        auto coding = PvsCoding(1 + seed % 6);
        std::vector<std::byte> bytes = encoded(data, coding);
        Pvs pvs = opened(bytes);
        RC_ASSERT(pvs.coding() == coding);
        RC_ASSERT(pvs.guarantee() == data.guarantee);
        RC_ASSERT(pvs.method() == data.method);
        RC_ASSERT(pvs.tool_version() == data.tool_version);
        RC_ASSERT(pvs.options_json() == data.options_json);
        RC_ASSERT(pvs.scene_fingerprint() == data.scene_fingerprint);
        RC_ASSERT(pvs.structure_fingerprint() == data.structure_fingerprint);
        RC_ASSERT(pvs.sides() == data.sides);
        RC_ASSERT(pvs.origin() == data.origin);
        RC_ASSERT(pvs.grid().bounds == data.grid.bounds);
        RC_ASSERT(pvs.grid().count == data.grid.count);
        RC_ASSERT(pvs.object_count() == data.objects.size());
        for (std::uint32_t o = 0; o < data.objects.size(); ++o) {
            PvsObject object = pvs.object(o);
            const PvsObject& given = data.objects[o];
            RC_ASSERT(object.node == given.node && object.primitive == given.primitive &&
                      object.instance == given.instance && object.flags == given.flags);
            RC_ASSERT(object.triangle_count == given.triangle_count);
            RC_ASSERT(object.bounds == given.bounds);
            RC_ASSERT(object.name == given.name);
            RC_ASSERT(pvs.object_name(o) == given.name);
            RC_ASSERT(pvs.object_bounds(o).min == to_double(given.bounds.min) + data.origin);
            RC_ASSERT(pvs.object_bounds(o).max == to_double(given.bounds.max) + data.origin);
        }
        Words words(pvs.words_per_row());
        for (std::uint64_t c = 0; c < data.grid.cells(); ++c) {
            if (data.cell_row[c] >= kCellSolid) {
                RC_ASSERT(pvs.cell_row(c) == data.cell_row[c]);
                continue;
            }
            pvs.decode_row(pvs.cell_row(c), words);
            RC_ASSERT(words == expected_row(data, data.cell_row[c]));
        }
    }));
}

TEST(Pvs, QueriesAgreeWithTheData) {
    EXPECT_TRUE(rc::check("a query anywhere in a cell gives its row", [](std::uint64_t seed) {
        PvsData data = random_pvs(seed);
        std::vector<std::byte> bytes = encoded(data);
        Pvs pvs = opened(bytes);
        Random random(seed, 1);
        PvsCursor cursor;
        for (int i = 0; i < 50; ++i) {
            std::uint64_t cell = random.below(std::uint32_t(data.grid.cells()));
            Box3d box = data.grid.cell(cell);
            Vec3d eye;
            for (int k = 0; k < 3; ++k)
                eye[k] = random.uniform(box.min[k], box.max[k]);
            (void)pvs.query(eye, cursor);
            RC_ASSERT(cursor.cell == std::int64_t(cell));
            RC_ASSERT(cursor.everything == (data.cell_row[cell] >= kCellSolid));
            auto expected = cursor.everything ? all_objects(data.objects.size())
                                              : members(expected_row(data, data.cell_row[cell]));
            RC_ASSERT(members(cursor.visible) == expected);
            RC_ASSERT(cursor.visible_count == expected.size());
        }
    }));
}

TEST(Pvs, TheSameDataGivesTheSameBytes) {
    PvsData data = small_pvs();
    // Another arrangement of the rows: swapped, one of them doubled, one of them unused.
    PvsData other = small_pvs();
    other.row_count = 4;
    other.rows = {5, 1, 1, 2};
    other.cell_row = {2, 0};
    EXPECT_EQ(encoded(data), encoded(other));
    EXPECT_TRUE(rc::check("encoding twice", [](std::uint64_t seed) {
        RC_ASSERT(encoded(random_pvs(seed)) == encoded(random_pvs(seed)));
    }));
}

TEST(Pvs, ACopyAnswersWhenTheOriginalIsGone) {
    for (PvsCoding coding : {PvsCoding::tree_sibling, PvsCoding::archive, PvsCoding::references}) {
        std::vector<std::byte> bytes = encoded(small_pvs(), coding);
        std::optional<Pvs> original = opened(bytes);
        Pvs copy = *original;
        original.reset();
        PvsCursor cursor;
        (void)copy.query({1.5, 0.5, 0.5}, cursor);
        EXPECT_EQ(cursor.visible, (Words{5}));
    }
}

TEST(Pvs, SharesEqualRows) {
    PvsData data = small_pvs();
    data.rows = {5, 5};
    std::vector<std::byte> bytes = encoded(data);
    EXPECT_EQ(opened(bytes).row_count(), 1u);
}

TEST(Pvs, RefusesDataThatContradictsItself) {
    auto refused = [](auto change, const char* part) {
        PvsData data = small_pvs();
        change(data);
        Status status = encode_pvs(data).status();
        EXPECT_EQ(status.code(), ErrorCode::usage) << part;
        EXPECT_NE(status.message().find(part), std::string::npos) << status.message();
    };
    refused([](PvsData& d) { d.cell_row[1] = 2; }, "cell 1 refers to row 2 of 2");
    refused([](PvsData& d) { d.cell_row.push_back(0); }, "3 entries for 2 cells");
    refused([](PvsData& d) { d.rows.push_back(0); }, "3 words");
    refused([](PvsData& d) { d.rows[1] = 8; }, "row 1 has bits set beyond");
    refused([](PvsData& d) { d.grid.bounds.max.x = INFINITY; }, "grid");
    refused([](PvsData& d) { d.grid.count[1] = 0; }, "grid");
    refused([](PvsData& d) { d.origin.y = std::nan(""); }, "origin");
    EXPECT_EQ(encode_pvs(small_pvs(), PvsCoding(9)).status().code(), ErrorCode::usage);
    refused([](PvsData& d) { d.guarantee = Guarantee(9); }, "guarantee");
}

TEST(Pvs, NoObjectsAndNoCellsAreFine) {
    std::vector<std::byte> bytes = encoded(PvsData{});
    Pvs pvs = opened(bytes);
    PvsCursor cursor;
    EXPECT_TRUE(pvs.query({0, 0, 0}, cursor));
    EXPECT_TRUE(cursor.everything);
    EXPECT_EQ(cursor.visible_count, 0u);
    EXPECT_FALSE(pvs.query({1, 0, 0}, cursor));
}

TEST(Pvs, ManyThreadsMayAskOneFile) {
    PvsData data = random_pvs(7, 2000);
    std::vector<std::byte> bytes = encoded(data);
    Pvs pvs = opened(bytes);
    std::vector<Vec3d> eyes(2000);
    Random random(3);
    for (Vec3d& eye : eyes)
        for (int k = 0; k < 3; ++k)
            eye[k] = random.uniform(data.grid.bounds.min[k] - 1, data.grid.bounds.max[k] + 1);
    auto ask = [&] {
        PvsCursor cursor;
        std::uint64_t sum = 0;
        for (const Vec3d& eye : eyes) {
            (void)pvs.query(eye, cursor);
            for (std::uint64_t word : cursor.visible)
                sum = sum * 31 + word;
        }
        return sum;
    };
    std::uint64_t expected = ask();
    std::vector<std::uint64_t> sums(16);
    std::vector<std::thread> threads;
    for (std::uint64_t& sum : sums)
        threads.emplace_back([&] { sum = ask(); });
    for (std::thread& thread : threads)
        thread.join();
    for (std::uint64_t sum : sums)
        EXPECT_EQ(sum, expected);
}

} // namespace
} // namespace antumbra
