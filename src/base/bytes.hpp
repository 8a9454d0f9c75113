// Little-endian numbers in byte sequences: read and written byte by byte, so that neither alignment nor the
// machine's byte order matters (compilers turn each into one load or store where they can).
#pragma once

#include <bit>
#include <cstddef>
#include <cstdint>
#include <span>
#include <string_view>
#include <vector>

namespace antumbra {

/// Reads sizeof(T) bytes at `offset`, which the caller has proved to lie inside `bytes`.
template <class T>
constexpr T load_le(std::span<const std::byte> bytes, std::size_t offset) {
    T value = 0;
    for (std::size_t i = 0; i < sizeof(T); ++i)
        value = static_cast<T>(value | static_cast<T>(static_cast<T>(bytes[offset + i]) << (8 * i)));
    return value;
}
inline std::uint16_t load_u16(std::span<const std::byte> bytes, std::size_t offset) {
    return load_le<std::uint16_t>(bytes, offset);
}
inline std::uint32_t load_u32(std::span<const std::byte> bytes, std::size_t offset) {
    return load_le<std::uint32_t>(bytes, offset);
}
inline std::uint64_t load_u64(std::span<const std::byte> bytes, std::size_t offset) {
    return load_le<std::uint64_t>(bytes, offset);
}
inline float load_f32(std::span<const std::byte> bytes, std::size_t offset) {
    return std::bit_cast<float>(load_u32(bytes, offset));
}
inline double load_f64(std::span<const std::byte> bytes, std::size_t offset) {
    return std::bit_cast<double>(load_u64(bytes, offset));
}

/// LEB128 of at most 35 bits at `at`, which moves behind it. False where the bytes end or do not.
inline bool read_varint(std::span<const std::byte> bytes, std::size_t& at, std::uint64_t& value) {
    value = 0;
    for (unsigned shift = 0; shift < 35 && at < bytes.size(); shift += 7) {
        auto byte = std::to_integer<unsigned>(bytes[at++]);
        value |= std::uint64_t(byte & 0x7F) << shift;
        if (byte < 0x80)
            return true;
    }
    return false;
}

/// Whole numbers of either sign as such without: 0, -1, 1, -2 .. as 0, 1, 2, 3 ..
inline std::uint64_t zigzag(std::int64_t value) { return (std::uint64_t(value) << 1) ^ std::uint64_t(value >> 63); }
inline std::int64_t unzigzag(std::uint64_t value) { return std::int64_t(value >> 1) ^ -std::int64_t(value & 1); }

/// Appends to a vector of bytes.
class ByteWriter {
  public:
    std::vector<std::byte> bytes;

    void u8(std::uint8_t value) { bytes.push_back(std::byte(value)); }
    void u16(std::uint16_t value) { append<2>(value); }
    void u32(std::uint32_t value) { append<4>(value); }
    void i32(std::int32_t value) { append<4>(static_cast<std::uint32_t>(value)); }
    void u64(std::uint64_t value) { append<8>(value); }
    void f32(float value) { u32(std::bit_cast<std::uint32_t>(value)); }
    void f64(double value) { u64(std::bit_cast<std::uint64_t>(value)); }
    /// LEB128: seven bits a byte, low ones first, the top bit says that more follow.
    void varint(std::uint64_t value) {
        for (; value >= 0x80; value >>= 7)
            u8(static_cast<std::uint8_t>(value | 0x80));
        u8(static_cast<std::uint8_t>(value));
    }
    void text(std::string_view text) { raw(std::as_bytes(std::span(text.data(), text.size()))); }
    void raw(std::span<const std::byte> more) { bytes.insert(bytes.end(), more.begin(), more.end()); }
    /// Zero bytes up to the next multiple of `alignment`.
    void align(std::size_t alignment) {
        while (bytes.size() % alignment != 0)
            u8(0);
    }

  private:
    template <int N>
    void append(std::uint64_t value) {
        for (int i = 0; i < N; ++i)
            u8(static_cast<std::uint8_t>(value >> (8 * i)));
    }
};

} // namespace antumbra
