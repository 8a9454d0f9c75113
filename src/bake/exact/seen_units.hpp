// Which units one cell is known to see, with counts in the tree above them. Costs what is seen, not what the scene holds.
#pragma once

#include "bake/exact/scene_tree.hpp"

#include <vector>

namespace antumbra::exact {

class SeenUnits {
  public:
    explicit SeenUnits(const SceneTree& tree) : tree_(tree), below_(tree.nodes().size(), 0) {}

    /// Starts a cell with the units whose bits are set; `bits` is written until the next call.
    void begin(std::vector<std::uint64_t>& bits) {
        for (std::uint32_t n : touched_)
            below_[n] = 0;
        touched_.clear();
        bits_ = &bits;
        for (std::size_t w = 0; w < bits.size(); ++w)
            for (std::uint64_t word = bits[w]; word != 0; word &= word - 1)
                count(static_cast<std::uint32_t>(64 * w) + static_cast<std::uint32_t>(__builtin_ctzll(word)));
    }
    bool seen(std::uint32_t unit) const { return (*bits_)[unit / 64] >> (unit % 64) & 1; }
    /// False if it was seen before.
    bool see(std::uint32_t unit) {
        std::uint64_t bit = std::uint64_t(1) << (unit % 64);
        if ((*bits_)[unit / 64] & bit)
            return false;
        (*bits_)[unit / 64] |= bit;
        count(unit);
        return true;
    }
    /// Are all units with triangles below this node seen?
    bool all_seen(std::uint32_t node) const {
        std::uint32_t unit = tree_.nodes()[node].unit;
        return unit != SceneTree::kManyObjects ? seen(unit) : below_[node] == tree_.nodes()[node].units;
    }
    /// Does it hold a unit, all of it, that is seen? Then the node itself is reached.
    bool holds_seen(std::uint32_t node) const { return below_[node] > 0; }

  private:
    void count(std::uint32_t unit) {
        std::uint32_t at = unit < tree_.units().count() ? tree_.root_of(unit) : UINT32_MAX;
        if (at == UINT32_MAX)
            return;
        while (at != 0) {
            at = tree_.parents()[at];
            if (below_[at]++ == 0)
                touched_.push_back(at);
        }
    }

    const SceneTree& tree_;
    std::vector<std::uint64_t>* bits_ = nullptr;
    std::vector<std::uint32_t> below_; ///< per node of several units: how many are seen
    std::vector<std::uint32_t> touched_;
};

} // namespace antumbra::exact
