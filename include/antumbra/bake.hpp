// Baking: what is visible from every cell of viewpoints, computed once.
#pragma once

#include <antumbra/job.hpp>
#include <antumbra/pvs.hpp>
#include <antumbra/scene.hpp>

#include <span>

namespace antumbra {

/// What the likelihoods of the sequential test are (Gotsman, Sudarsky, Fayman 1999, section 5; the paper's text allows
/// three readings, see docs/methods/five_dimensional.md).
enum class SprtReading : std::uint8_t {
    wald,       ///< simple against simple: s_1 against s_t
    printed,    ///< the paper's integrals as printed: a uniform prior over [0, 1]
    normalised, ///< each likelihood averaged over its own interval
};

/// The sequential probability ratio test of one (cell, object) pair: rays are aimed at the object until the ratio of the
/// likelihoods of "visible" and "invisible" leaves [b, a].
struct SprtOptions {
    SprtReading reading = SprtReading::wald;
    double s_t = 0.01;              ///< share of hits below which an object need not be found
    double s_1 = 0.1;               ///< share at which it should be (wald)
    double a = 50;                  ///< "visible" above this ratio; "visible" always needs a hit
    double b = 0.2;                 ///< "invisible" below this ratio
    std::uint32_t most_rays = 4096; ///< undecided by then: invisible without a hit, else visible
    bool operator==(const SprtOptions&) const = default;
};

enum class Sampling : std::uint8_t {
    uniform, ///< rays_per_cell uniform directions
    guided,  ///< the same budget, most of it spent around what was just found
};

/// How view space is cut into cells.
enum class Subdivision : std::uint8_t {
    grid,    ///< a regular grid of boxes
    spatial, ///< a k-d tree over positions
    angular, ///< the same, each leaf cut into eight headings: the paper's experimental setting
    five,    ///< a k-d tree over positions and directions
    boxes,   ///< the boxes of BakeOptions::where are the cells themselves; they need not be alike, nor touch
};

/// Against what the objects that both halves of a split see are counted.
enum class SplitEstimate : std::uint8_t {
    published, ///< all objects that the node's rays saw
    corrected, ///< those that both halves would see by chance if the plane separated nothing
};

/// The k-d tree of view space (Gotsman, Sudarsky, Fayman 1999, section 4).
struct ViewTreeOptions {
    Subdivision subdivision = Subdivision::grid;
    double view_space = 1;          ///< spatial part of view space, as a multiple of the scene's box about its centre
    SplitEstimate estimate = SplitEstimate::corrected;
    double effectiveness = 0.1;     ///< split only above this effectiveness, 0..1
    std::uint64_t min_visible = 1;  ///< split only where at least so many triangles belong to visible objects
    std::uint32_t max_depth = 10;   ///< of splits below a tile
    double min_extent = 1.0 / 64;   ///< of a cell along an axis, as a share of view space
    std::uint32_t node_rays = 1024; ///< for the rough visibility of a node; cached ones count
    /// View space is first halved so many times along its longest axis: 2^tile_depth independent tiles, the units of
    /// threads, checkpoints and shards.
    std::uint32_t tile_depth = 2;
};

/// What a bake lists. Objects are listed in any case.
enum class Granularity : std::uint8_t {
    object,
    cluster,  ///< objects of many triangles are cut into parts
    triangle, ///< every triangle on its own
};

/// Which triangles of an object make a cluster.
enum class ClusterOrder : std::uint8_t {
    compact, ///< those that lie together in space, wherever the file has them: index buffers must be sorted by cluster
    file,    ///< runs of the order in the file: can be drawn from the index buffers as they are
};

/// How the exact query is answered (docs/methods/exact.md). Both forms are exact and list the same.
enum class ExactForm : std::uint8_t {
    fast,      ///< lazy: a line in each piece names its next blocker; ends with the first unblocked one
    published, ///< Nirenstein, Blake, Gain 2002: every occluder subtracted from a complex of polytopes with face lattices
};

/// Method "exact" only.
struct ExactOptions {
    ExactForm form = ExactForm::fast;
    Granularity granularity = Granularity::object;
    std::uint32_t cluster_triangles = 256; ///< the most in a cluster
    ClusterOrder cluster_order = ClusterOrder::compact;
    /// Budget of one query in pieces; beyond it its target is listed as visible and counted as undecided.
    std::uint32_t max_pieces = 20000;
    /// Cells of a grid are solved in blocks of so many along each axis (a power of two, up to 64): what no line from the
    /// box around a block reaches is hidden from its cells. 1: every cell alone. Changes the time and the counts of work;
    /// rows only where a budget runs out.
    std::uint32_t block = 1;
    /// Budget of one cell: pieces of line space and pairs of faces asked for, summed, never time, so that the same is undecided
    /// on every machine; 0: none. When less than a quarter is left, boxes are asked for before triangles. What is not decided
    /// when it is spent is listed as visible and counted as undecided. The default is some minutes of one core.
    std::uint64_t cell_work = 4000000;
    bool operator==(const ExactOptions&) const = default;
};

/// Which share of a bake's units (cells, or tiles of a view tree) to compute: those whose place in their order leaves
/// `index` when divided by `count`.
struct Shard {
    std::uint32_t index = 0, count = 1;
    bool operator==(const Shard&) const = default;
};

struct BakeOptions {
    /// "sampled": rays (aggressive). "exact": rays, then a proof for all that they did not find; Subdivision::grid, boxes or
    /// spatial (cells are halved where the halves see different things).
    std::string method = "sampled";
    ViewTreeOptions tree;
    ExactOptions exact;
    /// The grid, for Subdivision::grid: a count per axis, or, if cell_size > 0, cubes of about that edge (scene units).
    std::array<std::uint32_t, 3> cells{16, 4, 16};
    double cell_size = 0;
    /// Where viewers can be (world). Empty: the scene's bounds. Cells that touch none of them are not baked. The cells
    /// themselves for Subdivision::boxes.
    std::vector<Box3d> where;
    /// Occludee volumes along each axis, so that moving boxes can be asked about (Pvs::is_box_visible); 0: none.
    /// Sampled bakes only.
    std::array<std::uint32_t, 3> volumes{0, 0, 0};
    /// Rays per cell that look around, before the sequential test aims at each object that they did not find.
    std::uint32_t rays_per_cell = 32768;
    Sampling sampling = Sampling::uniform;
    SprtOptions sequential;
    /// Weigh the sequential test by how often objects of like size and distance were seen from the cell before.
    bool informed_prior = false;
    /// Rays per cell that only measure the miss rate, from a stream of their own.
    std::uint32_t holdout_rays = 2048;
    std::uint64_t seed = 1;
    /// Where to keep finished cells while baking ("" = nowhere), and whether to take up what is there.
    std::string checkpoint;
    bool resume = false;
    /// Part of a bake, to be united by merge_parts(). A part is a whole file itself; the units of other shards are not
    /// baked in it. Nothing that a unit holds depends on the shard.
    Shard shard;
};

/// What method "exact" did (docs/methods/exact.md).
struct ExactStatistics {
    std::uint64_t box_queries = 0, triangle_queries = 0; ///< asked of a cell
    std::uint64_t pairs = 0;                             ///< pairs of polygons asked for these
    std::uint64_t undecided = 0;      ///< triangles listed as visible because a budget ran out; 0 in an exact bake
    std::uint64_t found_by_query = 0; ///< (cell, object or cluster) pairs that the rays before had missed
    /// Effective occluders: summed over the pairs of polygons that needed any, the number of these, and the most of one.
    std::uint64_t effective_occluders = 0, queries_with_occluders = 0, most_effective = 0;
};

/// What a bake measured. `bytes` and `bits_per_pair` belong to the file and are filled by whoever writes it.
struct BakeStatistics {
    /// Cells of the grid, or leaves of the view tree.
    std::uint64_t cells = 0, cells_baked = 0, cells_solid = 0, cells_not_baked = 0;
    std::uint64_t cells_resumed = 0, tiles_resumed = 0; ///< taken from the checkpoint
    std::uint64_t rays = 0;
    std::uint64_t confirmed_pairs = 0;   ///< (cell, object) bits, each proved by one exact segment
    std::uint64_t unconfirmed_pairs = 0; ///< proposed by a ray, never confirmed: not set
    double seconds = 0, cpu_seconds = 0;
    double mean_visible = 0; ///< objects per baked cell
    std::uint64_t holdout_rays = 0, holdout_misses = 0;
    double miss_rate = 0, miss_rate_upper95 = 0; ///< a fresh random ray of a cell first hits an unlisted object
    std::uint64_t rays_reused = 0;               ///< cached rays of a node that its children did not cast again
    std::uint64_t aimed_rays = 0;                ///< of rays: those of the sequential test
    /// Bound on losing a pair that a share s >= pair_s1 of aimed rays sees: all of its rays miss.
    double pair_s1 = 0, pair_miss_at_s1 = 0;
    ExactStatistics exact; ///< method "exact" only
};

struct BakeResult {
    PvsData pvs;
    BakeStatistics statistics;
};

struct BakePlan {
    CellGrid grid; ///< no cells where they are not a grid
    std::uint64_t cells_to_bake = 0;
    /// Cells are leaves of a tree that grows as it is baked: their number is an estimate, too.
    bool is_cells_estimate = false;
    double estimated_seconds = 0; ///< from a few cells, or tiles of the tree, baked for the purpose
    std::uint64_t estimated_bytes = 0;
};

/// A pure function of (scene, options): the same result, byte for byte, for any job.threads, and whether or not it
/// was interrupted and resumed. ErrorCode::cancelled keeps finished cells in the checkpoint.
Result<BakeResult> bake(const Scene& scene, const BakeOptions& options, const Job& job = {});

/// The header and the objects of a .pvs of this scene without any cell: from everywhere everything is visible. To carry
/// chunks beside a bake (prepare_chunks() of cull.hpp), or to be filled.
PvsData describe_scene(const Scene& scene);

/// Unites all parts of one sharded bake, given in any order: what bake() gives without shards, byte for byte once encoded.
/// ErrorCode::usage without parts; mismatch, naming the file (names[i] is that of parts[i]), if one is no part, parts
/// belong to different bakes, or a shard is missing or comes twice.
Result<PvsData> merge_parts(std::span<const Pvs> parts, std::span<const std::string> names);

/// What bake() would do, from a handful of cells.
Result<BakePlan> plan_bake(const Scene& scene, const BakeOptions& options, const Job& job = {});

} // namespace antumbra
