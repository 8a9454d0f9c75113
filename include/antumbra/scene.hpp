// The scene: what a user draws or hides, as triangles in one flat structure of arrays.
//
// An importer or generator fills a RawScene; Scene::create validates it once, snaps every coordinate once to a
// grid of 24 bits per axis and freezes it. Everything after that (rays, bake, truth, fingerprints) sees only the
// snapped scene, so that all parts of the toolkit speak of exactly the same geometry.
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

/// Who an object is, in the terms of the file it came from. -1 where the file has no such notion.
struct ObjectId {
    std::int32_t node = -1;
    std::int32_t primitive = -1;
    std::int32_t instance = -1; ///< index within EXT_mesh_gpu_instancing, else -1
    constexpr bool operator==(const ObjectId&) const = default;
};

/// Bits of Object::flags. Stored in .pvs files: the numbers never change.
enum ObjectFlag : std::uint32_t {
    kOccludes = 1u << 0,      ///< blocks sight (opaque, rigid, and not told otherwise)
    kDoubleSided = 1u << 1,   ///< seen, and occludes, from both sides; else only from its front
    kAlwaysVisible = 1u << 2, ///< never culled: moving, deforming, lost by snapping, or told so
    kMoves = 1u << 3,         ///< animated, skinned or morphed: bounds are those of the rest pose
};

using TriangleIndices = std::array<std::uint32_t, 3>;

/// An object as an importer gives it. Its triangles are contiguous in RawScene::triangles and their winding is
/// already that of world space (counter-clockwise seen from the front).
struct RawObject {
    ObjectId id;
    std::string name;
    std::uint32_t flags = kOccludes;
    std::uint32_t first_triangle = 0;
    std::uint32_t triangle_count = 0;
};

/// One oddity of a scene, counted. `example` says where one of them is.
struct Finding {
    std::string kind;
    std::uint64_t count = 0;
    std::string example;
};

/// Finding::kind of SceneOptions::count_cracks: two places of different objects that lay nearer than half a grid step along
/// every axis before snapping, and are apart after it.
inline constexpr const char* kCrackOpened = "crack opened by snapping";

/// What importers and generators produce: untrusted until Scene::create has looked at it.
struct RawScene {
    std::string source; ///< file name or generator call, for messages
    std::vector<Vec3d> positions;
    std::vector<TriangleIndices> triangles;
    std::vector<RawObject> objects;
    std::vector<Finding> findings; ///< what the reader itself noticed
};

enum class SidesOption : std::uint8_t {
    material, ///< as the file says; formats without the notion: both
    both,     ///< every face is seen and occludes from both sides
};

struct SceneOptions {
    SidesOption sides = SidesOption::material;
    /// Shell-like patterns (`*`, `?`) over object names.
    std::vector<std::string> never_cull, never_occlude, ignore;
    /// Close cracks up to so wide (scene units) between triangles that hide others; 0: take the scene as it is. What is
    /// said of the scene then holds for the repaired one: not for sight lines through such cracks.
    double crack_width = 0;
    /// Count the cracks that snapping opens between objects, as a finding. O(n log n).
    bool count_cracks = false;
};

struct Object {
    ObjectId id;
    std::uint32_t flags = 0;
    std::uint32_t first_triangle = 0; ///< into Scene::triangles()
    std::uint32_t triangle_count = 0; ///< triangles that are left after snapping, and those that close cracks behind them
    std::uint32_t source_triangles = 0; ///< triangles in the file, degenerate ones included
    Box3f bounds;                     ///< local; holds the unsnapped positions too (grown by one grid step)

    bool has(ObjectFlag flag) const { return (flags & flag) != 0; }
};

/// 128-bit hash of everything that decides visibility.
using Fingerprint = std::array<std::uint8_t, 16>;
std::string to_hex(const Fingerprint& fingerprint);

/// Immutable after create(); safe to read from any number of threads.
///
/// Local coordinates are world coordinates minus origin(), in the scene's own units. Each local coordinate of a
/// vertex is a whole multiple of step() (a power of two) of magnitude below 2^23 steps: exact in float, and
/// origin() + local is exact in double unless the scene lies more than 2^29 times its own size from the origin.
class Scene {
  public:
    /// Validates (index ranges, finite coordinates, at least one triangle), applies the options, snaps, drops
    /// triangles without area and computes both fingerprints. O(triangles). An object that has lost all its
    /// triangles keeps its place and becomes kAlwaysVisible: what snapping cannot represent is never culled.
    static Result<Scene> create(RawScene raw, const SceneOptions& options = {});

    const std::string& source() const { return source_; }
    Vec3d origin() const { return origin_; }
    double step() const { return step_; }
    Vec3d to_local(const Vec3d& world) const { return world - origin_; }
    Vec3d to_world(const Vec3d& local) const { return local + origin_; }
    Box3f local_bounds() const { return bounds_; }
    Box3d world_bounds() const;

    std::span<const Vec3f> positions() const { return positions_; } ///< local
    std::span<const TriangleIndices> triangles() const { return triangles_; }
    std::span<const Object> objects() const { return objects_; }
    /// Index of the object of each triangle.
    std::span<const std::uint32_t> triangle_objects() const { return triangle_objects_; }
    /// Number of each triangle within its object in the file, degenerate ones counted: what a renderer's index buffer has
    /// at three times this place. Those that close cracks go on from Object::source_triangles. Ascends within an object.
    std::span<const std::uint32_t> triangle_sources() const { return triangle_sources_; }
    std::string_view name(std::uint32_t object) const { return names_[object]; }
    SidesOption sides() const { return sides_; }
    double crack_width() const { return crack_width_; } ///< SceneOptions::crack_width

    Vec3d vertex(std::uint32_t triangle, int corner) const {
        return to_double(positions_[triangles_[triangle][static_cast<std::size_t>(corner)]]);
    }
    const Object& object_of(std::uint32_t triangle) const { return objects_[triangle_objects_[triangle]]; }

    /// Hash of snapped geometry, flags, sides, ids and order: equal fingerprints see the same.
    const Fingerprint& fingerprint() const { return fingerprint_; }
    /// Cheap hash (FNV-1a, 64 bits) of (node, primitive, instance, triangles in the file) of every object in
    /// order: what a viewer can compute from the file's headers alone to notice a stale bake.
    std::uint64_t structure_fingerprint() const { return structure_fingerprint_; }

    /// What the reader and create() noticed. See validate() for the findings that cost more to search.
    std::span<const Finding> findings() const { return findings_; }

  private:
    Scene() = default;
    Status close_cracks(double width);
    std::string source_;
    Vec3d origin_;
    double step_ = 1;
    Box3f bounds_;
    SidesOption sides_ = SidesOption::material;
    double crack_width_ = 0;
    std::vector<Vec3f> positions_;
    std::vector<TriangleIndices> triangles_;
    std::vector<std::uint32_t> triangle_objects_, triangle_sources_;
    std::vector<Object> objects_;
    std::vector<std::string> names_;
    std::vector<Finding> findings_;
    Fingerprint fingerprint_{};
    std::uint64_t structure_fingerprint_ = 0;
};

/// Findings that need a search: duplicate triangles, boundary and non-manifold edges. O(n log n) time, about 40
/// bytes a triangle.
std::vector<Finding> validate(const Scene& scene);

} // namespace antumbra
