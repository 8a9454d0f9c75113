// EXT_meshopt_compression, decoded by meshoptimizer behind our own checks.
#pragma once

#include "import/gltf_document.hpp"

#include <cstddef>
#include <span>
#include <vector>

namespace antumbra::gltf {

/// `view.count` elements of `view.stride` bytes. ErrorCode::corrupt if the stream is damaged or the numbers do not
/// belong together, limit beyond `max_bytes`. The values themselves (indices above all) are as untrusted as those
/// of a plain buffer.
Result<std::vector<std::byte>> decode_meshopt(const Meshopt& view, std::span<const std::byte> packed,
                                              std::uint64_t max_bytes);

} // namespace antumbra::gltf
