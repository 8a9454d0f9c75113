#include "base/random.hpp"
#include "evaluate/gl/drawing.hpp"
#include "evaluate/item_buffer.hpp"
#include "support/make_scene.hpp"

namespace antumbra {
namespace {

using test::SceneMaker;

#define OR_SKIP(drawing)                                                                                               \
    if (!(drawing))                                                                                                    \
    GTEST_SKIP() << (drawing).status().message()

View view_of(const Scene& scene, Vec3d eye, Vec3d target) {
    View view;
    view.eye = scene.to_local(eye);
    view.target = scene.to_local(target);
    view.near_plane = 0;
    return view;
}

/// Number + 1 of the object at a pixel, as DrawStyle::items writes it.
std::uint32_t item_at(const Image& image, std::uint32_t x, std::uint32_t y) {
    const std::uint8_t* p = &image.rgb[3 * (x + std::size_t(y) * image.width)];
    return std::uint32_t(p[0]) | std::uint32_t(p[1]) << 8 | std::uint32_t(p[2]) << 16;
}

bool sees(const Scene& scene, const ItemBuffer& buffer, std::uint32_t x, std::uint32_t y, std::uint32_t item) {
    if (item == 0)
        return buffer.seen(x, y).empty();
    for (std::uint32_t triangle : buffer.seen(x, y))
        if (scene.triangle_objects()[triangle] + 1 == item)
            return true;
    return false;
}

/// Is what OpenGL drew at a pixel what a ray through it or through a neighbour sees?
bool near_truth(const Scene& scene, const ItemBuffer& buffer, std::uint32_t x, std::uint32_t y, std::uint32_t item) {
    for (std::uint32_t j = y > 0 ? y - 1 : 0; j <= std::min(y + 1, buffer.height() - 1); ++j)
        for (std::uint32_t i = x > 0 ? x - 1 : 0; i <= std::min(x + 1, buffer.width() - 1); ++i)
            if (sees(scene, buffer, i, j, item))
                return true;
    return false;
}

Scene boxes_at_random(std::uint32_t seed) {
    Random random(seed);
    SceneMaker maker;
    for (int k = 0; k < 40; ++k) {
        Vec3d low{random.uniform(-8, 8), random.uniform(-4, 4), random.uniform(-20, -4)};
        Vec3d size{random.uniform(0.3, 3), random.uniform(0.3, 3), random.uniform(0.3, 3)};
        bool inward = random.below(4) == 0;
        maker.object("box", kOccludes | (random.below(3) == 0 ? kDoubleSided : 0u)).box(low, low + size, inward);
    }
    return maker.scene();
}

TEST(Drawing, AgreesWithTheRaysUpToEdges) {
    for (std::uint32_t seed = 1; seed <= 4; ++seed) {
        Scene scene = boxes_at_random(seed);
        constexpr std::uint32_t kWidth = 160, kHeight = 90;
        auto drawing = Drawing::create(scene, kWidth, kHeight);
        OR_SKIP(drawing);
        View view = view_of(scene, {0.3, 0.2, 2}, {0, 0, -10});
        view.aspect = double(kWidth) / kHeight;
        if (seed % 2 == 0) {
            view.projection = Projection::orthographic;
            view.height = 9;
        }
        (*drawing)->draw(view, std::vector<std::uint64_t>{~std::uint64_t(0)}, DrawStyle::items);
        Image image = (*drawing)->read_back();
        Tracer tracer = Tracer::build(scene);
        ItemBuffer buffer = ItemBuffer::render(tracer, PixelRays::of_view(view, kWidth, kHeight));
        std::uint32_t same = 0, far_off = 0;
        for (std::uint32_t y = 0; y < kHeight; ++y)
            for (std::uint32_t x = 0; x < kWidth; ++x) {
                std::uint32_t item = item_at(image, x, y);
                same += sees(scene, buffer, x, y, item);
                far_off += !near_truth(scene, buffer, x, y, item);
            }
        // A sliver of a face can pass through one centre and miss all those around it.
        EXPECT_LE(far_off, 3u) << "seed " << seed;
        EXPECT_GT(same, kWidth * kHeight * 995 / 1000) << "seed " << seed;
    }
}

TEST(Drawing, DrawsOnlyWhatItIsTold) {
    Scene scene = SceneMaker()
                      .object("front")
                      .quad({-9, -9, -2}, {9, -9, -2}, {9, 9, -2}, {-9, 9, -2})
                      .object("back")
                      .quad({-9, -9, -4}, {9, -9, -4}, {9, 9, -4}, {-9, 9, -4})
                      .scene();
    auto drawing = Drawing::create(scene, 8, 8);
    OR_SKIP(drawing);
    View view = view_of(scene, {0, 0, 0}, {0, 0, -1});
    for (std::uint64_t objects = 0; objects < 4; ++objects) {
        double seconds = (*drawing)->draw(view, {&objects, 1}, DrawStyle::items);
        EXPECT_GT(seconds, 0);
        std::uint32_t expected = objects & 1 ? 1 : objects & 2 ? 2 : 0;
        EXPECT_EQ(item_at((*drawing)->read_back(), 3, 5), expected);
    }
}

TEST(Drawing, GlassShowsWhatIsBehindIt) {
    auto colour_of = [](bool with_wall) {
        SceneMaker maker;
        maker.object("glass", 0).quad({-9, -9, -2}, {9, -9, -2}, {9, 9, -2}, {-9, 9, -2});
        maker.object("wall").quad({-9, -9, -4}, {9, -9, -4}, {9, 9, -4}, {-9, 9, -4});
        Scene scene = maker.scene();
        std::vector<std::uint8_t> result;
        if (auto drawing = Drawing::create(scene, 4, 4)) {
            std::uint64_t objects = with_wall ? 3 : 1;
            (*drawing)->draw(view_of(scene, {0, 0, 0}, {0, 0, -1}), {&objects, 1});
            result = (*drawing)->read_back().rgb;
        }
        return result;
    };
    if (colour_of(true).empty())
        GTEST_SKIP() << "no OpenGL";
    EXPECT_NE(colour_of(true), colour_of(false));
}

TEST(ObjectColour, IsStableAndWithinRange) {
    EXPECT_EQ(object_colour(7), object_colour(7));
    for (std::uint32_t object = 0; object < 1000; ++object)
        for (int k = 0; k < 3; ++k) {
            EXPECT_GE(object_colour(object)[k], 0.0f);
            EXPECT_LE(object_colour(object)[k], 1.0f);
        }
}

} // namespace
} // namespace antumbra
