#include "evaluate/report/pictures.hpp"

#include "evaluate/item_buffer.hpp"

#include <algorithm>

namespace antumbra {
namespace {

constexpr std::uint8_t kMagenta[3] = {230, 0, 200};
constexpr std::uint8_t kSky[3] = {209, 222, 235};

/// The picture without culling, greyed, with the pixels that differ in magenta.
Image paint_difference(const Image& off, const Image& on, std::uint64_t& differing) {
    Image image = off;
    for (std::size_t p = 0; p < image.rgb.size(); p += 3) {
        bool same = std::equal(off.rgb.begin() + std::ptrdiff_t(p), off.rgb.begin() + std::ptrdiff_t(p) + 3,
                               on.rgb.begin() + std::ptrdiff_t(p));
        differing += !same;
        int grey = (off.rgb[p] + off.rgb[p + 1] + off.rgb[p + 2]) / 3;
        for (std::size_t k = 0; k < 3; ++k)
            image.rgb[p + k] = same ? std::uint8_t(150 + grey / 3) : kMagenta[k];
    }
    return image;
}

MethodPicture compare(const Image& off, Image on) {
    MethodPicture picture;
    Image difference = paint_difference(off, on, picture.differing_pixels);
    if (picture.differing_pixels > 0) {
        picture.on = std::move(on);
        picture.difference = std::move(difference);
    }
    return picture;
}

/// Shades the first occluding object of each pixel; what `reported` lacks is painted magenta.
Image shade(const Scene& scene, const ItemBuffer& buffer, const std::vector<std::uint64_t>* reported) {
    Image image{buffer.width(), buffer.height(), {}};
    for (std::uint32_t y = 0; y < image.height; ++y)
        for (std::uint32_t x = 0; x < image.width; ++x) {
            std::uint32_t triangle = kNoTriangle;
            for (std::uint32_t one : buffer.seen(x, y))
                if (scene.object_of(one).has(kOccludes)) {
                    triangle = one;
                    break;
                }
            if (triangle == kNoTriangle) {
                image.rgb.insert(image.rgb.end(), kSky, kSky + 3);
                continue;
            }
            std::uint32_t object = scene.triangle_objects()[triangle];
            if (reported && !has_bit(*reported, object)) {
                image.rgb.insert(image.rgb.end(), kMagenta, kMagenta + 3);
                continue;
            }
            Vec3d a = scene.vertex(triangle, 0), b = scene.vertex(triangle, 1), c = scene.vertex(triangle, 2);
            Vec3d normal = normalized(cross(b - a, c - a));
            double facing = std::abs(dot(normal, normalized(buffer.ray(x, y).direction)));
            double light = 0.35 + 0.45 * facing + 0.2 * std::abs(normal.y);
            Vec3f colour = object_colour(object);
            for (int k = 0; k < 3; ++k)
                image.rgb.push_back(std::uint8_t(255 * std::min(1.0, light * double(colour[k]))));
        }
    return image;
}

} // namespace

std::vector<FramePictures> make_pictures(const Tracer& tracer, const WalkResult& result, const Job& job) {
    const Scene& scene = tracer.scene();
    std::unique_ptr<Drawing> drawing;
    if (!result.renderer.empty())
        if (auto made = Drawing::create(scene, result.width, result.height))
            drawing = std::move(*made);
    std::vector<std::uint64_t> all((scene.objects().size() + 63) / 64, ~std::uint64_t(0));
    std::vector<FramePictures> pictures;
    for (const WalkSnapshot& snapshot : result.notable) {
        const View& view = result.frames[snapshot.frame].view;
        FramePictures picture{snapshot.frame, snapshot.why, {}, {}};
        std::optional<ItemBuffer> buffer;
        if (drawing) {
            drawing->draw(view, all);
            picture.off = drawing->read_back();
        } else {
            buffer = ItemBuffer::render(tracer, PixelRays::of_view(view, result.width, result.height), {}, job);
            picture.off = shade(scene, *buffer, nullptr);
        }
        for (const auto& reported : snapshot.reported) {
            if (drawing)
                drawing->draw(view, reported);
            picture.methods.push_back(
                compare(picture.off, drawing ? drawing->read_back() : shade(scene, *buffer, &reported)));
        }
        pictures.push_back(std::move(picture));
    }
    return pictures;
}

} // namespace antumbra
