#include "pvs/reference_tree.hpp"

#include "pvs/count_bits.hpp"

#include <algorithm>

namespace antumbra {
namespace {

constexpr std::uint64_t kMostWork = std::uint64_t(1) << 33;

/// Prim's algorithm over the rows [first, last), each starting from the empty set.
class BlockTree {
  public:
    BlockTree(std::span<const std::uint64_t> bits, std::size_t words, std::size_t first, std::size_t last,
              std::uint32_t most_depth, std::vector<std::uint32_t>& references)
        : bits_(bits), words_(words), first_(first), most_depth_(most_depth), references_(references),
          distance_(last - first), depth_(last - first), done_(last - first) {
        for (std::size_t i = 0; i < distance_.size(); ++i)
            distance_[i] = count_bits(row(i));
    }

    void grow() {
        for (std::size_t step = 0; step < distance_.size(); ++step) {
            std::size_t nearest = find_nearest();
            done_[nearest] = true;
            std::uint32_t reference = references_[first_ + nearest];
            depth_[nearest] = reference == kNoReference ? 0 : depth_[reference - first_] + 1;
            if (depth_[nearest] < most_depth_)
                offer(nearest);
        }
    }

  private:
    std::span<const std::uint64_t> row(std::size_t i) const { return bits_.subspan((first_ + i) * words_, words_); }

    /// On a draw the first, so that nothing depends on chance.
    std::size_t find_nearest() const {
        std::size_t nearest = distance_.size();
        for (std::size_t i = 0; i < distance_.size(); ++i)
            if (!done_[i] && (nearest == distance_.size() || distance_[i] < distance_[nearest]))
                nearest = i;
        return nearest;
    }

    void offer(std::size_t reference) {
        std::span<const std::uint64_t> a = row(reference);
        for (std::size_t i = 0; i < distance_.size(); ++i) {
            if (done_[i])
                continue;
            std::span<const std::uint64_t> b = row(i);
            std::uint32_t differing = 0;
            for (std::size_t w = 0; w < words_; ++w)
                differing += count_bits(a[w] ^ b[w]);
            if (differing < distance_[i]) {
                distance_[i] = differing;
                references_[first_ + i] = static_cast<std::uint32_t>(first_ + reference);
            }
        }
    }

    std::span<const std::uint64_t> bits_;
    std::size_t words_, first_;
    std::uint32_t most_depth_;
    std::vector<std::uint32_t>& references_;
    std::vector<std::uint32_t> distance_, depth_;
    std::vector<bool> done_;
};

} // namespace

std::vector<std::uint32_t> choose_references(std::span<const std::uint64_t> bits, std::size_t rows, std::size_t words,
                                             std::uint32_t most_depth) {
    std::vector<std::uint32_t> references(rows, kNoReference);
    std::uint64_t block = kMostWork / (std::uint64_t(rows) * std::max<std::size_t>(words, 1) + 1);
    block = std::clamp<std::uint64_t>(block, 64, std::max<std::size_t>(rows, 64));
    for (std::size_t first = 0; first < rows; first += std::size_t(block))
        BlockTree(bits, words, first, std::min(rows, first + std::size_t(block)), most_depth, references).grow();
    return references;
}

} // namespace antumbra
