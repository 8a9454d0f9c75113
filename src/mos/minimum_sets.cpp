// Singletons first, then depth first over the items of the shortest list that is not hit yet (Poon, Wang 1999, 4.2).
// Each set is met once: what a list's earlier items have tried, its later ones leave out. A branch ends when it costs
// as much as the worst set kept, or when an item has become redundant: more items never make it needed again.
#include "mos/minimum_sets.hpp"

#include <algorithm>
#include <numeric>

namespace antumbra {
namespace {

class Search {
  public:
    Search(const ItemTable& table, std::span<const double> costs, std::uint32_t keep, std::uint64_t work)
        : table_(table), costs_(costs), keep_(keep), work_(work), state_(table.items), lists_of_(table.items) {}

    MinimumSets run() {
        order_lists();
        for (std::size_t i = 0; i < lists_.size(); ++i) {
            for (std::uint32_t item : lists_[i])
                lists_of_[item].push_back(static_cast<std::uint32_t>(i));
        }
        hits_.assign(lists_.size(), 0);
        hit_sum_.assign(lists_.size(), 0);
        for (std::vector<std::uint32_t>& list : lists_)
            std::sort(list.begin(), list.end(), [&](std::uint32_t a, std::uint32_t b) { return comes_first(a, b); });
        for (const std::vector<std::uint32_t>& list : lists_)
            if (list.empty())
                return {};
        greedy();
        for (const std::vector<std::uint32_t>& list : lists_)
            if (list.size() == 1 && state_[list[0]].chosen == 0)
                choose(list[0]);
        if (redundant_ == 0)
            descend(0);
        std::sort(result_.sets.begin(), result_.sets.end(), is_better);
        return std::move(result_);
    }

  private:
    struct Item {
        std::uint32_t chosen = 0, forbidden = 0;
        std::uint32_t only_hit = 0; ///< lists that this item alone hits
    };

    static bool is_better(const MinimumSet& a, const MinimumSet& b) {
        return a.cost != b.cost ? a.cost < b.cost : a.items < b.items;
    }
    /// Hits more for its cost.
    bool comes_first(std::uint32_t a, std::uint32_t b) const {
        double left = double(lists_of_[a].size()) * costs_[b], right = double(lists_of_[b].size()) * costs_[a];
        return left != right ? left > right : a < b;
    }

    /// Sorted by length; lists that contain another one are hit whenever that one is, and left out.
    void order_lists() {
        std::vector<std::vector<std::uint32_t>> all;
        for (std::size_t i = 0; i < table_.size(); ++i) {
            std::span<const std::uint32_t> list = table_.list(i);
            all.emplace_back(list.begin(), list.end());
            std::sort(all.back().begin(), all.back().end());
            all.back().erase(std::unique(all.back().begin(), all.back().end()), all.back().end());
        }
        std::sort(all.begin(), all.end(), [](const auto& a, const auto& b) {
            return a.size() != b.size() ? a.size() < b.size() : a < b;
        });
        std::vector<std::vector<std::uint32_t>> begins_with(table_.items); // kept lists by their least item
        std::vector<char> marked(table_.items, 0);
        for (std::vector<std::uint32_t>& list : all) {
            for (std::uint32_t item : list)
                marked[item] = 1;
            bool contains_another = false;
            for (std::size_t i = 0; i < list.size() && !contains_another; ++i)
                for (std::uint32_t kept : begins_with[list[i]]) {
                    contains_another = std::all_of(lists_[kept].begin(), lists_[kept].end(),
                                                   [&](std::uint32_t item) { return marked[item]; });
                    if (contains_another)
                        break;
                }
            for (std::uint32_t item : list)
                marked[item] = 0;
            if (contains_another)
                continue;
            if (!list.empty())
                begins_with[list[0]].push_back(static_cast<std::uint32_t>(lists_.size()));
            lists_.push_back(std::move(list));
        }
    }

    void choose(std::uint32_t item) {
        spent_ += lists_of_[item].size() + 1;
        state_[item].chosen = 1;
        cost_ += costs_[item];
        chosen_.push_back(item);
        for (std::uint32_t list : lists_of_[item]) {
            if (hits_[list] == 0)
                ++state_[item].only_hit;
            else if (hits_[list] == 1 && --state_[hit_sum_[list]].only_hit == 0)
                ++redundant_;
            ++hits_[list];
            hit_sum_[list] += item;
        }
        redundant_ += state_[item].only_hit == 0;
    }

    void undo() {
        std::uint32_t item = chosen_.back();
        chosen_.pop_back();
        redundant_ -= state_[item].only_hit == 0;
        for (std::uint32_t list : lists_of_[item]) {
            --hits_[list];
            hit_sum_[list] -= item;
            if (hits_[list] == 0)
                --state_[item].only_hit;
            else if (hits_[list] == 1 && state_[hit_sum_[list]].only_hit++ == 0)
                --redundant_;
        }
        state_[item].chosen = 0;
        cost_ = 0; // sums are formed anew, so that they do not depend on the way
        for (std::uint32_t other : chosen_)
            cost_ += costs_[other];
    }

