// Run-time culling: which objects can be seen from one view, decided anew each frame, without any bake.
//
// Run-time module: standard library only, no exceptions. A CullScene is made once; any number of cullers and
// threads read it. What changes from frame to frame lives in one ViewState per view, owned by the caller.
//
//     CullScene scene = CullScene::create({.bounds = boxes, .flags = flags});
//     auto culler = make_culler("frustum", scene).value();   // *Result
//     ViewState state;
//     CullResult result;
//     culler->cull(view, state, result);                      // each frame
#pragma once

#include <antumbra/job.hpp>
#include <antumbra/math.hpp>
#include <antumbra/occluder_database.hpp>
#include <antumbra/occluders.hpp>
#include <antumbra/pvs.hpp>
#include <antumbra/status.hpp>

#include <cstdint>
#include <limits>
#include <memory>
#include <span>
#include <string_view>
#include <vector>

namespace antumbra {

enum class Projection : std::uint8_t { perspective, orthographic };

/// A camera in local coordinates (world minus the scene's origin). Whether the renderer stores z reversed does not
/// matter here: the view volume is the same.
struct View {
    Projection projection = Projection::perspective;
    Vec3d eye{0, 0, 0};
    Vec3d target{0, 0, -1};
    Vec3d up{0, 1, 0};
    double fov_y_deg = 60;        ///< perspective: full vertical angle, above 0 and below 180
    double height = 10;           ///< orthographic: height of the view volume, scene units
    double aspect = 16.0 / 9.0;   ///< width / height
    double near_plane = 0.1;      ///< distance along the viewing direction; perspective: >= 0
    double far_plane = std::numeric_limits<double>::infinity();
};

/// nullptr for a view that makes sense, else why it does not ("the field of view is not between 0 and 180
/// degrees"). Cullers answer such a view with everything.
const char* problem_of(const View& view);

/// Which machine code the kernels use. The results are the same bit for bit; `automatic` takes the best that the
/// processor has.
enum class InstructionSet : std::uint8_t { automatic, scalar, avx2, avx512 };

/// What a CullScene is made of. Only read during create().
struct CullSceneInput {
    std::span<const Box3f> bounds;           ///< local, one per object
    std::span<const std::uint32_t> flags;    ///< ObjectFlag of scene.hpp; empty: no flags
    Vec3d origin;                            ///< world position of local zero (only `pvs` asks)
    std::span<const std::uint32_t> triangles; ///< one per object: what it costs to draw; empty: not known
    const OccluderSet* occluders = nullptr;  ///< local; without them occlusion methods only cull by the frustum
};

/// Immutable boxes and the trees above them. Cheap to copy (shared), safe from any number of threads.
class CullScene {
  public:
    struct Data;
    /// O(n log n). Objects with kAlwaysVisible, and those whose box is empty, not finite or beyond 1e17 units, are
    /// kept out of the trees and reported in every frame.
    static CullScene create(const CullSceneInput& input);

    /// From the objects of a .pvs file and its chunks OCCL, OGRP, CTRE, OSET (prepare_chunks()) and MOSD: the same scene, bit for
    /// bit, without looking for anything again. What a file lacks is left out (occluders) or made anew (trees, groups).
    /// ErrorCode::corrupt names the chunk that contradicts itself; safe with any content. `pvs` is only read during the
    /// call.
    static Result<CullScene> open(const Pvs& pvs);

    std::uint32_t object_count() const;
    std::size_t words() const { return (std::size_t(object_count()) + 63) / 64; }
    std::span<const Box3f> bounds() const;
    const Data& data() const { return *data_; } ///< for the cullers

