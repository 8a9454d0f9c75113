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
inline constexpr ChunkId kRowIndexChunk = chunk_id("RIDX"); ///< where each coded row ends
inline constexpr ChunkId kRowsChunk = chunk_id("ROWS");     ///< the coded rows

inline constexpr std::size_t kMetaBytes = 144; ///< the fixed part; method and tool version follow
inline constexpr std::size_t kObjectBytes = 48;
inline constexpr std::size_t kCellBytes = 4;
inline constexpr std::size_t kTreeHeaderBytes = 64;
inline constexpr std::size_t kVolumesBytes = 64;
inline constexpr std::size_t kRowIndexBytes = 4;

/// ObjectFlag::kAlwaysVisible of scene.hpp, which the run time may not include (a test compares the two).
inline constexpr std::uint32_t kAlwaysVisibleFlag = 1u << 2;

/// First byte of a node in TREE: below kLeaf the axis of the split.
enum TreeNode : std::uint8_t {
    kLeafOfNextRow = 5,  ///< the lowest row that no leaf before it has
    kLeafOfGivenRow = 6, ///< the row follows
};

/// How rows are coded; stored in META.
enum class RowCoding : std::uint32_t {
    cheapest = 1, ///< each row alone, in the shortest of three ways: row_coding.hpp
};

} // namespace antumbra
