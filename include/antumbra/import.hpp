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
    std::uint32_t node_depth = 256;
};

enum class UpAxis : std::uint8_t { y, z };

struct ImportOptions {
    ImportLimits limits;
    UpAxis up_axis = UpAxis::y; ///< z: (x, y, z) of the file becomes (x, z, -y)
};

/// Reads by the file's ending: .glb, .gltf, .obj.
Result<RawScene> import_file(const std::string& path, const ImportOptions& options = {});

/// glTF 2.0 from memory: GLB, or JSON with `folder` as the place of its external buffers ("" allows none).
Result<RawScene> import_gltf(std::span<const std::byte> bytes, const std::string& name,
                             const std::string& folder, const ImportOptions& options = {});
/// Wavefront OBJ, parsed in double. Groups (`o`, `g`) are objects; faces are seen from both sides. `folder` is
/// where its material libraries lie ("" reads none).
Result<RawScene> import_obj(std::span<const std::byte> bytes, const std::string& name,
                            const std::string& folder, const ImportOptions& options = {});

/// import_file, then Scene::create.
Result<Scene> load_scene(const std::string& path, const ImportOptions& options = {},
                         const SceneOptions& scene_options = {});

} // namespace antumbra
