// The .pvs file: what is visible from where, as data that a program can write, map and ask.
//
// Run-time module: standard library only, no exceptions. Byte layout: docs/format.md.
#pragma once

#include <antumbra/math.hpp>
#include <antumbra/status.hpp>

#include <array>
#include <cstddef>
#include <cstdint>
#include <memory>
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

/// Which cluster each triangle of an object belongs to.
struct PvsTriangles {
    static constexpr std::uint32_t kNone = 0xFFFFFFFFu; ///< no cluster: without area, never seen
    std::uint32_t in_file = 0; ///< triangles that the object has in the scene's file, those without area included
    /// Number of the cluster: of these, in the order of the file (triangle t has corners 3 t .. 3 t + 2 of the index buffer),
    /// then of those that were added to close cracks.
    std::vector<std::uint32_t> cluster;
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

/// What is asked: a closed box of viewpoints (world; a single one: min == max), and either all directions or those of
/// a camera's frustum.
struct ViewRange {
    Box3d eyes;
    bool all_directions = true;
    /// Else: directions of the four edges of the frustum, in order around it, none of them zero.
    std::array<Vec3d, 4> corners{};
};

/// The range of a camera that looks along `direction` with `up` upward (neither need be normal or unit), whose height
/// is 2 * tan_half_fov_y at distance 1 and whose width is `aspect` times that. Senseless values (NaN, zero or parallel
/// vectors, a field of view without end) give all directions.
ViewRange camera_range(const Box3d& eyes, const Vec3d& direction, const Vec3d& up, double tan_half_fov_y,
                       double aspect);

/// The five dimensions of view space. A direction d has no trigonometry in it: with |x|, |y|, |z| the sizes of its
/// components, theta counts quarter turns about the y axis, 0 at +x, 1 at +z, 2 at -x, 3 at -z, straight in |z| /
/// (|x| + |z|) between; phi is y / (|x| + |y| + |z|), from -1 (down) to 1 (up). So every bound in theta or phi is a
/// plane through the eye within each octant.

/// Each dimension of a view tree is 65,536 equal steps long; splits lie between steps.
inline constexpr std::uint32_t kViewSteps = 65536;

/// A closed box of view space, in steps: of the tree's bounds, of a whole turn, of phi from -1 to 1.
struct ViewRegion {
    std::array<std::uint32_t, 5> low{0, 0, 0, 0, 0};
    std::array<std::uint32_t, 5> high{kViewSteps, kViewSteps, kViewSteps, kViewSteps, kViewSteps};
    bool operator==(const ViewRegion&) const = default;
};

/// Where direction `d` (not zero, finite) lies, in steps: theta in [0, 65536), phi in [0, 65536].
struct ViewDirection {
    double theta = 0, phi = 0;
};
ViewDirection to_view_direction(const Vec3d& d);
/// A direction there; |x| + |y| + |z| = 1 but for rounding.
Vec3d from_view_direction(const ViewDirection& direction);

/// Node of a view tree, in preorder: the child below the split follows its parent directly.
struct ViewNode {
    static constexpr std::uint8_t kLeaf = 5;
    std::uint8_t axis = kLeaf; ///< 0..4: x, y, z, theta, phi; or kLeaf
    std::uint16_t split = 0;   ///< inner: step strictly inside the node's own box; below it one child, above the other
    std::uint32_t link = 0;    ///< inner: index of the child above; leaf: row, kCellNotBaked or kCellSolid
    bool operator==(const ViewNode&) const = default;
};

/// A k-d tree over the five dimensions (Gotsman, Sudarsky, Fayman 1999, section 3). What a leaf's row holds is visible
/// from some viewpoint of its box in some direction of its box.
struct ViewTree {
    static constexpr std::size_t kMostDepth = 255; ///< edges from the root to any leaf
    Box3d bounds;                                  ///< world; outside, everything is visible
    std::vector<ViewNode> nodes;                   ///< preorder; empty: no tree

