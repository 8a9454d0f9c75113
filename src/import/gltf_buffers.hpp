// The bytes behind a glTF document: GLB chunks, data URIs, external files.
#pragma once

#include "import/gltf_document.hpp"

#include "base/file.hpp"

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
    Buffers(const Document& document, const Container& container, std::string folder, std::uint64_t max_bytes);

    /// All bytes of a buffer view; its length as the JSON says.
    Result<std::span<const std::byte>> view(std::int32_t view);

  private:
    struct Loaded {
        std::optional<MappedFile> file;
        std::vector<std::byte> owned;
        std::span<const std::byte> bytes;
        bool ready = false;
    };
    Status load(std::size_t buffer);
    Status load_external(std::size_t buffer, Loaded& loaded);

    const Document& document_;
    Container container_;
    std::string folder_;
    std::uint64_t bytes_left_;
    std::vector<Loaded> loaded_;
};

} // namespace antumbra::gltf
