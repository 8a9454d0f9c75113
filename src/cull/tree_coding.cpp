// A tree over boxes as its shape alone: which item stands at which leaf. Boxes follow from the items when it is read,
// so that no file can make a tree that leaves something out.
#include "cull/scene_data.hpp"

namespace antumbra {
namespace {

class TreeDecoder {
  public:
    TreeDecoder(std::span<const std::byte> bits, std::span<const Box3f> bounds, std::span<const std::uint32_t> order)
        : bits_(bits), bounds_(bounds), order_(order) {}

    /// Empty if the bits are no tree of all items, or too deep a one.
    std::vector<BinaryNode> run() {
        std::size_t count = 2 * order_.size() - 1;
        nodes_.reserve(count);
        for (std::size_t i = 0; i < count; ++i) {
            nodes_.emplace_back();
            if (std::to_integer<unsigned>(bits_[i / 8]) >> (i % 8) & 1) {
                nodes_.back().first = leaf_;
                open_.push_back({static_cast<std::uint32_t>(i), false});
                if (open_.size() > std::size_t(kTreeDepth))
                    return {};
            } else if (leaf_ == order_.size() || (close_leaf(), open_.empty() && i + 1 < count)) {
                return {};
            }
        }
        if (!open_.empty() || leaf_ != order_.size())
            return {};
        return std::move(nodes_);
    }

  private:
    struct Open {
        std::uint32_t node;
        bool left_done;
    };

    /// Fills the last node, then every node that is complete by that.
    void close_leaf() {
        BinaryNode& leaf = nodes_.back();
        leaf.box = bounds_[order_[leaf_]];
        leaf.first = leaf_++;
        leaf.count = 1;
        while (!open_.empty()) {
            Open& top = open_.back();
            BinaryNode& node = nodes_[top.node];
            if (!top.left_done) {
                top.left_done = true;
                node.right = static_cast<std::uint32_t>(nodes_.size());
                return;
            }
            node.box = nodes_[top.node + 1].box;
            node.box.extend(nodes_[node.right].box);
            node.count = leaf_ - node.first;
            open_.pop_back();
        }
    }

    std::span<const std::byte> bits_;
    std::span<const Box3f> bounds_;
    std::span<const std::uint32_t> order_;
    std::vector<BinaryNode> nodes_;
    std::vector<Open> open_;
    std::uint32_t leaf_ = 0;
};

Status corrupt(const char* what) {
    return {ErrorCode::corrupt, std::string("chunk 'CTRE': ") + what + "; the file is damaged, prepare it again"};
}

} // namespace

void encode_tree(const std::vector<BinaryNode>& binary, std::span<const std::uint32_t> order, ByteWriter& out) {
    out.u32(static_cast<std::uint32_t>(order.size()));
    for (std::uint32_t item : order)
        out.u32(item);
    for (std::size_t i = 0; i < binary.size(); i += 8) {
        unsigned byte = 0;
        for (std::size_t k = 0; k < 8 && i + k < binary.size(); ++k)
            byte |= unsigned(binary[i + k].right != 0) << k;
        out.u8(static_cast<std::uint8_t>(byte));
    }
    out.align(4);
}

Result<std::vector<BinaryNode>> decode_tree(std::span<const std::byte> bytes, std::size_t& at,
                                            std::span<const Box3f> bounds, std::vector<std::uint32_t>& order) {
    if (bytes.size() - at < 4)
        return corrupt("it ends too early");
    std::size_t count = load_u32(bytes, at);
    at += 4;
    if (count != order.size())
        return corrupt("a tree has another number of items than the scene");
    if (count == 0)
        return std::vector<BinaryNode>();
    std::size_t shape = (2 * count - 1 + 7) / 8, end = count * 4 + (shape + 3) / 4 * 4;
    if (end > bytes.size() - at)
        return corrupt("it ends too early");
    std::vector<char> wanted(bounds.size(), 0);
    for (std::uint32_t item : order)
        wanted[item] = 1;
    for (std::size_t i = 0; i < count; ++i) {
        order[i] = load_u32(bytes, at + 4 * i);
        if (order[i] >= bounds.size() || !wanted[order[i]])
            return corrupt("a tree holds an item twice, or one that belongs to no tree");
        wanted[order[i]] = 0;
    }
    std::vector<BinaryNode> binary = TreeDecoder(bytes.subspan(at + 4 * count, shape), bounds, order).run();
    if (binary.empty())
        return corrupt("the shape of a tree is none, or too deep");
    at += end;
    return binary;
}

} // namespace antumbra
