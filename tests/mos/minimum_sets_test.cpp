// The search for minimum occluder sets against all subsets.
#include "mos/minimum_sets.hpp"

#include "base/random.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <bit>

namespace antumbra {
namespace {

ItemTable table_of(std::uint32_t items, std::initializer_list<std::vector<std::uint32_t>> lists) {
    ItemTable table;
    table.items = items;
    for (const auto& list : lists)
        table.add(list);
    return table;
}

/// Every minimal set that hits every list, by the definition, over all subsets; cheapest first.
std::vector<MinimumSet> all_minimum_sets(const ItemTable& table, const std::vector<double>& costs) {
    auto hits_all = [&](std::uint32_t subset) {
        for (std::size_t i = 0; i < table.size(); ++i)
            if (std::none_of(table.list(i).begin(), table.list(i).end(),
                             [&](std::uint32_t item) { return subset >> item & 1; }))
                return false;
        return true;
    };
    std::vector<MinimumSet> sets;
    for (std::uint32_t subset = 0; subset < 1u << table.items; ++subset) {
        if (!hits_all(subset))
            continue;
        bool minimal = true;
        for (std::uint32_t item = 0; item < table.items; ++item)
            minimal = minimal && (!(subset >> item & 1) || !hits_all(subset & ~(1u << item)));
        if (!minimal)
            continue;
        MinimumSet set;
        for (std::uint32_t item = 0; item < table.items; ++item)
            if (subset >> item & 1) {
                set.items.push_back(item);
                set.cost += costs[item];
            }
        sets.push_back(set);
    }
    std::sort(sets.begin(), sets.end(), [](const MinimumSet& a, const MinimumSet& b) {
        return a.cost != b.cost ? a.cost < b.cost : a.items < b.items;
    });
    return sets;
}

ItemTable random_table(Random& random, std::uint32_t items) {
    ItemTable table;
    table.items = items;
    std::uint32_t lists = 1 + random.below(14);
    for (std::uint32_t i = 0; i < lists; ++i) {
        std::vector<std::uint32_t> list;
        std::uint32_t length = 1 + random.below(random.below(3) ? 4 : items);
        for (std::uint32_t k = 0; k < length; ++k)
            list.push_back(random.below(items)); // repeats are allowed
        table.add(list);
    }
    return table;
}

/// Figure 3 of the paper: A, C / AC, BC, BD / ABC, ABD, ACD, CD / ABCD.
TEST(MinimumSets, the_example_of_the_paper_gives_abc_and_acd) {
    enum : std::uint32_t { A, B, C, D };
    ItemTable table = table_of(4, {{A}, {C}, {A, C}, {B, C}, {B, D}, {A, B, C}, {A, B, D}, {A, C, D}, {C, D}, {A, B, C, D}});
    std::vector<double> costs{1, 1, 1, 1};
    MinimumSets found = find_minimum_sets(table, costs, 10, 1000000);
    ASSERT_TRUE(found.complete);
    ASSERT_EQ(found.sets.size(), 2u);
    EXPECT_EQ(found.sets[0].items, (std::vector<std::uint32_t>{A, B, C}));
    EXPECT_EQ(found.sets[1].items, (std::vector<std::uint32_t>{A, C, D}));
    EXPECT_FALSE(is_minimum_set(table, std::vector<std::uint32_t>{A, B, C, D})) << "B or D is redundant";
    EXPECT_FALSE(is_minimum_set(table, std::vector<std::uint32_t>{A, C})) << "BD is not hit";
}

TEST(MinimumSets, a_pixel_with_nothing_in_front_has_no_set) {
    ItemTable table = table_of(2, {{0, 1}, {}});
    std::vector<double> costs{1, 1};
    EXPECT_TRUE(find_minimum_sets(table, costs, 4, 1000).sets.empty());
}

TEST(MinimumSets, without_a_limit_all_of_them_are_found) {
    std::uint64_t sets = 0;
    for (std::uint32_t trial = 0; trial < 2000; ++trial) {
        Random random(91, trial);
        ItemTable table = random_table(random, 1 + random.below(11));
        std::vector<double> costs;
        for (std::uint32_t i = 0; i < table.items; ++i)
            costs.push_back(random.uniform(0.5, 2));
        std::vector<MinimumSet> expected = all_minimum_sets(table, costs);
        MinimumSets found = find_minimum_sets(table, costs, 100000, 1u << 30);
        ASSERT_TRUE(found.complete);
        ASSERT_EQ(found.sets.size(), expected.size()) << trial;
        for (std::size_t s = 0; s < expected.size(); ++s)
            ASSERT_EQ(found.sets[s].items, expected[s].items) << trial;
        sets += expected.size();
    }
    EXPECT_GT(sets, 4000u);
}

TEST(MinimumSets, with_a_limit_the_cheapest_are_found) {
    for (std::uint32_t trial = 0; trial < 2000; ++trial) {
        Random random(92, trial);
        ItemTable table = random_table(random, 1 + random.below(11));
        std::vector<double> costs;
        for (std::uint32_t i = 0; i < table.items; ++i)
            costs.push_back(random.uniform(0.5, 2));
        std::vector<MinimumSet> expected = all_minimum_sets(table, costs);
        std::uint32_t keep = 1 + random.below(4);
        MinimumSets found = find_minimum_sets(table, costs, keep, 1u << 30);
        ASSERT_EQ(found.sets.size(), std::min<std::size_t>(keep, expected.size()));
        for (std::size_t s = 0; s < found.sets.size(); ++s)
            ASSERT_EQ(found.sets[s].items, expected[s].items) << trial << " " << s;
    }
}

TEST(MinimumSets, little_work_degrades_the_cost_never_the_cover) {
    std::uint64_t cut = 0;
    for (std::uint32_t trial = 0; trial < 500; ++trial) {
        Random random(93, trial);
        std::uint32_t items = 20 + random.below(60);
        ItemTable table;
        table.items = items;
        for (int i = 0; i < 60; ++i) {
            std::vector<std::uint32_t> list;
            for (std::uint32_t k = 0, length = 2 + random.below(5); k < length; ++k)
                list.push_back(random.below(items));
            table.add(list);
        }
        std::vector<double> costs(items, 1);
        for (double& cost : costs)
            cost += random.uniform();
        double last = 1e300;
        for (std::uint64_t work : {0u, 100u, 10000u}) {
            MinimumSets found = find_minimum_sets(table, costs, 3, work);
            cut += !found.complete;
            ASSERT_GE(found.sets.size(), 1u);
            for (const MinimumSet& set : found.sets)
                ASSERT_TRUE(is_minimum_set(table, set.items));
            ASSERT_LE(found.sets[0].cost, last) << "more work never finds worse";
            last = found.sets[0].cost;
        }
    }
    EXPECT_GT(cut, 100u);
}

} // namespace
} // namespace antumbra
