// The GLB container (glTF 2.0, section 4.4): a JSON chunk and a binary chunk.
#pragma once

#include <antumbra/status.hpp>

#include <bit>
#include <cstddef>
#include <cstdint>
#include <nlohmann/json.hpp>
#include <span>
#include <vector>

namespace antumbra::glb {

using Json = nlohmann::ordered_json;

/// Numbers of the glTF specification.
enum : int {
    kArrayBuffer = 34962,
    kElementArrayBuffer = 34963,
    kUnsignedShort = 5123,
    kUnsignedInt = 5125,
    kFloat = 5126,
    kLines = 1,
};

/// Little-endian, whatever the machine.
template <class T>
void append(std::vector<std::byte>& bytes, T value) {
    auto raw = std::bit_cast<std::array<std::byte, sizeof(T)>>(value);
    if constexpr (std::endian::native == std::endian::big)
        bytes.insert(bytes.end(), raw.rbegin(), raw.rend());
    else
        bytes.insert(bytes.end(), raw.begin(), raw.end());
}

/// The file. The parts of the binary chunk follow one another; together they are a multiple of four bytes. Broken
/// UTF-8 in the document is replaced. ErrorCode::limit beyond 4 GiB.
Result<std::vector<std::byte>> pack(const Json& document, std::span<const std::vector<std::byte>* const> binary);

} // namespace antumbra::glb
