#include "import/gltf_buffers.hpp"

#include "import/meshopt.hpp"
#include "import/uri.hpp"

#include <algorithm>
#include <cstring>

namespace antumbra::gltf {
namespace {

constexpr std::uint32_t kMagic = 0x46546C67, kJsonChunk = 0x4E4F534A, kBinaryChunk = 0x004E4942;

std::uint32_t read_u32(std::span<const std::byte> bytes, std::size_t at) {
    std::uint32_t value = 0;
    for (std::size_t i = 0; i < 4; ++i)
        value |= static_cast<std::uint32_t>(bytes[at + i]) << (8 * i);
    return value;
}

Status damaged(const std::string& text) { return {ErrorCode::corrupt, text + "; copy or export the file anew"}; }

Result<Container> open_glb(std::span<const std::byte> bytes) {
    if (bytes.size() < 12)
        return damaged("GLB header is cut off");
    if (std::uint32_t version = read_u32(bytes, 4); version != 2)
        return Status(ErrorCode::unsupported,
                      "GLB version " + std::to_string(version) + " is not read; export as glTF 2.0");
    std::uint32_t length = read_u32(bytes, 8);
    if (length > bytes.size())
        return damaged("GLB is cut off: it says " + std::to_string(length) + " bytes but has " +
                       std::to_string(bytes.size()));
    bytes = bytes.first(length);
    Container container;
    bool has_json = false;
    for (std::size_t at = 12; at < bytes.size();) {
        if (bytes.size() - at < 8)
            return damaged("GLB chunk header at byte " + std::to_string(at) + " is cut off");
        std::uint32_t size = read_u32(bytes, at), type = read_u32(bytes, at + 4);
        at += 8;
        if (size > bytes.size() - at)
            return damaged("GLB chunk at byte " + std::to_string(at - 8) + " is longer than the file");
        if (!has_json && type != kJsonChunk)
            return damaged("the first chunk of a GLB must be JSON");
        if (!has_json)
            container.json = bytes.subspan(at, size);
        else if (type == kBinaryChunk && !container.has_binary)
            container.binary = bytes.subspan(at, size);
        container.has_binary = container.has_binary || (has_json && type == kBinaryChunk);
        has_json = true;
        at += size;
    }
    if (!has_json)
        return damaged("GLB without a JSON chunk");
    return container;
}

} // namespace

Result<Container> open_container(std::span<const std::byte> bytes) {
    if (bytes.empty())
        return Status(ErrorCode::corrupt, "the file is empty");
    if (bytes.size() >= 4 && read_u32(bytes, 0) == kMagic)
        return open_glb(bytes);
    return Container{bytes, {}, false};
}

Buffers::Buffers(const Document& document, const Container& container, std::string folder, std::uint64_t max_bytes,
                 std::uint64_t max_memory)
    : document_(document), container_(container), folder_(std::move(folder)), bytes_left_(max_bytes),
      memory_left_(max_memory), loaded_(document.buffers.size()) {}

Status Buffers::load_external(std::size_t buffer, Loaded& loaded) {
    const std::string& uri = document_.buffers[buffer].uri;
    if (uri.rfind("data:", 0) == 0) {
        Result<std::vector<std::byte>> data = data_of_uri(uri);
        if (!data)
            return data.status();
        loaded.owned = std::move(*data);
        loaded.bytes = loaded.owned;
        return {};
    }
    std::optional<std::string> relative = percent_decoded(uri);
    if (!relative)
        return {ErrorCode::corrupt, "the URI holds a broken %XX"};
    Result<std::string> path = path_inside(folder_, *relative);
    if (!path)
        return path.status();
    Result<MappedFile> file = MappedFile::open(*path, bytes_left_);
    if (!file)
        return file.status();
    loaded.file.emplace(std::move(*file));
    loaded.bytes = loaded.file->bytes();
    bytes_left_ -= loaded.bytes.size();
    return {};
}

Status Buffers::load(std::size_t buffer) {
    Loaded& loaded = loaded_[buffer];
    if (loaded.ready)
        return {};
    const Buffer& declared = document_.buffers[buffer];
    if (declared.has_uri) {
        if (Status status = load_external(buffer, loaded); !status)
            return status.in("buffers[" + std::to_string(buffer) + "].uri");
    } else if (buffer == 0 && container_.has_binary) {
        loaded.bytes = container_.binary;
    } else {
        return Status(ErrorCode::corrupt, "has neither a uri nor a GLB chunk")
            .in("buffers[" + std::to_string(buffer) + "]");
    }
    if (loaded.bytes.size() < declared.bytes)
        return damaged("should have " + std::to_string(declared.bytes) + " bytes but has " +
                       std::to_string(loaded.bytes.size()))
            .in("buffers[" + std::to_string(buffer) + "].byteLength");
    loaded.bytes = loaded.bytes.first(static_cast<std::size_t>(declared.bytes));
    loaded.ready = true;
    return {};
}

Result<std::span<const std::byte>> Buffers::range(std::int32_t index, std::uint64_t offset, std::uint64_t bytes) {
    std::size_t buffer = static_cast<std::size_t>(index);
    if (Status status = load(buffer); !status)
        return status;
    std::uint64_t size = loaded_[buffer].bytes.size();
    // In this order nothing can wrap.
    if (offset > size || bytes > size - offset)
        return Status(ErrorCode::corrupt, "bytes " + std::to_string(offset) + " and the next " +
                                              std::to_string(bytes) + " reach beyond the buffer's " +
                                              std::to_string(size));
    return loaded_[buffer].bytes.subspan(static_cast<std::size_t>(offset), static_cast<std::size_t>(bytes));
}

Result<std::span<const std::byte>> Buffers::decoded(std::int32_t index) {
    const BufferView& view = document_.views[static_cast<std::size_t>(index)];
    auto [found, is_new] = decoded_.try_emplace(index);
    if (!is_new)
        return std::span<const std::byte>(found->second);
    Result<std::span<const std::byte>> packed =
        range(view.meshopt.buffer, view.meshopt.offset, view.meshopt.bytes);
    if (!packed)
        return packed.status();
    Result<std::vector<std::byte>> bytes = decode_meshopt(view.meshopt, *packed, std::min(view.bytes, memory_left_));
    if (!bytes)
        return bytes.status();
    memory_left_ -= bytes->size();
    found->second = std::move(*bytes);
    return std::span<const std::byte>(found->second);
}

Result<std::span<const std::byte>> Buffers::view(std::int32_t index) {
    const BufferView& view = document_.views[static_cast<std::size_t>(index)];
    Result<std::span<const std::byte>> bytes =
        view.meshopt.used ? decoded(index) : range(view.buffer, view.offset, view.bytes);
    if (!bytes)
        return bytes.status().in("bufferViews[" + std::to_string(index) + "]");
    return bytes;
}

} // namespace antumbra::gltf