    /// World coordinate of a step, axis 0..2. Never decreases with the step.
    double position(int axis, std::uint32_t step) const;
    /// The spatial part of a view box.
    Box3d spatial_box(const ViewRegion& box) const;
    /// The view box of a node. O(depth).
    ViewRegion region(std::uint32_t node) const;
    /// The leaf that holds a viewpoint in every direction, or -1 where directions are split, and outside. O(depth).
    std::int64_t find_leaf(const Vec3d& eye) const;
    /// ErrorCode::usage if the nodes are no tree in preorder of at most kMostDepth, a split lies outside its node, the
    /// bounds are not finite, or a leaf's row is neither below row_count nor one of the two special values.
    Status check(std::uint32_t row_count) const;
    /// Appends the indices of all leaves that the range touches, in preorder; a viewpoint on a split belongs to the
    /// side above. False, and nothing appended, if part of the range lies outside the bounds or is not finite: then
    /// everything is visible. Conservative in direction: poles, the turn's end and roll count, borders belong to both
    /// sides. Allocates only to append. O(nodes touched).
    bool find_leaves(const ViewRange& range, std::vector<std::uint32_t>& leaves) const;
};

/// Everything that goes into a file, decoded. Rows are bit sets over objects, then over occludee volumes: bit o of row
/// r is bit o%64 of word r*words_per_row + o/64. View cells are a grid or a tree, not both.
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
    ViewTree tree;
    std::vector<PvsObject> objects;
    /// Occludee volumes: boxes of space that were baked as pseudo-objects, so that moving things can be asked about.
    /// Bit objects.size() + v of a row: some of volume v, a cell of this grid, can be seen. Count 0: none;
    /// at most 2^20.
    CellGrid volumes;
    /// Clusters: triangles of one object each (no empty ones), listed besides the objects. Sorted by cluster, the scene's
    /// triangles cluster_first[c] .. cluster_first[c + 1] are those of cluster c; the last entry is the number of all
    /// triangles. Bit objects.size() + volumes.cells() + c of a row: some of cluster c can be seen. Empty: no clusters.
    std::vector<std::uint32_t> cluster_first;
    /// Per object: which triangles its clusters hold. Empty: the scene's triangles are in the order of clusters already.
    std::vector<PvsTriangles> triangles;
    std::uint32_t row_count = 0;
    std::vector<std::uint64_t> rows; ///< row_count * words_per_row() words; bits beyond bits_per_row() are zero

    std::size_t cluster_count() const { return cluster_first.empty() ? 0 : cluster_first.size() - 1; }
    std::size_t bits_per_row() const { return objects.size() + std::size_t(volumes.cells()) + cluster_count(); }
    std::size_t words_per_row() const { return (bits_per_row() + 63) / 64; }
};

/// How a file stores its rows. All are lossless; the numbers are those of files and never change.
enum class PvsCoding : std::uint32_t {
    cheapest = 1,     ///< each row alone, the shortest of three ways: a new cell in well below a microsecond per 4,000 objects
    tree_leaves = 2,  ///< published scheme 1 (Gotsman et al. 1999, section 6): every leaf in full; unpacked on opening
    tree_parent = 3,  ///< scheme 2: children relative to their parent; unpacked on opening
    tree_sibling = 4, ///< scheme 3: the heavier child relative to the lighter one; unpacked on opening
    references = 5,   ///< each row relative to another, arithmetic coded; decoded in tens of microseconds where asked
    archive = 6,      ///< the fewest bytes; unpacked on opening
};
const char* to_string(PvsCoding coding);

/// Encodes to the bytes of a file. The same data and coding give the same bytes. ErrorCode::usage if the data contradicts
/// itself (row indices, sizes, set bits beyond the objects); limit if something does not fit the format.
Result<std::vector<std::byte>> encode_pvs(const PvsData& data, PvsCoding coding = PvsCoding::cheapest);

/// A chunk beside those of the bake: see docs/format.md, section 6. Readers that do not know it skip it.
struct PvsChunk {
    std::string name; ///< four letters
    std::vector<std::byte> bytes;
};

/// A copy of `file` with these chunks, in place of any of the same names; all others are kept. ErrorCode::usage for a
/// name that is not four capital letters or digits, comes twice, or belongs to the bake itself; corrupt if `file` is no
/// .pvs. O(bytes).
Result<std::vector<std::byte>> add_pvs_chunks(std::span<const std::byte> file, std::span<const PvsChunk> chunks);

