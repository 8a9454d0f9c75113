// Camera paths and boxes from JSON.
#include <antumbra/camera.hpp>

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
    using namespace antumbra;
    std::span<const std::byte> bytes = std::as_bytes(std::span(data, size));
    CameraPathOptions options;
    options.frames = 1000;
    (void)parse_camera_path(bytes, "fuzz.json", options);
    (void)parse_boxes(bytes, "fuzz.json");
    return 0;
}
