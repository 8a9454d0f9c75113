// Shadows that hide together what none of them hides alone: claims with literal answers, and random walls by lines of sight.
#include "cull/joined_shadows.hpp"
#include "cull/proof.hpp"
#include "support/make_scene.hpp"

namespace antumbra {
namespace {

using test::Stage;

/// Two walls that share no edge, one 0.5 before the other and reaching `overlap` across it as seen from the eye, and a thing behind.
Stage two_walls(double overlap) {
    test::SceneMaker maker;
    maker.object("left", kOccludes | kDoubleSided).quad({-20, -10, 0}, {0, -10, 0}, {0, 10, 0}, {-20, 10, 0});
    maker.object("right", kOccludes | kDoubleSided).quad({-overlap, -10, -0.5}, {20, -10, -0.5}, {20, 10, -0.5}, {-overlap, 10, -0.5});
    maker.object("thing").box({-0.5, -0.5, -5}, {0.5, 0.5, -4});
    return Stage(maker.scene());
}

/// Whether the shadows of both walls are needed and enough to hide the thing.
bool is_hidden_by_both(const Stage& stage) {
    const CullScene::Data& scene = stage.cull_scene.data();
    View view;
    view.eye = stage.scene->to_local({0, 0, 10});
    view.target = stage.scene->to_local({0, 0, 0});
    Camera camera = camera_of(view);
    SightStart sight = sight_start(camera, scene.tree_box);
    FrustumPlanes planes = frustum_planes(camera, scene.tree_box);
    std::vector<Shadow> shadows;
    for (const ConvexGroups::Group& group : scene.groups.groups) {
        Shadow shadow;
        const OccluderPolygon& first = scene.occluders.polygons[scene.groups.members[group.first]];
        if (first.object < 2 && !first.synthetic &&
            cast_shadow(scene.occluders, std::span(scene.groups.members).subspan(group.first, group.count), sight, shadow))
            shadows.push_back(shadow);
    }
    EXPECT_EQ(shadows.size(), 2u);
    const Box3f& thing = scene.bounds[2];
    for (int alone = 0; alone < 2; ++alone)
        EXPECT_EQ(find_joined_shadows(thing, shadows, 1u << alone, -1, 4, planes, 0).first, -1);
    JoinedShadows joined = find_joined_shadows(thing, shadows, 3, -1, 4, planes, 0);
    EXPECT_EQ(joined.used, joined.first < 0 ? 0u : 3u);
    return joined.first >= 0;
}

TEST(JoinedShadows, walls_without_a_shared_edge_hide_together_and_a_slit_shows) {
    EXPECT_TRUE(is_hidden_by_both(two_walls(0.1)));
    EXPECT_TRUE(is_hidden_by_both(two_walls(0.001)));
    EXPECT_FALSE(is_hidden_by_both(two_walls(-0.001)));
    EXPECT_FALSE(is_hidden_by_both(two_walls(-0.1)));
}

/// Walls in rows, some with gaps: nothing that a line of sight meets is hidden, and much more is than single walls hide.
TEST(JoinedShadows, random_walls_lose_no_line_of_sight) {
    test::ProofCounts counts;
    for (std::uint32_t trial = 0; trial < 30; ++trial) {
        Random random(91, trial);
        Result<Scene> scene = Scene::create(test::slit_wall(random, 12, 60));
        ASSERT_TRUE(scene.ok());
        Stage stage(std::move(*scene));
        auto culler = std::move(make_culler("planes", stage.cull_scene)).value();
        ViewState state;
        View view;
        view.near_plane = 0.05;
        for (int f = 0; f < 12; ++f) {
            view.eye = stage.scene->to_local({random.uniform(-8, 8), random.uniform(-4, 4), random.uniform(2, 8)});
            view.target = view.eye + Vec3d{random.uniform(-0.4, 0.4), random.uniform(-0.3, 0.3), -1};
            test::prove(stage, *culler, view, state, 16, 48, random, counts);
            ASSERT_FALSE(HasFailure()) << "trial " << trial << " frame " << f;
        }
    }
    EXPECT_GT(counts.hidden * 10, counts.in_frustum);
}

} // namespace
} // namespace antumbra