  private:
    std::shared_ptr<const Data> data_;
};

struct PrepareOptions {
    /// Occluder sets (Coorg, Teller 1997): cells that space is cut into, at most about so many (each leaf of a kd-tree over the
    /// objects, where it has no more), and occluders for each cell and direction; 0: no sets.
    std::uint32_t leaves = 4096, per_set = 64;
    /// Cells of objects with sets of occluders for what is in them (detail objects): upper nodes of that tree.
    std::uint32_t detail_leaves = 256;
    /// Leaves that have sets by first hit (OccluderChoice::first_hit).
    std::uint32_t first_hit_leaves = 256;
    /// Its cells are the cells of the sets (several together where they are more), and what they do not see is in none of their
    /// sets. Without one the cells are upper nodes of a kd-tree over the objects. Only read during the call.
    const Pvs* pvs = nullptr;
};

/// A CullScene as chunks for add_pvs_chunks(): occluders, their groups, the trees, and sets of occluders per place and
/// direction. The file must describe the same objects in the same order. A pure function of (scene, options), whatever
/// the threads. ErrorCode::cancelled if the job is.
Result<std::vector<PvsChunk>> prepare_chunks(const CullScene& scene, const PrepareOptions& options = {},
                                             const Job& job = {});

/// The database of build_occluder_database() (mos.hpp) as another chunk, MOSD: of the same occluders as the others.
PvsChunk occluder_database_chunk(const OccluderDatabase& database);

/// What the stages of one call did. A stage that a method does not have stays 0.
struct CullCounters {
    std::uint64_t nodes_visited = 0;      ///< inner nodes of the tree that were opened
    std::uint64_t boxes_tested = 0;       ///< boxes (of nodes and objects) put to the frustum
    std::uint64_t outside_frustum = 0;    ///< boxes rejected by the frustum
    std::uint64_t hidden_by_pvs = 0;      ///< objects that the baked cell does not see
    std::uint64_t occluders_used = 0;     ///< shadows that were cast
    std::uint64_t shadow_tests = 0;       ///< (occluder, eight boxes) pairs
    std::uint64_t relations_cached = 0;   ///< published form: relations whose planes were there already
    std::uint64_t relations_made = 0;     ///< published form: relations whose planes had to be formed
    std::uint64_t hidden_by_last = 0;     ///< boxes hidden by the occluder that hid them last time
    std::uint64_t hidden_by_planes = 0;   ///< boxes (of nodes and objects) in the shadow of some other occluder
    std::uint64_t hidden_by_raster = 0;   ///< boxes (of nodes and objects) behind the rasterised depth
    std::uint64_t tree_nodes = 0;         ///< shadow planes in the occlusion tree
    std::uint64_t tree_fragments = 0;     ///< its leaves that are in shadow
    std::uint64_t tree_tests = 0;         ///< boxes put to the occlusion tree
    std::uint64_t tree_queries = 0;       ///< `tree`: those of them that the point seen last time did not decide
    std::uint64_t tree_planes_tested = 0; ///< shadow planes that polygons and boxes were put to, building included
    std::uint64_t tests_saved = 0;        ///< boxes not tested: too cheap to draw, or visible in part last time
    std::uint64_t hidden_by_tree = 0;     ///< boxes (of nodes and objects) that the occlusion tree hides
    std::uint64_t patches_drawn = 0;      ///< occluder patches that were rasterised
    std::uint64_t polygons_drawn = 0;     ///< and their polygons
    std::uint64_t overlap_tests = 0;      ///< `opacity`: boxes (of nodes and objects) put to the opacity map
    std::uint64_t stopped_early = 0;      ///< `opacity`: nodes covered so little that nothing below was tested
    bool switched_off = false;            ///< `opacity`: it did not pay lately, the frustum alone was asked
    bool budget_spent = false;            ///< occluders were left out because the budget was used up
};

struct CullResult {
    std::vector<std::uint64_t> visible; ///< bit set over objects; bits beyond the objects are zero
    std::uint32_t visible_count = 0;    ///< set bits in `visible`
    /// True if the method had to give up and reports every object; `reason` says why (static text).
    bool everything = false;
    const char* reason = "";
    CullCounters counters;

    bool is_visible(std::uint32_t object) const { return visible[object / 64] >> (object % 64) & 1; }
};

/// What one view keeps between frames: caches, lists, buffers. Belongs to the culler it was last used with (using
/// it with another one empties it) and to one thread at a time. Bounded; allocates in the first frames only.
class ViewState {
  public:
    struct Storage {
        virtual ~Storage() = default;
    };
    ViewState() = default;
    ViewState(ViewState&&) noexcept = default;
    ViewState& operator=(ViewState&&) noexcept = default;

    /// For cullers: the storage of type T that belongs to the culler with this serial number.
    template <class T, class... Arguments>
    T& storage(std::uint64_t serial, Arguments&&... arguments) {
        if (serial != serial_ || !storage_) {
            storage_ = std::make_unique<T>(std::forward<Arguments>(arguments)...);
            serial_ = serial;
        }
        return static_cast<T&>(*storage_);
    }

