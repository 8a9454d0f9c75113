#include "pvs/coding_tree.hpp"

#include "pvs/count_bits.hpp"
#include "pvs/row_coding.hpp"

#include <array>
#include <bit>

namespace antumbra {
namespace {

using Set = std::vector<std::uint64_t>;
using Words = std::span<const std::uint64_t>;

bool has(Words words, std::size_t bit) { return words[bit / 64] >> (bit % 64) & 1; }

/// Builds a CodingTree from its leaves up: an inner node is there only when both of its children are.
class TreeBuilder {
  public:
    using Index = std::uint32_t;
    static constexpr Index kNothing = 0xFFFFFFFFu;

    /// A leaf, if its row is one and new.
    Index leaf(std::uint32_t row) {
        if (row >= kCellSolid)
            return kNothing;
        if (row >= used_.size())
            used_.resize(std::size_t(row) + 1);
        if (used_[row])
            return kNothing;
        used_[row] = true;
        return add({row, 0, 0});
    }

    Index inner(Index below, Index above) {
        return below == kNothing ? above : above == kNothing ? below : add({CodingTree::kInner, below, above});
    }

    /// The same in preorder.
    CodingTree take(Index root) {
        CodingTree tree;
        tree.nodes.reserve(nodes_.size());
        if (root != kNothing)
            append(root, tree);
        return tree;
    }

  private:
    struct Node {
        std::uint32_t row;
        Index below, above;
    };

    Index add(const Node& node) {
        nodes_.push_back(node);
        return static_cast<Index>(nodes_.size() - 1);
    }

    void append(Index index, CodingTree& tree) const {
        std::size_t self = tree.nodes.size();
        tree.nodes.push_back({nodes_[index].row, 0});
        if (nodes_[index].row != CodingTree::kInner)
            return;
        append(nodes_[index].below, tree);
        tree.nodes[self].above = static_cast<std::uint32_t>(tree.nodes.size());
        append(nodes_[index].above, tree);
    }

    std::vector<Node> nodes_;
    std::vector<bool> used_;
};

TreeBuilder::Index add_view_node(TreeBuilder& builder, const ViewTree& tree, std::uint32_t n) {
    const ViewNode& node = tree.nodes[n];
    if (node.axis == ViewNode::kLeaf)
        return builder.leaf(node.link);
    TreeBuilder::Index below = add_view_node(builder, tree, n + 1);
    return builder.inner(below, add_view_node(builder, tree, node.link));
}

using Corner = std::array<std::uint32_t, 3>;

TreeBuilder::Index add_cells(TreeBuilder& builder, const CellGrid& grid, std::span<const std::uint32_t> cell_row,
                             Corner low, Corner high) {
    std::size_t axis = 0;
    for (std::size_t k = 1; k < 3; ++k)
        if (high[k] - low[k] > high[axis] - low[axis])
            axis = k;
    if (high[axis] - low[axis] == 1)
        return builder.leaf(
            cell_row[low[0] + grid.count[0] * (low[1] + std::uint64_t(grid.count[1]) * low[2])]);
    Corner below_high = high, above_low = low;
    below_high[axis] = above_low[axis] = low[axis] + (high[axis] - low[axis]) / 2;
    TreeBuilder::Index below = add_cells(builder, grid, cell_row, low, below_high);
    return builder.inner(below, add_cells(builder, grid, cell_row, above_low, high));
}

class BitWriter {
  public:
    void put(bool bit) {
        if (count_ % 8 == 0)
            bytes.push_back(std::byte(0));
        if (bit)
            bytes.back() |= std::byte(1u << (count_ % 8));
        ++count_;
    }
    std::uint64_t count() const { return count_; }
    std::vector<std::byte> bytes;

  private:
    std::uint64_t count_ = 0;
};

class BitReader {
  public:
    explicit BitReader(std::span<const std::byte> bytes) : bytes_(bytes) {}
    bool get() {
        std::uint64_t at = at_++;
        return at / 8 < bytes_.size() && (std::to_integer<unsigned>(bytes_[std::size_t(at / 8)]) >> (at % 8) & 1);
    }
    /// Everything was read, nothing beyond, and the rest of the last byte is zero.
    bool ends_here() {
        if ((at_ + 7) / 8 != bytes_.size())
            return false;
        while (at_ % 8 != 0)
            if (get())
                return false;
        return true;
    }
    bool ran_out() const { return at_ > std::uint64_t(bytes_.size()) * 8; }

