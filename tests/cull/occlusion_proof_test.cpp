#include "cull/proof.hpp"
#include "support/ball.hpp"

namespace antumbra {
namespace {

using test::ProofCounts;
using test::Stage;

const char* const kMethods[] = {"hzb", "masked", "planes", "planes-published", "tree-fse", "tree-fme", "tree-fmc", "tree", "opacity", "opacity-published"};

/// Frames per scene and method; a longer search with the environment variable.
int frames() {
    const char* wanted = std::getenv("ANTUMBRA_PROOF_FRAMES");
    return wanted ? std::atoi(wanted) : 12;
}

std::unique_ptr<Culler> make(const char* name, const Stage& stage, CullerOptions options = {}) {
    options.tree.minimum_cost = 0; // the things in these scenes have few triangles
    options.opacity.width = options.raster_width;
    options.opacity.height = std::string_view(name) == "opacity-published" ? options.raster_width : 0;
    options.opacity.object_seconds = 1; // never gives up
    auto culler = make_culler(name, stage.cull_scene, options);
    EXPECT_TRUE(culler.ok()) << culler.status().message();
    return std::move(culler).value();
}

TEST(OcclusionProof, random_soup_loses_no_line_of_sight) {
    ProofCounts counts[std::size(kMethods)];
    for (std::uint32_t trial = 0; trial < 60; ++trial) {
        Random random(21, trial);
        double size = std::ldexp(1.0, int(random.below(20)) - 6);
        Result<Scene> scene = Scene::create(test::random_soup(random, 40, size));
        ASSERT_TRUE(scene.ok());
        Stage stage(std::move(*scene));
        for (std::size_t m = 0; m < std::size(kMethods); ++m) {
            CullerOptions options;
            options.raster_width = 64 + int(random.below(4)) * 64;
            auto culler = make(kMethods[m], stage, options);
            ViewState state;
            for (int f = 0; f < frames(); ++f) {
                View view = test::random_view(random, {0, 0, 0}, size);
                if (problem_of(view) == nullptr)
                    test::prove(stage, *culler, view, state, 32, 48, random, counts[m]);
                if (HasFailure())
                    FAIL() << "trial " << trial << " frame " << f;
            }
        }
    }
    for (std::size_t m = 0; m < std::size(kMethods); ++m) {
        EXPECT_GT(counts[m].hidden * 20, counts[m].in_frustum) << kMethods[m] << " culls next to nothing";
    }
}

/// Rows of houses that share walls, some of them cut finely, with things on and between them; eyes in the streets, within
/// houses and just beside their walls.
TEST(OcclusionProof, joined_houses_hide_nothing_that_is_seen) {
    ProofCounts counts[std::size(kMethods)];
    std::uint64_t joined = 0;
    for (std::uint32_t trial = 0; trial < 24; ++trial) {
        Random random(24, trial);
        test::SceneMaker maker;
        for (int row = 0; row < 4; ++row) {
            double x = random.uniform(0, 4), z = row * 12.0;
            for (int house = 0; house < 5; ++house) {
                double width = 2 + random.below(6), height = 3 + random.below(8), depth = random.below(4) ? 4 : 5;
                maker.object("house").box({x, 0, z}, {x + width, height, z + depth});
                if (random.below(3) == 0) // a tower on it
                    maker.box({x + 0.5, height, z + 1}, {x + width - 0.5, height + 2, z + 3});
                maker.object("window").box({x + 0.5, 1, z + depth}, {x + 1.5, 2, z + depth + 0.125});
                maker.object("thing").box({x, 0, z + depth + 2}, {x + 0.5, random.uniform(0.5, 9), z + depth + 2.5});
                x += width + (random.below(5) == 0 ? 0.25 : 0);
            }
        }
        Stage stage(maker.scene());
        for (const OccluderPolygon& polygon : stage.occluders.polygons)
            joined += polygon.synthetic;
        for (std::size_t m = 0; m < std::size(kMethods); ++m) {
            auto culler = make(kMethods[m], stage);
            ViewState state;
            for (int f = 0; f < frames(); ++f) {
                View view = test::random_view(random, {0, 0, 0}, 24);
                if (random.below(2)) { // close to a wall
                    const Box3f& box = stage.scene->objects()[random.below(std::uint32_t(stage.scene->objects().size()))].bounds;
                    view.eye = to_double(box.corner(int(random.below(8)))) +
                               Vec3d{random.uniform(-1, 1), random.uniform(-1, 1), random.uniform(-1, 1)} * 0.5;
                    view.target = view.eye + Vec3d{random.uniform(-1, 1), random.uniform(-0.2, 0.2), random.uniform(-1, 1)};
                    view.near_plane = random.uniform(0, 0.4);
                }
                if (problem_of(view) == nullptr)
                    test::prove(stage, *culler, view, state, 24, 48, random, counts[m]);
                if (HasFailure())
                    FAIL() << "trial " << trial << " frame " << f;
            }
        }
    }
    EXPECT_GT(joined, 200u);
    for (std::size_t m = 0; m < std::size(kMethods); ++m) {
        EXPECT_GT(counts[m].hidden * 10, counts[m].in_frustum) << kMethods[m] << " culls next to nothing";
    }
}

/// Dense meshes, whose own triangles are too small for any budget: only their inner shells hide what stands behind.
TEST(OcclusionProof, inner_shells_hide_nothing_that_is_seen) {
    ProofCounts with, without;
    for (std::uint32_t trial = 0; trial < 4; ++trial) {
        Random random(25, trial);
        test::SceneMaker maker;
        for (int b = 0; b < 3; ++b) {
            maker.object("ball");
            test::add_ball(maker, {b * 11.0, 0, random.uniform(-1, 1)}, 40, random.uniform(0, 2));
        }
        for (int t = 0; t < 60; ++t) {
            Vec3d at{random.uniform(-6, 28), random.uniform(-4, 4), random.below(2) ? -7.0 : 7.0};
            maker.object("thing").box(at, at + Vec3d{0.4, 0.4, 0.4});
        }
        OccluderOptions options;
        options.inner_boxes = false;
        Stage plain(maker.scene(), options);
        options.inner_shells = true;
        Stage stage(maker.scene(), options);
        for (const char* name : {"masked", "hzb", "planes"}) {
            auto culler = make(name, stage), other = make(name, plain);
            ViewState state, other_state;
            for (int f = 0; f < 3 * frames(); ++f) {
                View view;
                view.eye = {random.uniform(-4, 26), random.uniform(-3, 3), random.below(2) ? -9.0 : 9.0};
                view.target = {random.uniform(-4, 26), 0, 0};
                view.near_plane = random.uniform(0, 0.3);
                test::prove(stage, *culler, view, state, 24, 48, random, with);
                test::prove(plain, *other, view, other_state, 1, 0, random, without);
                if (HasFailure())
                    FAIL() << "trial " << trial << " frame " << f;
            }
        }
    }
    EXPECT_GT(with.hidden, without.hidden) << "shells hide more than the mesh's own triangles";
}

TEST(OcclusionProof, slits_narrower_than_a_pixel_stay_open) {
    ProofCounts counts[std::size(kMethods)];
    for (std::uint32_t trial = 0; trial < 40; ++trial) {
        Random random(22, trial);
        Result<Scene> scene = Scene::create(test::slit_wall(random, 14, 150));
        ASSERT_TRUE(scene.ok());
        Stage stage(std::move(*scene));
        for (std::size_t m = 0; m < std::size(kMethods); ++m) {
            CullerOptions options;
            options.raster_width = 32 << random.below(4);
            auto culler = make(kMethods[m], stage, options);
            ViewState state;
            for (int f = 0; f < frames(); ++f) {
                View view = test::random_view(random, {0, 0, 0}, 3);
                view.eye.z = random.uniform(2, 12);
                view.target = {random.uniform(-4, 4), random.uniform(-2, 2), 0};
                view.up = {0, 1, 0};
                view.fov_y_deg = random.uniform(20, 90);
                view.far_plane = INFINITY;
                if (problem_of(view) == nullptr)
                    test::prove(stage, *culler, view, state, 16, 48, random, counts[m]);
                if (HasFailure())
                    FAIL() << "trial " << trial << " frame " << f;
            }
        }
    }
    for (std::size_t m = 0; m < std::size(kMethods); ++m) {
        EXPECT_GT(counts[m].hidden * 20, counts[m].in_frustum) << kMethods[m] << " culls next to nothing";
    }
}

} // namespace
} // namespace antumbra
