// Occluder sets of cells: those of a PVS and what it sees, those of the kd-tree, those of files of before; and the methods that take
// their occluders from what a cell sees.
#include "cull/proof.hpp"
#include "cull/opacity_occluders.hpp"
#include "cull/scene_data.hpp"
#include "cull/set_cells.hpp"
#include "support/make_scene.hpp"

#include <antumbra/bake.hpp>
#include <antumbra/generate.hpp>

#include <fstream>
#include <set>

namespace antumbra {
namespace {

using test::Stage;
using Bytes = std::vector<std::byte>;

/// Two rooms of cells along x, a wall between, things on both sides: objects 0 wall, 1 and 2 left, 3 and 4 right.
Stage two_rooms() {
    test::SceneMaker maker;
    maker.object("wall").box({-0.5, 0, -10}, {0.5, 6, 10});
    maker.object("left screen").box({-6, 0, -4}, {-5.8, 3, 4});
    maker.object("left thing").box({-9, 0, 0}, {-8.5, 0.5, 0.5});
    maker.object("right screen").box({5.8, 0, -4}, {6, 3, 4});
    maker.object("right thing").box({8.5, 0, 0}, {9, 0.5, 0.5});
    return Stage(maker.scene());
}

/// What each half sees: wall and its own side.
PvsData rooms(const Stage& stage) {
    PvsData data = describe_scene(*stage.scene);
    data.grid = {{{-10, 0, -10}, {10, 6, 10}}, {2, 1, 1}};
    data.cell_row = {0, 1};
    data.row_count = 2;
    data.rows = {0b00111, 0b11001};
    return data;
}

TEST(SetCells, of_a_grid_are_its_cells_and_hold_what_they_see) {
    Stage stage = two_rooms();
    Bytes baked = *encode_pvs(rooms(stage));
    Pvs pvs = *Pvs::open(baked);
    PrepareOptions options;
    options.pvs = &pvs;
    Bytes bytes = *add_pvs_chunks(baked, *prepare_chunks(stage.cull_scene, options));
    CullScene opened = *CullScene::open(*Pvs::open(bytes));
    const CullScene::Data& data = opened.data();
    for (const OccluderSets* sets : {&data.front_sets, &data.first_hit_sets}) {
        ASSERT_EQ(sets->cells().leaves, 2u);
        EXPECT_EQ(sets->cells().find(stage.scene->to_local({-1, 1, 0})), 0u);
        EXPECT_EQ(sets->cells().find(stage.scene->to_local({1, 1, 0})), 1u);
    }
    std::size_t members = 0;
    for (double side : {-1.0, 1.0})
        for (const Vec3d& direction : OccluderSets::directions())
            for (std::uint32_t polygon : data.front_sets.at(stage.scene->to_local({3 * side, 1, 0}), direction)) {
                const OccluderPolygon& p = data.occluders.polygons[polygon];
                EXPECT_TRUE(p.synthetic || p.object == 0 || (p.object < 3) == (side < 0)) << p.object;
                ++members;
            }
    EXPECT_GT(members, 20u);
}

TEST(SetCells, of_a_grid_with_more_cells_than_wanted_stay_together) {
    Stage stage = two_rooms();
    PvsData data = rooms(stage);
    data.grid.count = {8, 1, 4};
    data.cell_row.assign(32, 0);
    Bytes baked = *encode_pvs(data);
    Pvs pvs = *Pvs::open(baked);
    SetCells all = choose_set_cells(stage.cull_scene.data(), &pvs, 32), few = choose_set_cells(stage.cull_scene.data(), &pvs, 9);
    EXPECT_EQ(all.cells.leaves, 32u);
    EXPECT_EQ(few.cells.leaves, 8u);
    // Each place of the grid is in the box of its cell.
    std::vector<Box3d> boxes = few.cells.boxes();
    Random random(3);
    for (int i = 0; i < 1000; ++i) {
        Vec3d p = stage.scene->to_local({random.uniform(-10, 10), random.uniform(0, 6), random.uniform(-10, 10)});
        EXPECT_TRUE(boxes[few.cells.find(p)].contains(p));
    }
}

TEST(SetCells, of_a_view_tree_are_its_cuts_of_space) {
    Stage stage = two_rooms();
    PvsData data = describe_scene(*stage.scene);
    data.tree.bounds = {{-10, 0, -10}, {10, 6, 10}};
    // x in the middle; the upper half by direction, which is no cut of space.
    data.tree.nodes = {{0, 32768, 2}, {ViewNode::kLeaf, 0, 0}, {3, 32768, 4}, {ViewNode::kLeaf, 0, 1}, {ViewNode::kLeaf, 0, 1}};
    data.row_count = 2;
    data.rows = {0b00111, 0b11001};
    Result<Bytes> baked = encode_pvs(data);
    ASSERT_TRUE(baked) << baked.status().message();
    Pvs pvs = *Pvs::open(*baked);
    SetCells cells = choose_set_cells(stage.cull_scene.data(), &pvs, 64);
    ASSERT_EQ(cells.cells.leaves, 2u);
    ASSERT_TRUE(cells.is_seen);
    std::uint32_t left = cells.cells.find(stage.scene->to_local({-3, 1, 0})), right = cells.cells.find(stage.scene->to_local({3, 1, 0}));
    EXPECT_NE(left, right);
    EXPECT_TRUE(cells.is_seen(left, 1) && !cells.is_seen(left, 3) && cells.is_seen(right, 3) && !cells.is_seen(right, 2));
}

TEST(SetCells, of_objects_are_upper_nodes_of_the_tree_that_is_walked) {
    Result<Scene> scene = Scene::create(*generate("office", {.triangles = 20000}));
    Stage stage(std::move(*scene));
    const CullScene::Data& data = stage.cull_scene.data();
    SpaceCells cells = cells_of_objects(data, 64);
    EXPECT_GT(cells.leaves, 32u);
    EXPECT_LE(cells.leaves, 64u);
    KdTreeOptions options;
    options.rule = KdRule::balanced_counts;
    KdTree tree = build_kd_tree(data.bounds, data.order, options);
    std::vector<Box3d> boxes = cells.boxes();
    for (const KdNode& node : tree.nodes) {
        if (!node.leaf())
            continue;
        const Box3d& box = boxes[cells.find(to_double(node.cell).centre())];
        EXPECT_TRUE(box.contains(to_double(node.cell.min)) && box.contains(to_double(node.cell.max))) << "a leaf in two cells";
    }
}

TEST(SpaceCells, come_back_from_bytes_and_refuse_others) {
    SpaceCells cells = SpaceCells::of_grid({{0, 0, 0}, {8, 4, 2}}, {4, 2, 1});
    ByteWriter out;
    cells.encode(out);
    std::size_t at = 0;
    SpaceCells again = SpaceCells::decode(out.bytes, at, cells.bounds);
    EXPECT_EQ(at, out.bytes.size());
    EXPECT_EQ(again.leaves, 8u);
    EXPECT_EQ(again.nodes.size(), cells.nodes.size());
    for (std::size_t cut = 0; cut < out.bytes.size(); ++cut) {
        at = 0;
        EXPECT_TRUE(SpaceCells::decode(std::span(out.bytes).first(cut), at, cells.bounds).nodes.empty()) << cut;
    }
    out.bytes[0] = std::byte(7);
    at = 0;
    EXPECT_TRUE(SpaceCells::decode(out.bytes, at, cells.bounds).nodes.empty());
}

/// Prepared before cells of sets were a tree and solids had restrictions: two boxes side by side and a third behind them.
TEST(SetCells, a_prepared_file_of_the_first_version_opens_for_ever) {
    std::ifstream stream(ANTUMBRA_SOURCE_DIR "/tests/cull/golden-prepared-1.pvs.hex");
    Bytes bytes;
    for (std::string word; stream >> word;)
        for (std::size_t i = 0; i + 1 < word.size(); i += 2)
            bytes.push_back(std::byte(std::stoi(word.substr(i, 2), nullptr, 16)));
    ASSERT_EQ(bytes.size(), 4428u);
    Result<Pvs> pvs = Pvs::open(bytes);
    ASSERT_TRUE(pvs.ok()) << pvs.status().message();
    Result<CullScene> scene = CullScene::open(*pvs);
    ASSERT_TRUE(scene.ok()) << scene.status().message();
    EXPECT_EQ(scene->data().front_sets.cells().leaves, 2u);
    EXPECT_EQ(scene->data().first_hit_sets.cells().leaves, 2u);
    EXPECT_GT(scene->data().front_sets.members().size(), 0u);
    auto culler = std::move(make_culler("planes-published", *scene)).value();
    View view;
    view.eye = Vec3d{3, 1, 8} - pvs->origin();
    view.target = view.eye + Vec3d{0, 0, -1};
    ViewState state;
    CullResult result;
    culler->cull(view, state, result);
    EXPECT_EQ(result.visible[0], 0b011u) << "the third stands behind the first";
}

// Occluders that the cell does not see are not drawn; nothing that a line of sight sees is hidden.
TEST(FromPvs, every_method_with_occluders_takes_what_the_cell_sees) {
    GenerateOptions generated;
    generated.triangles = 15000;
    Stage stage(std::move(Scene::create(*generate("office", generated))).value());
    BakeOptions options;
    options.cells = {3, 1, 3};
    options.rays_per_cell = 8192;
    Result<BakeResult> baked = bake(*stage.scene, options);
    ASSERT_TRUE(baked) << baked.status().message();
    Bytes bytes = *encode_pvs(baked->pvs);
    Pvs pvs = *Pvs::open(bytes);
    struct Case {
        const char* method;
        OpacityChoice choice = OpacityChoice::as_listed;
        bool draws_less = false;
    };
    for (auto [method, choice, draws_less] :
         {Case{"masked", {}, true}, Case{"hzb", {}, true}, Case{"planes"}, Case{"planes-published"}, Case{"tree"},
          Case{"tree-fse"}, Case{"tree-fme"}, Case{"tree-fmc"}, Case{"opacity"}, Case{"opacity", OpacityChoice::by_gain},
          Case{"opacity-published"}}) {
        CullerOptions with;
        with.opacity.choice = choice;
        with.opacity.adaptive = false;
        auto plain = std::move(make_culler(method, stage.cull_scene, with)).value();
        with.pvs = &pvs;
        auto fed = std::move(make_culler(method, stage.cull_scene, with)).value();
        test::ProofCounts counts;
        ViewState plain_state, state;
        CullResult a, b;
        std::uint64_t drawn = 0, drawn_with = 0, reported = 0, reported_with = 0;
        Random random(5);
        Box3d bounds = to_double(stage.scene->local_bounds());
        for (int f = 0; f < 40; ++f) {
            View view;
            for (int axis = 0; axis < 3; ++axis)
                view.eye[axis] = random.uniform(bounds.min[axis], bounds.max[axis]);
            view.target = view.eye + Vec3d{random.uniform(-1, 1), random.uniform(-0.2, 0.2), random.uniform(-1, 1)};
            view.near_plane = 0.05;
            test::prove(stage, *fed, view, state, 16, 16, random, counts);
            fed->cull(view, state, b);
            plain->cull(view, plain_state, a);
            drawn += a.counters.polygons_drawn;
            drawn_with += b.counters.polygons_drawn;
            reported += a.visible_count;
            reported_with += b.visible_count;
        }
        EXPECT_GT(counts.hidden * 5, counts.in_frustum) << method;
        EXPECT_LE(reported_with * 10, reported * 13) << method << ": what is left out hid next to nothing";
        if (draws_less) {
            EXPECT_LT(drawn_with, drawn) << method;
        }
    }
}

/// What the left cell sees is all on the left; the eye, a little beyond the wall's plane in the same cell, would else find the
/// right screen large and near.
TEST(FromPvs, what_the_cell_does_not_see_is_no_occluder) {
    Stage stage = two_rooms();
    PvsData data = rooms(stage);
    data.grid.count = {1, 1, 1};
    data.cell_row = {0};
    Bytes bytes = *encode_pvs(data);
    Pvs pvs = *Pvs::open(bytes);
    View view;
    view.eye = stage.scene->to_local({2, 1, 0});
    view.target = view.eye + Vec3d{1, 0, 0};
    view.near_plane = 0.05;
    const CullScene::Data& scene = stage.cull_scene.data();
    FrustumPlanes planes = frustum_planes(camera_of(view), scene.tree_box);
    auto objects_of = [&](const Pvs* given, OccluderChoice choice) {
        OpacityOccluders occluders(scene, choice, given);
        occluders.choose(scene, nullptr, camera_of(view), planes, 64);
        std::set<std::uint32_t> objects;
        for (std::uint32_t polygon : occluders.polygons())
            if (!scene.occluders.polygons[polygon].synthetic)
                objects.insert(scene.occluders.polygons[polygon].object);
        return objects;
    };
    for (OccluderChoice choice : {OccluderChoice::area_angle, OccluderChoice::projected_size}) {
        EXPECT_TRUE(objects_of(nullptr, choice).count(3));
        EXPECT_FALSE(objects_of(&pvs, choice).count(3));
    }
    OccluderInterest interest;
    interest.look(scene, OccluderChoice::area_angle, &pvs, camera_of(view));
    for (const OccluderPolygon& polygon : scene.occluders.polygons)
        EXPECT_EQ(interest.is_seen(polygon), polygon.synthetic || polygon.object < 3);
}

TEST(FromPvs, of_another_scene_is_refused) {
    Stage stage = two_rooms();
    PvsData other = rooms(stage);
    other.objects.pop_back();
    other.rows = {0b0111, 0b1001};
    Bytes bytes = *encode_pvs(other);
    Pvs pvs = *Pvs::open(bytes);
    CullerOptions options;
    options.pvs = &pvs;
    for (const char* method : {"masked", "hzb", "planes", "planes-published", "tree", "tree-fme", "opacity", "opacity-published"})
        EXPECT_EQ(make_culler(method, stage.cull_scene, options).status().code(), ErrorCode::mismatch) << method;
}

} // namespace
} // namespace antumbra
