// The published codings against their published lengths.
#include "pvs/coding_tree.hpp"

#include "pvs/random_tree.hpp"

#include <gtest/gtest.h>
#include <rapidcheck.h>

namespace antumbra {
namespace {

using Words = std::vector<std::uint64_t>;
constexpr TreeCoding kCodings[] = {TreeCoding::leaves, TreeCoding::parent, TreeCoding::sibling};

std::uint64_t bits_of(const CodingTree& tree, TreeCoding coding, const Words& rows, std::size_t objects) {
    std::uint64_t bits = 0;
    (void)encode_tree_rows(tree, coding, rows, objects, &bits);
    return bits;
}

std::uint64_t inner_nodes(const CodingTree& tree) { return tree.nodes.size() / 2; }

/// A complete binary tree of `leaves` rows.
CodingTree complete_tree(std::uint32_t leaves) {
    std::vector<std::uint32_t> cell_row(leaves);
    for (std::uint32_t c = 0; c < leaves; ++c)
        cell_row[c] = c;
    return coding_tree_of(CellGrid{{{0, 0, 0}, {1, 1, 1}}, {leaves, 1, 1}}, cell_row);
}

TEST(TreeCoding, TheExampleOfThePaper) {
    // v(B) = 0011000, v(C) = 0101000, the first object leftmost; v(A) = 0111000.
    Words rows{0b0001100, 0b0001010};
    CodingTree tree = complete_tree(2);
    EXPECT_EQ(bits_of(tree, TreeCoding::leaves, rows, 7), 14u);
    EXPECT_EQ(bits_of(tree, TreeCoding::parent, rows, 7), 13u);
    EXPECT_EQ(bits_of(tree, TreeCoding::sibling, rows, 7), 12u + 1) << "and one bit that says which child is lighter";
    std::vector<std::byte> bytes = encode_tree_rows(tree, TreeCoding::parent, rows, 7);
    // A, then B within A (011), then C within A (101), first bit lowest.
    EXPECT_EQ(bytes, (std::vector<std::byte>{std::byte(0b0'0001110), std::byte(0b000'101'11)}));
}

TEST(TreeCoding, IdealTreesOfDisjointLeaves) {
    for (std::uint32_t log = 1; log <= 6; ++log) {
        std::uint64_t n = std::uint64_t(1) << log;
        Words rows(n);
        for (std::uint64_t r = 0; r < n; ++r)
            rows[r] = std::uint64_t(1) << r;
        CodingTree tree = complete_tree(std::uint32_t(n));
        EXPECT_EQ(bits_of(tree, TreeCoding::leaves, rows, n), n * n);
        EXPECT_EQ(bits_of(tree, TreeCoding::parent, rows, n), n + 2 * n * log);
        EXPECT_EQ(bits_of(tree, TreeCoding::sibling, rows, n) - inner_nodes(tree), n + 3 * n * log / 2);
        if (n == 8) {
            EXPECT_EQ(bits_of(tree, TreeCoding::leaves, rows, n), 64u);
            EXPECT_EQ(bits_of(tree, TreeCoding::parent, rows, n), 56u);
            EXPECT_EQ(bits_of(tree, TreeCoding::sibling, rows, n), 44u + 7);
        }
    }
}

TEST(TreeCoding, EveryCodingIsLossless) {
    EXPECT_TRUE(rc::check("grids and view trees, shared rows, special cells", [](std::uint64_t seed) {
        bool grid = seed % 2;
        PvsData data = grid ? test::random_pvs(seed, 100) : test::random_pvs_tree(seed, 100);
        std::size_t words = data.words_per_row();
        CodingTree tree = grid ? coding_tree_of(data.grid, data.cell_row) : coding_tree_of(data.tree);
        for (TreeCoding coding : kCodings) {
            std::vector<std::byte> bytes = encode_tree_rows(tree, coding, data.rows, data.bits_per_row());
            std::vector<int> seen(data.row_count);
            RC_ASSERT(decode_tree_rows(tree, coding, bytes, data.bits_per_row(), [&](std::uint32_t row, auto set) {
                ++seen[row];
                RC_ASSERT(std::equal(set.begin(), set.end(), data.rows.begin() + std::ptrdiff_t(row * words)));
            }));
            for (std::uint32_t row = 0; row < data.row_count; ++row) {
                bool used = false;
                for (std::uint32_t r : data.cell_row)
                    used = used || r == row;
                for (const ViewNode& node : data.tree.nodes)
                    used = used || (node.axis == ViewNode::kLeaf && node.link == row);
                RC_ASSERT(seen[row] == int(used));
            }
            if (bytes.empty() || data.bits_per_row() == 0)
                continue;
            auto ignore = [](std::uint32_t, auto) {};
            std::vector<std::byte> longer = bytes;
            longer.push_back(std::byte(0));
            RC_ASSERT(!decode_tree_rows(tree, coding, longer, data.bits_per_row(), ignore));
            bytes.pop_back();
            RC_ASSERT(!decode_tree_rows(tree, coding, bytes, data.bits_per_row(), ignore));
        }
    }));
}

TEST(TreeCoding, AGridIsHalvedAcrossItsLongestAxis) {
    // 3 x 2 cells: below, x = 0; above, x = 1 and 2.
    CodingTree tree = coding_tree_of(CellGrid{{{0, 0, 0}, {1, 1, 1}}, {3, 2, 1}}, std::vector<std::uint32_t>{0, 1, 2, 3, 4, 5});
    std::vector<std::uint32_t> order;
    for (const CodingTree::Node& node : tree.nodes)
        if (node.row != CodingTree::kInner)
            order.push_back(node.row);
    EXPECT_EQ(order, (std::vector<std::uint32_t>{0, 3, 1, 4, 2, 5}));
    EXPECT_EQ(tree.nodes.size(), 11u);
}

} // namespace
} // namespace antumbra
