// Truth and measurement: is what a .pvs or a culler reports right, and what does it save?
//
// Truth is an item buffer traced in strict doubles; a pixel that would convict a method is judged again by exact
// arithmetic before it counts. Coordinates in results are world coordinates.
#pragma once

#include <antumbra/cull.hpp>
#include <antumbra/job.hpp>
#include <antumbra/pvs.hpp>
#include <antumbra/scene.hpp>
#include <antumbra/study.hpp>

#include <cstdint>
#include <functional>
#include <optional>
#include <span>
#include <string>
#include <vector>

namespace antumbra {

/// ErrorCode::mismatch unless `pvs` was baked from exactly this scene. The message says whether another scene was
/// baked, or this one before its geometry, flags or sides changed.
Status check_belongs(const Scene& scene, const Pvs& pvs);

/// The width of cracks that were closed in the scene before the bake (SceneOptions::crack_width), in scene units; 0: none.
double crack_width(const Pvs& pvs);
/// The guarantee in words for people: "exact", or "exact for cracks closed up to 0.01".
std::string describe_guarantee(const Pvs& pvs);

// -- verify: a .pvs against the truth ------------------------------------------------------------------------------

struct VerifyOptions {
    std::uint32_t samples = 200;  ///< viewpoints
    std::uint32_t face_size = 64; ///< a viewpoint sees six square pictures of that many pixels squared
    std::uint64_t seed = 1;
    std::uint32_t worst = 20; ///< longest list of the worst
};

/// An object that was seen from a viewpoint and is not in the answer for it.
struct FalseInvisible {
    Vec3d eye;
    std::int64_t cell = -1; ///< as PvsCursor::cell
    std::uint32_t object = 0;
    std::uint64_t pixels = 0; ///< confirmed ones
};

struct VerifyResult {
    std::uint64_t viewpoints = 0;
    std::uint64_t in_matter = 0; ///< random points that were no viewpoints and were drawn again
    std::uint64_t pixels = 0;    ///< rays of all viewpoints together
    /// Totals over the viewpoints. A false invisible pixel is one whose ray exact arithmetic has confirmed.
    std::uint64_t false_invisible_objects = 0, false_invisible_pixels = 0;
    /// Pixels against the file that exact arithmetic did not confirm: lines that graze an edge (measure zero), and
    /// lines that are blocked after all (the double-precision tracer rounded).
    std::uint64_t grazing_pixels = 0, unconfirmed_pixels = 0;
    /// Reported, but in no pixel of the viewpoint. Holds objects that only other viewpoints of the cell see and
    /// those smaller than a pixel, so that even an exact file has some.
    std::uint64_t false_visible_objects = 0;
    std::uint64_t reported_objects = 0, seen_objects = 0;
    std::vector<FalseInvisible> worst; ///< most pixels first
};

/// Random viewpoints, uniform over the baked cells, each with a full panorama; a view tree is asked face by face, so
/// that what it knows about directions is verified too. Refuses what check_belongs() refuses. The result is
/// a function of the arguments alone. ErrorCode::usage if no baked cell holds a viewpoint.
Result<VerifyResult> verify(const Scene& scene, const Pvs& pvs, const VerifyOptions& options = {}, const Job& job = {});

// -- walk: methods of culling along a camera path ------------------------------------------------------------------

enum class PathKind : std::uint8_t {
    automatic, ///< a walk, or an orbit where there is nowhere to stand
    orbit,     ///< once around the scene, looking at its middle: for parts and machines
};

struct PathOptions {
    PathKind kind = PathKind::automatic;
    std::uint32_t frames = 120;
    std::uint64_t seed = 1;
    double eye_height = 0; ///< above the floor, scene units; 0: guessed from the heights of the rooms
    double step = 0;       ///< way from frame to frame, scene units; 0: at most half the eye height
    double fov_y_deg = 60;
};

struct FoundPath {
    std::vector<View> views; ///< local coordinates, near plane 0
    /// How it came about, one sentence: "walks 61 units through rooms at eye height 1.6", or an orbit around a scene
    /// without anywhere to stand.
    std::string description;
};

/// A walk through free space: at eye height over floors, outside matter, away from walls, without jumps, looking
/// ahead, preferring what was not visited yet. A pure function of (scene, options). About a second.
Result<FoundPath> find_path(const Scene& scene, const PathOptions& options = {}, const Job& job = {});

struct WalkOptions {
    /// Names of culler_names(). `frustum` is always among the methods of the result: the others are compared with it.
    std::vector<std::string> methods{"none", "frustum"};
    std::uint32_t width = 640, height = 360;
    std::uint32_t repeat = 3;      ///< times that the whole walk is timed
    std::uint32_t truth_scale = 1; ///< the item buffer has that many times the picture's width and height, 1..8
    const Pvs* pvs = nullptr;      ///< for the methods that ask a baked file; must belong to the scene
    std::uint32_t occluders = 0;   ///< per frame, for the methods that choose some; 0: their default
    OccluderChoice occluder_choice = OccluderChoice::area_angle; ///< of the methods that choose
    OcclusionTreeOptions tree;     ///< for the methods with occlusion trees
    bool draw = true;              ///< measure drawing, if there is an OpenGL
    std::uint64_t snapshot_bytes = 2'000'000; ///< upper bound of what WalkResult::snapshots holds
};

/// One method at one frame. Times in milliseconds are the fastest of the repetitions; negative: not measured.
struct WalkSample {
    double cull_ms = -1, draw_ms = -1;
    std::uint32_t objects_reported = 0;
    std::uint64_t triangles_drawn = 0;
    std::uint32_t false_visible_objects = 0;                  ///< reported, but in no pixel
    std::uint32_t false_invisible_objects = 0;                ///< in a confirmed pixel, but not reported
    std::uint64_t false_invisible_pixels = 0;                 ///< confirmed by exact arithmetic
    std::uint64_t grazing_pixels = 0, unconfirmed_pixels = 0; ///< against the method, but not confirmed
    std::uint32_t culled_of_frustum = 0; ///< objects that `frustum` reports and this method does not

