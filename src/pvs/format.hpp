// Names and sizes of what the chunks of a .pvs file hold. Byte layout: docs/format.md, section 3.
#pragma once

#include "pvs/chunks.hpp"

namespace antumbra {

inline constexpr ChunkId kMetaChunk = chunk_id("META");     ///< who baked what, how; sizes of the rest
inline constexpr ChunkId kOptionsChunk = chunk_id("OPTS");  ///< options and statistics, JSON text
inline constexpr ChunkId kObjectsChunk = chunk_id("OBJS");  ///< a record per object
inline constexpr ChunkId kNamesChunk = chunk_id("NAME");    ///< the names of all objects, end to end
inline constexpr ChunkId kCellsChunk = chunk_id("CELL");    ///< row of each cell
inline constexpr ChunkId kTreeChunk = chunk_id("TREE");     ///< view tree, in place of the grid
inline constexpr ChunkId kVolumesChunk = chunk_id("VOLS");  ///< grid of occludee volumes
inline constexpr ChunkId kClustersChunk = chunk_id("CLUS"); ///< where each cluster of triangles begins
inline constexpr ChunkId kTrianglesChunk = chunk_id("CTRI"); ///< which cluster each triangle is in
inline constexpr ChunkId kRowIndexChunk = chunk_id("RIDX"); ///< where each coded row ends
inline constexpr ChunkId kRowsChunk = chunk_id("ROWS");     ///< the coded rows

/// Chunks that every reader must understand; all others are beside the bake.
constexpr bool is_chunk_of_bake(ChunkId id) {
    for (ChunkId known : {kMetaChunk, kOptionsChunk, kObjectsChunk, kNamesChunk, kCellsChunk, kTreeChunk, kVolumesChunk, kClustersChunk,
                          kTrianglesChunk, kRowIndexChunk, kRowsChunk})
        if (id == known)
            return true;
    return false;
}

inline constexpr std::size_t kMetaBytes = 144; ///< the fixed part; method and tool version follow
inline constexpr std::size_t kObjectBytes = 48;
inline constexpr std::size_t kCellBytes = 4;
inline constexpr std::size_t kTreeHeaderBytes = 64;
inline constexpr std::size_t kVolumesBytes = 64;
inline constexpr std::size_t kRowIndexBytes = 4;
/// A volume takes no bytes of its own, so that their number must be bounded.
inline constexpr std::uint64_t kMostVolumes = std::uint64_t(1) << 20;

/// ObjectFlag::kAlwaysVisible of scene.hpp, which the run time may not include (a test compares the two).
inline constexpr std::uint32_t kAlwaysVisibleFlag = 1u << 2;

/// First byte of a node in TREE: below kLeaf the axis of the split.
enum TreeNode : std::uint8_t {
    kLeafOfNextRow = 5,  ///< the lowest row that no leaf before it has
    kLeafOfGivenRow = 6, ///< the row follows
};

/// Whether a coding that must be unpacked on opening may hold so many (row, object) pairs in so many bytes: bounds the
/// time and memory that a small file can ask for.
constexpr bool may_unpack(std::uint64_t rows, std::uint64_t objects, std::uint64_t bytes) {
    std::uint64_t most = (std::uint64_t(1) << 22) + 1024 * bytes;
    return objects == 0 || rows <= most / objects;
}

} // namespace antumbra
