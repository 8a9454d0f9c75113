// The parts of `planes-published` that the paper names: relations kept while the viewer moves, the sets that follow it, the
// trees of either rule.
#include "cull/proof.hpp"
#include "cull/relations.hpp"

#include <antumbra/generate.hpp>

namespace antumbra {
namespace {

using test::Stage;

/// A block of houses: walls of two metres' height in rows, things between them.
Stage rows_of_walls() {
    RawScene raw;
    raw.source = "rows";
    Random random(5);
    auto quad = [&](const Vec3d& a, const Vec3d& u, const Vec3d& w) {
        RawObject object;
        object.name = "o" + std::to_string(raw.objects.size());
        object.flags = kOccludes | kDoubleSided;
        object.first_triangle = std::uint32_t(raw.triangles.size());
        object.triangle_count = 2;
        auto base = std::uint32_t(raw.positions.size());
        for (const Vec3d& p : {a, a + u, a + u + w, a + w})
            raw.positions.push_back(p);
        raw.triangles.push_back({base, base + 1, base + 2});
        raw.triangles.push_back({base, base + 2, base + 3});
        raw.objects.push_back(object);
    };
    for (int row = 0; row < 12; ++row) {
        for (int i = 0; i < 6; ++i) // with gaps: several occluders
            quad({-30 + 10.0 * i, 0, -4.0 * row}, {9.5, 0, 0}, {0, 4, 0});
        for (int i = 0; i < 60; ++i)
            quad({random.uniform(-30, 29), random.uniform(0, 1.5), -4.0 * row - random.uniform(0.5, 3.5)}, {0.3, 0, 0.1},
                 {0, 0.3, 0});
    }
    Result<Scene> scene = Scene::create(raw);
    return Stage(std::move(*scene));
}

View in_front(const Stage& stage, double x = 0, double z = 5) {
    View view;
    view.eye = stage.scene->to_local({x, 1.6, z});
    view.target = view.eye + Vec3d{0, 0, -1};
    view.near_plane = 0.05;
    return view;
}

std::unique_ptr<Culler> make(const Stage& stage, PublishedPlanesOptions published = {}) {
    CullerOptions options;
    options.published = published;
    return std::move(make_culler("planes-published", stage.cull_scene, options)).value();
}

TEST(PlanesPublished, who_stands_still_forms_no_plane_again) {
    Stage stage = rows_of_walls();
    auto culler = make(stage);
    ViewState state;
    CullResult result;
    culler->cull(in_front(stage), state, result);
    EXPECT_GT(result.counters.relations_made, 0u);
    EXPECT_GT(result.counters.hidden_by_planes, 0u);
    for (int frame = 0; frame < 5; ++frame)
        culler->cull(in_front(stage), state, result);
    EXPECT_EQ(result.counters.relations_made, 0u);
    EXPECT_GT(result.counters.relations_cached, 0u);
}

TEST(PlanesPublished, who_looks_away_and_back_forms_no_plane_again) {
    Stage stage = rows_of_walls();
    auto culler = make(stage, {.adapt = false});
    ViewState state;
    CullResult result;
    View view = in_front(stage), away = view;
    away.target = view.eye + Vec3d{0, 0, 1};
    culler->cull(view, state, result);
    culler->cull(away, state, result); // everything is outside of the frustum
    EXPECT_EQ(result.visible_count, 0u);
    for (int frame = 0; frame < 40; ++frame)
        culler->cull(away, state, result);
    std::uint64_t made = 0;
    for (int frame = 0; frame < 20; ++frame) { // the set comes back little by little
        culler->cull(view, state, result);
        made += result.counters.relations_made;
    }
    EXPECT_EQ(made, 0u);
    EXPECT_GT(result.counters.relations_cached, 0u);
}

TEST(PlanesPublished, who_walks_slower_finds_more_relations) {
    Stage stage = rows_of_walls();
    auto culler = make(stage);
    double made[2] = {0, 0};
    for (int speed = 0; speed < 2; ++speed) {
        ViewState state;
        CullResult result;
        int frames = speed == 0 ? 160 : 40;
        for (int frame = 0; frame < frames; ++frame) {
            culler->cull(in_front(stage, -4 + 8.0 * frame / frames), state, result);
            if (frame > 0)
                made[speed] += double(result.counters.relations_made) / frames;
        }
    }
    EXPECT_LT(made[0], made[1]);
}

TEST(PlanesPublished, both_rules_cut_other_trees_and_hide_alike) {
    Stage stage = rows_of_walls();
    CullResult result[2];
    for (int rule = 0; rule < 2; ++rule) {
        auto culler = make(stage, {.split = KdSplit(rule)});
        ViewState state;
        culler->cull(in_front(stage), state, result[rule]);
        EXPECT_LT(result[rule].visible_count * 3, stage.cull_scene.object_count());
    }
    EXPECT_NE(result[0].counters.boxes_tested, result[1].counters.boxes_tested);
}

TEST(PlanesPublished, neither_rule_nor_leaf_size_loses_a_line_of_sight) {
    test::ProofCounts counts[3];
    const PublishedPlanesOptions kinds[3] = {
        {}, {.split = KdSplit::fewest_splits}, {.leaf_objects = 32, .cache_bytes = 1u << 16, .adapt = false}};
    for (std::uint32_t trial = 0; trial < 20; ++trial) {
        Random random(71, trial);
        double size = std::ldexp(1.0, int(random.below(20)) - 6);
        Result<Scene> scene = Scene::create(test::random_soup(random, 60, size));
        ASSERT_TRUE(scene.ok());
        Stage stage(std::move(*scene));
        for (int kind = 0; kind < 3; ++kind) {
            auto culler = make(stage, kinds[kind]);
            ViewState state;
            for (int f = 0; f < 16; ++f) {
                View view = test::random_view(random, {0, 0, 0}, size);
                if (problem_of(view) == nullptr)
                    test::prove(stage, *culler, view, state, 24, 32, random, counts[kind]);
                ASSERT_FALSE(HasFailure()) << "trial " << trial << " frame " << f;
            }
        }
    }
    for (const test::ProofCounts& one : counts)
        EXPECT_GT(one.hidden * 20, one.in_frustum);
}

TEST(PlanesPublished, the_set_shrinks_to_what_pays_and_stays_safe) {
    Stage stage = rows_of_walls();
    auto adapting = make(stage), whole = make(stage, {.adapt = false});
    ViewState a, b;
    CullResult few, all;
    for (int frame = 0; frame < 64; ++frame) {
        adapting->cull(in_front(stage, 0.01 * frame), a, few);
        whole->cull(in_front(stage, 0.01 * frame), b, all);
    }
    EXPECT_LT(few.counters.occluders_used, all.counters.occluders_used);
    EXPECT_LE(few.visible_count, all.visible_count + all.visible_count / 10);
}

TEST(PlanesPublished, without_usable_occluders_no_relation_is_looked_at) {
    Stage stage = rows_of_walls();
    CullerOptions options;
    options.occluders = 0;
    auto culler = std::move(make_culler("planes-published", stage.cull_scene, options)).value();
    ViewState state;
    CullResult result, frustum;
    culler->cull(in_front(stage), state, result);
    EXPECT_EQ(result.counters.relations_made + result.counters.relations_cached, 0u);
    EXPECT_STREQ(result.reason, "no occluders allowed: frustum only");
    ViewState plain;
    (*make_culler("frustum", stage.cull_scene))->cull(in_front(stage), plain, frustum);
    EXPECT_EQ(result.visible, frustum.visible);
}

// Parallel lines of sight come from a viewpoint at infinity: what the walls hide from afar they hide from there.
TEST(PlanesPublished, orthographic_views_are_culled_and_lose_nothing) {
    Stage stage = rows_of_walls();
    auto culler = make(stage);
    ViewState state;
    View view = in_front(stage);
    view.projection = Projection::orthographic;
    view.height = 6;
    CullResult result, frustum;
    ViewState plain;
    culler->cull(view, state, result);
    (*make_culler("frustum", stage.cull_scene))->cull(view, plain, frustum);
    EXPECT_STREQ(result.reason, "");
    EXPECT_GT(result.counters.hidden_by_planes, 0u);
    EXPECT_LT(result.visible_count * 2, frustum.visible_count);
    test::ProofCounts counts;
    Random random(74);
    Box3d bounds = to_double(stage.scene->local_bounds());
    for (int f = 0; f < 60; ++f) {
        for (int axis = 0; axis < 3; ++axis)
            view.eye[axis] = random.uniform(bounds.min[axis], bounds.max[axis]);
        view.target = view.eye + Vec3d{random.uniform(-0.5, 0.5), random.uniform(-0.3, 0.3), random.below(2) ? -1.0 : 1.0};
        view.height = random.uniform(1, 20);
        view.near_plane = random.uniform(-30, 10);
        if (problem_of(view) == nullptr)
            test::prove(stage, *culler, view, state, 24, 32, random, counts);
        ASSERT_FALSE(HasFailure()) << "frame " << f;
    }
    EXPECT_GT(counts.hidden * 10, counts.in_frustum);
}

// Towers of many small faces: no face hides much, the boxes inside do. Viewers stand in streets, the middles of cells do not.
TEST(PlanesPublished, towers_hide_by_what_is_inside_of_them) {
    GenerateOptions options;
    options.triangles = 40000;
    Stage stage(std::move(Scene::create(*generate("downtown", options))).value());
    auto culler = make(stage);
    ViewState state;
    test::ProofCounts counts;
    Random random(75);
    Box3d bounds = to_double(stage.scene->local_bounds());
    for (int f = 0; f < 16; ++f) {
        View view;
        view.eye = {random.uniform(bounds.min.x, bounds.max.x), bounds.min.y + 2.2, 40 * std::floor(random.uniform(1, 6)) + bounds.min.z};
        view.target = view.eye + Vec3d{random.uniform(-1, 1), 0, random.uniform(-1, 1)};
        view.near_plane = 0.1;
        for (int again = 0; again < 2; ++again)
            test::prove(stage, *culler, view, state, 16, 4, random, counts);
        ASSERT_FALSE(HasFailure()) << "frame " << f;
    }
    EXPECT_GT(counts.hidden * 25, counts.in_frustum) << "it was nothing while nodes across a plane dropped its occluder";
}

// What each part is worth: without re-use the answers are the same and all relations are made anew; without joined occluders or those of
// single objects nothing more is hidden, and over all frames less.
TEST(PlanesPublished, every_part_does_what_it_is_for) {
    Stage stage(std::move(Scene::create(*generate("office", {.triangles = 15000}))).value());
    const PublishedPlanesOptions kinds[4] = {
        {.adapt = false}, {.adapt = false, .reuse = false}, {.adapt = false, .joined = false}, {.adapt = false, .detail = false}};
    std::unique_ptr<Culler> cullers[4];
    ViewState states[4];
    CullResult results[4];
    std::uint64_t visible[4]{}, made[4]{}, cached[4]{};
    for (int kind = 0; kind < 4; ++kind)
        cullers[kind] = make(stage, kinds[kind]);
    Random random(77);
    Box3d bounds = to_double(stage.scene->local_bounds());
    for (int place = 0; place < 12; ++place) {
        View view;
        for (int axis = 0; axis < 3; ++axis)
            view.eye[axis] = random.uniform(bounds.min[axis], bounds.max[axis]);
        Vec3d ahead{random.uniform(-1, 1), random.uniform(-0.2, 0.2), random.uniform(-1, 1)};
        view.near_plane = 0.05;
        for (int step = 0; step < 4; ++step) {
            view.eye = view.eye + ahead * 0.02;
            view.target = view.eye + ahead;
            for (int kind = 0; kind < 4; ++kind) {
                cullers[kind]->cull(view, states[kind], results[kind]);
                visible[kind] += results[kind].visible_count;
                made[kind] += results[kind].counters.relations_made;
                cached[kind] += results[kind].counters.relations_cached;
            }
            ASSERT_EQ(results[0].visible, results[1].visible);
            for (std::size_t word = 0; word < results[0].visible.size(); ++word)
                for (int kind : {2, 3})
                    ASSERT_EQ(results[0].visible[word] & ~results[kind].visible[word], 0u) << "a part less, an object less";
        }
    }
    EXPECT_GT(made[1], 2 * made[0]);
    EXPECT_GT(cached[0], 2 * made[0]);
    EXPECT_GT(visible[3], visible[0]);
    EXPECT_GE(visible[2], visible[0]);
}

TEST(PlanesPublished, nonsense_options_are_usage_errors) {
    Stage stage = rows_of_walls();
    CullerOptions options;
    options.published.leaf_objects = 0;
    EXPECT_EQ(make_culler("planes-published", stage.cull_scene, options).status().code(), ErrorCode::usage);
    options.published.leaf_objects = 4;
    options.published.cache_bytes = 100;
    EXPECT_EQ(make_culler("planes-published", stage.cull_scene, options).status().code(), ErrorCode::usage);
}

TEST(RelationCache, keeps_to_its_bound_and_drops_what_was_used_longest_ago) {
    RelationCache cache;
    cache.reset(1 << 20);
    EXPECT_LE(cache.bytes(), 1u << 20);
    EXPECT_GT(cache.bytes(), 1u << 18);
    bool known = false;
    std::uint64_t most = cache.bytes() / sizeof(Relation);
    // A working set of a quarter of the cache survives a stream of strangers, if it is used now and then.
    for (int frame = 0; frame < 40; ++frame) {
        cache.begin_frame();
        std::uint64_t found = 0;
        for (std::uint64_t key = 0; key < most / 8; ++key) {
            cache.find(key, known);
            found += known;
        }
        if (frame > 0) {
            EXPECT_GT(found * 10, most / 8 * 9) << frame;
        }
        for (std::uint64_t stranger = 0; stranger < most / 8; ++stranger)
            cache.find(1000000 + std::uint64_t(frame) * most + stranger, known);
    }
    EXPECT_LE(cache.bytes(), 1u << 20);
}

/// One wall and one box, by hand: full behind, partial where the shadow's rim cuts the box, none beside.
TEST(Relation, full_partial_and_none_as_the_regions_of_the_paper) {
    OccluderSet set;
    set.vertices = {{-1, -1, 0}, {1, -1, 0}, {1, 1, 0}, {-1, 1, 0}};
    set.loops = {0, 1, 2, 3};
    OccluderPolygon polygon;
    polygon.count = 4;
    polygon.normal = {0, 0, 1};
    polygon.area = 4;
    set.polygons = {polygon};
    connect_occluders(set);
    Box3d box{{-0.5, -0.5, -3}, {0.5, 0.5, -2}};
    Relation relation;
    form_relation(set, set.polygons[0], box, 1e-9, relation);
    ASSERT_TRUE(relation.possible);
    EXPECT_EQ(relation.edges, 4u);
    EXPECT_EQ(classify(relation, {0, 0, 1}, 1e-9), Occlusion::full);
    // From (x, 0, 1) the wall's edge x = 1 casts its rim to x + (1 - x) d at distance d. The box's far corners (0.5 at
    // distance 4) leave the shadow at x = 7/6; its near ones (-0.5 at distance 3) are the last in it, until 7/4.
    EXPECT_EQ(classify(relation, {1.1666, 0, 1}, 1e-9), Occlusion::full);
    EXPECT_EQ(classify(relation, {1.1667, 0, 1}, 1e-9), Occlusion::partial);
    EXPECT_EQ(classify(relation, {1.7499, 0, 1}, 1e-9), Occlusion::partial);
    EXPECT_EQ(classify(relation, {1.7501, 0, 1}, 1e-9), Occlusion::none);
    EXPECT_EQ(classify(relation, {-1.1667, 0, 1}, 1e-9), Occlusion::partial);
}

TEST(Relation, agrees_with_lines_of_sight_through_random_walls) {
    Random random(72);
    int full = 0, partial = 0, none = 0;
    for (int trial = 0; trial < 4000; ++trial) {
        OccluderSet set;
        Vec3d centre{random.uniform(-1, 1), random.uniform(-1, 1), random.uniform(-1, 1)};
        Vec3d u{random.uniform(-1, 1), random.uniform(-1, 1), random.uniform(-1, 1)};
        Vec3d w{random.uniform(-1, 1), random.uniform(-1, 1), random.uniform(-1, 1)};
        Vec3d corners[3] = {centre, centre + u, centre + w};
        OccluderPolygon polygon;
        polygon.count = 3;
        polygon.normal = normalized(cross(u, w));
        for (const Vec3d& p : corners)
            set.vertices.push_back({float(p.x), float(p.y), float(p.z)});
        Vec3d a = to_double(set.vertices[0]), b = to_double(set.vertices[1]), c = to_double(set.vertices[2]);
        polygon.normal = normalized(cross(b - a, c - a));
        polygon.offset = -dot(polygon.normal, a);
        polygon.centre = (a + b + c) / 3.0;
        polygon.area = length(cross(b - a, c - a)) / 2;
        set.loops = {0, 1, 2};
        set.polygons = {polygon};
        connect_occluders(set);
        Vec3d eye = polygon.centre + polygon.normal * random.uniform(0.1, 3) + u * random.uniform(-0.5, 0.5);
        Vec3d middle = polygon.centre - polygon.normal * random.uniform(0.5, 2) + u * random.uniform(-1.0, 1.0);
        double half = random.uniform(0.01, 0.3);
        Box3f box;
        box.extend(Vec3f{float(middle.x - half), float(middle.y - half), float(middle.z - half)});
        box.extend(Vec3f{float(middle.x + half), float(middle.y + half), float(middle.z + half)});
        if (!is_behind(box, polygon, 1, 1e-9))
            continue;
        Relation relation;
        form_relation(set, polygon, to_double(box), 1e-9, relation);
        if (!relation.possible)
            continue;
        Occlusion occlusion = classify(relation, eye, 1e-9);
        int hit = 0, all = 0;
        for (int i = 0; i < 200; ++i) {
            Vec3d p = to_double(box.corner(int(random.below(8))));
            if (i >= 40)
                for (int axis = 0; axis < 3; ++axis)
                    p[axis] = random.uniform(box.min[axis], box.max[axis]);
            Vec3d way = p - eye;
            double t = -(dot(polygon.normal, eye) + polygon.offset) / dot(polygon.normal, way);
            Vec3d q = eye + way * t;
            bool inside = true;
            const Vec3d* loop[3] = {&a, &b, &c};
            for (int e = 0; e < 3; ++e)
                inside = inside && dot(cross(*loop[(e + 1) % 3] - *loop[e], q - *loop[e]), polygon.normal) > 0;
            hit += inside;
            ++all;
        }
        full += occlusion == Occlusion::full;
        partial += occlusion == Occlusion::partial;
        none += occlusion == Occlusion::none;
        if (occlusion == Occlusion::full) {
            EXPECT_EQ(hit, all) << trial;
        } else if (occlusion == Occlusion::none) {
            EXPECT_EQ(hit, 0) << trial;
        }
        // And full whenever all corners are hidden: the planes of edges of the occluder suffice (paper).
        int corners_hidden = 0;
        for (int corner = 0; corner < 8; ++corner) {
            Vec3d way = to_double(box.corner(corner)) - eye;
            double t = -(dot(polygon.normal, eye) + polygon.offset) / dot(polygon.normal, way);
            Vec3d q = eye + way * t;
            const Vec3d* loop[3] = {&a, &b, &c};
            bool inside = true;
            for (int e = 0; e < 3; ++e)
                inside = inside && dot(cross(*loop[(e + 1) % 3] - *loop[e], q - *loop[e]), polygon.normal) > 1e-6;
            corners_hidden += inside;
        }
        if (corners_hidden == 8) {
            EXPECT_EQ(int(occlusion), int(Occlusion::full)) << trial;
        }
    }
    EXPECT_GT(full, 100);
    EXPECT_GT(partial, 100);
    EXPECT_GT(none, 100);
}

} // namespace
} // namespace antumbra
