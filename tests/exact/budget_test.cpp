// The budget of a cell: counted, never timed; what it leaves open is listed as visible and counted.
#include "bake/exact/cell.hpp"
#include "bake/exact/units.hpp"
#include "village.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <bit>
#include <filesystem>

namespace antumbra {
namespace {

struct Solved {
    std::vector<std::uint64_t> visible;
    exact::CellCounters counters;
    std::uint64_t work() const { return counters.query.pieces + counters.pairs; }
    std::uint64_t count() const {
        std::uint64_t sum = 0;
        for (std::uint64_t word : visible)
            sum += static_cast<std::uint64_t>(std::popcount(word));
        return sum;
    }
    bool holds(const Solved& other) const {
        for (std::size_t w = 0; w < visible.size(); ++w)
            if (other.visible[w] & ~visible[w])
                return false;
        return true;
    }
};

/// A cell between the houses of the village; every triangle is a unit.
class BudgetOfACell : public ::testing::Test {
  protected:
    Solved solve(std::uint64_t work, std::uint64_t work_before = 0) {
        exact::CellOptions options;
        options.work = work;
        exact::CellSolver solver(tree_, tracer_, options);
        exact::GridBox cell{tree_.to_grid(scene_.to_local({4.2, 0.5, 5})), tree_.to_grid(scene_.to_local({5.5, 1.5, 7}))};
        Solved out;
        out.visible.assign((tree_.units().count() + 63) / 64, 0);
        out.counters.pairs = work_before;
        EXPECT_TRUE(solver.solve(cell, out.visible, out.counters));
        out.counters.pairs -= work_before;
        return out;
    }
    Scene scene_ = village();
    Tracer tracer_ = Tracer::build(scene_);
    exact::SceneTree tree_ = exact::SceneTree::build(scene_, exact::Units::triangles(scene_));
};

TEST_F(BudgetOfACell, NothingVisibleIsLostWhateverIsLeftUndecided) {
    Solved whole = solve(0);
    ASSERT_EQ(whole.counters.undecided, 0u);
    ASSERT_GT(whole.work(), 200u);
    ASSERT_LT(whole.count(), tree_.units().count()); // something is hidden
    std::uint64_t cut_short = 0;
    for (std::uint64_t work = 1; work <= 2 * whole.work(); work = work * 5 / 4 + 1) {
        Solved part = solve(work);
        EXPECT_TRUE(part.holds(whole)) << work;
        EXPECT_LE(part.work(), work + 2) << work; // the last query may see one piece more than it may have
        EXPECT_LE(part.count() - whole.count(), part.counters.undecided) << work;
        EXPECT_LE(part.counters.unasked, part.counters.undecided) << work;
        cut_short += part.counters.undecided > 0;
        if (part.counters.undecided == 0) {
            EXPECT_EQ(part.visible, whole.visible) << work;
        }
    }
    EXPECT_GT(cut_short, 5u);
    Solved nothing = solve(1);
    EXPECT_GT(nothing.counters.unasked, 20u);
    EXPECT_EQ(solve(4 * whole.work()).visible, whole.visible);
    EXPECT_EQ(solve(4 * whole.work()).counters.undecided, 0u);
}

TEST_F(BudgetOfACell, WorkDoneBeforeIsNotCounted) {
    std::uint64_t budget = solve(0).work() / 3;
    Solved fresh = solve(budget), later = solve(budget, 1000000);
    EXPECT_GT(fresh.counters.undecided, 0u);
    EXPECT_EQ(fresh.visible, later.visible);
    EXPECT_EQ(fresh.counters.undecided, later.counters.undecided);
}

TEST(BudgetOfABake, IsConservativeAndTheSameForAnyThreadsAndAfterAnInterruption) {
    Scene scene = village();
    BakeOptions o = exact_options();
    Result<BakeResult> whole = bake(scene, o);
    ASSERT_TRUE(whole.ok());
    EXPECT_EQ(whole->pvs.guarantee, Guarantee::exact);
    o.exact.cell_work = 12;
    Job one, three;
    one.threads = 1;
    three.threads = 3;
    Result<BakeResult> a = bake(scene, o, one), b = bake(scene, o, three);
    ASSERT_TRUE(a.ok() && b.ok());
    EXPECT_EQ(a->pvs.guarantee, Guarantee::conservative);
    EXPECT_GT(a->statistics.exact.undecided, 0u);
    EXPECT_EQ(a->statistics.holdout_misses, 0u);
    EXPECT_EQ(*encode_pvs(a->pvs), *encode_pvs(b->pvs));
    for (std::size_t cell = 0; cell < a->pvs.cell_row.size(); ++cell) {
        std::uint32_t all = a->pvs.cell_row[cell], exact = whole->pvs.cell_row[cell];
        ASSERT_EQ(all == kCellSolid, exact == kCellSolid);
        for (std::size_t w = 0; all < kCellSolid && w < a->pvs.words_per_row(); ++w)
            EXPECT_EQ(whole->pvs.rows[exact * a->pvs.words_per_row() + w] & ~a->pvs.rows[all * a->pvs.words_per_row() + w], 0u);
    }
    o.checkpoint = ::testing::TempDir() + "exact_budget.part";
    std::filesystem::remove(o.checkpoint);
    ASSERT_TRUE(bake(scene, o, one).ok());
    o.resume = true;
    Result<BakeResult> c = bake(scene, o, one);
    ASSERT_TRUE(c.ok()) << c.status().message();
    EXPECT_EQ(*encode_pvs(a->pvs), *encode_pvs(c->pvs));
    std::filesystem::remove(o.checkpoint);
}

TEST(BudgetOfABake, OfABoxAroundABlockLeavesItsCellsExact) {
    Scene scene = village();
    BakeOptions o = exact_options();
    o.cells = {4, 1, 4};
    Result<BakeResult> alone = bake(scene, o);
    o.exact.block = 4;
    o.exact.max_pieces = 20000;
    Result<BakeResult> block = bake(scene, o);
    ASSERT_TRUE(alone.ok() && block.ok());
    EXPECT_EQ(block->pvs.guarantee, Guarantee::exact);
    EXPECT_EQ(alone->pvs.rows, block->pvs.rows);
}

} // namespace
} // namespace antumbra
