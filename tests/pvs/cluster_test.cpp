// Clusters of triangles: what is stored of them, and that no bytes can deceive.
#include "pvs/random_pvs.hpp"
#include "pvs/reseal.hpp"

#include <gtest/gtest.h>

namespace antumbra {
namespace {

/// Two objects: five triangles in two clusters that take turns, one without area, one that closes a crack; three of one each.
PvsData data_of_two() {
    PvsData data;
    data.method = "test";
    data.objects.resize(2);
    data.objects[0].triangle_count = 5;
    data.objects[1].triangle_count = 3;
    data.cluster_first = {0, 3, 5, 6, 7, 8};
    data.triangles = {{5, {0, 1, PvsTriangles::kNone, 0, 1, 0}}, {3, {2, 3, 4}}};
    data.grid = {{{0, 0, 0}, {1, 1, 1}}, {1, 1, 1}};
    data.cell_row = {0};
    data.row_count = 1;
    data.rows = {0b1010101};
    return data;
}

TEST(Clusters, AFileTellsWhichTrianglesTheyHold) {
    std::vector<std::byte> bytes = *encode_pvs(data_of_two());
    Pvs pvs = *Pvs::open(bytes);
    EXPECT_TRUE(pvs.tells_triangles());
    EXPECT_EQ(pvs.cluster_count(), 5u);
    EXPECT_EQ(pvs.first_cluster_of(1), 2u);
    EXPECT_EQ(pvs.first_cluster_of(2), 5u);
    PvsTriangles first = pvs.triangles_of(0, 1000), second = pvs.triangles_of(1, 1000);
    EXPECT_EQ(first.in_file, 5u);
    EXPECT_EQ(first.cluster, data_of_two().triangles[0].cluster);
    EXPECT_EQ(second.cluster, data_of_two().triangles[1].cluster);
    PvsCursor cursor;
    (void)pvs.query({0.5, 0.5, 0.5}, cursor);
    for (std::uint32_t c = 0; c < 5; ++c)
        EXPECT_EQ(pvs.is_cluster_visible(c, cursor), c % 2 == 0) << c;
}

TEST(Clusters, FilesOfBeforeAreInTheOrderOfTheScene) {
    PvsData data = data_of_two();
    data.triangles.clear();
    std::vector<std::byte> bytes = *encode_pvs(data);
    Pvs pvs = *Pvs::open(bytes);
    EXPECT_FALSE(pvs.tells_triangles());
    EXPECT_EQ(pvs.triangles_of(0, 1000).cluster, (std::vector<std::uint32_t>{0, 0, 0, 1, 1}));
    EXPECT_EQ(pvs.triangles_of(1, 1000).cluster, (std::vector<std::uint32_t>{2, 3, 4}));
    EXPECT_EQ(pvs.triangles_of(1, 1000).in_file, 3u);
}

TEST(Clusters, RandomOnesComeBackWhateverTheCoding) {
    for (std::uint64_t seed = 0; seed < 60; ++seed) {
        PvsData data = test::random_pvs(seed, 40, true);
        std::vector<std::byte> bytes = *encode_pvs(data, PvsCoding(1 + seed % 6));
        Result<Pvs> pvs = Pvs::open(bytes);
        ASSERT_TRUE(pvs) << pvs.status().message();
        ASSERT_EQ(pvs->cluster_count(), data.cluster_count());
        for (std::uint32_t o = 0; o < data.triangles.size(); ++o) {
            PvsTriangles triangles = pvs->triangles_of(o, 1000);
            ASSERT_EQ(triangles.cluster, data.triangles[o].cluster) << seed << " " << o;
            ASSERT_EQ(triangles.in_file, data.triangles[o].in_file);
        }
    }
}

TEST(Clusters, ContradictionsAreRefusedWhenWritten) {
    auto refuse = [](auto change) {
        PvsData data = data_of_two();
        change(data);
        EXPECT_EQ(encode_pvs(data).status().code(), ErrorCode::usage);
    };
    refuse([](PvsData& data) { data.triangles.pop_back(); });
    refuse([](PvsData& data) { data.triangles[0].cluster[0] = 2; });                   // of another object
    refuse([](PvsData& data) { data.triangles[0].cluster[0] = 1; });                   // not its number
    refuse([](PvsData& data) { data.triangles[0].cluster[0] = PvsTriangles::kNone; }); // one is missing
    refuse([](PvsData& data) { data.triangles[1].in_file = 4; });
    refuse([](PvsData& data) { data.cluster_first = {0, 3, 6, 7, 8}; }); // reaches into the next object
}

/// Bytes with right checksums that say anything are refused or answered without harm.
TEST(Clusters, ForgedOnesAreRefusedOrHarmless) {
    std::uint64_t refused = 0;
    for (std::uint64_t seed = 0; seed < 12; ++seed) {
        std::vector<std::byte> bytes = *encode_pvs(test::random_pvs(seed + 100, 8, true));
        for (std::string_view name : {"CLUS", "CTRI"}) {
            test::TableEntry place{};
            for (const test::TableEntry& entry : test::table_of(bytes))
                if (to_string(entry.id) == "'" + std::string(name) + "'")
                    place = entry;
            for (std::size_t bit = 0; bit < place.bytes * 8; ++bit) {
                std::vector<std::byte> forged = bytes;
                forged[std::size_t(place.offset) + bit / 8] ^= std::byte(1 << bit % 8);
                test::reseal(forged);
                Result<Pvs> pvs = Pvs::open(forged);
                refused += !pvs;
                for (std::uint32_t o = 0; pvs && o < pvs->object_count(); ++o)
                    for (std::uint32_t c : pvs->triangles_of(o, 1000).cluster)
                        ASSERT_TRUE(c == PvsTriangles::kNone || c < pvs->cluster_count());
            }
        }
    }
    EXPECT_GT(refused, 1000u);
}

} // namespace
} // namespace antumbra
