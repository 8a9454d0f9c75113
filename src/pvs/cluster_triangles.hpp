// Which triangles clusters hold: chunks CLUS and CTRI. Byte layout: docs/format.md, section 3.
#pragma once

#include <antumbra/pvs.hpp>

namespace antumbra {

/// Where each object's clusters and triangles are told.
struct ClusterIndex {
    std::vector<std::uint32_t> first;   ///< per object: its first cluster; and the number of all at the end
    std::vector<std::size_t> triangles; ///< per object: where CTRI tells of its triangles; empty without CTRI
};

/// Fills the index from the bytes of CLUS, CTRI (nullptr: the file has none) and OBJS. What is wrong with the chunks, or nullptr.
/// O(objects + clusters + bytes), whatever the bytes say.
const char* index_clusters(std::span<const std::byte> first, const std::span<const std::byte>* triangles,
                           std::span<const std::byte> objects, ClusterIndex& index);

/// What CTRI tells at `at` of an object's triangles. It was checked. The list stays empty if there are more than `most`.
void decode_triangles(std::span<const std::byte> bytes, std::size_t at, std::uint32_t first_cluster, std::uint32_t most,
                      PvsTriangles& triangles);

/// CTRI of `data.triangles`.
std::vector<std::byte> encode_triangles(const PvsData& data);

} // namespace antumbra
