// The kernels that decide sides: the same masks bit for bit, and never against exact numbers.
#include "occlusion_tree/configurations.hpp"

#include "occlusion_tree/side_kernels.hpp"

#include <gtest/gtest.h>

namespace antumbra {
namespace {

using namespace test;

PicturePolygon random_corners(Random& random) {
    PicturePolygon polygon;
    int count = 3 + int(random.below(PicturePolygon::kMost - 2));
    for (int i = 0; i < count; ++i) {
        Direction at;
        at.d = {random.uniform(-1, 1), random.uniform(-1, 1), random.uniform(-1, 1)};
        at.error = std::ldexp(1.0, -int(random.below(60)));
        at.size = random.uniform(0.1, 3);
        polygon.push(at, {}, false);
    }
    return polygon;
}

TEST(SideKernels, all_give_the_same_masks) {
    Random random(11);
    int tried = 0;
    std::uint64_t certain = 0, open = 0;
    for (int trial = 0; trial < 20000; ++trial) {
        PicturePolygon polygon = random_corners(random);
        LineFilter line{{random.uniform(-1, 1), random.uniform(-1, 1), random.uniform(-1, 1)},
                        std::ldexp(1.0, -int(random.below(60))), random.uniform(0, 2)};
        SideMasks expected = certain_sides_scalar(line, polygon);
        ASSERT_EQ(expected.positive & expected.negative, 0u);
        (expected.positive | expected.negative) == (std::uint64_t(1) << polygon.count) - 1 ? ++certain : ++open;
        for (SideKernelKind kind : {SideKernelKind::avx2, SideKernelKind::avx512, SideKernelKind::best})
            if (SideKernel kernel = side_kernel(kind)) {
                SideMasks masks = kernel(line, polygon);
                ASSERT_EQ(masks.positive, expected.positive) << int(kind) << " trial " << trial;
                ASSERT_EQ(masks.negative, expected.negative) << int(kind) << " trial " << trial;
                ++tried;
            }
    }
    EXPECT_GE(tried, 20000);
    EXPECT_GT(certain, 1000u);
    EXPECT_GT(open, 1000u);
}

TEST(SideKernels, trees_are_the_same_with_each) {
    for (std::uint64_t trial = 0; trial < 200; ++trial) {
        Random random(13, trial);
        Configuration made = trial % 2 ? wall_configuration(random, 8) : general_configuration(random, 6, 8, true);
        TreeOccluders occluders = TreeOccluders::build(made.set);
        std::vector<std::uint32_t> all;
        for (std::uint32_t p = 0; p < made.set.polygons.size(); ++p)
            all.push_back(p);
        std::vector<std::string> answers;
        for (SideKernelKind kind : {SideKernelKind::scalar, SideKernelKind::avx2, SideKernelKind::avx512}) {
            SideKernel kernel = side_kernel(kind);
            if (!kernel)
                continue;
            OcclusionTree tree({1u << 10, 1u << 12, 1u << 10});
            tree.sight().use(kernel);
            tree.begin(made.eye, 10, TreeForm::modified);
            TreeBuilder builder(occluders, std::uint32_t(all.size()) * 8 + 8);
            builder.insert(tree, all, TreeBuilder::Order::binary_space_partition);
            std::string answer = std::to_string(tree.node_count()) + " " + std::to_string(tree.planes_tested());
            for (const Box3d& box : made.boxes)
                answer += std::to_string(int(tree.visibility_by_faces(box))) + (tree.hides(box, tree.root(), nullptr) ? "h" : "s");
            answers.push_back(answer + " " + std::to_string(tree.sight().tally().exact));
        }
        for (const std::string& answer : answers)
            ASSERT_EQ(answer, answers[0]) << "trial " << trial;
    }
}

} // namespace
} // namespace antumbra
