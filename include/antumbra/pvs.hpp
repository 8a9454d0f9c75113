// The .pvs file: what is visible from where, as data that a program can write, map and ask.
//
// Run-time module: standard library only, no exceptions. Byte layout: docs/format.md.
#pragma once

#include <antumbra/math.hpp>
#include <antumbra/status.hpp>

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <string_view>
#include <vector>

namespace antumbra {

/// The newest format that this library writes and reads: major * 65536 + minor.
inline constexpr std::uint32_t kPvsFormatVersion = 1u << 16 | 0;

/// What an answer promises. Stored in files: the numbers never change.
enum class Guarantee : std::uint8_t {
    exact = 1,        ///< what is visible and nothing else
    conservative = 2, ///< at least what is visible
    aggressive = 3,   ///< only what is visible, perhaps not all of it
    approximate = 4,  ///< neither
};
const char* to_string(Guarantee guarantee);

/// An object as a .pvs knows it. `flags` are ObjectFlag of scene.hpp.
struct PvsObject {
    std::int32_t node = -1, primitive = -1, instance = -1;
    std::uint32_t flags = 0;
    std::uint32_t triangle_count = 0;
    Box3f bounds; ///< relative to PvsData::origin
    std::string name;
};

/// Values of PvsData::cell_row that are no row.
inline constexpr std::uint32_t kCellNotBaked = 0xFFFFFFFFu; ///< outside `--where`: everything is visible
inline constexpr std::uint32_t kCellSolid = 0xFFFFFFFEu;    ///< inside geometry, no viewpoint: everything is visible

/// A regular grid of view cells. Cell (i,j,k) has index i + nx*(j + ny*k) and is the closed box
/// bounds.min + (i,j,k)*size/(nx,ny,nz) .. one step further.
struct CellGrid {
    Box3d bounds; ///< world
    std::array<std::uint32_t, 3> count{0, 0, 0};

    std::uint64_t cells() const { return std::uint64_t(count[0]) * count[1] * count[2]; }
    Box3d cell(std::uint64_t index) const;
    /// Index of the cell that holds `eye` (world), or -1 outside or for NaN. A point on a common face belongs to
    /// the cell above it, except at the far face of the grid.
    std::int64_t find(const Vec3d& eye) const;
};

/// Everything that goes into a file, decoded. Rows are bit sets over objects: bit o of row r is bit o%64 of word
/// r*words_per_row + o/64.
struct PvsData {
    Guarantee guarantee = Guarantee::approximate;
    std::string method;       ///< e.g. "sampled"
    std::string tool_version; ///< of the program that baked
    std::string options_json; ///< options and measured statistics, one JSON object
    std::array<std::uint8_t, 16> scene_fingerprint{};
    std::uint64_t structure_fingerprint = 0;
    std::uint8_t sides = 0; ///< SidesOption of scene.hpp
    Vec3d origin;           ///< world position of local zero
    CellGrid grid;
    std::vector<std::uint32_t> cell_row; ///< per cell: row, kCellNotBaked or kCellSolid
    std::vector<PvsObject> objects;
    std::uint32_t row_count = 0;
    std::vector<std::uint64_t> rows; ///< row_count * words_per_row() words; bits beyond the objects are zero

    std::size_t words_per_row() const { return (objects.size() + 63) / 64; }
};

/// Encodes to the bytes of a file. The same data gives the same bytes. ErrorCode::usage if the data contradicts
/// itself (row indices, sizes, set bits beyond the objects).
Result<std::vector<std::byte>> encode_pvs(const PvsData& data);

/// Per-view state of a query, owned by the caller, one per thread. Value-initialised before first use; belongs
/// to one Pvs. Never allocates after the first query.
struct PvsCursor {
    std::int64_t cell = -2;            ///< cell of the last answer, -1: outside, -2: none asked yet
    bool everything = false;           ///< the answer is "all objects" (outside, not baked, solid, damaged)
    std::uint32_t visible_count = 0;   ///< set bits in `visible`
    std::vector<std::uint64_t> visible; ///< bit set over objects, valid until the next query with this cursor
};

/// An opened file: an immutable view of bytes that the caller keeps alive and unchanged. Safe from any number of
/// threads. Every chunk is checked (ranges, CRC-32C) on opening, so that queries need not.
class Pvs {
  public:
    /// ErrorCode::corrupt names the chunk that is damaged; unsupported: written by a later major version.
    static Result<Pvs> open(std::span<const std::byte> bytes);

    Guarantee guarantee() const { return guarantee_; }
    std::string_view method() const { return method_; }
    std::string_view tool_version() const { return tool_version_; }
    std::string_view options_json() const { return options_json_; }
    const std::array<std::uint8_t, 16>& scene_fingerprint() const { return scene_fingerprint_; }
    std::uint64_t structure_fingerprint() const { return structure_fingerprint_; }
    std::uint8_t sides() const { return sides_; }
    Vec3d origin() const { return origin_; }
    const CellGrid& grid() const { return grid_; }
    std::uint32_t object_count() const { return object_count_; }
    PvsObject object(std::uint32_t index) const;
    std::string_view object_name(std::uint32_t index) const;
    Box3d object_bounds(std::uint32_t index) const; ///< world
    std::uint32_t row_count() const { return row_count_; }
    std::uint32_t cell_row(std::uint64_t cell) const; ///< row, kCellNotBaked or kCellSolid
    std::uint64_t file_bytes() const { return bytes_.size(); }
    std::uint64_t visibility_bytes() const; ///< bytes of the coded rows and their index alone

    /// Decodes row `row` into `words` (words_per_row() of them). Objects with kAlwaysVisible are set in every row.
    void decode_row(std::uint32_t row, std::span<std::uint64_t> words) const;
    std::size_t words_per_row() const { return (std::size_t(object_count_) + 63) / 64; }

    /// What can be seen from `eye` (world). An eye outside every cell, in a cell without an answer, or NaN sees
    /// everything (cursor.everything). Returns whether the answer differs from the cursor's last one; the same
    /// cell again costs a few nanoseconds. Guarantee: guarantee() inside baked cells, conservative elsewhere.
    bool query(const Vec3d& eye, PvsCursor& cursor) const;

  private:
    friend class PvsOpener;
    Pvs() = default;
    std::span<const std::byte> coded_row(std::uint32_t row) const;
    std::uint32_t row_or_everything(std::int64_t cell) const;

    std::span<const std::byte> bytes_;
    Guarantee guarantee_ = Guarantee::approximate;
    std::string_view method_, tool_version_, options_json_;
    std::array<std::uint8_t, 16> scene_fingerprint_{};
    std::uint64_t structure_fingerprint_ = 0;
    std::uint8_t sides_ = 0;
    Vec3d origin_;
    CellGrid grid_;
    std::uint32_t object_count_ = 0, row_count_ = 0;
    std::span<const std::byte> objects_, names_, cells_, row_index_, row_bytes_;
    std::vector<std::uint64_t> always_visible_; ///< bit set over objects
};

} // namespace antumbra
