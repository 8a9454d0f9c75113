// GLB and glTF from memory. The first byte chooses the up axis; the camera animation is sampled, too.
#include "whole_path.hpp"

#include <antumbra/camera.hpp>

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
    using namespace antumbra;
    if (size == 0)
        return 0;
    std::span<const std::byte> bytes = std::as_bytes(std::span(data + 1, size - 1));
    ImportOptions options = fuzz::small_limits();
    options.up_axis = data[0] & 1 ? UpAxis::z : UpAxis::y;
    fuzz::go_on_with(import_gltf(bytes, "fuzz.glb", "", options));
    CameraPathOptions path;
    path.frames = 1000;
    (void)sample_gltf_camera(bytes, "fuzz.glb", "", path);
    return 0;
}
