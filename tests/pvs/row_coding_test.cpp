#include "pvs/row_coding.hpp"

#include "pvs/random_pvs.hpp"

#include <gtest/gtest.h>
#include <rapidcheck.h>

namespace antumbra {
namespace {

using Words = std::vector<std::uint64_t>;

std::vector<std::byte> bytes_of(std::initializer_list<int> values) {
    std::vector<std::byte> bytes;
    for (int value : values)
        bytes.push_back(std::byte(value));
    return bytes;
}

std::vector<std::byte> coded(const Words& words, std::size_t objects) {
    ByteWriter out;
    encode_row(words, objects, out);
    return out.bytes;
}

TEST(RowCoding, TakesTheShortestOfThreeWays) {
    // 16 objects: two raw bytes and the byte that says so; no other way is shorter.
    EXPECT_EQ(coded({0xAAAA}, 16), bytes_of({0, 0xAA, 0xAA}));
    // Bits 5 and 105 of 200: two gaps.
    EXPECT_EQ(coded({1u << 5, std::uint64_t(1) << 41, 0, 0}, 200), bytes_of({2, 5, 99}));
    // The first 128 of 300 set: sixteen bytes of ones, 22 of zeros.
    EXPECT_EQ(coded({~std::uint64_t(0), ~std::uint64_t(0), 0, 0, 0}, 300), bytes_of({1, 0xC0 + 15, 0x80 + 21}));
    EXPECT_EQ(coded({0}, 40), bytes_of({2})) << "an empty row is no gaps";
    EXPECT_EQ(coded({}, 0), bytes_of({0}));
}

TEST(RowCoding, LongGapsTakeSeveralBytes) {
    Words words(40);
    words[2000 / 64] = std::uint64_t(1) << (2000 % 64);
    EXPECT_EQ(coded(words, 2560), bytes_of({2, 0xD0, 0x0F}));
}

TEST(RowCoding, RoundTrip) {
    EXPECT_TRUE(rc::check("any row", [](std::uint64_t seed) {
        Random random(seed);
        std::uint32_t objects = random.below(1000);
        Words words(words_for(objects)), back(words.size());
        test::random_row(random, objects, words);
        std::vector<std::byte> bytes = coded(words, objects);
        RC_ASSERT(is_row(bytes, objects));
        RC_ASSERT(decode_row(bytes, objects, back));
        RC_ASSERT(back == words);
        RC_ASSERT(bytes.size() <= bytes_for(objects) + 1);
    }));
}

// Found by the fuzzer: memcpy to a null pointer.
TEST(RowCoding, ARowOfNoObjectsDecodes) {
    Words none;
    EXPECT_TRUE(decode_row(bytes_of({0}), 0, none));
    EXPECT_TRUE(decode_row(bytes_of({1}), 0, none));
    EXPECT_TRUE(decode_row(bytes_of({2}), 0, none));
}

TEST(RowCoding, RefusesWhatIsNoRow) {
    auto refused = [](std::initializer_list<int> values, std::size_t objects) {
        Words words(words_for(objects));
        std::vector<std::byte> bytes = bytes_of(values);
        EXPECT_FALSE(is_row(bytes, objects));
        EXPECT_FALSE(decode_row(bytes, objects, words));
    };
    refused({}, 12);
    refused({3, 0, 0}, 12);                              // no such way
    refused({0, 1}, 12);                                 // raw: too short
    refused({0, 1, 2, 3}, 12);                           // raw: too long
    refused({0, 1, 0x10}, 12);                           // raw: bit 12 of 12
    refused({1, 0x80}, 12);                              // runs: too short
    refused({1, 0x82}, 12);                              // runs: too long
    refused({1, 0xC1}, 12);                              // runs: ones beyond the objects
    refused({1, 0x41, 0, 0}, 12);                        // runs: no such token
    refused({1, 0x01, 0}, 12);                           // runs: literal cut off
    refused({1, 0x80, 0x00, 0x10}, 12);                  // runs: literal bit beyond the objects
    refused({2, 12}, 12);                                // gaps: beyond the objects
    refused({2, 11, 0}, 12);                             // gaps: the second beyond
    refused({2, 0x80}, 12);                              // gaps: number cut off
    refused({2, 0x80, 0x80, 0x80, 0x80, 0x80, 1}, 12);   // gaps: number too long
    refused({2, 0xFF, 0xFF, 0xFF, 0xFF, 0x7F}, 12);      // gaps: number too large
    refused({2, 0}, 0);                                  // gaps: no object to set
}

TEST(RowCoding, AnyBytesAreSafeAndTheCheckAgreesWithTheDecoder) {
    EXPECT_TRUE(rc::check("random bytes", [](std::uint64_t seed) {
        Random random(seed);
        std::uint32_t objects = random.below(200);
        for (int round = 0; round < 100; ++round) {
            std::vector<std::byte> bytes(random.below(40));
            for (std::byte& byte : bytes)
                byte = std::byte(random.below(4) ? random.below(256) : random.below(3));
            Words words(words_for(objects));
            bool decoded = decode_row(bytes, objects, words);
            RC_ASSERT(decoded == is_row(bytes, objects));
            if (decoded && objects % 64 != 0)
                RC_ASSERT(words.back() >> (objects % 64) == 0u);
        }
    }));
}

} // namespace
} // namespace antumbra
