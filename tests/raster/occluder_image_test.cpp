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

struct EightBoxes {
    std::vector<Box3f> boxes;
    float min[3][8], max[3][8];

    explicit EightBoxes(std::vector<Box3f> of) : boxes(std::move(of)) {
        for (int lane = 0; lane < 8; ++lane)
            for (int axis = 0; axis < 3; ++axis) {
                min[axis][lane] = boxes[std::size_t(lane)].min[axis];
                max[axis][lane] = boxes[std::size_t(lane)].max[axis];
            }
    }
};

/// Far from the origin, where the eye has bits that a float has not; `scale` stretches the scene.
void check_eight(const View& view, const EightBoxes& eight_boxes, double extent, std::uint64_t& testable,
                 std::uint64_t& same) {
    Screen screen = make_screen(camera_of(view), 128, 128, extent);
    EightOnScreen first;
    project_eight_scalar(screen, eight_boxes.min, eight_boxes.max, first);
    for (ProjectEight project : {project_eight_avx2(), project_eight_avx512()}) {
        EightOnScreen other;
        if (!project)
            continue;
        project(screen, eight_boxes.min, eight_boxes.max, other);
        ASSERT_EQ(first.testable, other.testable);
        for (int lane = 0; lane < 8; ++lane) {
            ASSERT_EQ(first.x0[lane], other.x0[lane]);
            ASSERT_EQ(first.y0[lane], other.y0[lane]);
            ASSERT_EQ(first.x1[lane], other.x1[lane]);
            ASSERT_EQ(first.y1[lane], other.y1[lane]);
            if (first.testable >> lane & 1) {
                ASSERT_EQ(first.nearness[lane], other.nearness[lane]);
            }
        }
    }
    for (int lane = 0; lane < 8; ++lane) {
        if (!(first.testable >> lane & 1))
            continue;
        BoxOnScreen box = project_box(screen, eight_boxes.boxes[std::size_t(lane)]);
        ASSERT_TRUE(box.testable);
        PixelRect rect = pixel_rect(screen, box), found = first.rect(lane);
        // At the border one of the two may just be beside the screen.
        if (!rect.empty()) {
            ASSERT_LE(found.x0, rect.x0);
            ASSERT_LE(found.y0, rect.y0);
            ASSERT_GE(found.x1, rect.x1);
            ASSERT_GE(found.y1, rect.y1);
            same += found.x0 == rect.x0 && found.y0 == rect.y0 && found.x1 == rect.x1 && found.y1 == rect.y1;
        }
        // What the doubles say, without their own padding.
        double padding = 1e-5 * (std::abs(double(box.nearness)) + screen.orthographic_slack);
        ASSERT_GE(double(first.nearness[lane]), double(box.nearness) - padding);
        ++testable;
    }
}

TEST(EightOnScreen, floats_contain_what_doubles_say_and_every_kernel_gives_the_same) {
    std::uint64_t testable = 0, same = 0;
    for (std::uint32_t trial = 0; trial < 6000; ++trial) {
        Random random(72, trial);
        Vec3d away = trial % 3 == 0 ? Vec3d{} : Vec3d{random.uniform(-1e5, 1e5), random.uniform(-1e3, 1e3), 40000.7};
        View view = test::random_view(random, away, 8);
        if (problem_of(view))
            continue;
        std::vector<Box3f> boxes = test::random_boxes(random, 8, away, trial % 5 == 0 ? 300 : 8);
        check_eight(view, EightBoxes(boxes), 16 + length(away), testable, same);
        if (HasFatalFailure())
            FAIL() << trial;
    }
    EXPECT_GT(testable, 6000u);
    EXPECT_GT(double(same), 0.97 * double(testable)) << "of " << testable;
}

TEST(EightOnScreen, a_box_around_the_eye_or_without_numbers_is_untestable) {
    View view;
    view.target = {0, 0, -1};
    view.aspect = 1;
    std::vector<Box3f> boxes(8, Box3f{{-1, -1, -20}, {1, 1, -10}});
    boxes[1] = {{-1, -1, -1}, {1, 1, 1}};
    boxes[2] = {{-1, -1, 10}, {1, 1, 20}};
    boxes[3] = {{-3e38f, -3e38f, -3e38f}, {3e38f, 3e38f, -10}};
    boxes[4] = {{NAN, -1, -20}, {1, 1, -10}};
    boxes[5] = {{100, -1, -20}, {101, 1, -10}}; // beside the screen
    EightBoxes eight_boxes(boxes);
    EightOnScreen eight;
    project_eight_scalar(make_screen(camera_of(view), 128, 128, 100), eight_boxes.min, eight_boxes.max, eight);
    EXPECT_EQ(eight.testable, 0b11000001u);
}

} // namespace
} // namespace antumbra