/// Per-view state of a query, owned by the caller, one per thread. Value-initialised before first use; belongs
/// to one Pvs. Queries by eye never allocate after the first one in a grid; others reuse what it has grown to.
struct PvsCursor {
    /// Of the last answer: the cell (of a tree: the node of the leaf), -1: outside, -2: none asked yet, -3: the answer
    /// comes from several, or was for a range.
    std::int64_t cell = -2;
    /// No cell answers (outside, not baked, solid, damaged): all objects that lie in the range's frustum.
    bool everything = false;
    std::uint32_t visible_count = 0;    ///< set bits in `visible`
    std::vector<std::uint64_t> visible; ///< bit set over objects, valid until the next query with this cursor
    std::vector<std::uint64_t> volumes; ///< bit set over occludee volumes

    /// Scratch of Pvs: the rows to unite, their union, and one of them.
    std::vector<std::uint32_t> next_rows;
    std::vector<std::uint64_t> united, decoded;
};

/// An opened file: an immutable view of bytes that the caller keeps alive and unchanged. Safe from any number of
/// threads; copies share what was unpacked. Every chunk is checked (ranges, CRC-32C) on opening, so that queries need not.
class Pvs {
  public:
    /// ErrorCode::corrupt names the chunk that is damaged; unsupported: written by a later major version.
    static Result<Pvs> open(std::span<const std::byte> bytes);

    Guarantee guarantee() const { return guarantee_; }
    PvsCoding coding() const { return coding_; }
    std::string_view method() const { return method_; }
    std::string_view tool_version() const { return tool_version_; }
    std::string_view options_json() const { return options_json_; }
    const std::array<std::uint8_t, 16>& scene_fingerprint() const { return scene_fingerprint_; }
    std::uint64_t structure_fingerprint() const { return structure_fingerprint_; }
    std::uint8_t sides() const { return sides_; }
    Vec3d origin() const { return origin_; }
    const CellGrid& grid() const { return grid_; }
    const ViewTree& tree() const { return tree_; } ///< empty where cells are a grid
    const CellGrid& volumes() const { return volumes_; }
    std::uint32_t object_count() const { return object_count_; }
    PvsObject object(std::uint32_t index) const;
    std::string_view object_name(std::uint32_t index) const;
    Box3d object_bounds(std::uint32_t index) const; ///< world
    std::uint32_t row_count() const { return row_count_; }
    std::uint32_t cell_row(std::uint64_t cell) const; ///< row, kCellNotBaked or kCellSolid
    std::uint64_t file_bytes() const { return bytes_.size(); }
    std::uint64_t visibility_bytes() const { return visibility_bytes_; } ///< of the coded rows and their index alone

    /// The bytes of a chunk beside those of the bake (add_pvs_chunks()), or nothing. Its checksum was right; what is in
    /// it was not looked at. O(chunks).
    std::span<const std::byte> chunk(std::string_view name) const;
    bool has_chunk(std::string_view name) const;

    /// Decodes row `row` into `words` (words_per_row() of them). Objects with kAlwaysVisible are set in every row.
    void decode_row(std::uint32_t row, std::span<std::uint64_t> words) const;
    std::size_t bits_per_row() const {
        return std::size_t(object_count_) + std::size_t(volumes_.cells()) + cluster_count_;
    }
    std::uint32_t cluster_count() const { return cluster_count_; } ///< 0: only objects are listed
    /// Where the triangles of cluster c begin, once those of the scene are sorted by cluster; of c == cluster_count(): the
    /// number of all triangles.
    std::uint32_t cluster_first(std::uint32_t c) const;
    /// The clusters of an object: from this one up to, not including, that of the next object (`object` up to object_count()).
    /// 0 where there are none.
    std::uint32_t first_cluster_of(std::uint32_t object) const {
        return object < cluster_index_.size() ? cluster_index_[object] : 0;
    }
    /// Which cluster each triangle of the object in the scene's file belongs to. To draw clusters as ranges, sort the
    /// object's index buffer by them once, keeping their order within each, and leave out what belongs to none. In files of
    /// before chunk CTRI triangles without area are not counted: compare `in_file` with your own number, and draw such an
    /// object whole if they differ. `most`: how many triangles the caller takes; where the file tells of more (a damaged one
    /// may claim anything), the list is empty. O(triangles of the object).
    PvsTriangles triangles_of(std::uint32_t object, std::uint32_t most) const;
    bool tells_triangles() const { return !triangle_index_.empty(); } ///< the file has chunk CTRI
    /// Can something of cluster c be seen, by the cursor's last answer? True where that cannot be told. The frustum of a
    /// range is not looked at.
    bool is_cluster_visible(std::uint32_t c, const PvsCursor& cursor) const;
    std::size_t words_per_row() const { return (bits_per_row() + 63) / 64; }

