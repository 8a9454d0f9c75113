#include "base/crc32c.hpp"

#include "base/random.hpp"

#include <gtest/gtest.h>

#include <string_view>
#include <vector>

namespace antumbra {
namespace {

std::span<const std::byte> bytes_of(std::string_view text) { return std::as_bytes(std::span(text.data(), text.size())); }

TEST(Crc32c, KnownValues) {
    EXPECT_EQ(crc32c({}), 0u);
    EXPECT_EQ(crc32c(bytes_of("123456789")), 0xE3069283u);
    // RFC 3720, appendix B.4: 32 bytes of zeros, of ones, and 0..31.
    std::vector<std::byte> bytes(32);
    EXPECT_EQ(crc32c(bytes), 0x8A9136AAu);
    for (std::byte& byte : bytes)
        byte = std::byte(0xFF);
    EXPECT_EQ(crc32c(bytes), 0x62A8AB43u);
    for (std::size_t i = 0; i < 32; ++i)
        bytes[i] = std::byte(i);
    EXPECT_EQ(crc32c(bytes), 0x46DD794Eu);
}

TEST(Crc32c, PiecesInTurnGiveTheSumOfTheWhole) {
    Random random(1);
    std::vector<std::byte> bytes(100);
    for (std::byte& byte : bytes)
        byte = std::byte(random.below(256));
    std::span<const std::byte> all(bytes);
    for (std::size_t cut = 0; cut <= bytes.size(); ++cut)
        EXPECT_EQ(crc32c(all.subspan(cut), crc32c(all.first(cut))), crc32c(all));
}

} // namespace
} // namespace antumbra
