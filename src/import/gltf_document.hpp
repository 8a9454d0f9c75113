// The JSON of a glTF 2.0 file as plain structs. Every index in them lies in range and every number has its type;
// whether byte ranges fit their buffers is proved later, by those who touch bytes (gltf_buffers, gltf_accessors).
#pragma once

#include "import/json_text.hpp"

#include <antumbra/import.hpp>

#include <array>
#include <cstdint>
#include <string>
#include <vector>

namespace antumbra::gltf {

enum class ComponentType : std::uint16_t { i8 = 5120, u8 = 5121, i16 = 5122, u16 = 5123, u32 = 5125, f32 = 5126 };
std::uint32_t size_of(ComponentType type);

struct Buffer {
    std::string uri;
    bool has_uri = false;
    std::uint64_t bytes = 0;
};

enum class MeshoptMode : std::uint8_t { attributes, triangles, indices };
enum class MeshoptFilter : std::uint8_t { none, octahedral, quaternion, exponential };

/// EXT_meshopt_compression: the view's bytes are `count` elements of `stride` bytes, to be decoded from a range of
/// another buffer.
struct Meshopt {
    bool used = false;
    std::int32_t buffer = -1;
    std::uint64_t offset = 0, bytes = 0, count = 0, stride = 0;
    MeshoptMode mode = MeshoptMode::attributes;
    MeshoptFilter filter = MeshoptFilter::none;
};

struct BufferView {
    std::int32_t buffer = -1;
    std::uint64_t offset = 0, bytes = 0;
    std::uint32_t stride = 0; ///< 0: elements follow each other
    Meshopt meshopt;
};

struct Sparse {
    std::uint64_t count = 0; ///< 0: not sparse
    std::int32_t index_view = -1, value_view = -1;
    std::uint64_t index_offset = 0, value_offset = 0;
    ComponentType index_type = ComponentType::u32;
};

struct Accessor {
    std::int32_t view = -1; ///< -1: zeros
    std::uint64_t offset = 0, count = 0;
    ComponentType type = ComponentType::f32;
    std::uint8_t components = 1;
    bool normalized = false;
    Sparse sparse;
};

/// The flags that authors may set in `extras` (see import.hpp).
struct Flags {
    bool never_cull = false, never_occlude = false, ignore = false;
    Flags operator|(const Flags& b) const {
        return {never_cull || b.never_cull, never_occlude || b.never_occlude, ignore || b.ignore};
    }
};

struct Material {
    bool see_through = false; ///< masked, blended or transmissive: hides nothing
    bool double_sided = false;
    Flags flags;
};

struct Primitive {
    std::int32_t position = -1, indices = -1, material = -1;
    std::uint32_t mode = 4;
    bool morphed = false;
    std::vector<std::int32_t> variant_materials; ///< KHR_materials_variants
    std::int32_t draco_view = -1;                ///< KHR_draco_mesh_compression; -1: plain accessors
    std::uint32_t draco_position = 0;            ///< id of the positions within the Draco stream
};

struct Mesh {
    std::string name;
    Flags flags;
    std::vector<Primitive> primitives;
};

/// Affine: p -> linear * p + translation, linear in rows.
struct Transform {
    std::array<Vec3d, 3> rows{{{1, 0, 0}, {0, 1, 0}, {0, 0, 1}}};
    Vec3d translation;

    Vec3d point(const Vec3d& p) const {
        return Vec3d{dot(rows[0], p), dot(rows[1], p), dot(rows[2], p)} + translation;
    }
    double determinant() const { return dot(rows[0], cross(rows[1], rows[2])); }
    /// This after `inner`.
    Transform operator*(const Transform& inner) const;
};

/// Translation, unit quaternion (x, y, z, w) and scale; a quaternion that is not of unit length is taken as it is,
/// the way renderers do.
struct Placement {
    Vec3d translation;
    std::array<double, 4> rotation{0, 0, 0, 1};
    Vec3d scale{1, 1, 1};
    Transform transform() const;
};

struct Node {
    std::string name;
    std::int32_t parent = -1, mesh = -1, camera = -1;
    std::vector<std::int32_t> children;
    bool has_matrix = false;
    Transform matrix;    ///< if has_matrix
    Placement placement; ///< else
    bool skinned = false, hidden = false;
    bool animated = false;         ///< this node's own transform
    bool weights_animated = false; ///< its mesh's morph targets
    bool instanced = false;        ///< EXT_mesh_gpu_instancing
    std::int32_t instance_translation = -1, instance_rotation = -1, instance_scale = -1;
    Flags flags;

    Transform local() const { return has_matrix ? matrix : placement.transform(); }
};

struct Camera {
    double fov_y = 0; ///< radians; 0: orthographic
};

enum class Interpolation : std::uint8_t { linear, step, cubic_spline };
enum class Path : std::uint8_t { translation, rotation, scale, weights, other };

struct Channel {
    std::int32_t node = -1;
    Path path = Path::other;
    std::int32_t input = -1, output = -1; ///< accessors
    Interpolation interpolation = Interpolation::linear;
};

struct Animation {
    std::vector<Channel> channels;
};

struct Document {
    std::vector<Buffer> buffers;
    std::vector<BufferView> views;
    std::vector<Accessor> accessors;
    std::vector<Material> materials;
    std::vector<Mesh> meshes;
    std::vector<Node> nodes;
    std::vector<Camera> cameras;
    std::vector<Animation> animations;
    std::vector<std::int32_t> roots; ///< of the scene that is shown
};

/// Messages name the place in the JSON, e.g. "accessors[12].bufferView: ..".
Result<Document> read_document(const Json& json);

} // namespace antumbra::gltf
