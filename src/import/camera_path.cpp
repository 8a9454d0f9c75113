#include <antumbra/camera.hpp>

#include "import/json_text.hpp"
#include "import/uri.hpp"

#include "base/file.hpp"

namespace antumbra {
namespace {

constexpr std::uint64_t kMostBoxes = 10'000'000;

Vec3d read_vector(const JsonObject& object, const char* key, const Vec3d& fallback, bool required) {
    std::array<double, 3> v{fallback.x, fallback.y, fallback.z};
    if (!object.reals(key, v) && required)
        object.fail(ErrorCode::corrupt, key, "is missing");
    return {v[0], v[1], v[2]};
}

CameraFrame read_frame(const JsonObject& object) {
    CameraFrame frame;
    frame.eye = read_vector(object, "eye", {}, true);
    frame.target = read_vector(object, "target", {}, true);
    frame.up = read_vector(object, "up", frame.up, false);
    frame.fov_y_deg = object.real("fov_y_deg", frame.fov_y_deg);
    if (!(frame.fov_y_deg > 0 && frame.fov_y_deg < 180))
        object.fail(ErrorCode::corrupt, "fov_y_deg", "must lie between 0 and 180");
    if (frame.eye == frame.target)
        object.fail(ErrorCode::corrupt, "target", "is where the eye is");
    if (cross(frame.target - frame.eye, frame.up) == Vec3d{})
        object.fail(ErrorCode::corrupt, "up", "must not be zero nor along the line of sight");
    return frame;
}

bool is_gltf(const std::string& path) {
    std::string ending = path.size() < 5 ? std::string() : path.substr(path.size() - 5);
    return ending == ".gltf" || (ending.size() == 5 && ending.substr(1) == ".glb");
}

} // namespace

Result<std::vector<CameraFrame>> parse_camera_path(std::span<const std::byte> text, const std::string& name,
                                                   const CameraPathOptions& options) {
    Result<Json> json = parse_json(text);
    if (!json)
        return json.status().in(name);
    Status status;
    JsonObject root(*json, "", status);
    std::vector<CameraFrame> frames;
    if (root.size_of("frames") > options.frames)
        root.fail(ErrorCode::limit, "frames", "are more than " + std::to_string(options.frames));
    if (root.size_of("frames") == 0)
        root.fail(ErrorCode::corrupt, "frames", "must hold at least one frame");
    root.for_each_object("frames", [&](const JsonObject& object, std::size_t) { frames.push_back(read_frame(object)); });
    if (!status)
        return status.in(name);
    return frames;
}

Result<std::vector<CameraFrame>> read_camera_path(const std::string& path, const CameraPathOptions& options) {
    Result<MappedFile> file = MappedFile::open(path, options.bytes);
    if (!file)
        return file.status();
    if (is_gltf(path))
        return sample_gltf_camera(file->bytes(), path, folder_of(path), options);
    return parse_camera_path(file->bytes(), path, options);
}

Result<std::vector<Box3d>> parse_boxes(std::span<const std::byte> text, const std::string& name) {
    Result<Json> json = parse_json(text);
    if (!json)
        return json.status().in(name);
    Status status;
    Json holder = Json::object();
    holder["boxes"] = std::move(*json);
    JsonObject root(holder, "", status);
    std::vector<Box3d> boxes;
    if (root.size_of("boxes") == 0)
        root.fail(ErrorCode::corrupt, "", "must be an array of at least one box {\"min\":[..],\"max\":[..]}");
    if (root.size_of("boxes") > kMostBoxes)
        root.fail(ErrorCode::limit, "", "holds more than " + std::to_string(kMostBoxes) + " boxes");
    root.for_each_object("boxes", [&](const JsonObject& object, std::size_t) {
        Box3d box{read_vector(object, "min", {}, true), read_vector(object, "max", {}, true)};
        if (box.empty())
            object.fail(ErrorCode::corrupt, "max", "must not be below min");
        boxes.push_back(box);
    });
    if (!status)
        return status.in(name);
    return boxes;
}

Result<std::vector<Box3d>> read_boxes(const std::string& path) {
    Result<MappedFile> file = MappedFile::open(path, CameraPathOptions().bytes);
    if (!file)
        return file.status();
    return parse_boxes(file->bytes(), path);
}

} // namespace antumbra