  private:
    std::uint64_t serial_ = 0;
    std::unique_ptr<Storage> storage_;
};

/// One method of culling over one CullScene (of which it keeps a share). Thread-safe: cull() is const and all that
/// changes is in `state` and `result`.
class Culler {
  public:
    virtual ~Culler() = default;
    virtual std::string_view name() const = 0;
    /// Of the reported set against what is visible in the view.
    virtual Guarantee guarantee() const = 0;
    /// Never fails: whatever cannot be decided is visible. An object whose box touches the view volume is inside.
    virtual void cull(const View& view, ViewState& state, CullResult& result) const = 0;
};

/// How large occluders look (area A, normal N, viewing direction V, D from the eye to the centre): the published
/// area-angle -A (N.V) / |D|^2, or the same with D / |D| in V's place, which does not starve large walls at the rim of
/// a wide view.
enum class AreaAngle : std::uint8_t { viewing_direction, line_of_sight };

/// Whether nodes that were visible in part are tested again in the next frame (Bittner, Havran, Slavik 1998, 5.4).
enum class Retest : std::uint8_t { when_unmarked, always };

/// Where `tree` begins to put a box to its occlusion tree: at the deepest node that the box around it came down to undivided,
/// or at the leaves that the box around it reached without being hidden there. The answers are the same.
enum class TreeStart : std::uint8_t { deepest_node, reached_leaves };

/// For the methods with occlusion trees.
struct OcclusionTreeOptions {
    /// Nodes with fewer triangles below are drawn without a test. Without CullSceneInput::triangles all are tested.
    std::uint32_t minimum_cost = 50;
    /// `tree`: objects with fewer triangles are drawn without a test by the tree. Which nodes above objects are tested is
    /// decided from what such tests cost and brought in the last frames, in planes tested, so that the same views give the
    /// same answers.
    std::uint32_t minimum_object_cost = 0;
    /// `tree`: what it is worth to leave out an object besides its triangles, in shadow planes tested (some 50 ns each). Boxes
    /// are tested where that is expected to pay; infinity: always.
    double object_worth = 256;
    Retest retest = Retest::when_unmarked;
    /// `tree-fme`, `tree-fmc`: intersection tests at inner nodes of the occlusion tree too, which make FME exact; and extra nodes
    /// where shadow planes meet at a sharp angle. The paper sketches both (6.2, 9).
    bool inner_tests = false, extra_nodes = false;
    TreeStart start = TreeStart::reached_leaves;
    AreaAngle area_angle = AreaAngle::line_of_sight;
    /// Occluders are chosen from visible leaves whose centres are so near, scene units; 0: a hundred times the longest
    /// step of the eye so far, but a quarter of the scene's size at least (everything, before it has moved).
    double reach = 0;
};

/// Where the kd-tree of `planes-published` is cut: the axes in turn by balanced counts (Coorg, Teller 1997), or across
/// the largest extent where the fewest objects are cut (Bittner, Havran, Slavik 1998).
enum class KdSplit : std::uint8_t { balanced_counts, fewest_splits };

/// For `planes-published`.
struct PublishedPlanesOptions {
    KdSplit split = KdSplit::balanced_counts;
    std::uint32_t leaf_objects = 4;                  ///< leaves with so many are not cut
    std::uint64_t cache_bytes = std::uint64_t(32) << 20; ///< relations that a view keeps, at most
    /// Occluders that pay little are left out of a view's set until it is worth more again; false: always the whole set.
    bool adapt = true;
    /// Parts of the method, to see what each is worth: occluders joined over shared edges; occluders of single objects; relations
    /// that are used again in later frames.
    bool joined = true, detail = true, reuse = true;
};

/// How `opacity` works: the same occluders and guarantee, once for today's processors (bits and masks), once as Poon and
/// Wang published it (summed-area table and sparse depth map), and once by the pixel-wise comparison that they
/// measure against. `opacity-published` is `opacity` with the second.
enum class OpacityForm : std::uint8_t { modern, published, pixel_wise };

enum class OpacityCoverage : std::uint8_t {
    inner,  ///< a pixel counts only if it is wholly covered: conservative
    centre, ///< a pixel counts if its centre is covered, as published: approximate
};

/// Which occluders `opacity` draws, of those that a database names or, without one, of all. Decides what is found to be
/// hidden, never whether it is.
enum class OpacityChoice : std::uint8_t {
    by_gain,   ///< modern form: whole patches, front to back, each only if it would cover pixels that are open yet
    as_listed, ///< single polygons, best first (the lists of the nearest grid point; else by area-angle), as published
};

struct OpacityOptions {
    OpacityForm form = OpacityForm::modern;
    /// The published and the pixel-wise form always draw as listed. by_gain culls far more of cities, less of interiors.
    OpacityChoice choice = OpacityChoice::as_listed;
    OpacityCoverage coverage = OpacityCoverage::inner;
    /// Pixels of the map, 8..2048, rounded up to multiples of 8. 0: 128 x 128 as published, or, in the modern form, 256
    /// across and square pixels.
    int width = 0, height = 0;
    std::uint32_t occluders = 256; ///< polygons drawn per frame at most
    /// Share of a box's pixels that may be open, 0..1. Anything but 0 is approximate.
    float tolerance = 0;
    /// Below a node whose pixels are covered to a lesser share than this nothing is tested. Costs culling, loses nothing.
    float stop_below = 0.2f;
    /// Raises stop_below while culling costs more than it saves, and switches the method off (the frustum alone) when
    /// that does not help, with a fresh try after 1, 2, 4 .. 64 frames.
    bool adaptive = true;
    double object_seconds = 2e-6; ///< what it saves to leave out an object
    /// Seconds since any moment. With it the adaptive stop weighs measured times; without, counts of what was done, and
    /// then results are the same in every run.
    double (*clock)() = nullptr;
    /// Occluders by place and direction, polygons of the scene's own occluder set; must outlive the culler. nullptr: what
    /// the scene was prepared with, or those of the largest area-angle.
    const OccluderDatabase* database = nullptr;
};

/// How `planes`, `planes-published`, `tree`, `tree-fse`, `tree-fme`, `tree-fmc`, and `opacity` and `opacity-published` without a
/// database, choose their occluders. `masked`, `hzb` and OpacityChoice::by_gain always go by the pixels that a patch may cover
/// for each of its polygons. The choice decides what is found to be hidden, never whether it is.
enum class OccluderChoice : std::uint8_t {
    area_angle,     ///< area times cosine over squared distance (Coorg, Teller 1997), searched for anew as the eye moves
    projected_size, ///< the same without the cosine: size over squared distance
    /// What most rays of sample views hit first, from the lists of a prepared file; without them area_angle. The tree methods
    /// take what else they have room for by area-angle.
    first_hit,
};

struct CullerOptions {
    OccluderChoice occluder_choice = OccluderChoice::area_angle;
    InstructionSet instruction_set = InstructionSet::automatic;
    /// `planes`: occluders per frame, 0..64; `planes-published`: per leaf and direction, 0..256;
    /// `tree-fse`, `tree-fme`, `tree-fmc`: per frame, 0..256; `tree`: 0..512.
    std::uint32_t occluders = 64;
    OcclusionTreeOptions tree;
    PublishedPlanesOptions published;
    /// `hzb`, `masked`: pixels across (the height follows from the view), 8..2048.
    int raster_width = 256;
    /// `hzb`, `masked`: polygons drawn per frame at most.
    std::uint32_t polygon_budget = 512;
    /// `masked`: patches are not drawn where their box covers fewer pixels for each of their polygons.
    float pixels_per_polygon = 8;
    OpacityOptions opacity;
    /// `pvs` needs one of the same objects in the same order; all methods that have occluders take them from what the cell of the
    /// eye sees, if one is given. It must outlive the culler.
    const Pvs* pvs = nullptr;
};

/// Names that make_culler() knows, from the plainest method to the most elaborate.
std::span<const std::string_view> culler_names();

/// One line about a method, for help texts; "" for an unknown name.
std::string_view culler_summary(std::string_view name);

/// ErrorCode::usage: unknown name (the message lists the known ones) or a missing option; mismatch: a Pvs with
/// another number of objects; unsupported: the processor lacks the instruction set that was asked for.
Result<std::unique_ptr<Culler>> make_culler(std::string_view name, const CullScene& scene,
                                            const CullerOptions& options = {});

} // namespace antumbra
