// Readers. Every reader takes finite limits and treats its input as hostile: a bad file gives one Status that
// names the file, the place in it and the cure; nothing crashes, hangs or allocates without bound.
#pragma once

#include <antumbra/scene.hpp>

namespace antumbra {

/// Upper bounds on what a reader may accept. Exceeding one is ErrorCode::limit.
struct ImportLimits {
    std::uint64_t bytes = std::uint64_t(4) << 30;      ///< of all files of the scene together
    std::uint64_t vertices = 500'000'000;              ///< after instancing
    std::uint64_t triangles = 500'000'000;             ///< after instancing
    std::uint64_t objects = 20'000'000;
    std::uint64_t memory = std::uint64_t(8) << 30;     ///< bytes that the RawScene, and the JSON, may take
    std::uint32_t node_depth = 256;
};

enum class UpAxis : std::uint8_t { y, z };

struct ImportOptions {
    ImportLimits limits;
    UpAxis up_axis = UpAxis::y; ///< z: (x, y, z) of the file becomes (x, z, -y)
    std::uint32_t patch_levels = 4; ///< quads along each side of a Quake III patch of 3 x 3 points, 1..32
};

/// Reads by the file's ending: .glb, .gltf, .obj, .ply, .stl, .bsp (Quake III, see quake3.hpp), and through assimp
/// .off, .dae, .3ds, .fbx.
Result<RawScene> import_file(const std::string& path, const ImportOptions& options = {});

/// What each format becomes
///
/// glTF 2.0. One object per (node, primitive, instance) of the default scene (else the first, else all root nodes),
/// ids being the file's indices, in their order; `name` is the node's name, else the mesh's, else "node N", with
/// "/primitive P" if the mesh has several and "#I" for instances of EXT_mesh_gpu_instancing. Transforms are
/// multiplied in double; a negative determinant turns the winding. Read: all component types, normalised or not
/// (KHR_mesh_quantization), sparse accessors, strips, fans, external and data: buffers. Points and lines are left
/// out, with a finding. An unknown extension is refused (ErrorCode::unsupported) if the file requires it.
///
/// Never occluding, though seen: materials with alphaMode MASK or BLEND, KHR_materials_transmission with a factor,
/// _volume, _diffuse_transmission, an animated material, a KHR_materials_variants choice of which one does not
/// occlude, nodes hidden by KHR_node_visibility. Moving, hence always visible and never occluding (kMoves): what an
/// animation moves, itself or through an ancestor, what is skinned and what has morph targets.
///
/// Authors may set in `extras` of a node (it holds for all below it), mesh or material
///     {"antumbra": {"never_cull": true, "never_occlude": true, "ignore": true}}
/// or the same as plain properties "antumbra_never_cull", .. (true or 1).
///
/// External files (buffers, material libraries) are looked for in the scene's own folder and below: paths that are
/// absolute, hold "..", a scheme, a drive or a backslash, or lead out through a link, are refused.

/// glTF 2.0 from memory: GLB, or JSON with `folder` as the place of its external buffers ("" allows none).
Result<RawScene> import_gltf(std::span<const std::byte> bytes, const std::string& name,
                             const std::string& folder, const ImportOptions& options = {});
/// Wavefront OBJ, parsed in double. Groups (`o`, `g`) are objects; faces are seen from both sides. `folder` is
/// where its material libraries lie ("" reads none).
Result<RawScene> import_obj(std::span<const std::byte> bytes, const std::string& name,
                            const std::string& folder, const ImportOptions& options = {});

/// PLY, text or binary: one object of all faces, seen from both sides.
Result<RawScene> import_ply(std::span<const std::byte> bytes, const std::string& name,
                            const ImportOptions& options = {});
/// STL, text (an object per solid) or binary (one object); seen from both sides.
Result<RawScene> import_stl(std::span<const std::byte> bytes, const std::string& name,
                            const ImportOptions& options = {});

/// OFF, Collada, 3DS and FBX (`ending` in lower case, without a dot) by the optional library assimp. One
/// object per mesh of each node; seen from both sides; never occluding if its opacity is below 1 or has a texture;
/// moving if animated or skinned. Single precision: scenes far from the origin lose detail. Reads one file from
/// memory and nothing else. Up to 1 GiB. What comes out of assimp is checked; its inside is not ours to promise:
/// its Collada reader follows a null pointer on a damaged file of 700 bytes (fuzz_assimp). Hence it is an option of
/// the build, off by default: for files of unknown origin convert to glTF first, in a process of its own.
Result<RawScene> import_with_assimp(std::span<const std::byte> bytes, const std::string& ending,
                                    const std::string& name, const ImportOptions& options = {});

/// import_file, then Scene::create.
Result<Scene> load_scene(const std::string& path, const ImportOptions& options = {},
                         const SceneOptions& scene_options = {});

} // namespace antumbra
