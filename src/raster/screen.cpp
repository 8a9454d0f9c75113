#include "raster/screen.hpp"

#include <algorithm>

namespace antumbra {
namespace {

int whole_tiles(double pixels) { return static_cast<int>(std::clamp(std::ceil(pixels / kTile), 1.0, 256.0)) * kTile; }

} // namespace

Screen make_screen(const Camera& camera, int width, double extent) {
    int across = whole_tiles(width);
    return make_screen(camera, across, whole_tiles(double(across) * camera.half_height / camera.half_width), extent);
}

Screen make_screen(const Camera& camera, int width, int height, double extent) {
    Screen screen;
    screen.camera = camera;
    screen.width = whole_tiles(width);
    screen.height = whole_tiles(height);
    screen.tiles_x = screen.width / kTile;
    screen.tiles_y = screen.height / kTile;
    screen.scale_x = screen.width / (2 * camera.half_width);
    screen.scale_y = screen.height / (2 * camera.half_height);
    screen.centre_x = screen.width / 2.0;
    screen.centre_y = screen.height / 2.0;
    double smallest = 1e-7 * (extent + length(camera.eye));
    screen.clip_depth = camera.orthographic ? camera.near_plane : std::max(camera.near_plane, smallest);
    screen.depth_slack = 1e-9 * (extent + length(camera.eye));
    screen.orthographic_slack = camera.orthographic ? extent + length(camera.eye) : 0;
    return screen;
}

BoxOnScreen project_box(const Screen& screen, const Box3f& box) {
    const Camera& camera = screen.camera;
    // Corner coordinates are sums of one term per axis; each term has two values.
    double x[2][3], y[2][3], z[2][3];
    for (int axis = 0; axis < 3; ++axis)
        for (int side = 0; side < 2; ++side) {
            double offset = double(side ? box.max[axis] : box.min[axis]) - camera.eye[axis];
            x[side][axis] = camera.right[axis] * offset;
            y[side][axis] = camera.up[axis] * offset;
            z[side][axis] = camera.forward[axis] * offset;
        }
    double nearest = std::min(z[0][0], z[1][0]) + std::min(z[0][1], z[1][1]) + std::min(z[0][2], z[1][2]);
    BoxOnScreen result;
    // NaN and anything near the clip depth stay untestable. The relative margin covers rounding of the sum.
    double reach = 0;
    for (int axis = 0; axis < 3; ++axis)
        reach += std::max(std::abs(z[0][axis]), std::abs(z[1][axis]));
    nearest -= 1e-13 * reach;
    if (!(nearest > screen.clip_depth))
        return result;
    double min_x = 1e300, max_x = -1e300, min_y = 1e300, max_y = -1e300;
    for (int corner = 0; corner < 8; ++corner) {
        int a = corner & 1, b = corner >> 1 & 1, c = corner >> 2;
        double scale = camera.orthographic ? 1 : 1 / (z[a][0] + z[b][1] + z[c][2]);
        double sx = (x[a][0] + x[b][1] + x[c][2]) * scale, sy = (y[a][0] + y[b][1] + y[c][2]) * scale;
        min_x = std::min(min_x, sx);
        max_x = std::max(max_x, sx);
        min_y = std::min(min_y, sy);
        max_y = std::max(max_y, sy);
    }
    constexpr double kOutward = 0x1p-8; // pixels: rounding of the projection and of the conversion to float
    auto pixel = [](double value) { return static_cast<float>(std::clamp(value, -1e6, 1e6)); };
    result.testable = true;
    result.min_x = pixel(screen.centre_x + min_x * screen.scale_x - kOutward);
    result.max_x = pixel(screen.centre_x + max_x * screen.scale_x + kOutward);
    result.min_y = pixel(screen.centre_y + min_y * screen.scale_y - kOutward);
    result.max_y = pixel(screen.centre_y + max_y * screen.scale_y + kOutward);
    result.nearness = static_cast<float>(screen.surely_above(screen.nearness(nearest)));
    return result;
}

} // namespace antumbra
