#include <antumbra/cull.hpp>

#include <gtest/gtest.h>

#include "cull/random_views.hpp"

namespace antumbra {
namespace {

/// Two cells side by side along x (0..10, 10..20); object 0 belongs to the left one, 1 to the right one, both
/// see 2. Everything lies in front of a viewer that looks along -z.
struct TwoCells {
    std::vector<Box3f> boxes{{{-1, 0, -20}, {1, 1, -19}}, {{19, 0, -20}, {21, 1, -19}}, {{9, 0, -20}, {11, 1, -19}},
                             {{9, 0, 200}, {11, 1, 201}}};
    std::vector<std::byte> bytes;
    CullScene scene;

    explicit TwoCells(Guarantee guarantee = Guarantee::exact, std::uint32_t second_row = 1) {
        PvsData data;
        data.guarantee = guarantee;
        data.method = "test";
        data.options_json = std::string("{}");
        data.grid.bounds = {{0, 0, 0}, {20, 10, 10}};
        data.grid.count = {2, 1, 1};
        data.cell_row = {0, second_row};
        data.row_count = 2;
        data.rows = {0b0101, 0b0110};
        for (std::size_t o = 0; o < boxes.size(); ++o) {
            PvsObject object;
            object.node = int(o);
            object.bounds = boxes[o];
            object.name = "object";
            data.objects.push_back(object);
        }
        bytes = std::move(encode_pvs(data)).value();
        CullSceneInput input;
        input.bounds = boxes;
        scene = CullScene::create(input);
    }

    std::uint64_t visible(const View& view) const {
        Result<Pvs> pvs = Pvs::open(bytes);
        EXPECT_TRUE(pvs.ok()) << pvs.status().message();
        CullerOptions options;
        options.pvs = &*pvs;
        auto culler = make_culler("pvs", scene, options);
        EXPECT_TRUE(culler.ok());
        ViewState state;
        CullResult result;
        (*culler)->cull(view, state, result);
        (*culler)->cull(view, state, result); // again, with the cell known
        return result.visible.at(0);
    }
};

View from(double x, double z = 5, double near_plane = 0.1) {
    View view;
    view.eye = {x, 5, z};
    view.target = view.eye + Vec3d{0, 0, -1};
    view.fov_y_deg = 120;
    view.near_plane = near_plane;
    return view;
}

TEST(PvsCuller, reports_what_the_cell_sees_within_the_frustum) {
    TwoCells cells;
    EXPECT_EQ(cells.visible(from(5)), 0b0101u);
    EXPECT_EQ(cells.visible(from(15)), 0b0110u);
}

TEST(PvsCuller, outside_every_cell_only_the_frustum_culls) {
    TwoCells cells;
    EXPECT_EQ(cells.visible(from(5, 11)), 0b0111u);
    EXPECT_EQ(cells.visible(from(-0.001)), 0b0111u);
}

TEST(PvsCuller, near_rectangle_across_two_cells_unites_them) {
    TwoCells cells;
    // A wall between the cells would not be drawn if it lay nearer than the near plane.
    EXPECT_EQ(cells.visible(from(9.9, 5, 0.1)), 0b0111u);
    EXPECT_EQ(cells.visible(from(9.0, 5, 0.1)), 0b0101u);
}

TEST(PvsCuller, near_rectangle_that_leaves_the_grid_sees_everything_in_the_frustum) {
    TwoCells cells;
    EXPECT_EQ(cells.visible(from(5, 0.05, 0.1)), 0b0111u);
}

TEST(PvsCuller, orthographic_rays_start_all_over_the_near_rectangle) {
    TwoCells cells;
    View view = from(5, 5, 0);
    view.projection = Projection::orthographic;
    view.height = 4;
    view.aspect = 1;
    view.far_plane = 100;
    EXPECT_EQ(cells.visible(view), 0b0000u); // three to seven: none of the boxes
    view.height = 9;                         // half a unit to nine and a half: object 0 and 2
    EXPECT_EQ(cells.visible(view), 0b0101u);
    view.aspect = 1.2; // beyond ten: the right cell counts too, and what lies there is in view
    EXPECT_EQ(cells.visible(view), 0b0101u);
}

TEST(PvsCuller, cells_without_an_answer_see_everything_in_the_frustum) {
    EXPECT_EQ(TwoCells(Guarantee::exact, kCellNotBaked).visible(from(15)), 0b0111u);
    EXPECT_EQ(TwoCells(Guarantee::exact, kCellSolid).visible(from(15)), 0b0111u);
}

TEST(PvsCuller, passes_on_what_the_bake_promised) {
    for (auto [baked, culled] : {std::pair(Guarantee::exact, Guarantee::conservative),
                                 std::pair(Guarantee::conservative, Guarantee::conservative),
                                 std::pair(Guarantee::aggressive, Guarantee::approximate),
                                 std::pair(Guarantee::approximate, Guarantee::approximate)}) {
        TwoCells cells(baked);
        Result<Pvs> pvs = Pvs::open(cells.bytes);
        ASSERT_TRUE(pvs.ok());
        CullerOptions options;
        options.pvs = &*pvs;
        EXPECT_EQ((*make_culler("pvs", cells.scene, options))->guarantee(), culled);
    }
}

/// View space 0..20 x 0..10 x 0..10, cut in theta at a half turn: looking towards -z (theta 2 to 4) sees 0 and 2, the
/// other way 1 and 3.
TEST(PvsCuller, a_view_tree_answers_for_the_direction) {
    TwoCells cells;
    PvsData data;
    data.guarantee = Guarantee::exact;
    data.method = "test";
    data.tree.bounds = {{0, 0, 0}, {20, 10, 10}};
    data.tree.nodes = {{std::uint8_t(3), kViewSteps / 2, 2}, {ViewNode::kLeaf, 0, 0}, {ViewNode::kLeaf, 0, 1}};
    data.row_count = 2;
    data.rows = {0b1010, 0b0101};
    for (const Box3f& box : cells.boxes) {
        PvsObject object;
        object.bounds = box;
        data.objects.push_back(object);
    }
    cells.bytes = encode_pvs(data).value();
    EXPECT_EQ(cells.visible(from(10)), 0b0101u);
    View back = from(10);
    back.target = back.eye + Vec3d{0, 0, 1};
    EXPECT_EQ(cells.visible(back), 0b1000u);
    View side = from(10); // along the cut: both leaves count, the frustum holds neither end
    side.target = side.eye + Vec3d{1, 0, 0};
    side.fov_y_deg = 10;
    EXPECT_EQ(cells.visible(side), 0u);
    View orthographic = from(10);
    orthographic.projection = Projection::orthographic;
    orthographic.height = 9.8;
    EXPECT_EQ(cells.visible(orthographic), 0b0100u);
    EXPECT_EQ(cells.visible(from(-5)), 0b0111u); // outside of view space: the frustum alone
}

TEST(PvsCuller, another_number_of_objects_is_a_mismatch) {
    TwoCells cells;
    Result<Pvs> pvs = Pvs::open(cells.bytes);
    ASSERT_TRUE(pvs.ok());
    CullerOptions options;
    options.pvs = &*pvs;
    CullSceneInput input;
    auto culler = make_culler("pvs", CullScene::create(input), options);
    ASSERT_FALSE(culler.ok());
    EXPECT_EQ(culler.status().code(), ErrorCode::mismatch);
}

} // namespace
} // namespace antumbra