    double frame_ms() const { return draw_ms < 0 ? -1 : cull_ms + draw_ms; }
};

struct WalkFrame {
    View view;              ///< local
    bool in_matter = false; ///< no viewpoint by the rule of the bake: a baked answer promises nothing here
    std::uint32_t objects_true = 0, objects_in_frustum = 0;
    std::uint64_t triangles_true = 0; ///< of the true objects, all their triangles
    double empty_ms = -1;             ///< drawing nothing
    double ceiling_ms = -1;           ///< drawing the true objects alone: no culling of objects draws faster
    std::vector<WalkSample> methods;  ///< as WalkResult::methods
};

/// A method over the whole walk. Means per frame, the false invisible as totals.
struct WalkMethod {
    std::string name;
    Guarantee guarantee = Guarantee::approximate;
    bool from_region = false; ///< its answers come from baked cells: frames in matter are left out of its judgement
    double cull_ms_median = -1, cull_ms_p99 = -1, draw_ms_median = -1, frame_ms_median = -1;
    double objects_reported = 0, triangles_drawn = 0, culled_of_frustum = 0, false_visible_objects = 0;
    std::uint64_t false_invisible_objects = 0, false_invisible_pixels = 0;
    std::uint64_t grazing_pixels = 0, unconfirmed_pixels = 0;
    double speedup_over_frustum = -1; ///< ratio of the medians of frame_ms; negative: not measured
};

/// What was seen and what was reported at one frame, as bit sets over objects.
struct WalkSnapshot {
    std::uint32_t frame = 0;
    std::string why; ///< of a notable frame: what makes it worth a look
    std::vector<std::uint64_t> seen;
    std::vector<std::vector<std::uint64_t>> reported; ///< as WalkResult::methods
};

struct WalkResult {
    std::uint32_t width = 0, height = 0, repeat = 0, truth_scale = 1;
    std::vector<WalkMethod> methods;
    std::vector<WalkFrame> frames;
    std::vector<WalkSnapshot> snapshots; ///< evenly spread over the frames, as many as the bound allows
    std::vector<WalkSnapshot> notable;   ///< at most three frames: most culled, most pixels lost, most triangles seen
    double objects_true = 0, triangles_true = 0; ///< means per frame
    double empty_ms_median = -1, ceiling_ms_median = -1;
    double ceiling_speedup = -1; ///< of the ceiling over `frustum`, culling for free
    std::uint64_t truth_pixels = 0;
    std::uint32_t frames_in_matter = 0;
    double occluder_seconds = 0;    ///< finding the scene's occluders, once before the walk
    std::string renderer;           ///< of the draw times; empty: nothing was drawn
    std::vector<std::string> notes; ///< what the reader of the numbers should know
};

/// Walks `path` (local coordinates; its aspects, near and far planes are not read) with every method. First the truth
/// of each frame and the judgement of each method's answer; then `repeat` timed walks in which all methods cull and
/// draw each frame one after the other, in turning order, so that noise hits all alike. Everything but the times is a
/// pure function of the arguments.
Result<WalkResult> walk(const Scene& scene, std::span<const View> path, const WalkOptions& options = {},
                        const Job& job = {});

/// The first method that promises not to lose pixels and lost some, or nullptr.
const WalkMethod* find_broken_promise(const WalkResult& result);

// -- prove: many random frames of every method ---------------------------------------------------------------------

struct ProofResult;

struct ProofOptions {
    /// Names of culler_names(); empty: all but `none`, `frustum-scalar` and `pvs` (which joins where `pvs` is given).
    std::vector<std::string> methods;
    std::uint64_t frames = 1000;
    std::uint32_t width = 160, height = 90; ///< of the picture; the truth has truth_scale times as many pixels a side
    std::uint32_t truth_scale = 4;          ///< 1..8
    std::uint32_t aimed = 1000; ///< lines of sight per frame and method aimed at objects that it hides
    std::uint64_t seed = 1;
    const Pvs* pvs = nullptr;
    std::uint32_t occluders = 0; ///< as WalkOptions::occluders
    /// Called after every block of frames with all that is proved so far: where to save it.
    std::function<Status(const ProofResult&)> keep;
};

/// What one method did with the frames. A lost pixel is a line of sight, confirmed by exact arithmetic, that sees an
/// object which the method did not report although it lies in the frustum.
struct ProofMethod {
    std::string name;
    Guarantee guarantee = Guarantee::approximate;
    std::uint64_t frames = 0;               ///< judged
    std::uint64_t in_frustum = 0, hidden = 0; ///< objects, totals
    std::uint64_t pixels = 0, aimed = 0;    ///< lines of sight that were asked
    std::uint64_t lost_objects = 0, lost_pixels = 0;
    std::uint64_t grazing_pixels = 0, unconfirmed_pixels = 0; ///< against the method, but no proof: see LostPixels
};

/// A frame in which a method lost something, to look at again.
struct ProofLoss {
    std::string method;
    std::uint64_t frame = 0;
    View view; ///< local
    std::uint32_t object = 0;
    std::uint64_t pixels = 0;
};

struct ProofResult {
    std::vector<ProofMethod> methods;
    std::uint64_t seen_objects = 0; ///< totals over the frames
    std::vector<ProofLoss> losses;  ///< the first ones, at most 20
};

/// Frames come in blocks of that many; every block begins with empty caches and is a pure function of (scene, seed,
/// its number), so that proofs can go on where they stopped.
inline constexpr std::uint64_t kProofBlock = 64;

/// Judges every method on random frames by the truth: places where one can stand, close to surfaces, in planes of the
/// scene, inside matter and outside; any direction and roll; fields of view from 5 to 150 degrees; orthographic views;
/// near planes of zero and more; moving in small steps and in jumps, so that caches are tried, too. Continues `result`:
/// methods that it holds go on from their number of frames. ErrorCode::cancelled, `result` being whole up to a block.
Status prove(const Scene& scene, const ProofOptions& options, ProofResult& result, const Job& job = {});

struct ReportOptions {
    std::string path_description;    ///< of FoundPath
    std::uint32_t plan_pixels = 640; ///< along the longer side of the view from above
    std::span<const Study> studies;  ///< shown after the walk
};

/// The walk as one HTML page that opens from disk and loads nothing: tables, plots, pictures with culling off and on,
/// and the scene from above with what was culled. `pvs` may be nullptr. ErrorCode::cancelled if job says so.
Result<std::string> make_report(const Scene& scene, const Pvs* pvs, const WalkResult& result,
                                const ReportOptions& options = {}, const Job& job = {});

/// May `guarantee` lose pixels? False for exact and conservative.
bool may_lose_pixels(Guarantee guarantee);

} // namespace antumbra
