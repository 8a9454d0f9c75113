// The bytes behind a glTF document: GLB chunks, data URIs, external files.
#pragma once

#include "import/gltf_document.hpp"

#include "base/file.hpp"

#include <map>
#include <optional>
#include <span>
#include <string>
#include <vector>

namespace antumbra::gltf {

/// The two chunks of a GLB, or the whole of a .gltf as `json`.
struct Container {
    std::span<const std::byte> json, binary;
    bool has_binary = false;
};
Result<Container> open_container(std::span<const std::byte> bytes);

/// Hands out ranges of bytes, each proved to lie inside its buffer. Buffers are opened when first asked for, so
/// that those that geometry does not need may be missing. Refers to the document; not thread-safe.
class Buffers {
  public:
    /// `max_bytes` of further files are read, and at most `max_memory` bytes are decoded.
    Buffers(const Document& document, const Container& container, std::string folder, std::uint64_t max_bytes,
            std::uint64_t max_memory);

    /// All bytes of a buffer view, decoded if it is compressed; its length as the JSON says. Valid as long as this.
    Result<std::span<const std::byte>> view(std::int32_t view);

  private:
    struct Loaded {
        std::optional<MappedFile> file;
        std::vector<std::byte> owned;
        std::span<const std::byte> bytes;
        bool ready = false;
    };
    Status load(std::size_t buffer);
    Result<std::span<const std::byte>> range(std::int32_t buffer, std::uint64_t offset, std::uint64_t bytes);
    Result<std::span<const std::byte>> decoded(std::int32_t view);
    Status load_external(std::size_t buffer, Loaded& loaded);

    const Document& document_;
    Container container_;
    std::string folder_;
    std::uint64_t bytes_left_;
    std::uint64_t memory_left_;
    std::vector<Loaded> loaded_;
    std::map<std::int32_t, std::vector<std::byte>> decoded_; // by view
};

} // namespace antumbra::gltf
