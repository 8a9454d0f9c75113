// `opacity`: laws between its forms, what its options do, and when it gives up.
#include "cull/adaptive_stop.hpp"
#include "cull/opacity_occluders.hpp"
#include "cull/proof.hpp"

#include <bit>

namespace antumbra {
namespace {

using test::Stage;

CullerOptions plain(OpacityForm form) {
    CullerOptions options;
    options.opacity.form = form;
    options.opacity.choice = OpacityChoice::as_listed; // the same occluders in every form
    options.opacity.width = options.opacity.height = 128;
    options.opacity.adaptive = false;
    options.opacity.stop_below = 0;
    return options;
}

std::unique_ptr<Culler> make(const Stage& stage, const CullerOptions& options = {}, const char* name = "opacity") {
    auto culler = make_culler(name, stage.cull_scene, options);
    EXPECT_TRUE(culler.ok()) << culler.status().message();
    return std::move(culler).value();
}

Stage soup(std::uint32_t trial) {
    Random random(81, trial);
    Result<Scene> scene = Scene::create(test::random_soup(random, 60, 8));
    return Stage(std::move(*scene));
}

std::uint64_t count_without(const CullResult& a, const CullResult& b) {
    std::uint64_t sum = 0;
    for (std::size_t word = 0; word < a.visible.size(); ++word)
        sum += std::uint64_t(std::popcount(a.visible[word] & ~b.visible[word]));
    return sum;
}

/// At the same resolution with the same occluders the bits hide all that the table hides.
TEST(Opacity, the_modern_form_is_at_least_as_tight_as_the_published) {
    std::uint64_t hidden = 0;
    for (std::uint32_t trial = 0; trial < 30; ++trial) {
        Stage stage = soup(trial);
        auto modern = make(stage, plain(OpacityForm::modern));
        auto published = make(stage, plain(OpacityForm::published));
        auto pixel_wise = make(stage, plain(OpacityForm::pixel_wise));
        ViewState a, b, c;
        CullResult of_modern, of_published, of_pixels;
        Random random(82, trial);
        for (int frame = 0; frame < 30; ++frame) {
            View view = test::random_view(random, {0, 0, 0}, 8);
            modern->cull(view, a, of_modern);
            published->cull(view, b, of_published);
            pixel_wise->cull(view, c, of_pixels);
            ASSERT_EQ(count_without(of_modern, of_published), 0u) << trial << " " << frame;
            ASSERT_EQ(of_published.visible, of_pixels.visible) << trial << " " << frame;
            hidden += of_published.counters.hidden_by_raster;
        }
    }
    EXPECT_GT(hidden, 100u);
}

TEST(Opacity, choosing_by_gain_draws_what_covers_open_pixels_and_keeps_to_the_limit) {
    std::uint64_t hidden = 0, hidden_by_few = 0, drawn = 0;
    for (std::uint32_t trial = 0; trial < 20; ++trial) {
        Stage stage = soup(trial);
        CullerOptions many = plain(OpacityForm::modern), few = many;
        many.opacity.choice = few.opacity.choice = OpacityChoice::by_gain;
        many.opacity.occluders = 100000;
        few.opacity.occluders = 12;
        auto all = make(stage, many), limited = make(stage, few);
        ViewState a, b;
        CullResult of_all, of_few;
        Random random(87, trial);
        for (int frame = 0; frame < 20; ++frame) {
            View view = test::random_view(random, {0, 0, 0}, 8);
            all->cull(view, a, of_all);
            limited->cull(view, b, of_few);
            ASSERT_LE(of_few.counters.polygons_drawn, 12u);
            ASSERT_FALSE(of_all.counters.budget_spent);
            ASSERT_LE(of_all.counters.patches_drawn, stage.occluders.patches.size());
            hidden += of_all.counters.hidden_by_raster;
            hidden_by_few += of_few.counters.hidden_by_raster;
            drawn += of_all.counters.polygons_drawn;
        }
    }
    EXPECT_GT(hidden, 200u);
    EXPECT_LT(hidden_by_few, hidden);
    EXPECT_GT(drawn, 1000u);
}

/// Stopping early never hides more, and a stop of nothing never stops.
TEST(Opacity, the_early_stop_only_reports_more) {
    std::uint64_t stopped = 0;
    for (std::uint32_t trial = 0; trial < 10; ++trial) {
        Stage stage = soup(trial);
        CullerOptions eager = plain(OpacityForm::published), patient = eager;
        eager.opacity.stop_below = 1;
        auto stopping = make(stage, eager);
        auto whole = make(stage, patient);
        ViewState a, b;
        CullResult with, without;
        Random random(83, trial);
        for (int frame = 0; frame < 30; ++frame) {
            View view = test::random_view(random, {0, 0, 0}, 8);
            stopping->cull(view, a, with);
            whole->cull(view, b, without);
            ASSERT_EQ(count_without(without, with), 0u);
            ASSERT_EQ(without.counters.stopped_early, 0u);
            stopped += with.counters.stopped_early;
        }
    }
    EXPECT_GT(stopped, 100u);
}

TEST(Opacity, only_whole_pixels_without_tolerance_are_called_conservative) {
    Stage stage = soup(1);
    auto guarantee = [&](OpacityCoverage coverage, float tolerance) {
        CullerOptions options;
        options.opacity.coverage = coverage;
        options.opacity.tolerance = tolerance;
        return (*make_culler("opacity", stage.cull_scene, options))->guarantee();
    };
    EXPECT_EQ(guarantee(OpacityCoverage::inner, 0), Guarantee::conservative);
    EXPECT_EQ(guarantee(OpacityCoverage::centre, 0), Guarantee::approximate);
    EXPECT_EQ(guarantee(OpacityCoverage::inner, 0.01f), Guarantee::approximate);
}

TEST(Opacity, options_that_make_no_sense_are_refused) {
    Stage stage = soup(1);
    auto code = [&](auto&& change) {
        CullerOptions options;
        change(options.opacity);
        auto culler = make_culler("opacity", stage.cull_scene, options);
        return culler ? ErrorCode::ok : culler.status().code();
    };
    EXPECT_EQ(code([](OpacityOptions&) {}), ErrorCode::ok);
    EXPECT_EQ(code([](OpacityOptions& o) { o.width = 7; }), ErrorCode::usage);
    EXPECT_EQ(code([](OpacityOptions& o) { o.height = 4096; }), ErrorCode::usage);
    EXPECT_EQ(code([](OpacityOptions& o) { o.tolerance = NAN; }), ErrorCode::usage);
    EXPECT_EQ(code([](OpacityOptions& o) { o.stop_below = -1; }), ErrorCode::usage);
    EXPECT_EQ(code([](OpacityOptions& o) { o.object_seconds = NAN; }), ErrorCode::usage);
    OccluderDatabase broken; // says one point, has no list
    EXPECT_EQ(code([&](OpacityOptions& o) { o.database = &broken; }), ErrorCode::corrupt);
}

TEST(Opacity, a_database_is_asked_at_its_nearest_point) {
    OccluderDatabase database;
    database.origin = {0, 0, 0};
    database.step = {10, 1, 2};
    database.count = {3, 1, 2};
    EXPECT_EQ(database.points(), 6u);
    EXPECT_EQ(database.nearest({4.9, 0, 0}), 0u);
    EXPECT_EQ(database.nearest({5.1, 77, 0.9}), 1u);
    EXPECT_EQ(database.nearest({1e9, 0, 1.1}), 5u);
    EXPECT_EQ(database.nearest({-1e9, 0, -1e9}), 0u);
    EXPECT_LT(database.nearest({NAN, NAN, NAN}), 6u);
    EXPECT_EQ(database.point(5), (Vec3d{20, 0, 2}));
    EXPECT_EQ(OccluderDatabase::direction(3), (Vec3d{0, -1, 0}));
}

TEST(Opacity, a_damaged_database_is_refused) {
    OccluderDatabase good;
    good.first = {0, 1, 1, 1, 1, 1, 2};
    good.polygons = {4, 0};
    EXPECT_TRUE(check_occluder_database(good, 5).ok());
    EXPECT_FALSE(check_occluder_database(good, 4).ok()) << "polygon 4 of 4";
    for (auto change : std::initializer_list<void (*)(OccluderDatabase&)>{
             [](OccluderDatabase& d) { d.first[2] = 0; }, [](OccluderDatabase& d) { d.first.pop_back(); },
             [](OccluderDatabase& d) { d.first[0] = 1; }, [](OccluderDatabase& d) { d.polygons.pop_back(); },
             [](OccluderDatabase& d) { d.count[1] = 0; }, [](OccluderDatabase& d) { d.step.y = 0; },
             [](OccluderDatabase& d) { d.origin.z = NAN; }, [](OccluderDatabase& d) { d.count = {1u << 20, 1u << 20, 1u << 20}; }}) {
        OccluderDatabase bad = good;
        change(bad);
        EXPECT_FALSE(check_occluder_database(bad, 5).ok());
    }
}

TEST(Opacity, a_database_comes_back_from_its_bytes_and_damage_is_noticed) {
    Random random(86);
    std::uint64_t refused = 0;
    for (int trial = 0; trial < 200; ++trial) {
        OccluderDatabase database;
        database.count = {1 + random.below(4), 1 + random.below(2), 1 + random.below(3)};
        database.origin = {random.uniform(-9, 9), 0, random.uniform(-9, 9)};
        database.first = {0};
        for (std::size_t i = 0; i < database.points() * OccluderDatabase::kDirections; ++i) {
            for (std::uint32_t k = random.below(4); k > 0; --k)
                database.polygons.push_back(random.below(1000));
            database.first.push_back(std::uint32_t(database.polygons.size()));
        }
        std::vector<std::byte> bytes = encode_occluder_database(database);
        auto back = decode_occluder_database(bytes, 1000);
        ASSERT_TRUE(back.ok()) << back.status().message();
        ASSERT_EQ(back->first, database.first);
        ASSERT_EQ(back->polygons, database.polygons);
        ASSERT_EQ(back->origin, database.origin);
        ASSERT_EQ(back->count, database.count);
        for (std::size_t cut = 0; cut < bytes.size(); ++cut)
            ASSERT_FALSE(decode_occluder_database({bytes.data(), cut}, 1000).ok());
        for (int flips = 0; flips < 50; ++flips) { // whatever still decodes is at least safe to use
            std::vector<std::byte> damaged = bytes;
            damaged[random.below(std::uint32_t(bytes.size()))] ^= std::byte(1u << random.below(8));
            auto read = decode_occluder_database(damaged, 1000);
            refused += !read.ok();
            if (read.ok()) {
                ASSERT_TRUE(check_occluder_database(*read, 1000).ok());
            }
        }
    }
    EXPECT_GT(refused, 1000u);
}

/// A wall, a thing behind it, and things beside it.
Stage wall_and_things() {
    RawScene raw;
    raw.source = "wall";
    auto quad = [&](double x, double y, double z, double size) {
        RawObject object;
        object.flags = kOccludes | kDoubleSided;
        object.first_triangle = std::uint32_t(raw.triangles.size());
        object.triangle_count = 2;
        auto base = std::uint32_t(raw.positions.size());
        for (int corner = 0; corner < 4; ++corner)
            raw.positions.push_back({x + (corner == 1 || corner == 2 ? size : 0), y + (corner > 1 ? size : 0), z});
        raw.triangles.push_back({base, base + 1, base + 2});
        raw.triangles.push_back({base, base + 2, base + 3});
        raw.objects.push_back(object);
    };
    quad(-4, -4, -4, 8);
    for (int i = 0; i < 40; ++i)
        quad(-1 + 0.05 * i, -1, -6 - 0.1 * i, 1);
    Result<Scene> scene = Scene::create(std::move(raw));
    return Stage(std::move(*scene));
}

View looking_at_the_wall(const Stage& stage) {
    View view;
    view.eye = stage.scene->to_local({0, 0, 0});
    view.target = stage.scene->to_local({0, 0, -1});
    view.near_plane = 0.01;
    view.aspect = 1;
    return view;
}

TEST(Opacity, what_a_database_does_not_name_hides_nothing) {
    Stage stage = wall_and_things();
    std::uint32_t wall = 0; // the largest polygon
    for (std::uint32_t p = 0; p < stage.occluders.polygons.size(); ++p)
        if (stage.occluders.polygons[p].area > stage.occluders.polygons[wall].area)
            wall = p;
    OccluderDatabase database;
    database.first = {0, 0, 0, 0, 0, 0, 1};
    database.polygons = {wall};
    for (bool named : {true, false}) {
        if (!named) {
            database.first = {0, 0, 0, 0, 0, 0, 0};
            database.polygons.clear();
        }
        CullerOptions options = plain(OpacityForm::modern);
        options.opacity.database = &database;
        ViewState state;
        CullResult result;
        (*make_culler("opacity", stage.cull_scene, options))->cull(looking_at_the_wall(stage), state, result);
        EXPECT_EQ(result.counters.occluders_used, named ? 1u : 0u);
        EXPECT_EQ(result.visible_count, named ? 1u : 41u);
    }
}

double thousand_seconds_a_call() {
    static double now = 0;
    return now += 1000;
}

TEST(Opacity, it_switches_itself_off_when_it_does_not_pay_and_loses_nothing_by_it) {
    Stage stage = wall_and_things();
    CullerOptions options = plain(OpacityForm::modern);
    options.opacity.adaptive = true;
    options.opacity.stop_below = 0.2f;
    options.opacity.clock = thousand_seconds_a_call;
    auto culler = make(stage, options);
    auto frustum = make(stage, {}, "frustum");
    ViewState state, plain_state;
    CullResult result, expected;
    int off = 0;
    for (int frame = 0; frame < 400; ++frame) {
        culler->cull(looking_at_the_wall(stage), state, result);
        off += result.counters.switched_off;
        if (!result.counters.switched_off)
            continue;
        frustum->cull(looking_at_the_wall(stage), plain_state, expected);
        ASSERT_EQ(result.visible, expected.visible);
    }
    EXPECT_GT(off, 370);
    EXPECT_LT(off, 400) << "it tries again now and then";
}

/// Two objects cost less to draw than a map: it is never drawn, and the answer is the frustum's.
TEST(Opacity, it_does_not_begin_where_everything_is_cheap) {
    Stage stage = wall_and_things();
    CullerOptions options;
    auto frustum = make(stage, {}, "frustum");
    for (double seconds : {1e-9, 1e-3}) {
        options.opacity.object_seconds = seconds;
        auto culler = make(stage, options);
        ViewState state, plain_state;
        CullResult result, expected;
        for (int frame = 0; frame < 10; ++frame) {
            culler->cull(looking_at_the_wall(stage), state, result);
            EXPECT_EQ(result.counters.switched_off, seconds < 1e-6);
            EXPECT_EQ(result.counters.patches_drawn > 0, seconds > 1e-6);
            frustum->cull(looking_at_the_wall(stage), plain_state, expected);
            if (seconds < 1e-6)
                EXPECT_EQ(result.visible, expected.visible);
            else
                EXPECT_EQ(result.visible_count, 1u);
        }
    }
}

TEST(Opacity, without_a_clock_every_run_reports_the_same) {
    Stage stage = soup(3);
    auto reported = [&] {
        auto culler = make(stage);
        ViewState state;
        CullResult result;
        std::vector<std::vector<std::uint64_t>> all;
        Random random(84);
        for (int frame = 0; frame < 200; ++frame) {
            culler->cull(test::random_view(random, {0, 0, 0}, 8), state, result);
            all.push_back(result.visible);
        }
        return all;
    };
    EXPECT_EQ(reported(), reported());
}

TEST(AdaptiveStop, rises_while_it_does_not_pay_and_comes_back) {
    AdaptiveStop stop(0.2f);
    EXPECT_FALSE(stop.sits_out());
    stop.learn(2, 1);
    EXPECT_FLOAT_EQ(stop.stop_below(), 0.3f);
    stop.learn(1, 2);
    stop.learn(1, 2);
    EXPECT_FLOAT_EQ(stop.stop_below(), 0.2f) << "never below what was asked for";
}

TEST(AdaptiveStop, sits_out_one_two_four_and_at_most_sixty_four_frames) {
    AdaptiveStop stop(0.2f);
    std::vector<int> pauses;
    for (int pause = 0; pauses.size() < 9;) {
        if (stop.sits_out()) {
            ++pause;
            continue;
        }
        if (pause > 0)
            pauses.push_back(pause);
        pause = 0;
        stop.learn(2, 1);
    }
    EXPECT_EQ(pauses, (std::vector<int>{1, 2, 4, 8, 16, 32, 64, 64, 64}));
    stop.learn(1, 2);
    EXPECT_FALSE(stop.sits_out());
}

/// Each chosen polygon is in one patch or more, and patches hold chosen ones only.
TEST(OpacityOccluders, patches_hold_the_chosen_polygons) {
    for (std::uint32_t trial = 0; trial < 20; ++trial) {
        Stage stage = soup(trial);
        const CullScene::Data& scene = stage.cull_scene.data();
        OpacityOccluders occluders(scene);
        Random random(85, trial);
        for (int frame = 0; frame < 10; ++frame) {
            View view = test::random_view(random, {0, 0, 0}, 8);
            if (problem_of(view))
                continue;
            Camera camera = camera_of(view);
            occluders.choose(scene, nullptr, camera, frustum_planes(camera, scene.tree_box), 40);
            ASSERT_LE(occluders.polygons().size(), 40u);
            const PatchStore& store = occluders.patches(scene.occluders);
            std::size_t held = 0;
            for (const PatchRange& patch : store.patches)
                held += patch.polygon_count;
            ASSERT_GE(held, occluders.polygons().size());
            ASSERT_LE(store.patches.size(), occluders.polygons().size());
        }
    }
}

} // namespace
} // namespace antumbra
