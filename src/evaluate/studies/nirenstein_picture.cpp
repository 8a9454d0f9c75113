#include "evaluate/studies/nirenstein_picture.hpp"

#include "base/parallel.hpp"
#include "evaluate/item_buffer.hpp"
#include "evaluate/report/image_coding.hpp"

#include <antumbra/export.hpp>

#include <cmath>

namespace antumbra {
namespace {

using Colour = std::array<double, 3>;
constexpr Colour kSeen{30, 190, 50}, kHidden{215, 45, 40}, kCell{250, 215, 20}, kSky{255, 255, 255};
constexpr int kSamples = 3; ///< along either side of a pixel: edges of thin things stay visible

/// Does the ray enter the box before `limit`?
bool enters(const Ray& ray, const Box3d& box, double limit) {
    double first = 0, last = limit;
    for (int k = 0; k < 3; ++k) {
        if (ray.direction[k] == 0) {
            if (ray.origin[k] < box.min[k] || ray.origin[k] > box.max[k])
                return false;
            continue;
        }
        double a = (box.min[k] - ray.origin[k]) / ray.direction[k], b = (box.max[k] - ray.origin[k]) / ray.direction[k];
        first = std::max(first, std::min(a, b));
        last = std::min(last, std::max(a, b));
    }
    return first <= last;
}

/// What a ray meets, lit from the viewer.
Colour colour_of(const Tracer& tracer, const Ray& ray, const Box3d& cell, const std::vector<std::uint64_t>& visible) {
    const Scene& scene = tracer.scene();
    bool back = false;
    Hit hit = tracer.nearest_surface(ray, back);
    if (enters(ray, cell, hit ? hit.t : std::numeric_limits<double>::infinity()))
        return kCell;
    if (!hit)
        return kSky;
    Vec3d a = scene.vertex(hit.triangle, 0), b = scene.vertex(hit.triangle, 1), c = scene.vertex(hit.triangle, 2);
    Vec3d normal = cross(b - a, c - a);
    double light = 0.45 + 0.55 * std::abs(dot(normal, ray.direction)) / (length(normal) * length(ray.direction) + 1e-300);
    Colour colour = has_bit(visible, hit.triangle) ? kSeen : kHidden;
    for (double& part : colour)
        part *= light;
    return colour;
}

/// From above, near enough to tell the cell, and so that what is visible from it fills the picture.
View view_of(const Scene& scene, const Box3d& cell, const std::vector<std::uint64_t>& visible, double aspect) {
    std::vector<double> reach[2]; // along x and z, of what is visible
    for (std::uint32_t t = 0; t < scene.triangles().size(); ++t)
        if (has_bit(visible, t)) {
            Vec3d centre = (scene.vertex(t, 0) + scene.vertex(t, 1) + scene.vertex(t, 2)) * (1.0 / 3);
            reach[0].push_back(std::abs(centre.x - cell.centre().x));
            reach[1].push_back(std::abs(centre.z - cell.centre().z));
        }
    double size = 0.1 * length(scene.world_bounds().size());
    for (auto& list : reach)
        if (!list.empty()) { // nine tenths of it: the last are far away and small
            auto at = list.begin() + std::ptrdiff_t(list.size() * 9 / 10);
            std::nth_element(list.begin(), at, list.end());
            size = std::max(size, 2 * *at);
        }
    View view;
    view.target = cell.centre();
    view.fov_y_deg = 40;
    double distance = 0.75 * size / std::tan(20 * 3.14159265358979 / 180) / std::min(1.0, aspect);
    view.eye = view.target + normalized(Vec3d{0.35, 1, 0.75}) * distance;
    view.near_plane = distance * 1e-3;
    return view;
}

Image draw(const Tracer& tracer, const View& view, const Box3d& cell, const std::vector<std::uint64_t>& visible,
           const StudyOptions& options, const Job& job) {
    PixelRays rays = PixelRays::of_view(view, options.width, options.height);
    Image image{options.width, options.height, std::vector<std::uint8_t>(std::size_t(3) * options.width * options.height)};
    parallel_for(options.height, job, [&](std::size_t y, unsigned) {
        for (std::uint32_t x = 0; x < options.width; ++x) {
            Colour sum{0, 0, 0};
            for (int s = 0; s < kSamples * kSamples; ++s) {
                Ray ray = rays.at(x + (s % kSamples + 0.5) / kSamples, double(y) + (s / kSamples + 0.5) / kSamples);
                Colour one = colour_of(tracer, ray, cell, visible);
                for (std::size_t k = 0; k < 3; ++k)
                    sum[k] += one[k] / (kSamples * kSamples);
            }
            for (std::size_t k = 0; k < 3; ++k)
                image.rgb[3 * (y * options.width + x) + k] = std::uint8_t(std::lround(sum[k]));
        }
    });
    return image;
}

Result<std::vector<std::byte>> drawing_of(const Scene& scene, const Box3d& cell, const std::vector<std::uint64_t>& visible) {
    std::vector<DrawingPart> parts = {{"visible", {0.013F, 0.515F, 0.032F, 1}, false, {}, {}},
                                      {"hidden", {0.679F, 0.026F, 0.021F, 1}, false, {}, {}},
                                      {"cell", {0.956F, 0.679F, 0.007F, 1}, false, {}, {}}};
    for (std::uint32_t t = 0; t < scene.triangles().size(); ++t) {
        DrawingPart& part = parts[has_bit(visible, t) ? 0 : 1];
        for (int corner = 0; corner < 3; ++corner) {
            part.indices.push_back(static_cast<std::uint32_t>(part.positions.size()));
            part.positions.push_back(scene.to_world(scene.vertex(t, corner)));
        }
    }
    static constexpr std::uint32_t faces[6][4] = {{0, 4, 6, 2}, {1, 3, 7, 5}, {0, 1, 5, 4},
                                                  {2, 6, 7, 3}, {0, 2, 3, 1}, {4, 5, 7, 6}};
    for (int corner = 0; corner < 8; ++corner)
        parts[2].positions.push_back(scene.to_world(cell.corner(corner)));
    for (const auto& f : faces)
        parts[2].indices.insert(parts[2].indices.end(), {f[0], f[1], f[2], f[0], f[2], f[3]});
    return export_drawing(parts);
}

} // namespace

Result<StudyPicture> seen_from_cell(const Tracer& tracer, const Box3d& cell, const std::vector<std::uint64_t>& visible,
                                    const StudyOptions& options, const Job& job) {
    StudyPicture picture;
    picture.caption = "Figure 5: the first of the cells (yellow), what is visible from it (green) and what is not (red).";
    View view = view_of(tracer.scene(), cell, visible, double(options.width) / options.height);
    picture.png = encode_png(draw(tracer, view, cell, visible, options, job));
    Result<std::vector<std::byte>> drawing = drawing_of(tracer.scene(), cell, visible);
    if (!drawing)
        return drawing.status();
    picture.glb = std::move(*drawing);
    return picture;
}

} // namespace antumbra
