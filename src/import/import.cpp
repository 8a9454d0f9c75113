#include <antumbra/import.hpp>
#include <antumbra/quake3.hpp>

#include "import/assimp_scene.hpp"
#include "import/uri.hpp"

#include "base/file.hpp"

#include <algorithm>
#include <cctype>

namespace antumbra {
namespace {

std::string ending_of(const std::string& path) {
    std::size_t dot = path.find_last_of("./");
    if (dot == std::string::npos || path[dot] != '.')
        return {};
    std::string ending = path.substr(dot + 1);
    std::transform(ending.begin(), ending.end(), ending.begin(),
                   [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
    return ending;
}

} // namespace

Result<RawScene> import_file(const std::string& path, const ImportOptions& options) {
    std::string ending = ending_of(path);
    bool gltf = ending == "glb" || ending == "gltf", obj = ending == "obj", bsp = ending == "bsp";
    bool ply = ending == "ply", stl = ending == "stl";
    if (!gltf && !obj && !bsp && !ply && !stl && !is_assimp_ending(ending))
        return Status(ErrorCode::unsupported, path + ": '." + ending + "' is not read; convert to .glb or .obj");
    Result<MappedFile> file = MappedFile::open(path, options.limits.bytes);
    if (!file)
        return file.status();
    if (gltf)
        return import_gltf(file->bytes(), path, folder_of(path), options);
    if (ply)
        return import_ply(file->bytes(), path, options);
    if (stl)
        return import_stl(file->bytes(), path, options);
    if (is_assimp_ending(ending))
        return import_with_assimp(file->bytes(), ending, path, options);
    if (bsp) {
        Result<Quake3Map> map = import_quake3(file->bytes(), path, options);
        if (!map)
            return map.status();
        return std::move(map->scene);
    }
    return import_obj(file->bytes(), path, folder_of(path), options);
}

Result<Scene> load_scene(const std::string& path, const ImportOptions& options, const SceneOptions& scene_options) {
    Result<RawScene> raw = import_file(path, options);
    if (!raw)
        return raw.status();
    return Scene::create(std::move(*raw), scene_options);
}

} // namespace antumbra
