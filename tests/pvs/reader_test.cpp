// The page docs/format.md is enough: a reader written from it alone agrees with ours, and a file of the first version
// opens for ever.
#include "base/file.hpp"
#include "pvs/random_tree.hpp"

#include <gtest/gtest.h>

#include <cstdio>
#include <fstream>
#include <sstream>
#include <unistd.h>

namespace antumbra {
namespace {

/// What read_pvs.py prints for a row, or for what a cursor sees.
std::string bits_text(std::span<const std::uint64_t> words, std::size_t bits, std::size_t first = 0) {
    std::string text;
    for (std::size_t o = 0; o < bits; ++o)
        if (words[o / 64] >> (o % 64) & 1)
            text += (text.empty() ? "" : " ") + std::to_string(first + o);
    return text;
}

std::string row_text(const Pvs& pvs, std::uint32_t row) {
    std::vector<std::uint64_t> words(pvs.words_per_row());
    if (row >= kCellSolid)
        return "everything";
    pvs.decode_row(row, words);
    return bits_text(words, pvs.bits_per_row());
}

std::string answer_text(const Pvs& pvs, const PvsCursor& cursor) {
    if (cursor.everything)
        return "everything";
    std::string objects = bits_text(cursor.visible, pvs.object_count());
    std::string volumes = bits_text(cursor.volumes, pvs.bits_per_row() - pvs.object_count(), pvs.object_count());
    return objects + (objects.empty() || volumes.empty() ? "" : " ") + volumes;
}

std::string run(const std::string& command) {
    std::string output;
    FILE* pipe = ::popen(command.c_str(), "r");
    char buffer[4096];
    while (std::size_t size = std::fread(buffer, 1, sizeof buffer, pipe))
        output.append(buffer, size);
    EXPECT_EQ(::pclose(pipe), 0) << command;
    return output;
}

TEST(PvsFormatPage, AReaderWrittenFromThePageAgrees) {
    std::string path = testing::TempDir() + "reader_test" + std::to_string(::getpid()) + ".pvs";
    // Every coding, over grids and over view trees.
    for (std::uint64_t seed = 0; seed < 18; ++seed) { // the last six list clusters
        PvsData data = seed < 6    ? test::random_pvs(seed, 200)
                       : seed < 12 ? test::random_pvs_tree(seed, 200)
                                   : test::random_pvs(seed, 60, true);
        std::vector<std::byte> bytes = *encode_pvs(data, PvsCoding(1 + seed % 6));
        ASSERT_TRUE(write_file_atomically(path, bytes));
        Pvs pvs = *Pvs::open(bytes);
        PvsCursor cursor;
        std::string expected, eyes;
        std::uint64_t cells = 0;
        for (std::uint32_t o = 0; pvs.tells_triangles() && o < pvs.object_count(); ++o) {
            PvsTriangles triangles = pvs.triangles_of(o, 1000);
            expected += "triangles " + std::to_string(triangles.in_file) + ":";
            for (std::uint32_t c : triangles.cluster)
                expected += " " + (c == PvsTriangles::kNone ? "-" : std::to_string(c));
            expected += "\n";
        }
        for (; cells < data.grid.cells(); ++cells)
            expected += "cell " + std::to_string(cells) + ": " + row_text(pvs, pvs.cell_row(cells)) + "\n";
        for (const ViewNode& node : pvs.tree().nodes)
            if (node.axis == ViewNode::kLeaf)
                expected += "cell " + std::to_string(cells++) + ": " + row_text(pvs, node.link) + "\n";
        CellGrid grid = data.tree.nodes.empty() ? data.grid : CellGrid{data.tree.bounds, {4, 4, 4}};
        for (std::uint64_t c = 0; c < grid.cells(); c += 3) {
            // Corners are on common faces: both readers must choose the same cell.
            Vec3d eye = c == 3 ? Vec3d{1e30, 0, 0} : grid.cell(c).corner(int(c % 8));
            char text[100];
            std::snprintf(text, sizeof text, "%.17g,%.17g,%.17g", eye.x, eye.y, eye.z);
            (void)pvs.query(eye, cursor);
            expected += "eye " + std::string(text) + ": " + answer_text(pvs, cursor) + "\n";
            eyes += " ' " + std::string(text) + "'";
        }
        std::string output = run("python3 '" ANTUMBRA_SOURCE_DIR "/tests/pvs/read_pvs.py' '" + path + "'" + eyes);
        for (std::size_t at; (at = output.find("eye  ")) != std::string::npos;)
            output.erase(at + 3, 1); // the blank that keeps a minus from looking like an option
        EXPECT_EQ(output, expected) << "seed " << seed;
    }
    std::remove(path.c_str());
}

/// What golden-1.pvs.hex was made of. All three row codings, a cell that is not baked, a solid one, an object that
/// is always visible.
PvsData golden_data() {
    PvsData data;
    data.guarantee = Guarantee::conservative;
    data.method = "golden";
    data.tool_version = "0.1.0";
    data.options_json = "{\"seed\":1}";
    for (std::uint8_t i = 0; i < 16; ++i)
        data.scene_fingerprint[i] = static_cast<std::uint8_t>(16 * i + i);
    data.structure_fingerprint = 0xFEDCBA9876543210u;
    data.sides = 1;
    data.origin = {0.1, -2.5, 1e6};
    data.grid = {{{-1, 0, 1e6}, {5, 2.25, 1e6 + 1}}, {3, 2, 1}};
    data.objects.resize(70);
    for (std::int32_t o = 0; o < 70; ++o) {
        float x = float(o) / 8;
        data.objects[std::size_t(o)] = {o, o % 3, o % 5 - 1, o == 69 ? 5u : 1u, std::uint32_t(o * 100),
                                        {{x, -x, 0}, {x + 1, 0, 0.5f}}, o % 7 ? "part" : "\xC3\xA4" "ou\xC3\x9F" "en"};
    }
    data.row_count = 3;
    data.rows = {~std::uint64_t(0), 0x0F, 0x8000000000000001u, 0x20, 0x123456789ABCDEF0u, 0x2A};
    data.cell_row = {0, 1, 2, kCellNotBaked, kCellSolid, 1};
    return data;
}

std::string golden_path() { return ANTUMBRA_SOURCE_DIR "/tests/pvs/golden-1.pvs.hex"; }

std::vector<std::byte> read_hex(const std::string& path) {
    std::ifstream stream(path);
    std::vector<std::byte> bytes;
    for (std::string word; stream >> word;)
        for (std::size_t i = 0; i + 1 < word.size(); i += 2)
            bytes.push_back(std::byte(std::stoi(word.substr(i, 2), nullptr, 16)));
    return bytes;
}

TEST(PvsGolden, AFileOfTheFirstVersionOpensForEver) {
    std::vector<std::byte> bytes = read_hex(golden_path());
    ASSERT_GT(bytes.size(), 1000u) << golden_path();
    Result<Pvs> pvs = Pvs::open(bytes);
    ASSERT_TRUE(pvs.ok()) << pvs.status().message();
    EXPECT_EQ(pvs->guarantee(), Guarantee::conservative);
    EXPECT_EQ(pvs->method(), "golden");
    EXPECT_EQ(pvs->options_json(), "{\"seed\":1}");
    EXPECT_EQ(pvs->structure_fingerprint(), 0xFEDCBA9876543210u);
    EXPECT_EQ(pvs->object_count(), 70u);
    EXPECT_EQ(pvs->object(69).flags, 5u);
    EXPECT_EQ(pvs->object_name(63), "\xC3\xA4" "ou\xC3\x9F" "en");
    PvsCursor cursor;
    (void)pvs->query({-0.5, 1, 1e6}, cursor);
    EXPECT_EQ(cursor.visible, (std::vector<std::uint64_t>{~std::uint64_t(0), 0x2F}));
    (void)pvs->query({1, 1, 1e6}, cursor);
    EXPECT_EQ(cursor.visible, (std::vector<std::uint64_t>{0x8000000000000001u, 0x20}));
    (void)pvs->query({3, 1, 1e6}, cursor);
    EXPECT_EQ(cursor.visible, (std::vector<std::uint64_t>{0x123456789ABCDEF0u, 0x2A}));
    for (double x : {-0.5, 1.5}) {
        (void)pvs->query({x, 2, 1e6}, cursor);
        EXPECT_TRUE(cursor.everything);
        EXPECT_EQ(cursor.visible_count, 70u);
    }
}

TEST(PvsGolden, TheWriterStillWritesTheSameBytes) { EXPECT_EQ(*encode_pvs(golden_data()), read_hex(golden_path())); }

} // namespace
} // namespace antumbra
