// Damaged, truncated and hostile files: a clear error, never a crash or a wrong answer.
#include "pvs/format.hpp"
#include "pvs/random_pvs.hpp"
#include "pvs/random_tree.hpp"
#include "pvs/reseal.hpp"

#include <gtest/gtest.h>

namespace antumbra {
namespace {

using test::random_pvs;
using test::reseal;
using Bytes = std::vector<std::byte>;

/// About 4 KiB: 40 objects with names, 60 cells, rows of all shapes.
PvsData small_data() {
    PvsData data;
    for (std::uint64_t seed = 0; data.objects.size() < 40 || data.grid.cells() < 60 || data.row_count < 20; ++seed)
        data = random_pvs(seed, 44);
    return data;
}

Bytes small_file(PvsCoding coding = PvsCoding::cheapest) { return *encode_pvs(small_data(), coding); }

Status open_status(std::span<const std::byte> bytes) { return Pvs::open(bytes).status(); }

/// Who holds byte `at`: the chunk's name in quotes, or "header".
std::string owner(std::span<const std::byte> file, std::size_t at) {
    for (const test::TableEntry& entry : test::table_of(file))
        if (at < entry.offset + entry.bytes)
            return at >= kHeaderBytes + test::table_of(file).size() * kTableEntryBytes ? to_string(entry.id) : "header";
    return "nobody";
}

TEST(PvsDamage, EveryFlippedBitIsNoticedAndItsChunkNamed) {
    Bytes file = small_file();
    ASSERT_GT(file.size(), 3000u);
    ASSERT_LT(file.size(), 6000u);
    for (std::size_t at = 0; at < file.size(); ++at)
        for (int bit = 0; bit < 8; ++bit) {
            file[at] ^= std::byte(1 << bit);
            Status status = open_status(file);
            file[at] ^= std::byte(1 << bit);
            bool version = at == 8 || at == 9;
            ASSERT_EQ(status.code(), version ? ErrorCode::unsupported : ErrorCode::corrupt) << at;
            // A flip in the number of chunks makes the table seem to end elsewhere.
            std::string expected = at >= 24 && at < 28 ? "table" : owner(file, at);
            ASSERT_NE(status.message().find(expected), std::string::npos) << at << ": " << status.message();
        }
}

TEST(PvsDamage, EveryTruncationIsNoticed) {
    Bytes file = small_file();
    for (std::size_t size = 0; size < file.size(); ++size) {
        // A copy of its own, so that a sanitizer sees a read beyond the end.
        Bytes cut(file.begin(), file.begin() + std::ptrdiff_t(size));
        Status status = open_status(cut);
        ASSERT_EQ(status.code(), ErrorCode::corrupt) << size;
        std::size_t table_end = kHeaderBytes + test::table_of(file).size() * kTableEntryBytes;
        std::string expected = size < kHeaderBytes ? "header" : size < table_end ? "table" : owner(file, size);
        ASSERT_NE(status.message().find(expected), std::string::npos) << size << ": " << status.message();
    }
    file.push_back(std::byte(0));
    EXPECT_EQ(open_status(file).code(), ErrorCode::corrupt) << "appended to";
}

TEST(PvsDamage, RandomDamageOfABiggerFileIsNoticed) {
    PvsData data = random_pvs(11, 20000);
    data.options_json.assign(200000, 'x');
    Bytes file = *encode_pvs(data);
    Random random(5);
    for (int round = 0; round < 300; ++round) {
        Bytes damaged = file;
        std::uint32_t size = static_cast<std::uint32_t>(file.size()), flips = 2 + random.below(63);
        if (round % 3 == 0) { // two blocks change places
            std::uint32_t length = 16 + random.below(4096), a = random.below(size - length), b = random.below(size - length);
            std::copy_n(file.begin() + a, length, damaged.begin() + b);
            std::copy_n(file.begin() + b, length, damaged.begin() + a);
        } else {
            for (std::uint32_t i = 0; i < flips; ++i)
                damaged[random.below(size)] ^= std::byte(1u << random.below(8));
        }
        if (damaged == file)
            continue;
        ASSERT_FALSE(open_status(damaged).ok()) << round;
    }
}

/// Everything that a reader of `pvs` can ask, so that a sanitizer sees each access.
std::uint64_t ask_everything(const Pvs& pvs) {
    std::uint64_t sum = pvs.options_json().size() + pvs.method().size() + pvs.tool_version().size();
    for (std::uint32_t o = 0; o < pvs.object_count(); ++o)
        sum += pvs.object(o).name.size() + std::uint64_t(pvs.object_bounds(o).empty());
    PvsCursor cursor;
    for (std::uint64_t c = 0; c < std::min<std::uint64_t>(pvs.grid().cells(), 1000); ++c) {
        (void)pvs.query(pvs.grid().cell(c).centre(), cursor);
        sum += cursor.visible_count;
        EXPECT_LE(cursor.visible_count, pvs.object_count());
    }
    Box3d bounds = pvs.tree().nodes.empty() ? pvs.grid().bounds : pvs.tree().bounds;
    for (int corner = 0; corner < 8; ++corner) {
        Vec3d eye = bounds.corner(corner);
        (void)pvs.query(eye, cursor);
        (void)pvs.query_range(camera_range({eye, eye}, bounds.centre() - eye, {0.1, 1, 0.2}, 0.5, 1.5), cursor);
        sum += pvs.is_box_visible({eye, eye}, cursor);
        EXPECT_LE(cursor.visible_count, pvs.object_count());
    }
    return sum;
}

/// Every coding, over a grid and over a view tree with volumes.
std::vector<Bytes> files_of_all_kinds() {
    std::vector<Bytes> files;
    PvsData tree;
    for (std::uint64_t seed = 0; tree.objects.size() < 20 || tree.row_count < 20 || tree.volumes.cells() == 0; ++seed)
        tree = test::random_pvs_tree(seed, 40);
    for (std::uint32_t coding = 1; coding <= 6; ++coding) {
        files.push_back(small_file(PvsCoding(coding)));
        files.push_back(*encode_pvs(tree, PvsCoding(coding)));
    }
    return files;
}

TEST(PvsDamage, HostileContentWithRightChecksumsIsRefusedOrAnsweredSafely) {
    std::vector<Bytes> files = files_of_all_kinds();
    Random random(17);
    int opened = 0, refused = 0;
    const std::uint32_t telling[] = {0, 1, 0x7F, 0x80, 0xFF, 0x7FFFFFFF, 0xFFFFFFFE, 0xFFFFFFFF};
    for (int round = 0; round < 12000; ++round) {
        const Bytes& file = files[std::size_t(round) % files.size()];
        Bytes hostile = file;
        for (std::uint32_t i = 0, n = 1 + random.below(4); i < n; ++i) {
            std::uint32_t at = random.below(static_cast<std::uint32_t>(file.size() - 4));
            if (random.below(2))
                hostile[at] = std::byte(random.below(256));
            else
                test::store_u32(hostile, at, telling[random.below(8)]);
        }
        reseal(hostile);
        Result<Pvs> pvs = Pvs::open(hostile);
        if (pvs)
            (void)ask_everything(*pvs);
        ++(pvs ? opened : refused);
    }
    // Both kinds must occur, or the test looks at nothing.
    EXPECT_GT(opened, 1000);
    EXPECT_GT(refused, 1000);
}

/// The sections of a file, for tests that put it together differently.
std::vector<Section> sections_of(const Bytes& file) { return *read_chunks(file); }

TEST(PvsDamage, UnknownChunksAreSkippedUnlessRequired) {
    Bytes file = small_file();
    std::vector<Section> sections = sections_of(file);
    const std::byte more[] = {std::byte(1), std::byte(2), std::byte(3)};
    sections.insert(sections.begin() + 2, Section{chunk_id("NEWS"), 0, more});
    Bytes extended = write_chunks(sections);
    EXPECT_TRUE(Pvs::open(extended).ok());
    sections[2].flags = kRequired;
    Bytes required = write_chunks(sections);
    Status status = open_status(required);
    EXPECT_EQ(status.code(), ErrorCode::unsupported);
    EXPECT_NE(status.message().find("'NEWS'"), std::string::npos);
}

TEST(PvsDamage, AMissingOrDoubledChunkIsCorrupt) {
    Bytes file = small_file();
    for (std::size_t i = 0; i < sections_of(file).size(); ++i) {
        std::vector<Section> sections = sections_of(file);
        std::string name = to_string(sections[i].id);
        sections.erase(sections.begin() + std::ptrdiff_t(i));
        Bytes bytes = write_chunks(sections);
        Status status = open_status(bytes);
        EXPECT_EQ(status.code(), ErrorCode::corrupt);
        EXPECT_NE(status.message().find(name + ": it is missing"), std::string::npos) << status.message();
        sections = sections_of(file);
        sections.push_back(sections[i]);
        bytes = write_chunks(sections);
        EXPECT_EQ(open_status(bytes).code(), ErrorCode::corrupt) << name;
    }
}

TEST(PvsDamage, ALaterVersionIsUnsupported) {
    Bytes file = small_file();
    file[8] = std::byte(2);
    reseal(file);
    EXPECT_EQ(open_status(file).code(), ErrorCode::unsupported) << "major";
    file[8] = std::byte(1);
    file[10] = std::byte(9);
    reseal(file);
    EXPECT_TRUE(Pvs::open(file).ok()) << "a later minor version that old readers can read";
    file[12] = std::byte(kMinorVersion + 1);
    reseal(file);
    EXPECT_EQ(open_status(file).code(), ErrorCode::unsupported) << "the oldest minor version that can read it";
}

TEST(PvsDamage, AFewBytesCannotAskForMuch) {
    PvsData data;
    data.objects.resize(40000);
    data.grid = {{{0, 0, 0}, {1, 1, 1}}, {40, 1, 1}};
    data.row_count = 40;
    data.rows.resize(40 * data.words_per_row());
    for (std::uint32_t r = 0; r < 40; ++r) {
        data.rows[r * data.words_per_row()] = r;
        data.cell_row.push_back(r);
    }
    EXPECT_TRUE(encode_pvs(data, PvsCoding::archive).ok());
    EXPECT_TRUE(may_unpack(1000, 4194, 0));
    EXPECT_FALSE(may_unpack(1000, 4200, 0));
    EXPECT_TRUE(may_unpack(1000, 4200, 10));
    EXPECT_FALSE(may_unpack(0xFFFFFFFFu, 0xFFFFFFFFu, 1 << 20));
    EXPECT_TRUE(may_unpack(0xFFFFFFFFu, 0, 0));
}

// Found by a test that took too long: volumes without number.
TEST(PvsDamage, TooManyVolumesAreRefused) {
    PvsData data = small_data();
    data.row_count = 0;
    data.rows.clear();
    data.cell_row.assign(data.cell_row.size(), kCellNotBaked);
    data.volumes = {data.grid.bounds, {1024, 1024, 1}};
    Bytes file = *encode_pvs(data);
    EXPECT_TRUE(Pvs::open(file).ok());
    for (const test::TableEntry& entry : test::table_of(file))
        if (entry.id == kVolumesChunk)
            test::store_u32(file, std::size_t(entry.offset) + 56, 2);
    reseal(file);
    EXPECT_EQ(open_status(file).code(), ErrorCode::corrupt);
    data.volumes.count[2] = 2;
    EXPECT_EQ(encode_pvs(data).status().code(), ErrorCode::usage);
}

TEST(PvsDamage, UnknownRowCodingIsUnsupported) {
    Bytes file = small_file();
    for (const test::TableEntry& entry : test::table_of(file))
        if (entry.id == kMetaChunk)
            test::store_u32(file, std::size_t(entry.offset) + 4, 77);
    reseal(file);
    EXPECT_EQ(open_status(file).code(), ErrorCode::unsupported);
}

TEST(PvsDamage, ALargeSectionIsCutIntoChunksAndReadAsOne) {
    PvsData data = small_data();
    data.options_json.assign(kMaxChunkBytes + 5, 'a');
    data.options_json.back() = 'b';
    Bytes file = *encode_pvs(data);
    std::vector<test::TableEntry> table = test::table_of(file);
    std::vector<std::uint64_t> sizes;
    for (const test::TableEntry& entry : table)
        if (entry.id == kOptionsChunk)
            sizes.push_back(entry.bytes);
    EXPECT_EQ(sizes, (std::vector<std::uint64_t>{kMaxChunkBytes, 5}));
    Result<Pvs> pvs = Pvs::open(file);
    ASSERT_TRUE(pvs.ok()) << pvs.status().message();
    EXPECT_EQ(pvs->options_json(), data.options_json);
}

} // namespace
} // namespace antumbra
