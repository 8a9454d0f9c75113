#include "mos/select_sets.hpp"

#include <algorithm>
#include <bit>
#include <numeric>

namespace antumbra {
namespace {

using Bits = std::vector<std::uint64_t>;

bool is_subset(std::span<const std::uint32_t> small, std::span<const std::uint32_t> large) {
    return std::includes(large.begin(), large.end(), small.begin(), small.end());
}

class Selection {
  public:
    Selection(const OccluderStack& stack, std::vector<GroupedSet> sets, std::span<const double> gain,
              const MosOptions& options)
        : stack_(stack), sets_(std::move(sets)), gain_(gain), options_(options), picture_(stack),
          drawn_(stack.members(), 0) {
        for (GroupedSet& set : sets_)
            set.cost = cost_of(set.members, false);
        add_subsets();
    }

    std::vector<std::uint32_t> run() {
        if (options_.selection == MosSelection::published)
            take_by_score();
        else
            for (std::size_t before = 0; order_.size() > before || before == 0;) {
                before = order_.size();
                take_by_what_they_add(); // the next round hides everything once more, for eyes beside the grid point
                if (order_.empty())
                    break;
            }
        fill_up();
        std::vector<std::uint32_t> list;
        for (std::uint32_t member : order_)
            if (picture_.pixels(member) > 0)
                list.push_back(member);
        return list;
    }

  private:
    double cost_of(std::span<const std::uint32_t> members, bool only_new) const {
        double cost = 0;
        for (std::uint32_t member : members)
            if (!only_new || !drawn_[member])
                cost += options_.polygon_weight + options_.size_weight * double(stack_.fragments(member).size()) /
                                                      double(stack_.pixels());
        return cost;
    }

    double worth(const Bits& occludees, const Bits* without) const {
        double sum = 0;
        for (std::size_t word = 0; word < occludees.size(); ++word)
            for (std::uint64_t rest = occludees[word] & (without ? ~(*without)[word] : ~std::uint64_t(0)); rest;
                 rest &= rest - 1)
                sum += gain_[word * 64 + std::size_t(std::countr_zero(rest))];
        return sum;
    }

    /// What a set hides, its subsets hide in part: their occludees are its own, too. (The paper adds the gains, and counts
    /// an occludee twice that two subsets hide.)
    void add_subsets() {
        std::size_t words = (gain_.size() + 63) / 64;
        std::vector<std::vector<std::uint32_t>> sets_with(stack_.members());
        for (std::uint32_t s = 0; s < sets_.size(); ++s) {
            hides_.emplace_back(words, 0);
            for (std::uint32_t occludee : sets_[s].occludees)
                hides_[s][occludee / 64] |= std::uint64_t(1) << (occludee % 64);
            for (std::uint32_t member : sets_[s].members)
                sets_with[member].push_back(s);
        }
        std::vector<Bits> own = hides_;
        for (std::uint32_t small = 0; small < sets_.size(); ++small) {
            const std::vector<std::uint32_t>* fewest = nullptr;
            for (std::uint32_t member : sets_[small].members)
                if (!fewest || sets_with[member].size() < fewest->size())
                    fewest = &sets_with[member];
            for (std::uint32_t large : fewest ? *fewest : std::vector<std::uint32_t>())
                if (large != small && is_subset(sets_[small].members, sets_[large].members))
                    for (std::size_t word = 0; word < words; ++word)
                        hides_[large][word] |= own[small][word];
        }
    }

    std::uint32_t new_members(const GroupedSet& set) const {
        return static_cast<std::uint32_t>(
            std::count_if(set.members.begin(), set.members.end(), [&](std::uint32_t m) { return !drawn_[m]; }));
    }

    void draw(const GroupedSet& set) {
        for (std::uint32_t member : set.members)
            if (!drawn_[member]) {
                drawn_[member] = 1;
                order_.push_back(member);
                picture_.draw(member);
            }
    }

    bool fits(const GroupedSet& set) const { return picture_.visible() + new_members(set) <= options_.limit; }

    void take_by_score() {
        std::vector<std::uint32_t> by_score(sets_.size());
        std::iota(by_score.begin(), by_score.end(), 0u);
        std::vector<double> score(sets_.size());
        for (std::size_t s = 0; s < sets_.size(); ++s)
            score[s] = worth(hides_[s], nullptr) / sets_[s].cost;
        std::stable_sort(by_score.begin(), by_score.end(),
                         [&](std::uint32_t a, std::uint32_t b) { return score[a] > score[b]; });
        for (std::uint32_t s : by_score)
            if (picture_.visible() < options_.limit && fits(sets_[s]))
                draw(sets_[s]);
    }

    void take_by_what_they_add() {
        Bits hidden((gain_.size() + 63) / 64, 0);
        std::vector<char> taken(sets_.size(), 0);
        for (std::size_t s = 0; s < sets_.size(); ++s)
            taken[s] = new_members(sets_[s]) == 0;
        for (;;) {
            double best_score = 0;
            std::size_t best = sets_.size();
            for (std::size_t s = 0; s < sets_.size(); ++s) {
                if (taken[s])
                    continue;
                double worth_of = worth(hides_[s], &hidden);
                if (!(worth_of > 0)) { // hidden by what is drawn already
                    taken[s] = 1;
                    continue;
                }
                double cost = cost_of(sets_[s].members, true), score = cost > 0 ? worth_of / cost : 1e300;
                if (score > best_score && fits(sets_[s])) {
                    best_score = score;
                    best = s;
                }
            }
            if (best == sets_.size())
                return;
            taken[best] = 1;
            draw(sets_[best]);
            for (std::size_t word = 0; word < hidden.size(); ++word)
                hidden[word] |= hides_[best][word];
        }
    }

    /// What is left of the limit goes to the polygons that are seen most: no set needs them here, but one may beside
    /// the grid point.
    void fill_up() {
        std::vector<std::uint32_t> seen(stack_.members(), 0), order(stack_.members());
        for (std::size_t pixel = 0; pixel < stack_.pixels(); ++pixel)
            if (!stack_.stack(pixel).empty())
                ++seen[stack_.stack(pixel)[0].member];
        std::iota(order.begin(), order.end(), 0u);
        std::stable_sort(order.begin(), order.end(), [&](std::uint32_t a, std::uint32_t b) { return seen[a] > seen[b]; });
        for (std::uint32_t member : order)
            if (seen[member] > 0 && !drawn_[member] && picture_.visible() < options_.limit) {
                drawn_[member] = 1;
                order_.push_back(member);
                picture_.draw(member);
            }
    }

    const OccluderStack& stack_;
    std::vector<GroupedSet> sets_;
    std::span<const double> gain_;
    const MosOptions& options_;
    IdPicture picture_;
    std::vector<char> drawn_;
    std::vector<std::uint32_t> order_;
    std::vector<Bits> hides_;
};

} // namespace

void IdPicture::draw(std::uint32_t member) {
    for (const Fragment& fragment : stack_.fragments(member)) {
        if (!(fragment.nearness > nearness_[fragment.pixel]))
            continue;
        std::uint32_t& owner = owner_[fragment.pixel];
        if (owner != kNobody)
            visible_ -= --pixels_[owner] == 0;
        visible_ += pixels_[member]++ == 0;
        owner = member;
        nearness_[fragment.pixel] = fragment.nearness;
    }
}

std::vector<std::uint32_t> select_members(const OccluderStack& stack, std::vector<GroupedSet> sets,
                                          std::span<const double> gain, const MosOptions& options) {
    return Selection(stack, std::move(sets), gain, options).run();
}

} // namespace antumbra
