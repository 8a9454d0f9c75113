// KHR_draco_mesh_compression, decoded by libdraco behind our own checks.
#pragma once

#include "import/gltf_document.hpp"

#include <antumbra/scene.hpp>

#include <cstddef>
#include <span>
#include <vector>

namespace antumbra::gltf {

/// Appends the mesh's points and triangles. `accessor` is what the file says about its positions: no more points
/// than its count, and integers are mapped as it says; exactly `triangle_count` triangles. What the stream says
/// about its size is compared with that before libdraco sees it, for libdraco allocates first. ErrorCode::corrupt
/// for damage, indices out of range and numbers that are not finite; unsupported for streams with metadata (libdraco
/// reads those recursively) and for versions before 2.2, which no exporter of glTF ever wrote.
Status decode_draco(std::span<const std::byte> bytes, std::uint32_t position_id, const Accessor& accessor,
                    std::uint64_t triangle_count, std::vector<Vec3d>& positions,
                    std::vector<TriangleIndices>& triangles);

} // namespace antumbra::gltf
