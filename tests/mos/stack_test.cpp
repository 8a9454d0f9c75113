// Occluder stacks, lists and the choice among sets, on random scenes.
#include "mos/choose_list.hpp"

#include "cull/patch_layout.hpp"
#include "cull/proof.hpp"

#include <set>

namespace antumbra {
namespace {

using test::Stage;

struct Case {
    Stage stage;
    Screen screen;
};

Case random_case(std::uint32_t trial, int objects = 60) {
    Random random(95, trial);
    Result<Scene> scene = Scene::create(test::random_soup(random, objects, 8));
    Vec3d eye{random.uniform(-8, 8), random.uniform(-8, 8), random.uniform(-8, 8)};
    return {Stage(std::move(*scene)), picture_of(eye, random.below(6), 48, 16)};
}

MosOptions every_object() {
    MosOptions options;
    options.least_primitives = 0;
    options.most_primitives = 1;
    options.least_pixels = 1;
    return options;
}

TEST(OccluderStack, layers_are_sorted_and_hold_each_fragment_once) {
    for (std::uint32_t trial = 0; trial < 20; ++trial) {
        Case c = random_case(trial);
        OccluderStack stack(c.stage.occluders, c.screen, {1, 1000});
        std::size_t layers = 0, fragments = 0;
        for (std::size_t pixel = 0; pixel < stack.pixels(); ++pixel) {
            std::set<std::uint32_t> members;
            for (std::size_t k = 0; k < stack.stack(pixel).size(); ++k, ++layers) {
                members.insert(stack.stack(pixel)[k].member);
                if (k > 0) {
                    ASSERT_LE(stack.stack(pixel)[k].nearness, stack.stack(pixel)[k - 1].nearness);
                }
            }
            ASSERT_EQ(members.size(), stack.stack(pixel).size());
        }
        for (std::uint32_t member = 0; member < stack.members(); ++member)
            fragments += stack.fragments(member).size();
        ASSERT_EQ(layers, fragments);
    }
}

/// The nearest layer of a pixel is what a ray through its centre meets first.
TEST(OccluderStack, the_first_layer_is_what_a_ray_sees) {
    std::uint64_t hits = 0, differs = 0;
    for (std::uint32_t trial = 0; trial < 20; ++trial) {
        Case c = random_case(trial);
        OccluderOptions no_boxes;
        no_boxes.inner_boxes = false;
        OccluderSet occluders = find_occluders(*c.stage.scene, no_boxes);
        OccluderStack stack(occluders, c.screen, {1, 1000, PixelCoverage::centre});
        std::vector<std::uint32_t> triangles;
        const Camera& camera = c.screen.camera;
        for (std::size_t pixel = 0; pixel < stack.pixels(); pixel += 7) {
            double x = (double(pixel % 48) + 0.5) / 24 - 1, y = (double(pixel / 48) + 0.5) / 24 - 1;
            Ray ray{camera.eye, camera.forward + camera.right * x + camera.up * y};
            triangles.clear();
            c.stage.tracer->seen(ray, triangles);
            bool occludes = false, same = false;
            for (std::uint32_t t : triangles) {
                const Object& object = c.stage.scene->object_of(t);
                occludes = occludes || object.has(kOccludes);
                same = same || (!stack.stack(pixel).empty() &&
                                occluders.polygons[stack.polygon(stack.stack(pixel)[0].member)].object ==
                                    c.stage.scene->triangle_objects()[t]);
            }
            if (!occludes)
                continue;
            ++hits;
            differs += !same;
        }
    }
    EXPECT_GT(hits, 1000u);
    EXPECT_LT(differs * 100, hits) << "edges through pixel centres and coincident faces aside";
}

/// With every polygon drawn, the run time covers what the stacks say is covered.
TEST(OccluderStack, inner_pixels_are_those_that_the_run_time_draws) {
    std::uint64_t covered = 0, missing = 0;
    for (std::uint32_t trial = 0; trial < 20; ++trial) {
        Case c = random_case(trial);
        OccluderOptions no_boxes;
        no_boxes.inner_boxes = false;
        OccluderSet occluders = find_occluders(*c.stage.scene, no_boxes);
        OccluderStack stack(occluders, c.screen, {1, 1000});
        std::vector<std::uint32_t> all(occluders.polygons.size());
        for (std::uint32_t p = 0; p < all.size(); ++p)
            all[p] = p;
        // One patch per object: polygons with all of their neighbours, and nothing else in the way.
        PatchLayout layout(occluders);
        PatchStore store;
        for (std::uint32_t object = 0; object < c.stage.scene->objects().size(); ++object) {
            std::vector<std::uint32_t> own;
            for (std::uint32_t p : all)
                if (occluders.polygons[p].object == object)
                    own.push_back(p);
            layout.add(occluders, own, store);
        }
        OccluderImage image;
        OccluderBrush brush;
        image.reset(c.screen);
        brush.fit(c.screen, store);
        for (std::uint32_t p = 0; p < store.patches.size(); ++p)
            draw_occluder_scalar(store, p, c.screen, PixelCoverage::inner, brush, image);
        for (std::size_t pixel = 0; pixel < stack.pixels(); ++pixel) {
            covered += !stack.stack(pixel).empty();
            missing += !stack.stack(pixel).empty() && !image.is_covered(int(pixel % 48), int(pixel / 48));
        }
    }
    EXPECT_GT(covered, 5000u);
    EXPECT_LT(missing * 20, covered) << "where one object's silhouette crosses its own faces";
}

TEST(OccluderStack, lists_are_what_the_stacks_hold) {
    for (std::uint32_t trial = 0; trial < 20; ++trial) {
        Case c = random_case(trial);
        OccluderStack stack(c.stage.occluders, c.screen, {1, 6});
        Random random(96, trial);
        for (int r = 0; r < 50; ++r) {
            PixelRect rect{int(random.below(40)), int(random.below(40)), 0, 0};
            rect.x1 = rect.x0 + int(random.below(8));
            rect.y1 = rect.y0 + int(random.below(8));
            auto nearness = float(random.uniform(0, 0.5));
            std::set<std::vector<std::uint32_t>> expected, found;
            bool open = false;
            for (int y = rect.y0; y <= rect.y1; ++y)
                for (int x = rect.x0; x <= rect.x1; ++x) {
                    std::vector<std::uint32_t> list;
                    for (const OccluderStack::Layer& layer : stack.stack(std::size_t(y * 48 + x)))
                        if (layer.nearness > nearness)
                            list.push_back(layer.member);
                    std::sort(list.begin(), list.end());
                    open = open || list.empty();
                    expected.insert(list);
                }
            ItemTable table;
            std::vector<std::uint32_t> members;
            ASSERT_EQ(stack.lists_of(rect, nearness, table, members), !open);
            if (open)
                continue;
            for (std::size_t i = 0; i < table.size(); ++i) {
                std::vector<std::uint32_t> list;
                for (std::uint32_t item : table.list(i))
                    list.push_back(members[item]);
                std::sort(list.begin(), list.end());
                found.insert(list);
            }
            ASSERT_EQ(found, expected);
        }
    }
}

/// What MOS promises: with the polygons of the list in front, every occludee that a kept set hid is covered.
TEST(ChooseList, every_set_that_is_found_covers_and_is_minimal) {
    std::uint64_t sets = 0;
    for (std::uint32_t trial = 0; trial < 40; ++trial) {
        Case c = random_case(trial, 120);
        OccluderStack stack(c.stage.occluders, c.screen, {1, 48});
        for (const Occludee& occludee : find_occludees(*c.stage.scene, every_object())) {
            BoxOnScreen box = project_box(c.screen, occludee.box);
            PixelRect rect = pixel_rect(c.screen, box);
            ItemTable table;
            std::vector<std::uint32_t> members;
            if (rect.empty() || !stack.lists_of(rect, box.nearness, table, members))
                continue;
            std::vector<double> costs(members.size(), 1);
            for (const MinimumSet& set : find_minimum_sets(table, costs, 4, 10000).sets) {
                ++sets;
                std::vector<std::uint32_t> cover;
                for (std::uint32_t item : set.items)
                    cover.push_back(members[item]);
                std::sort(cover.begin(), cover.end());
                ASSERT_TRUE(stack.is_cover(rect, box.nearness, cover));
                for (std::size_t left_out = 0; left_out < cover.size(); ++left_out) {
                    std::vector<std::uint32_t> fewer = cover;
                    fewer.erase(fewer.begin() + std::ptrdiff_t(left_out));
                    ASSERT_FALSE(stack.is_cover(rect, box.nearness, fewer));
                }
            }
        }
    }
    EXPECT_GT(sets, 30u);
}

TEST(ChooseList, no_criterion_names_a_polygon_twice_or_too_many) {
    for (std::uint32_t trial = 0; trial < 20; ++trial) {
        Case c = random_case(trial, 120);
        for (OccluderCriterion criterion : {OccluderCriterion::minimum_sets, OccluderCriterion::first_hit,
                                            OccluderCriterion::projected_size})
            for (MosSelection selection : {MosSelection::published, MosSelection::marginal}) {
                MosOptions options = every_object();
                options.criterion = criterion;
                options.selection = selection;
                options.limit = 5;
                auto occludees = find_occludees(*c.stage.scene, options);
                std::vector<std::uint32_t> list = choose_list(c.stage.occluders, occludees, c.screen, options);
                ASSERT_LE(list.size(), 5u);
                ASSERT_EQ(std::set<std::uint32_t>(list.begin(), list.end()).size(), list.size());
            }
    }
}

TEST(FindOccludees, small_objects_are_taken_together_and_none_is_lost) {
    Case c = random_case(1, 200);
    MosOptions options;
    options.least_primitives = 0;
    options.most_primitives = 40;
    std::uint64_t triangles = 0, expected = 0;
    for (const Occludee& occludee : find_occludees(*c.stage.scene, options))
        triangles += occludee.primitives;
    for (const Object& object : c.stage.scene->objects())
        expected += object.triangle_count;
    EXPECT_EQ(triangles, expected);
    options.least_primitives = 20;
    for (const Occludee& occludee : find_occludees(*c.stage.scene, options))
        EXPECT_GT(occludee.primitives, 20u);
}

} // namespace
} // namespace antumbra
