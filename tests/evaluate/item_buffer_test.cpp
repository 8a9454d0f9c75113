#include "base/random.hpp"
#include "evaluate/item_buffer.hpp"
#include "support/make_scene.hpp"

#include <rapidcheck/gtest.h>

#include <cmath>

namespace antumbra {
namespace {

using test::SceneMaker;

View looking_down_z() {
    View view;
    view.eye = {0, 0, 0};
    view.target = {0, 0, -1};
    view.fov_y_deg = 90;
    view.near_plane = 0;
    return view;
}

/// A view in world coordinates, moved to the scene's.
View in(const Scene& scene, View view) {
    view.eye = scene.to_local(view.eye);
    view.target = scene.to_local(view.target);
    return view;
}

/// A wall at z = -2, a small box behind it, and a larger wall at z = -4.
Scene wall_and_box() {
    return SceneMaker()
        .object("wall")
        .quad({-1, -1, -2}, {1, -1, -2}, {1, 1, -2}, {-1, 1, -2})
        .object("box")
        .box({-0.5, -0.5, -3.5}, {0.5, 0.5, -3})
        .object("backdrop")
        .quad({-3, -3, -4}, {3, -3, -4}, {3, 3, -4}, {-3, 3, -4})
        .scene();
}

std::vector<std::uint32_t> pixels_per_object(const Scene& scene, const ItemBuffer& buffer) {
    std::vector<std::uint32_t> count(scene.objects().size(), 0);
    for (std::uint32_t y = 0; y < buffer.height(); ++y)
        for (std::uint32_t x = 0; x < buffer.width(); ++x)
            for (std::uint32_t triangle : buffer.seen(x, y))
                ++count[scene.triangle_objects()[triangle]];
    return count;
}

std::vector<std::uint32_t> look(const Scene& scene, const View& view, std::uint32_t width, std::uint32_t height) {
    Tracer tracer = Tracer::build(scene);
    return pixels_per_object(scene, ItemBuffer::render(tracer, PixelRays::of_view(in(scene, view), width, height)));
}

TEST(ItemBuffer, BoxBehindWallHasNoPixel) {
    // At 90 degrees and 16 pixels the wall spans the middle 8 x 8, the backdrop 12 x 12 less the wall.
    EXPECT_EQ(look(wall_and_box(), looking_down_z(), 16, 16), (std::vector<std::uint32_t>{64, 0, 80}));
}

TEST(ItemBuffer, WidePictureSeesMoreToTheSides) {
    // Twice the width at the same height: the objects keep their pixels.
    EXPECT_EQ(look(wall_and_box(), looking_down_z(), 32, 16), (std::vector<std::uint32_t>{64, 0, 80}));
}

TEST(ItemBuffer, ParallelPictureMeasuresLengths) {
    View view = looking_down_z();
    view.projection = Projection::orthographic;
    view.height = 8;
    // 2 pixels a unit: wall 2 x 2 units, backdrop 6 x 6 less the wall.
    EXPECT_EQ(look(wall_and_box(), view, 16, 16), (std::vector<std::uint32_t>{16, 0, 128}));
}

TEST(ItemBuffer, PaneAndWhatIsBehindItAreBothSeen) {
    Scene scene = SceneMaker()
                      .object("pane", 0)
                      .quad({-1, -1, -2}, {1, -1, -2}, {1, 1, -2}, {-1, 1, -2})
                      .object("wall")
                      .quad({-3, -3, -4}, {3, -3, -4}, {3, 3, -4}, {-3, 3, -4})
                      .scene();
    EXPECT_EQ(look(scene, looking_down_z(), 16, 16), (std::vector<std::uint32_t>{64, 144}));
}

TEST(ItemBuffer, CoincidentSurfacesAreBothSeen) {
    SceneMaker maker;
    for (const char* name : {"one", "two"})
        maker.object(name).quad({-1, -1, -2}, {1, -1, -2}, {1, 1, -2}, {-1, 1, -2});
    EXPECT_EQ(look(maker.scene(), looking_down_z(), 16, 16), (std::vector<std::uint32_t>{64, 64}));
}

TEST(ItemBuffer, SingleSidedRoomIsSeenFromInsideAndThroughFromOutside) {
    Scene scene = SceneMaker()
                      .object("room")
                      .box({-1, -1, -1}, {1, 1, 1}, true)
                      .object("behind")
                      .quad({-8, -8, -4}, {8, -8, -4}, {8, 8, -4}, {-8, 8, -4})
                      .scene();
    EXPECT_EQ(look(scene, looking_down_z(), 16, 16), (std::vector<std::uint32_t>{256, 0}));
    View outside = looking_down_z();
    outside.eye = {0, 0, 3};
    // The near wall shows its back and is not drawn; the inside of the far wall (2 x 2 at depth 4) is, and so are
    // the side walls up to the front edge (2 x 2 at depth 2): 8 x 8 pixels in all.
    EXPECT_EQ(look(scene, outside, 16, 16), (std::vector<std::uint32_t>{64, 256 - 64}));
}

TEST(ItemBuffer, ThreadsDoNotChangeIt) {
    Scene scene = wall_and_box();
    Tracer tracer = Tracer::build(scene);
    PixelRays rays = PixelRays::of_cube_face(scene.to_local({0.1, 0.2, 0.3}), 5, 33);
    ItemOptions options{PixelSampling::jittered, 7, 3};
    std::vector<std::vector<std::uint32_t>> first;
    for (unsigned threads : {1u, 2u, 5u}) {
        Job job;
        job.threads = threads;
        ItemBuffer buffer = ItemBuffer::render(tracer, rays, options, job);
        std::vector<std::vector<std::uint32_t>> sets;
        for (std::uint32_t y = 0; y < 33; ++y)
            for (std::uint32_t x = 0; x < 33; ++x)
                sets.emplace_back(buffer.seen(x, y).begin(), buffer.seen(x, y).end());
        if (first.empty())
            first = sets;
        EXPECT_EQ(sets, first) << threads << " threads";
    }
}

TEST(ItemBuffer, JitterIsTheFirstTwoNumbersOfThePixelsStream) {
    Scene scene = wall_and_box();
    Tracer tracer = Tracer::build(scene);
    PixelRays rays = PixelRays::of_view(in(scene, looking_down_z()), 7, 5);
    const std::uint64_t seed = 0x123456789ABCull, stream = 0xFEDCBA987654ull;
    ItemBuffer buffer = ItemBuffer::render(tracer, rays, {PixelSampling::jittered, seed, stream});
    for (std::uint32_t y = 0; y < 5; ++y)
        for (std::uint32_t x = 0; x < 7; ++x) {
            Random random(seed, stream, y * 7 + x);
            double right = random.uniform(), down = random.uniform();
            EXPECT_EQ(buffer.ray(x, y).direction, rays.at(x + right, y + down).direction);
        }
}

TEST(ItemBuffer, LostPixelsAreConfirmedOneByOne) {
    Scene scene = wall_and_box();
    Tracer tracer = Tracer::build(scene);
    ItemBuffer buffer = ItemBuffer::render(tracer, PixelRays::of_view(in(scene, looking_down_z()), 16, 16));
    std::uint64_t only_backdrop = 1u << 2;
    std::vector<LostPixels> lost = find_lost_pixels(scene, Arbiter(tracer), buffer, {&only_backdrop, 1});
    ASSERT_EQ(lost.size(), 1u);
    EXPECT_EQ(lost[0].object, 0u);
    // The diagonal that splits the wall runs through pixel centres: those 8 lines meet an edge.
    EXPECT_EQ(lost[0].confirmed, 56u);
    EXPECT_EQ(lost[0].grazing, 8u);
    EXPECT_EQ(lost[0].unconfirmed, 0u);
}

TEST(PixelRays, CubeFacesTogetherSeeEveryDirectionOnce) {
    // A box around the eye with a face per object: face k of the cube sees all of object k and nothing else.
    SceneMaker maker;
    const Vec3d low{-1, -1, -1}, high{1, 1, 1};
    Box3d b{low, high};
    static constexpr int faces[6][4] = {{5, 7, 3, 1}, {2, 6, 4, 0}, {3, 7, 6, 2},
                                        {4, 5, 1, 0}, {6, 7, 5, 4}, {1, 3, 2, 0}};
    for (const auto& f : faces)
        maker.object("face", kOccludes | kDoubleSided)
            .quad(b.corner(f[0]), b.corner(f[1]), b.corner(f[2]), b.corner(f[3]));
    Scene scene = maker.scene();
    Tracer tracer = Tracer::build(scene);
    for (int face = 0; face < 6; ++face) {
        std::vector<std::uint32_t> expected(6, 0);
        expected[std::size_t(face)] = 64;
        PixelRays rays = PixelRays::of_cube_face(scene.to_local({0, 0, 0}), face, 8);
        EXPECT_EQ(pixels_per_object(scene, ItemBuffer::render(tracer, rays)), expected) << "face " << face;
    }
}

TEST(PixelRays, FirstPixelIsTopLeft) {
    PixelRays rays = PixelRays::of_view(looking_down_z(), 4, 4);
    Ray ray = rays.at(0.5, 0.5);
    EXPECT_NEAR(ray.direction.x, -0.75, 1e-15);
    EXPECT_NEAR(ray.direction.y, 0.75, 1e-15);
    EXPECT_NEAR(ray.direction.z, -1, 1e-15);
}

RC_GTEST_PROP(PixelRays, HalfTangentAgreesWithTheLibrary, ()) {
    double degrees = *rc::gen::inRange(1, 179'999'999) * 1e-6;
    double expected = std::tan(degrees * (3.14159265358979323846 / 360));
    RC_ASSERT(std::abs(half_tangent(degrees) - expected) <= 4e-15 * std::max(expected, 1e-3) * (1 + expected));
}

} // namespace
} // namespace antumbra