  private:
    std::span<const std::byte> bytes_;
    std::uint64_t at_ = 0;
};

/// v(B)[v(A)]: the bits of `set` where `within` has a 1; all of them if it is null.
void put_set(BitWriter& out, Words set, const Set* within, std::size_t objects) {
    for (std::size_t o = 0; o < objects; ++o)
        if (!within || has(*within, o))
            out.put(has(set, o));
}

Set get_set(BitReader& in, const Set* within, std::size_t objects) {
    Set set(words_for(objects));
    for (std::size_t o = 0; o < objects; ++o)
        if ((!within || has(*within, o)) && in.get())
            set[o / 64] |= std::uint64_t(1) << (o % 64);
    return set;
}

/// a without b.
Set minus(const Set& a, const Set& b) {
    Set rest = a;
    for (std::size_t w = 0; w < rest.size(); ++w)
        rest[w] &= ~b[w];
    return rest;
}

class TreeEncoder {
  public:
    TreeEncoder(const CodingTree& tree, TreeCoding coding, Words rows, std::size_t objects)
        : tree_(tree), coding_(coding), objects_(objects), words_(words_for(objects)), sets_(tree.nodes.size()) {
        // Children stand behind their parent: from the last to the first every union's parts are there.
        for (std::size_t n = tree.nodes.size(); n-- > 0;) {
            const CodingTree::Node& node = tree.nodes[n];
            if (node.row != CodingTree::kInner) {
                Words row = rows.subspan(node.row * words_, words_);
                sets_[n].assign(row.begin(), row.end());
                continue;
            }
            sets_[n] = sets_[n + 1];
            for (std::size_t w = 0; w < words_; ++w)
                sets_[n][w] |= sets_[node.above][w];
        }
    }

    void write(BitWriter& out) const {
        if (!tree_.nodes.empty() && coding_ != TreeCoding::leaves)
            put_set(out, sets_[0], nullptr, objects_);
        for (std::size_t n = 0; n < tree_.nodes.size(); ++n)
            if (tree_.nodes[n].row == CodingTree::kInner)
                put_children(out, sets_[n], sets_[n + 1], sets_[tree_.nodes[n].above]);
            else if (coding_ == TreeCoding::leaves)
                put_set(out, sets_[n], nullptr, objects_);
    }

  private:
    void put_children(BitWriter& out, const Set& parent, const Set& below, const Set& above) const {
        if (coding_ == TreeCoding::parent) {
            put_set(out, below, &parent, objects_);
            put_set(out, above, &parent, objects_);
        } else if (coding_ == TreeCoding::sibling) {
            bool above_is_lighter = count_bits(above) < count_bits(below);
            const Set &lighter = above_is_lighter ? above : below, &heavier = above_is_lighter ? below : above;
            out.put(above_is_lighter);
            put_set(out, lighter, &parent, objects_);
            put_set(out, heavier, &lighter, objects_);
        }
    }

    const CodingTree& tree_;
    TreeCoding coding_;
    std::size_t objects_, words_;
    std::vector<Set> sets_; ///< of each node
};

/// Reads the two sets under `parent`.
void get_children(BitReader& in, TreeCoding coding, const Set& parent, std::size_t objects, Set& below, Set& above) {
    if (coding == TreeCoding::parent) {
        below = get_set(in, &parent, objects);
        above = get_set(in, &parent, objects);
        return;
    }
    bool above_is_lighter = in.get();
    Set lighter = get_set(in, &parent, objects);
    Set heavier = get_set(in, &lighter, objects);
    // Where the lighter one has a 0, the heavier one must have what the parent has.
    Set rest = minus(parent, lighter);
    for (std::size_t w = 0; w < heavier.size(); ++w)
        heavier[w] |= rest[w];
    below = above_is_lighter ? std::move(heavier) : lighter;
    above = above_is_lighter ? std::move(lighter) : std::move(heavier);
}

} // namespace

CodingTree coding_tree_of(const ViewTree& tree) {
    TreeBuilder builder;
    return builder.take(tree.nodes.empty() ? TreeBuilder::kNothing : add_view_node(builder, tree, 0));
}

CodingTree coding_tree_of(const CellGrid& grid, std::span<const std::uint32_t> cell_row) {
    TreeBuilder builder;
    return builder.take(cell_row.empty() ? TreeBuilder::kNothing
                                         : add_cells(builder, grid, cell_row, {0, 0, 0}, grid.count));
}

std::vector<std::byte> encode_tree_rows(const CodingTree& tree, TreeCoding coding, std::span<const std::uint64_t> rows,
                                        std::size_t objects, std::uint64_t* bits) {
    BitWriter out;
    TreeEncoder(tree, coding, rows, objects).write(out);
    if (bits)
        *bits = out.count();
    return std::move(out.bytes);
}

bool decode_tree_rows(const CodingTree& tree, TreeCoding coding, std::span<const std::byte> coded, std::size_t objects,
                      const std::function<void(std::uint32_t, std::span<const std::uint64_t>)>& row) {
    BitReader in(coded);
    std::vector<Set> waiting; // sets of the nodes to come, the next one last
    if (!tree.nodes.empty() && coding != TreeCoding::leaves)
        waiting.push_back(get_set(in, nullptr, objects));
    for (const CodingTree::Node& node : tree.nodes) {
        if (in.ran_out())
            return false;
        Set set;
        if (coding != TreeCoding::leaves) {
            set = std::move(waiting.back());
            waiting.pop_back();
        } else if (node.row != CodingTree::kInner) {
            set = get_set(in, nullptr, objects);
        }
        if (node.row != CodingTree::kInner) {
            row(node.row, set);
        } else if (coding != TreeCoding::leaves) {
            Set below, above;
            get_children(in, coding, set, objects, below, above);
            waiting.push_back(std::move(above));
            waiting.push_back(std::move(below));
        }
    }
    return in.ends_here();
}

} // namespace antumbra
