// The vector kernels against their scalar twins, on random input: every bit must agree.
#include "cull/proof.hpp"
#include "cull/shadow.hpp"
#include "cull/view_planes.hpp"
#include "raster/depth_pyramid.hpp"
#include "raster/tile_buffer.hpp"

namespace antumbra {
namespace {

using test::Stage;

Stage soup(std::uint32_t seed, double size) {
    Random random(51, seed);
    Result<Scene> scene = Scene::create(test::random_soup(random, 40, size));
    return Stage(std::move(*scene));
}

TEST(Twins, all_methods_report_the_same_with_every_instruction_set) {
    for (std::uint32_t trial = 0; trial < 12; ++trial) {
        Stage stage = soup(trial, 8);
        Random random(52, trial);
        for (const char* name : {"masked", "planes", "opacity"})
            for (InstructionSet set : {InstructionSet::avx2, InstructionSet::avx512}) {
                CullerOptions plain, fast;
                plain.instruction_set = InstructionSet::scalar;
                fast.instruction_set = set;
                auto twin = make_culler(name, stage.cull_scene, fast);
                if (!twin)
                    continue; // not on this processor
                auto scalar = make_culler(name, stage.cull_scene, plain);
                ViewState a, b;
                CullResult expected, result;
                for (int f = 0; f < 20; ++f) {
                    View view = test::random_view(random, {0, 0, 0}, 8);
                    (*scalar)->cull(view, a, expected);
                    (*twin)->cull(view, b, result);
                    ASSERT_EQ(result.visible, expected.visible) << name << " trial " << trial << " frame " << f;
                    ASSERT_EQ(result.counters.polygons_drawn, expected.counters.polygons_drawn);
                    ASSERT_EQ(result.counters.hidden_by_raster, expected.counters.hidden_by_raster);
                }
            }
    }
}

TEST(Twins, coverage_of_every_patch_is_the_same_bit_for_bit) {
    for (std::uint32_t trial = 0; trial < 12; ++trial) {
        Stage stage = soup(100 + trial, 8);
        const PatchStore& store = stage.cull_scene.data().patches.store;
        Random random(53, trial);
        View view = test::random_view(random, {0, 0, 0}, 8);
        Screen screen = make_screen(camera_of(view), 256, 16);
        PatchCoverage scalar, vector;
        scalar.fit(screen, store);
        vector.fit(screen, store);
        for (DrawPatch draw : {draw_patch_avx2(), draw_patch_avx512()})
            for (std::uint32_t p = 0; draw && p < store.patches.size(); ++p) {
                draw_patch_scalar(store, p, screen, scalar);
                draw(store, p, screen, vector);
                ASSERT_EQ(scalar.covered, vector.covered);
                ASSERT_EQ(scalar.silhouette, vector.silhouette);
                ASSERT_EQ(scalar.inner, vector.inner);
                ASSERT_EQ(scalar.nearness, vector.nearness);
                scalar.clear(screen);
                vector.clear(screen);
                ASSERT_EQ(std::count_if(scalar.covered.begin(), scalar.covered.end(), [](auto w) { return w != 0; }), 0);
            }
    }
}

TEST(Twins, shadow_kernels_agree) {
    Random random(54);
    ShadowKernel fast = shadow_kernel(InstructionSet::automatic);
    for (int trial = 0; trial < 20000; ++trial) {
        CullNode node{};
        for (int lane = 0; lane < kWidth; ++lane)
            for (int axis = 0; axis < 3; ++axis) {
                node.min[axis][lane] = static_cast<float>(random.uniform(-2, 2));
                node.max[axis][lane] = node.min[axis][lane] + static_cast<float>(random.uniform(0, 1));
            }
        Shadow shadow;
        shadow.count = 4 + int(random.below(6));
        for (int i = 0; i < shadow.count; ++i) {
            for (float& n : shadow.normal[i])
                n = static_cast<float>(random.uniform(-1, 1));
            float offset = static_cast<float>(random.uniform(0, 3));
            shadow.certainly[i] = offset - 1e-5f;
            shadow.possibly[i] = offset + 1e-5f;
        }
        std::uint32_t alive = random.below(256);
        ShadowVerdicts a = test_shadow_scalar({node.min, node.max}, shadow, alive);
        ShadowVerdicts b = fast({node.min, node.max}, shadow, alive);
        ASSERT_EQ(a.hidden & alive, b.hidden & alive);
        ASSERT_EQ(a.outside & alive, b.outside & alive);
    }
}

/// The pyramid keeps more than the masked tiles do (every pixel its own nearness): what the tiles hide, it hides, if
/// the same patches were merged and the question goes to the pixels.
TEST(Twins, what_masked_tiles_hide_the_pixels_hide) {
    std::uint64_t hidden = 0;
    for (std::uint32_t trial = 0; trial < 20; ++trial) {
        Stage stage = soup(200 + trial, 8);
        const PatchStore& store = stage.cull_scene.data().patches.store;
        Random random(55, trial);
        for (int f = 0; f < 5; ++f) {
            View view = test::random_view(random, {0, 0, 0}, 8);
            Screen screen = make_screen(camera_of(view), 128, 16);
            PatchCoverage coverage;
            coverage.fit(screen, store);
            TileBuffer tiles;
            DepthPyramid pixels;
            tiles.reset(screen);
            pixels.reset(screen);
            for (std::uint32_t p = 0; p < store.patches.size(); ++p) {
                draw_patch_scalar(store, p, screen, coverage);
                if (coverage.touched.empty())
                    continue;
                tiles.merge(coverage);
                pixels.merge(coverage);
                coverage.clear(screen);
            }
            pixels.levels.resize(1);
            for (const Box3f& box : test::random_boxes(random, 200, {0, 0, 0}, 8)) {
                BoxOnScreen on_screen = project_box(screen, box);
                PixelRect rect = pixel_rect(screen, on_screen);
                if (!is_hidden_scalar(tiles, rect, on_screen.nearness))
                    continue;
                ++hidden;
                ASSERT_TRUE(pixels.is_hidden(rect, on_screen.nearness)) << trial;
            }
        }
    }
    EXPECT_GT(hidden, 100u);
}

} // namespace
} // namespace antumbra