    void keep(std::vector<std::uint32_t> items) {
        std::sort(items.begin(), items.end());
        MinimumSet set;
        for (std::uint32_t item : items)
            set.cost += costs_[item];
        set.items = std::move(items);
        if (std::find(result_.sets.begin(), result_.sets.end(), set) != result_.sets.end())
            return;
        result_.sets.insert(std::upper_bound(result_.sets.begin(), result_.sets.end(), set, is_better), set);
        if (result_.sets.size() > keep_)
            result_.sets.pop_back();
    }
    /// What a set must cost less than to be kept.
    bool is_too_dear(double cost) const {
        return result_.sets.size() >= keep_ && cost >= result_.sets.back().cost;
    }

    /// The item that hits most of what is left for its cost, again and again; then, dearest first, without what turned
    /// out redundant.
    void greedy() {
        std::vector<std::uint32_t> left(table_.items);
        for (std::uint32_t item = 0; item < table_.items; ++item)
            left[item] = static_cast<std::uint32_t>(lists_of_[item].size());
        std::size_t open = lists_.size();
        while (open > 0) {
            std::uint32_t best = 0;
            for (std::uint32_t item = 1; item < table_.items; ++item)
                if (double(left[item]) * costs_[best] > double(left[best]) * costs_[item])
                    best = item;
            for (std::uint32_t list : lists_of_[best])
                if (hits_[list] == 0) {
                    --open;
                    for (std::uint32_t item : lists_[list])
                        --left[item];
                }
            choose(best);
        }
        std::vector<std::uint32_t> set = chosen_;
        std::sort(set.begin(), set.end(), [&](std::uint32_t a, std::uint32_t b) {
            return costs_[a] != costs_[b] ? costs_[a] > costs_[b] : a < b;
        });
        std::vector<std::uint32_t> needed;
        for (std::uint32_t item : set) {
            bool redundant = std::none_of(lists_of_[item].begin(), lists_of_[item].end(),
                                          [&](std::uint32_t list) { return hits_[list] == 1; });
            if (!redundant) {
                needed.push_back(item);
                continue;
            }
            for (std::uint32_t list : lists_of_[item])
                --hits_[list];
        }
        for (std::uint32_t item : set)
            state_[item] = {};
        std::fill(hits_.begin(), hits_.end(), 0);
        std::fill(hit_sum_.begin(), hit_sum_.end(), 0);
        chosen_.clear();
        cost_ = 0;
        redundant_ = 0;
        keep(std::move(needed));
    }

    /// Lists before `from` are hit.
    void descend(std::size_t from) {
        while (from < lists_.size() && hits_[from] > 0)
            ++from;
        if (from == lists_.size())
            return keep(chosen_);
        std::size_t tried = 0;
        for (std::uint32_t item : lists_[from]) {
            if (spent_ > work_) {
                result_.complete = false;
                break;
            }
            ++tried;
            if (state_[item].forbidden || is_too_dear(cost_ + costs_[item])) {
                ++state_[item].forbidden;
                continue;
            }
            choose(item);
            if (redundant_ == 0)
                descend(from + 1);
            undo();
            ++state_[item].forbidden;
        }
        for (std::size_t i = 0; i < tried; ++i)
            --state_[lists_[from][i]].forbidden;
    }

    const ItemTable& table_;
    std::span<const double> costs_;
    std::size_t keep_;
    std::uint64_t work_, spent_ = 0;
    std::vector<std::vector<std::uint32_t>> lists_;
    std::vector<Item> state_;
    std::vector<std::vector<std::uint32_t>> lists_of_;
    std::vector<std::uint32_t> hits_, hit_sum_, chosen_;
    std::uint32_t redundant_ = 0;
    double cost_ = 0;
    MinimumSets result_;
};

} // namespace

MinimumSets find_minimum_sets(const ItemTable& table, std::span<const double> costs, std::uint32_t keep,
                              std::uint64_t work) {
    return Search(table, costs, keep, work).run();
}

bool is_minimum_set(const ItemTable& table, std::span<const std::uint32_t> items) {
    std::vector<char> member(table.items, 0), needed(table.items, 0);
    for (std::uint32_t item : items)
        member[item] = 1;
    for (std::size_t i = 0; i < table.size(); ++i) {
        std::uint32_t hits = 0, hit = 0;
        for (std::uint32_t item : table.list(i))
            if (member[item] && (hits == 0 || item != hit)) { // lists may repeat items
                ++hits;
                hit = item;
            }
        if (hits == 0)
            return false;
        if (hits == 1)
            needed[hit] = 1;
    }
    return std::all_of(items.begin(), items.end(), [&](std::uint32_t item) { return needed[item]; });
}

} // namespace antumbra
