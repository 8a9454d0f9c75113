// Queries do not allocate after the first one.
#include "pvs/random_pvs.hpp"
#include "support/count_allocations.hpp"

#include <gtest/gtest.h>

namespace antumbra {
namespace {

using test::allocations;

TEST(PvsAllocation, QueriesDoNotAllocateAfterTheFirst) {
    PvsData data = test::random_pvs(3, 3000);
    std::vector<std::byte> bytes = *encode_pvs(data);
    std::uint64_t before = allocations;
    Result<Pvs> pvs = Pvs::open(bytes);
    EXPECT_GT(allocations, before) << "the counter counts";
    ASSERT_TRUE(pvs.ok());
    PvsCursor cursor;
    (void)pvs->query(data.grid.cell(0).centre(), cursor);
    before = allocations;
    std::uint64_t changes = 0;
    for (std::uint64_t c = 0; c < data.grid.cells(); ++c)
        changes += pvs->query(data.grid.cell(c).centre(), cursor);
    (void)pvs->query({1e38, 0, 0}, cursor);
    EXPECT_EQ(allocations, before);
    EXPECT_GT(changes, 0u);
}

} // namespace
} // namespace antumbra
