#include "export/glb_container.hpp"

namespace antumbra::glb {

Result<std::vector<std::byte>> pack(const Json& document, std::span<const std::vector<std::byte>* const> binary) {
    constexpr std::uint64_t kLargestFile = 0xFFFFFFFFull;
    std::uint64_t binary_size = 0;
    for (const std::vector<std::byte>* part : binary)
        binary_size += part->size();
    std::string text = document.dump(-1, ' ', false, Json::error_handler_t::replace);
    while (text.size() % 4)
        text += ' ';
    std::uint64_t size = 12 + 8 + text.size() + (binary_size ? 8 + binary_size : 0);
    if (size > kLargestFile)
        return Status(ErrorCode::limit, "the GLB would have " + std::to_string(size) +
                                            " bytes, its format ends at 4 GiB; split the scene");
    std::vector<std::byte> bytes;
    bytes.reserve(size);
    append(bytes, std::uint32_t(0x46546C67)); // "glTF"
    append(bytes, std::uint32_t(2));
    append(bytes, static_cast<std::uint32_t>(size));
    append(bytes, static_cast<std::uint32_t>(text.size()));
    append(bytes, std::uint32_t(0x4E4F534A)); // "JSON"
    for (char c : text)
        bytes.push_back(static_cast<std::byte>(c));
    if (binary_size) {
        append(bytes, static_cast<std::uint32_t>(binary_size));
        append(bytes, std::uint32_t(0x004E4942)); // "BIN"
        for (const std::vector<std::byte>* part : binary)
            bytes.insert(bytes.end(), part->begin(), part->end());
    }
    return bytes;
}

} // namespace antumbra::glb
