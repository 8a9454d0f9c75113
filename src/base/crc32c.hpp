// CRC-32C (Castagnoli), the checksum of every chunk and record. Within 255 MiB it shows every error of one, two or
// an odd number of bits and every burst of up to 32 bits.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>

namespace antumbra {

/// CRC of the bytes that `before` is the CRC of, followed by `bytes`.
std::uint32_t crc32c(std::span<const std::byte> bytes, std::uint32_t before = 0);

} // namespace antumbra
