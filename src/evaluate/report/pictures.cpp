#include "evaluate/report/pictures.hpp"

#include "evaluate/cull_scene.hpp"
#include "evaluate/item_buffer.hpp"

#include <algorithm>

namespace antumbra {
namespace {

constexpr std::uint8_t kMagenta[3] = {230, 0, 200};
constexpr std::uint8_t kSky[3] = {209, 222, 235};

struct Chosen {
    std::uint32_t frame = 0;
    std::string why;
};

template <class Value>
std::uint32_t frame_of_most(const WalkResult& result, Value&& value) {
    std::uint32_t best = 0;
    for (std::uint32_t f = 1; f < result.frames.size(); ++f)
        if (value(result.frames[f]) > value(result.frames[best]))
            best = f;
    return best;
}

std::vector<Chosen> choose_frames(const WalkResult& result) {
    std::vector<Chosen> chosen;
    auto add = [&](std::uint32_t frame, const char* why) {
        for (Chosen& one : chosen)
            if (one.frame == frame) {
                one.why += std::string(", ") + why;
                return;
            }
        chosen.push_back({frame, why});
    };
    auto lost = [](const WalkFrame& frame) {
        std::uint64_t most = 0;
        for (const WalkSample& sample : frame.methods)
            most = std::max(most, sample.false_invisible_pixels);
        return most;
    };
    add(frame_of_most(result,
                      [](const WalkFrame& f) {
                          double most = 0;
                          for (const WalkSample& sample : f.methods)
                              most = std::max(most, f.objects_in_frustum > 0 ? double(sample.culled_of_frustum) : 0);
                          return most;
                      }),
        "most culled");
    std::uint32_t worst = frame_of_most(result, lost);
    if (lost(result.frames[worst]) > 0)
        add(worst, "most pixels lost");
    add(frame_of_most(result, [](const WalkFrame& f) { return f.ceiling_ms < 0 ? double(f.objects_true) : f.ceiling_ms; }),
        "most to draw");
    return chosen;
}

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

std::vector<FramePictures> make_pictures(const Tracer& tracer, const WalkResult& result, const Pvs* pvs,
                                         const Job& job) {
    const Scene& scene = tracer.scene();
    CullScene cull_scene = cull_scene_of(scene);
    std::unique_ptr<Drawing> drawing;
    if (!result.renderer.empty())
        if (auto made = Drawing::create(scene, result.width, result.height))
            drawing = std::move(*made);
    std::vector<std::uint64_t> all((scene.objects().size() + 63) / 64, ~std::uint64_t(0));
    std::vector<FramePictures> pictures;
    for (const Chosen& chosen : choose_frames(result)) {
        const View& view = result.frames[chosen.frame].view;
        FramePictures picture{chosen.frame, chosen.why, {}, {}};
        std::optional<ItemBuffer> buffer;
        if (drawing) {
            drawing->draw(view, all);
            picture.off = drawing->read_back();
        } else {
            buffer = ItemBuffer::render(tracer, PixelRays::of_view(view, result.width, result.height), {}, job);
            picture.off = shade(scene, *buffer, nullptr);
        }
        for (const WalkMethod& method : result.methods) {
            CullerOptions options;
            options.pvs = pvs;
            auto culler = make_culler(method.name, cull_scene, options);
            if (!culler)
                continue;
            ViewState state;
            CullResult reported;
            (*culler)->cull(view, state, reported);
            if (drawing)
                drawing->draw(view, reported.visible);
            picture.methods.push_back(
                compare(picture.off, drawing ? drawing->read_back() : shade(scene, *buffer, &reported.visible)));
        }
        pictures.push_back(std::move(picture));
    }
    return pictures;
}

} // namespace antumbra
