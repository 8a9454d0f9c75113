// The search for minimum occluder sets: small sets that hit every list.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

namespace antumbra {

/// Lists of item numbers below `items`, flat; list i is entries[first[i] .. first[i + 1]).
struct ItemTable {
    std::uint32_t items = 0;
    std::vector<std::uint32_t> first{0}, entries;

    std::size_t size() const { return first.size() - 1; }
    std::span<const std::uint32_t> list(std::size_t i) const {
        return {entries.data() + first[i], first[i + 1] - first[i]};
    }
    void add(std::span<const std::uint32_t> list) {
        entries.insert(entries.end(), list.begin(), list.end());
        first.push_back(static_cast<std::uint32_t>(entries.size()));
    }
};

struct MinimumSet {
    std::vector<std::uint32_t> items; ///< ascending
    double cost = 0;                  ///< sum over the items
    bool operator==(const MinimumSet&) const = default;
};

struct MinimumSets {
    std::vector<MinimumSet> sets; ///< cheapest first; equal costs in the order of the items
    bool complete = true;         ///< false: the bound on work was reached, cheaper ones may exist
};

/// Up to `keep` of the cheapest sets that hit every list and from which no item can be left out. `costs` per item,
/// above 0. None if a list is empty. `work` bounds the steps: beyond it at least one set is still found, by greed.
/// A pure function of its arguments.
MinimumSets find_minimum_sets(const ItemTable& table, std::span<const double> costs, std::uint32_t keep,
                              std::uint64_t work);

/// Does `items` hit every list, and is every item the only hit of some list? The definition, written apart from the
/// search.
bool is_minimum_set(const ItemTable& table, std::span<const std::uint32_t> items);

} // namespace antumbra
