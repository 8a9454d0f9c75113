// The three published codings of a tree of bit sets (Gotsman, Sudarsky, Fayman 1999, section 6): leaves alone,
// children relative to their parent, and the heavier child relative to the lighter one, too.
#pragma once

#include <antumbra/pvs.hpp>

#include <cstdint>
#include <functional>
#include <span>
#include <vector>

namespace antumbra {

/// A binary tree whose leaves are the rows 0 .. n-1, each once; preorder. In every inner node both children hold rows.
struct CodingTree {
    static constexpr std::uint32_t kInner = 0xFFFFFFFFu;
    struct Node {
        std::uint32_t row = kInner;
        std::uint32_t above = 0; ///< inner: index of the second child; the first one is the next node
    };
    std::vector<Node> nodes; ///< empty: no rows
};

/// The tree that a view tree is over rows: each row at the first leaf, in preorder, that has it.
CodingTree coding_tree_of(const ViewTree& tree);
/// The same for a grid, cut in halves across its longest axis (in cells; x before y before z) again and again. Odd
/// counts leave the larger half above.
CodingTree coding_tree_of(const CellGrid& grid, std::span<const std::uint32_t> cell_row);

/// Which of the three.
enum class TreeCoding : std::uint8_t { leaves = 1, parent = 2, sibling = 3 };

/// Bits, the first in the lowest bit of the first byte, zeros at the end. Sets of inner nodes are the unions of
/// their leaves'. `bits` (may be null) receives their number. O(nodes * words + bits).
std::vector<std::byte> encode_tree_rows(const CodingTree& tree, TreeCoding coding, std::span<const std::uint64_t> rows,
                                        std::size_t objects, std::uint64_t* bits = nullptr);

/// Decodes and hands each row to `row(number, words)` in preorder. False if `coded` ends too early, or not with zeros to
/// the next byte. O(nodes * objects).
bool decode_tree_rows(const CodingTree& tree, TreeCoding coding, std::span<const std::byte> coded, std::size_t objects,
                      const std::function<void(std::uint32_t, std::span<const std::uint64_t>)>& row);

} // namespace antumbra
