// The scenes in which culling goes wrong elsewhere, one test each, for every method that claims to lose nothing.
#include "cull/proof.hpp"

namespace antumbra {
namespace {

using test::Stage;

/// Builds scenes of a few rectangles, looked at from the origin along -z unless told otherwise.
struct Builder {
    RawScene raw;
    Vec3d shift;
    Builder() { raw.source = "safety"; }

    std::uint32_t quad(const Vec3d& a, const Vec3d& u, const Vec3d& w, std::uint32_t flags = kOccludes | kDoubleSided) {
        RawObject object;
        object.name = "o" + std::to_string(raw.objects.size());
        object.flags = flags;
        object.first_triangle = std::uint32_t(raw.triangles.size());
        object.triangle_count = 2;
        auto base = std::uint32_t(raw.positions.size());
        for (const Vec3d& p : {a, a + u, a + u + w, a + w})
            raw.positions.push_back(p + shift);
        raw.triangles.push_back({base, base + 1, base + 2});
        raw.triangles.push_back({base, base + 2, base + 3});
        raw.objects.push_back(object);
        return std::uint32_t(raw.objects.size() - 1);
    }
    /// x0..x1, y0..y1 at depth z, its front towards +z.
    std::uint32_t wall(double x0, double x1, double y0, double y1, double z, std::uint32_t flags = kOccludes | kDoubleSided) {
        return quad({x0, y0, z}, {x1 - x0, 0, 0}, {0, y1 - y0, 0}, flags);
    }
};

const char* const kMethods[] = {"hzb", "masked", "planes", "planes-published", "tree-fse", "tree-fme", "tree-fmc", "tree", "opacity", "opacity-published"};

View looking(const Vec3d& eye = {0, 0, 0}, const Vec3d& way = {0, 0, -1}) {
    View view;
    view.eye = eye;
    view.target = eye + way;
    view.near_plane = 0.01;
    view.aspect = 1;
    view.fov_y_deg = 60;
    return view;
}

enum class Published { same, may_report };

/// For each method: does it report `object`? The view is relative to the builder's shift.
void expect(const Builder& builder, View view, std::uint32_t object, bool visible, const char* what,
            Published rule = Published::same) {
    Result<Scene> scene = Scene::create(builder.raw);
    ASSERT_TRUE(scene.ok());
    view.eye = scene->to_local(view.eye + builder.shift);
    view.target = scene->to_local(view.target + builder.shift);
    Stage stage(std::move(*scene));
    for (const char* method : kMethods) {
        bool published = std::string_view(method) == "planes-published";
        bool by_cells = std::string_view(method).starts_with("tree-"); // cells of a few walls hold what is hidden and what hides
        CullerOptions options;
        options.tree.minimum_cost = 0; // the things in these scenes have two triangles
        options.opacity.width = options.opacity.height = 384; // so that a hundredth behind a wall shows
        options.opacity.adaptive = false;                     // two objects are not worth it
        auto culler = make_culler(method, stage.cull_scene, options);
        ASSERT_TRUE(culler.ok());
        ViewState state;
        CullResult result;
        for (int frame = 0; frame < 3; ++frame) // the later ones with warm caches
            (*culler)->cull(view, state, result);
        if (visible) {
            EXPECT_TRUE(result.is_visible(object)) << what << ": " << method;
        } else if (!by_cells && (!published || (view.projection == Projection::perspective && rule == Published::same))) {
            EXPECT_FALSE(result.is_visible(object)) << what << ": " << method;
        }
    }
}

TEST(Safety, a_thing_behind_a_wall_is_hidden_so_that_the_other_tests_mean_something) {
    Builder b;
    b.wall(-4, 4, -4, 4, -4);
    std::uint32_t thing = b.wall(-1, 1, -1, 1, -6);
    expect(b, looking(), thing, false, "plain wall");
}

TEST(Safety, coplanar_things_stay_visible) {
    Builder b;
    b.wall(-4, 4, -4, 4, -4);
    std::uint32_t picture = b.wall(-1, 1, -1, 1, -4);
    expect(b, looking(), picture, true, "a picture in the plane of the wall");
}

TEST(Safety, things_that_stick_out_in_front_stay_visible) {
    Builder b;
    b.wall(-4, 4, -4, 4, -4);
    std::uint32_t shelf = b.quad({-1, 0, -5}, {2, 0, 0}, {0, 0, 1.001}); // from behind the wall to just in front
    expect(b, looking({0, 0.5, 0}), shelf, true, "a shelf through the wall");
}

TEST(Safety, touching_from_behind_is_not_in_front) {
    Builder b;
    b.wall(-4, 4, -4, 4, -4);
    std::uint32_t behind = b.wall(-1, 1, -1, 1, -4.01);
    expect(b, looking(), behind, false, "a hundredth behind the wall");
}

TEST(Safety, an_occluder_nearer_than_the_near_plane_does_not_hide) {
    Builder b;
    b.wall(-4, 4, -4, 4, -1);
    std::uint32_t thing = b.wall(-1, 1, -1, 1, -6);
    View view = looking();
    view.near_plane = 2;
    expect(b, view, thing, true, "wall before the near plane");
    view.near_plane = 1.0001;
    expect(b, view, thing, true, "wall just before the near plane");
}

TEST(Safety, an_occluder_that_crosses_the_near_plane_hides_only_with_its_drawn_part) {
    Builder b;
    // A slanted wall: at x = -4 it is at depth 0.5, at x = 4 at depth 4.5.
    b.quad({-4, -4, -0.5}, {8, 0, -4}, {0, 8, 0});
    std::uint32_t left = b.wall(-5, -4, -0.2, 0.2, -9), right = b.wall(2.5, 3, -0.2, 0.2, -9);
    View view = looking();
    view.near_plane = 2; // the wall is drawn from x = -1 on
    expect(b, view, left, true, "through the clipped part");
    expect(b, view, right, false, "behind the drawn part", Published::may_report); // it uses whole occluders only
}

TEST(Safety, walls_beside_the_viewer_that_begin_behind_hide) {
    Builder b;
    b.quad({2, -3, 20}, {0, 0, -60}, {0, 6, 0}); // a street wall from z = 20 to -40 at x = 2
    std::uint32_t beyond = b.wall(6, 7, -0.2, 0.2, -10);
    expect(b, looking(), beyond, false, "behind a street wall");
}

TEST(Safety, orthographic_views_cull_and_lose_nothing) {
    Builder b;
    b.wall(-2, 2, -2, 2, -4);
    std::uint32_t hidden = b.wall(-1, 1, -1, 1, -6), beside = b.wall(1.9, 2.1, 0, 0.1, -6);
    View view = looking();
    view.projection = Projection::orthographic;
    view.height = 10;
    expect(b, view, hidden, false, "orthographic, behind");
    expect(b, view, beside, true, "orthographic, past the edge");
    view.near_plane = -10; // near planes behind the eye are fine here
    expect(b, view, hidden, false, "orthographic, near plane behind the eye");
    view.near_plane = 5;
    expect(b, view, hidden, true, "orthographic, wall before the near plane");
}

TEST(Safety, gaps_of_every_width_stay_open) {
    for (int exponent = 0; exponent >= -18; --exponent) {
        Builder b;
        double gap = std::ldexp(1.0, exponent);
        b.wall(-4, 0, -4, 4, -4);
        b.wall(gap, 4, -4, 4, -4);
        std::uint32_t thing = b.wall(-1, 1, -1, 1, -6);
        expect(b, looking(), thing, true, ("gap 2^" + std::to_string(exponent)).c_str());
    }
}

TEST(Safety, touching_walls_leave_no_crack_and_hide_together) {
    Builder b;
    b.wall(-4, 0, -4, 4, -4);
    b.wall(0, 4, -4, 4, -4);
    std::uint32_t thing = b.wall(-0.5, 0.5, -0.5, 0.5, -6);
    expect(b, looking(), thing, false, "two walls with a common edge");
}

TEST(Safety, duplicate_occluders_do_no_harm) {
    Builder b;
    b.wall(-4, 4, -4, 4, -4);
    b.wall(-4, 4, -4, 4, -4);
    std::uint32_t hidden = b.wall(-1, 1, -1, 1, -6), beside = b.wall(5, 7, -1, 1, -6);
    expect(b, looking(), hidden, false, "behind duplicates");
    expect(b, looking({0, 0, 0}, {0.5, 0, -1}), beside, true, "past duplicates");
}

TEST(Safety, t_junctions_never_hide_what_a_crack_shows) {
    Builder b;
    b.wall(-4, 0, -4, 4, -4);
    b.wall(0.000001, 4, -4, 1, -4); // the left wall's edge meets two others, one of which stands off
    b.wall(0, 4, 1, 4, -4);
    std::uint32_t thing = b.wall(-0.5, 0.5, -0.5, 0.5, -6);
    expect(b, looking(), thing, true, "crack at a T-junction");
}

TEST(Safety, back_faces_of_single_sided_walls_hide_nothing) {
    Builder b;
    b.quad({4, -4, -4}, {-8, 0, 0}, {0, 8, 0}, kOccludes); // its front looks to -z
    std::uint32_t thing = b.wall(-1, 1, -1, 1, -6);
    expect(b, looking(), thing, true, "from behind a single-sided wall");
    expect(b, looking({0, 0, -10}, {0, 0, 1}), thing, true, "in front of the wall");
    Builder other;
    other.wall(-4, 4, -4, 4, -4, kOccludes); // its front looks to the viewer
    thing = other.wall(-1, 1, -1, 1, -6);
    expect(other, looking(), thing, false, "behind the front of a single-sided wall");
}

TEST(Safety, walls_that_let_light_through_hide_nothing) {
    Builder b;
    b.wall(-4, 4, -4, 4, -4, kDoubleSided);
    std::uint32_t thing = b.wall(-1, 1, -1, 1, -6);
    expect(b, looking(), thing, true, "behind glass");
}

TEST(Safety, an_eye_in_the_plane_of_a_wall_sees_past_it) {
    Builder b;
    b.wall(-4, 4, -4, 4, -4);
    std::uint32_t thing = b.wall(-1, 1, -1, 1, -6);
    expect(b, looking({-10, 0, -4}, {1, 0, -0.2}), thing, true, "edge-on");
    expect(b, looking({-10, 0, std::nextafter(-4.0, 0.0)}, {1, 0, -0.2}), thing, true, "all but edge-on");
}

TEST(Safety, far_from_the_origin_nothing_changes) {
    for (double distance : {1e3, 1e6, 1e8}) {
        Builder b;
        b.shift = {distance, -distance, 3 * distance};
        b.wall(-4, 4, -4, 4, -4);
        std::uint32_t hidden = b.wall(-1, 1, -1, 1, -6), beside = b.wall(6, 6.5, -1, 1, -6);
        expect(b, looking(), hidden, false, "far away, behind");
        expect(b, looking({0, 0, 0}, {1, 0, -1}), beside, true, "far away, beside");
    }
}

TEST(Safety, views_far_from_a_small_scene_lose_nothing) {
    Builder b;
    b.wall(-4, 4, -4, 4, -4);
    std::uint32_t beside = b.wall(4.5, 5, -1, 1, -6);
    View view = looking({0, 0, 1e6});
    view.fov_y_deg = 0.002;
    expect(b, view, beside, true, "through a telescope");
}

TEST(Safety, extreme_fields_of_view_lose_nothing) {
    Builder b;
    b.wall(-4, 4, -4, 4, -4);
    std::uint32_t beside = b.wall(30, 31, -1, 1, -6);
    View view = looking();
    view.fov_y_deg = 175;
    expect(b, view, beside, true, "wide, beside");
}

TEST(Safety, a_near_plane_of_zero_is_fine) {
    Builder b;
    b.wall(-4, 4, -4, 4, -4);
    std::uint32_t hidden = b.wall(-1, 1, -1, 1, -6);
    View view = looking();
    view.near_plane = 0;
    expect(b, view, hidden, false, "near plane at the eye");
}

TEST(Safety, an_eye_within_a_shell_is_not_fooled_by_its_inner_box) {
    // A finely divided single-sided box: its inner box hides what is behind it from outside. From between shell and
    // inner box one sees out through the backs of the shell, so there the inner box must hide nothing.
    Builder b;
    RawObject shell;
    shell.name = "shell";
    shell.flags = kOccludes;
    const int n = 10;
    for (int face = 0; face < 6; ++face) {
        int axis = face / 2, u = (axis + 1) % 3, v = (axis + 2) % 3;
        auto base = std::uint32_t(b.raw.positions.size());
        for (int j = 0; j <= n; ++j)
            for (int i = 0; i <= n; ++i) {
                Vec3d p;
                p[axis] = face % 2 ? 10 : 0;
                // Not a lattice: the faces are bumpy outward, so that nothing merges into large polygons.
                p[u] = 10.0 * i / n;
                p[v] = 10.0 * j / n;
                if (i > 0 && j > 0 && i < n && j < n)
                    p[axis] += (face % 2 ? 1 : -1) * 0.1 * ((i * 7 + j * 5) % 3);
                b.raw.positions.push_back(p);
            }
        for (std::uint32_t j = 0; j < n; ++j)
            for (std::uint32_t i = 0; i < n; ++i) {
                std::uint32_t a = base + i + (n + 1) * j, c1 = a + 1, c2 = a + n + 2, c3 = a + n + 1;
                if (face % 2 == 0)
                    std::swap(c1, c3);
                b.raw.triangles.push_back({a, c1, c2});
                b.raw.triangles.push_back({a, c2, c3});
            }
    }
    shell.triangle_count = std::uint32_t(b.raw.triangles.size());
    b.raw.objects.push_back(shell);
    std::uint32_t thing = b.wall(4, 6, 4, 6, -30);
    Result<Scene> scene = Scene::create(b.raw);
    ASSERT_TRUE(scene.ok());
    OccluderStatistics statistics;
    find_occluders(*scene, {}, &statistics);
    ASSERT_EQ(statistics.inner_boxes, 1u);
    expect(b, looking({5, 5, 30}), thing, false, "from outside");
    expect(b, looking({4, 5, 10.1}), thing, true, "from within the shell, under a bump");
    expect(b, looking({5, 5, 5}), thing, true, "from within the inner box");
}

TEST(Safety, no_occluders_or_none_allowed_means_frustum_only_and_says_so) {
    Builder b;
    b.wall(-4, 4, -4, 4, -4, kDoubleSided);
    std::uint32_t thing = b.wall(-1, 1, -1, 1, -6, kDoubleSided);
    expect(b, looking(), thing, true, "nothing occludes");
    Builder solid;
    solid.wall(-4, 4, -4, 4, -4);
    thing = solid.wall(-1, 1, -1, 1, -6);
    Result<Scene> made = Scene::create(solid.raw);
    Stage stage(std::move(*made));
    for (const char* method : {"planes", "planes-published", "tree-fse"}) {
        CullerOptions options;
        options.occluders = 0;
        ViewState state;
        CullResult result;
        (*make_culler(method, stage.cull_scene, options))->cull(looking(), state, result);
        EXPECT_TRUE(result.is_visible(thing));
        EXPECT_STREQ(result.reason, "no occluders allowed: frustum only");
    }
}

TEST(Safety, methods_without_occluders_cull_by_the_frustum_and_says_why) {
    Builder b;
    b.wall(-4, 4, -4, 4, -4, kDoubleSided); // seen, but hides nothing
    std::uint32_t thing = b.wall(-1, 1, -1, 1, -6, kDoubleSided), behind = b.wall(-1, 1, -1, 1, 6, kDoubleSided);
    Result<Scene> made = Scene::create(b.raw);
    View view = looking(made->to_local({0, 0, 0}));
    Stage stage(std::move(*made));
    for (const char* method : kMethods) {
        ViewState state;
        CullResult result;
        (*make_culler(method, stage.cull_scene))->cull(view, state, result);
        EXPECT_TRUE(result.is_visible(thing)) << method;
        if (std::string_view(method).substr(0, 4) != "tree") { // they draw what is cheap without any test
            EXPECT_FALSE(result.is_visible(behind)) << method;
        }
        EXPECT_NE(std::string_view(result.reason).find("no occluders"), std::string_view::npos) << method;
        EXPECT_EQ(result.counters.occluders_used, 0u) << method;
    }
}

TEST(Safety, reversed_z_changes_nothing_and_a_far_plane_only_cuts) {
    Builder b;
    b.wall(-4, 4, -4, 4, -4);
    std::uint32_t hidden = b.wall(-1, 1, -1, 1, -6), near = b.wall(-1, 1, -1, 1, -3);
    View view = looking();
    view.far_plane = 5;
    expect(b, view, near, true, "before the far plane");
    expect(b, view, hidden, false, "beyond the far plane");
}

/// Coordinates are snapped to a grid when a scene is made: the narrowest gap there is has one step of it, which in floats
/// is one unit in the last place or a few.
TEST(Safety, a_gap_of_one_step_of_the_grid_stays_open) {
    int open = 0;
    double narrowest = 1;
    for (int exponent = -10; exponent >= -30; --exponent) {
        Builder b;
        double gap = std::ldexp(1.0, exponent);
        std::uint32_t left = b.wall(-4, 3, -4, 4, -4), right = b.wall(3 + gap, 4, -4, 4, -4);
        std::uint32_t thing = b.wall(2, 5, -1, 1, -6);
        Result<Scene> scene = Scene::create(b.raw);
        ASSERT_TRUE(scene.ok());
        double width = double(scene->objects()[right].bounds.min.x) - double(scene->objects()[left].bounds.max.x);
        if (!(width > 0))
            break; // closed by snapping: no gap any more
        ++open;
        narrowest = width;
        expect(b, looking({3, 0, 0}), thing, true, ("gap 2^" + std::to_string(exponent)).c_str());
    }
    EXPECT_GE(open, 8);
    EXPECT_LE(narrowest, 0x1p-19) << "the grid of a scene of this size is finer";
}

TEST(Safety, things_that_cross_the_near_plane_or_hold_the_eye_stay_visible) {
    Builder b;
    b.wall(-4, 4, -4, 4, -4);
    std::uint32_t crossing = b.quad({-0.1, 0, -0.5}, {0.2, 0, 0}, {0, 0, -8}); // its box begins before the near plane
    std::uint32_t around = b.quad({-1, -0.5, 1}, {2, 0, 0}, {0, 1, -9});       // its box holds the eye
    View view = looking({0, 0.2, 0});
    view.near_plane = 1;
    expect(b, view, crossing, true, "across the near plane");
    expect(b, view, around, true, "around the eye");
    view.near_plane = 0;
    expect(b, view, around, true, "around the eye, near plane at the eye");
    view.projection = Projection::orthographic;
    view.height = 8;
    view.near_plane = 1;
    expect(b, view, around, true, "orthographic, around the eye");
}

TEST(Safety, narrow_flat_and_skewed_views_lose_nothing) {
    Builder b;
    b.wall(-4, 4, -4, 4, -4);
    std::uint32_t hidden = b.wall(-1, 1, -1, 1, -6), beside = b.wall(6.5, 7, -1, 1, -6);
    for (double aspect : {0.02, 1.0, 50.0})
        for (const Vec3d& up : {Vec3d{0, 1, 0}, Vec3d{1, 1, 0}, Vec3d{1, 0, 0}, Vec3d{0.3, 0.2, -5}}) {
            View view = looking();
            view.aspect = aspect;
            view.up = up;
            if (aspect == 1.0)
                expect(b, view, hidden, false, "skewed, behind", Published::may_report);
            view.target = Vec3d{6.75, 0, -6}; // past the edge
            expect(b, view, beside, true, "skewed, beside");
            view.fov_y_deg = 0.01;
            expect(b, view, beside, true, "skewed, through a telescope");
        }
}

TEST(Safety, an_eye_on_behind_and_inside_the_planes_of_a_box_sees_what_it_sees) {
    Builder b;
    // A closed box, single-sided, its fronts outside.
    const double s = 2;
    b.quad({-s, -s, s}, {2 * s, 0, 0}, {0, 2 * s, 0}, kOccludes);
    b.quad({s, -s, -s}, {-2 * s, 0, 0}, {0, 2 * s, 0}, kOccludes);
    b.quad({s, -s, s}, {0, 0, -2 * s}, {0, 2 * s, 0}, kOccludes);
    b.quad({-s, -s, -s}, {0, 0, 2 * s}, {0, 2 * s, 0}, kOccludes);
    b.quad({-s, s, s}, {2 * s, 0, 0}, {0, 0, -2 * s}, kOccludes);
    b.quad({-s, -s, -s}, {2 * s, 0, 0}, {0, 0, 2 * s}, kOccludes);
    std::uint32_t thing = b.wall(-0.5, 4, -0.5, 4, -8);
    expect(b, looking({0, 0, 8}), thing, false, "from outside");
    expect(b, looking({0, 0, 0}), thing, true, "from inside: the backs hide nothing");
    expect(b, looking({0, 0, -s}), thing, true, "on the far side");
    expect(b, looking({0, 0, std::nextafter(-s, -3.0)}), thing, true, "just beyond the far side");
    expect(b, looking({s, 0, 8}), thing, true, "in the plane of a side");
    expect(b, looking({s, s, 8}, {-0.1, -0.1, -1}), thing, true, "on two planes at once");
    expect(b, looking({0, s, 8}, {0, -0.1, -1}), thing, true, "in the plane of the top");
}

} // namespace
} // namespace antumbra
