// The two codings of our own: lossless, safe with any bytes, and as short as they promise on coherent rows.
#include "pvs/coding_archive.hpp"
#include "pvs/coding_references.hpp"
#include "pvs/range_coder.hpp"
#include "pvs/reference_tree.hpp"
#include "pvs/row_coding.hpp"

#include "pvs/random_pvs.hpp"

#include <gtest/gtest.h>
#include <rapidcheck.h>

namespace antumbra {
namespace {

using Words = std::vector<std::uint64_t>;

struct Matrix {
    std::uint32_t rows = 0, objects = 0;
    Words bits;
};

/// Rows as along a walk: each one of those before it with a few runs changed.
Matrix coherent_matrix(std::uint64_t seed, std::uint32_t most_rows = 80, std::uint32_t most_objects = 400) {
    Random random(seed);
    Matrix matrix{random.below(most_rows + 1), random.below(most_objects + 1), {}};
    std::size_t words = words_for(matrix.objects);
    matrix.bits.resize(matrix.rows * words);
    for (std::uint32_t r = 0; r < matrix.rows; ++r) {
        auto row = std::span(matrix.bits).subspan(r * words, words);
        if (r == 0) {
            test::random_row(random, matrix.objects, row);
            continue;
        }
        std::copy_n(matrix.bits.begin() + std::ptrdiff_t(random.below(r) * words), words, row.begin());
        for (std::uint32_t run = random.below(4); run > 0 && matrix.objects > 0; --run)
            for (std::uint32_t o = random.below(matrix.objects), end = std::min(o + random.below(12), matrix.objects); o < end; ++o)
                row[o / 64] ^= std::uint64_t(1) << (o % 64);
    }
    return matrix;
}

TEST(RangeCoder, GivesBackWhatItWasGiven) {
    EXPECT_TRUE(rc::check("any bits with any probabilities", [](std::uint64_t seed) {
        Random random(seed);
        std::vector<std::pair<bool, Probability>> bits(random.below(500));
        RangeEncoder encoder;
        for (auto& [bit, one] : bits) {
            one = random.below(3) ? 1 + random.below(65535) : random.below(2) ? 1 : 65535;
            bit = random.below(65536) < one;
            if (random.below(50) == 0)
                bit = !bit;
            encoder.put(bit, one);
        }
        std::vector<std::byte> bytes = encoder.finish();
        RangeDecoder decoder(bytes);
        for (auto [bit, one] : bits)
            RC_ASSERT(decoder.get(one) == bit);
    }));
}

TEST(RangeCoder, LikelyBitsCostLittle) {
    RangeEncoder encoder;
    for (int i = 0; i < 10000; ++i)
        encoder.put(false, 66); // a thousandth
    EXPECT_LE(encoder.finish().size(), 3u) << "14.5 bits";
    RangeEncoder even;
    for (int i = 0; i < 8000; ++i)
        even.put(i % 3 == 0, 32768);
    EXPECT_NEAR(double(even.finish().size()), 1000, 3);
}

TEST(References, AreTheNearestRowsAndNeverTooDeep) {
    // Four rows of 8 objects: each differs from the one before in one bit.
    Words bits{0b1111, 0b0111, 0b0011, 0b11110000};
    auto references = choose_references(bits, 4, 1, 100);
    EXPECT_EQ(references, (std::vector<std::uint32_t>{1, 2, kNoReference, kNoReference}));
    references = choose_references(bits, 4, 1, 1);
    EXPECT_EQ(references, (std::vector<std::uint32_t>{2, 2, kNoReference, kNoReference}));
    EXPECT_EQ(choose_references(bits, 4, 1, 0), std::vector<std::uint32_t>(4, kNoReference));
}

TEST(References, AreWrittenAsDistances) {
    std::uint32_t reference = 7;
    for (std::uint32_t row = 0; row < 5; ++row)
        for (std::uint32_t other : {0u, 1u, 2u, 3u, 4u, kNoReference}) {
            if (other == row)
                continue;
            ASSERT_TRUE(read_reference(row, 5, reference_code(row, other), reference));
            ASSERT_EQ(reference, other);
        }
    EXPECT_FALSE(read_reference(2, 5, 2 * 3 - 1, reference)) << "the third before row 2";
    EXPECT_FALSE(read_reference(2, 5, 2 * 3, reference)) << "the third after row 2 of 5";
}

TEST(ReferenceRows, RoundTrip) {
    EXPECT_TRUE(rc::check("coherent rows, any depth", [](std::uint64_t seed) {
        Matrix matrix = coherent_matrix(seed);
        std::size_t words = words_for(matrix.objects);
        CodedReferences coded = encode_references(matrix.bits, matrix.rows, matrix.objects,
                                                  static_cast<std::uint32_t>(seed % (kMostReferences + 1)));
        Result<ReferenceRows> rows = ReferenceRows::open(coded.index, coded.rows, matrix.rows, matrix.objects);
        RC_ASSERT(rows.ok());
        Words row(words);
        for (std::uint32_t r = 0; r < matrix.rows; ++r) {
            rows->decode(r, row);
            RC_ASSERT(std::equal(row.begin(), row.end(), matrix.bits.begin() + std::ptrdiff_t(r * words)));
        }
    }));
}

TEST(ReferenceRows, AnyBytesAreRefusedOrDecodedSafely) {
    int opened = 0, refused = 0;
    Matrix matrix;
    for (std::uint64_t seed = 0; matrix.rows < 40 || matrix.objects < 100; ++seed)
        matrix = coherent_matrix(seed);
    CodedReferences coded = encode_references(matrix.bits, matrix.rows, matrix.objects);
    Random random(1);
    Words row(words_for(matrix.objects));
    for (int round = 0; round < 20000; ++round) {
        CodedReferences hostile = coded;
        std::vector<std::byte>& part = random.below(8) ? hostile.rows : hostile.index;
        std::uint32_t first = random.below(4) && &part == &hostile.rows ? 704 : 0;
        part[first + random.below(static_cast<std::uint32_t>(part.size() - first))] = std::byte(random.below(256));
        Result<ReferenceRows> rows = ReferenceRows::open(hostile.index, hostile.rows, matrix.rows, matrix.objects);
        ++(rows.ok() ? opened : refused);
        for (std::uint32_t r = 0; rows.ok() && r < matrix.rows; r += 7) {
            rows->decode(r, row);
            if (matrix.objects % 64 != 0) {
                ASSERT_EQ(row.back() >> (matrix.objects % 64), 0u);
            }
        }
    }
    EXPECT_GT(opened, 1000);
    EXPECT_GT(refused, 1000);
}

TEST(ReferenceRows, CirclesAndLongChainsAreRefused) {
    auto open = [](std::vector<std::uint64_t> codes) {
        ByteWriter index, rows;
        rows.bytes.resize(704);
        for (std::size_t r = 0; r < codes.size(); ++r) {
            if (r % 32 == 0)
                index.u32(static_cast<std::uint32_t>(rows.bytes.size()));
            rows.varint(codes[r]);
            rows.varint(0);
        }
        return ReferenceRows::open(index.bytes, rows.bytes, static_cast<std::uint32_t>(codes.size()), 10).ok();
    };
    EXPECT_TRUE(open({0, 0, 0}));
    EXPECT_TRUE(open({2, 0, 1}));
    EXPECT_FALSE(open({2, 1})) << "rows 0 and 1 refer to each other";
    EXPECT_FALSE(open({2, 2, 3})) << "a circle of three";
    for (std::size_t extra : {0, 1}) {
        std::vector<std::uint64_t> chain(kMostReferences + 1 + extra, 1); // each refers to the one before
        chain[0] = 0;
        EXPECT_EQ(open(chain), extra == 0);
        std::fill(chain.begin(), chain.end(), 2); // to the one after
        chain.back() = 0;
        EXPECT_EQ(open(chain), extra == 0);
    }
}

TEST(Archive, RoundTrip) {
    EXPECT_TRUE(rc::check("coherent rows", [](std::uint64_t seed) {
        Matrix matrix = coherent_matrix(seed);
        std::vector<std::byte> coded = encode_archive(matrix.bits, matrix.rows, matrix.objects);
        Result<Words> back = decode_archive(coded, matrix.rows, matrix.objects);
        RC_ASSERT(back.ok());
        RC_ASSERT(*back == matrix.bits);
    }));
}

TEST(Archive, AnyBytesAreRefusedOrDecodedSafely) {
    Matrix matrix = coherent_matrix(3);
    std::vector<std::byte> coded = encode_archive(matrix.bits, matrix.rows, matrix.objects);
    Random random(1);
    int opened = 0, refused = 0;
    for (int round = 0; round < 500; ++round) {
        std::vector<std::byte> hostile = coded;
        hostile[random.below(static_cast<std::uint32_t>(coded.size()))] = std::byte(random.below(256));
        Result<Words> bits = decode_archive(hostile, matrix.rows, matrix.objects);
        ++(bits.ok() ? opened : refused);
    }
    EXPECT_GT(opened, 50);
    EXPECT_GT(refused, 5);
}

TEST(Codings, CoherentRowsTakeFewBits) {
    Matrix matrix{400, 1000, {}};
    Random random(5);
    std::size_t words = words_for(matrix.objects);
    matrix.bits.resize(matrix.rows * words);
    for (std::uint32_t r = 0; r < matrix.rows; ++r)
        for (std::uint32_t o = 0; o < matrix.objects; ++o) // a window of 100 objects that slides along
            if (o + 2 * r >= 900 && o + 2 * r < 1000)
                matrix.bits[r * words + o / 64] |= std::uint64_t(1) << (o % 64);
    double pairs = double(matrix.rows) * matrix.objects;
    CodedReferences references = encode_references(matrix.bits, matrix.rows, matrix.objects);
    EXPECT_LT(double(references.index.size() + references.rows.size()) * 8 / pairs, 0.08);
    EXPECT_LT(double(encode_archive(matrix.bits, matrix.rows, matrix.objects).size()) * 8 / pairs, 0.04);
}

} // namespace
} // namespace antumbra
