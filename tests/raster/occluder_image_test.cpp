// Drawn occluders: vector kernels against scalar twins, inner against centre coverage, boxes one by one against eight.
#include "raster/occluder_image.hpp"
#include "raster/pixel_rect.hpp"

#include "cull/proof.hpp"
#include "cull/scene_data.hpp"
#include "cull/view_planes.hpp"

namespace antumbra {
namespace {

using test::Stage;

struct Drawn {
    Stage stage;
    Screen screen;
    const PatchStore& store() const { return stage.cull_scene.data().patches.store; }
};

Drawn random_case(std::uint32_t trial) {
    Random random(71, trial);
    Result<Scene> scene = Scene::create(test::random_soup(random, 30, 8));
    View view = test::random_view(random, {0, 0, 0}, 8);
    while (problem_of(view))
        view = test::random_view(random, {0, 0, 0}, 8);
    return {Stage(std::move(*scene)),
            make_screen(camera_of(view), 64 + int(random.below(200)), 64 + int(random.below(100)), 16)};
}

OccluderImage draw_all(const Drawn& drawn, DrawOccluder draw, PixelCoverage coverage) {
    OccluderImage image;
    OccluderBrush brush;
    image.reset(drawn.screen);
    brush.fit(drawn.screen, drawn.store());
    for (std::uint32_t p = 0; p < drawn.store().patches.size(); ++p)
        draw(drawn.store(), p, drawn.screen, coverage, brush, image);
    for (std::uint64_t word : brush.coverage.covered)
        EXPECT_EQ(word, 0u) << "the brush is clear between patches";
    for (float nearness : brush.nearness)
        EXPECT_EQ(nearness, INFINITY);
    return image;
}

TEST(OccluderImage, every_instruction_set_draws_the_same) {
    for (std::uint32_t trial = 0; trial < 40; ++trial) {
        Drawn drawn = random_case(trial);
        for (PixelCoverage coverage : {PixelCoverage::inner, PixelCoverage::centre})
            for (DrawOccluder draw : {draw_occluder_avx2(), draw_occluder_avx512()}) {
                if (!draw)
                    continue;
                OccluderImage scalar = draw_all(drawn, draw_occluder_scalar, coverage);
                OccluderImage vector = draw_all(drawn, draw, coverage);
                ASSERT_EQ(scalar.bits, vector.bits);
                ASSERT_EQ(scalar.nearness, vector.nearness);
                ASSERT_EQ(scalar.row_used, vector.row_used);
            }
    }
}

/// A pixel that is wholly covered is covered at its centre, by something at least as near.
TEST(OccluderImage, inner_coverage_lies_within_that_of_centres) {
    std::uint64_t inner_pixels = 0, centre_pixels = 0;
    for (std::uint32_t trial = 100; trial < 160; ++trial) {
        Drawn drawn = random_case(trial);
        OccluderImage inner = draw_all(drawn, draw_occluder_scalar, PixelCoverage::inner);
        OccluderImage centre = draw_all(drawn, draw_occluder_scalar, PixelCoverage::centre);
        for (int y = 0; y < inner.height; ++y)
            for (int x = 0; x < inner.width; ++x) {
                centre_pixels += centre.is_covered(x, y);
                float at_centre = centre.nearness[static_cast<std::size_t>(y * centre.stride + x)];
                float wholly = inner.nearness[static_cast<std::size_t>(y * inner.stride + x)];
                ASSERT_EQ(centre.is_covered(x, y), at_centre > -INFINITY);
                ASSERT_EQ(inner.is_covered(x, y), wholly > -INFINITY);
                if (!inner.is_covered(x, y))
                    continue;
                ++inner_pixels;
                ASSERT_TRUE(centre.is_covered(x, y)) << trial << " " << x << " " << y;
                ASSERT_LE(wholly, at_centre + 1e-4f * std::abs(at_centre)) << trial << " " << x << " " << y;
            }
    }
    EXPECT_GT(inner_pixels * 2, centre_pixels);
}

TEST(OccluderImage, the_order_of_patches_does_not_matter) {
    for (std::uint32_t trial = 200; trial < 220; ++trial) {
        Drawn drawn = random_case(trial);
        OccluderImage forward = draw_all(drawn, draw_occluder_scalar, PixelCoverage::inner), backward;
        OccluderBrush brush;
        backward.reset(drawn.screen);
        brush.fit(drawn.screen, drawn.store());
        for (std::size_t p = drawn.store().patches.size(); p-- > 0;)
            draw_occluder_scalar(drawn.store(), std::uint32_t(p), drawn.screen, PixelCoverage::inner, brush, backward);
        ASSERT_EQ(forward.bits, backward.bits);
        ASSERT_EQ(forward.nearness, backward.nearness);
    }
}

TEST(EightOnScreen, every_kernel_gives_what_one_box_at_a_time_gives) {
    std::uint64_t testable = 0;
    for (std::uint32_t trial = 0; trial < 4000; ++trial) {
        Random random(72, trial);
        View view = test::random_view(random, {0, 0, 0}, 8);
        if (problem_of(view))
            continue;
        Screen screen = make_screen(camera_of(view), 128, 128, 16);
        std::vector<Box3f> boxes = test::random_boxes(random, 8, {0, 0, 0}, 8);
        float min[3][8], max[3][8];
        for (int lane = 0; lane < 8; ++lane)
            for (int axis = 0; axis < 3; ++axis) {
                min[axis][lane] = boxes[std::size_t(lane)].min[axis];
                max[axis][lane] = boxes[std::size_t(lane)].max[axis];
            }
        for (ProjectEight project : {ProjectEight(project_eight_scalar), project_eight_avx2(), project_eight_avx512()}) {
            if (!project)
                continue;
            EightOnScreen eight;
            project(screen, min, max, eight);
            for (int lane = 0; lane < 8; ++lane) {
                BoxOnScreen box = project_box(screen, boxes[std::size_t(lane)]);
                PixelRect rect = pixel_rect(screen, box);
                ASSERT_EQ(eight.testable >> lane & 1, rect.empty() ? 0u : 1u) << trial;
                if (rect.empty())
                    continue;
                ++testable;
                ASSERT_EQ(eight.x0[lane], rect.x0);
                ASSERT_EQ(eight.y0[lane], rect.y0);
                ASSERT_EQ(eight.x1[lane], rect.x1);
                ASSERT_EQ(eight.y1[lane], rect.y1);
                ASSERT_EQ(eight.nearness[lane], box.nearness);
            }
        }
    }
    EXPECT_GT(testable, 3000u);
}

} // namespace
} // namespace antumbra