    /// What can be seen from `eye` (world), whichever way one looks. An eye outside every cell, in a cell without an
    /// answer, or NaN sees everything (cursor.everything). Returns whether the answer differs from the cursor's last
    /// one; the same cell of a grid again costs a few nanoseconds. Guarantee: guarantee() inside baked cells,
    /// conservative elsewhere.
    bool query(const Vec3d& eye, PvsCursor& cursor) const;

    /// What can be seen from somewhere in the range: the union over all cells that it touches, less the objects whose
    /// stored bounds lie outside its frustum from every one of its viewpoints (objects that are always visible stay).
    /// A range that is partly outside, or not finite, sees everything in its frustum. Returns whether the answer differs
    /// from the cursor's last one. Guarantee as in query(eye), but no better than conservative.
    /// O(cells touched * row + visible objects).
    bool query_range(const ViewRange& range, PvsCursor& cursor) const;

    /// Whether something within `box` (world) can be seen, by the cursor's last answer: some occludee volume that the
    /// box touches is visible. True where that cannot be told: no volumes, a box partly outside of them, NaN. Does
    /// not look at the frustum of a range.
    bool is_box_visible(const Box3d& box, const PvsCursor& cursor) const;

  private:
    friend class PvsOpener;
    Pvs() = default;
    std::span<const std::byte> coded_row(std::uint32_t row) const;
    std::uint32_t row_or_everything(std::int64_t cell) const;
    /// What cells a range touches: `only` is the one (-1: none, -3: several); `known`: all of them have an answer.
    struct Touched {
        std::int64_t only = -1;
        bool known = false;
    };
    /// `rows` becomes their rows, ascending, each once.
    Touched touched(const ViewRange& range, std::vector<std::uint32_t>& rows) const;
    bool answer(bool known, const ViewRange& range, PvsCursor& cursor) const;
    void unite(PvsCursor& cursor) const;
    bool show(PvsCursor& cursor) const;
    void drop_outside(const ViewRange& range, std::span<std::uint64_t> objects) const;

    std::span<const std::byte> bytes_;
    Guarantee guarantee_ = Guarantee::approximate;
    PvsCoding coding_ = PvsCoding::cheapest;
    std::string_view method_, tool_version_, options_json_;
    std::array<std::uint8_t, 16> scene_fingerprint_{};
    std::uint64_t structure_fingerprint_ = 0;
    std::uint8_t sides_ = 0;
    Vec3d origin_;
    CellGrid grid_, volumes_;
    ViewTree tree_;
    std::uint32_t object_count_ = 0, row_count_ = 0;
    std::uint32_t cluster_count_ = 0;
    std::vector<std::uint32_t> cluster_index_; ///< ClusterIndex::first
    std::vector<std::size_t> triangle_index_;  ///< ClusterIndex::triangles
    std::span<const std::byte> objects_, names_, cells_, clusters_, triangles_, row_index_, row_bytes_;
    std::uint64_t visibility_bytes_ = 0;
    /// Index and rows in PvsCoding::cheapest, where the file's own coding has no random access.
    std::shared_ptr<const std::array<std::vector<std::byte>, 2>> unpacked_;
    std::vector<std::uint64_t> always_visible_; ///< bit set over objects
    struct OtherChunk {
        std::uint32_t id;
        std::span<const std::byte> bytes;
    };
    std::vector<OtherChunk> others_; ///< chunks beside those of the bake
};

} // namespace antumbra
