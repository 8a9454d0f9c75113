// Where a viewer goes: camera paths, and the boxes in which viewers can be.
#pragma once

#include <antumbra/math.hpp>
#include <antumbra/scene.hpp>
#include <antumbra/status.hpp>

#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <vector>

namespace antumbra {

/// One view, in world coordinates. The eye is not the target, and up is not along the line of sight.
struct CameraFrame {
    Vec3d eye, target;
    Vec3d up{0, 1, 0};
    double fov_y_deg = 60; ///< in (0, 180)
};

struct CameraPathOptions {
    double frames_per_second = 30;      ///< at which a glTF animation is sampled
    std::uint64_t frames = 100'000;     ///< more are ErrorCode::limit
    std::uint64_t bytes = 1ull << 30;   ///< of all files together; more are ErrorCode::limit
    bool z_up = false;                  ///< glTF only: the scene is read with UpAxis::z
};

/// Reads by the file's ending: .glb and .gltf have their camera animation sampled, anything else is the JSON of
/// parse_camera_path. At least one frame.
Result<std::vector<CameraFrame>> read_camera_path(const std::string& path, const CameraPathOptions& options = {});

/// {"frames":[{"eye":[x,y,z],"target":[x,y,z],"up":[x,y,z],"fov_y_deg":60},..]}; `up` and `fov_y_deg` may be left
/// out.
Result<std::vector<CameraFrame>> parse_camera_path(std::span<const std::byte> json, const std::string& name,
                                                   const CameraPathOptions& options = {});

/// The first camera of a glTF file's shown scene that an animation moves, itself or through its ancestors, sampled
/// from time 0 to the end of the first animation that does so. LINEAR (rotations along the great arc), STEP and
/// CUBICSPLINE. Deterministic: no transcendental function is involved.
Result<std::vector<CameraFrame>> sample_gltf_camera(std::span<const std::byte> bytes, const std::string& name,
                                                    const std::string& folder,
                                                    const CameraPathOptions& options = {});

/// [{"min":[x,y,z],"max":[x,y,z]},..], at least one, each with min <= max in every axis.
Result<std::vector<Box3d>> read_boxes(const std::string& path);
Result<std::vector<Box3d>> parse_boxes(std::span<const std::byte> json, const std::string& name);

} // namespace antumbra
