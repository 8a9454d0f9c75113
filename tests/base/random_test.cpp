#include "base/random.hpp"

#include <gtest/gtest.h>

namespace antumbra {

// Known answers of Philox4x32-10 from the reference implementation (Random123).
TEST(Philox, KnownAnswers) {
    using Block = std::array<std::uint32_t, 4>;
    EXPECT_EQ(philox({0, 0, 0, 0}, {0, 0}), (Block{0x6627e8d5, 0xe169c58d, 0xbc57ac4c, 0x9b00dbd8}));
    EXPECT_EQ(philox({~0u, ~0u, ~0u, ~0u}, {~0u, ~0u}), (Block{0x408f276d, 0x41c83b0e, 0xa20bc7c6, 0x6d5451fd}));
    EXPECT_EQ(philox({0x243f6a88, 0x85a308d3, 0x13198a2e, 0x03707344}, {0xa4093822, 0x299f31d0}),
              (Block{0xd16cfe09, 0x94fdcceb, 0x5001e420, 0x24126ea1}));
}

// The buffered stream is the plain one: block after block, each from its last number to its first.
TEST(Random, IsPhiloxBlockByBlock) {
    Random random(0x123456789abcdefu, 0xfedcba9876543210u, 77);
    for (std::uint32_t block = 0; block < 100; ++block) {
        auto expected = philox({block, 77, 0x76543210u, 0xfedcba98u}, {0x89abcdefu, 0x01234567u});
        for (int i = 3; i >= 0; --i)
            ASSERT_EQ(random.next_u32(), expected[std::size_t(i)]) << block;
    }
}

TEST(Random, UniformStaysInItsRange) {
    Random random(1);
    for (int i = 0; i < 100000; ++i) {
        double value = random.uniform();
        ASSERT_GE(value, 0);
        ASSERT_LT(value, 1);
        ASSERT_LT(random.below(7), 7u);
    }
}

} // namespace antumbra
