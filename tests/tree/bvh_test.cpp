#include "tree/bvh.hpp"

#include "base/random.hpp"

#include <gtest/gtest.h>

#include <cstring>

using namespace antumbra;

namespace {

std::vector<Box3f> random_boxes(std::size_t count, float spread, std::uint64_t seed) {
    Random random(seed);
    std::vector<Box3f> boxes(count);
    for (Box3f& box : boxes) {
        Vec3f p;
        for (int k = 0; k < 3; ++k)
            p[k] = float(random.uniform(-spread, spread));
        box.extend(p);
        for (int k = 0; k < 3; ++k)
            p[k] += float(random.uniform(0, 1));
        box.extend(p);
    }
    return boxes;
}

bool inside(const Box3f& inner, const Box3f& outer) {
    return outer.contains(inner.min) && outer.contains(inner.max);
}

/// Checks the laws of a binary tree and returns its depth.
int check(const Bvh& bvh, std::span<const Box3f> boxes, const BvhOptions& options) {
    std::vector<int> seen(boxes.size());
    int deepest = 0;
    struct Entry {
        std::uint32_t node;
        int depth;
    };
    std::vector<Entry> todo{{0, 1}};
    std::size_t visited = 0;
    while (!todo.empty()) {
        Entry entry = todo.back();
        todo.pop_back();
        ++visited;
        deepest = std::max(deepest, entry.depth);
        const BvhNode& node = bvh.nodes[entry.node];
        if (node.leaf()) {
            EXPECT_LE(node.count, options.leaf_size);
            for (std::uint32_t i = node.first; i < node.first + node.count; ++i) {
                ++seen[bvh.order[i]];
                EXPECT_TRUE(inside(boxes[bvh.order[i]], node.box));
            }
            continue;
        }
        EXPECT_GT(node.first, entry.node);
        for (std::uint32_t child : {node.first, node.first + 1}) {
            EXPECT_TRUE(inside(bvh.nodes[child].box, node.box));
            todo.push_back({child, entry.depth + 1});
        }
    }
    EXPECT_EQ(visited, bvh.nodes.size());
    for (int count : seen)
        EXPECT_EQ(count, 1);
    return deepest;
}

TEST(Bvh, holds_every_box_once_inside_all_its_ancestors) {
    for (std::size_t count : {1u, 2u, 3u, 9u, 100u, 5000u, 40000u}) {
        std::vector<Box3f> boxes = random_boxes(count, 50, count);
        BvhOptions options;
        options.leaf_size = count % 2 ? 4 : 8;
        Bvh bvh = build_bvh(boxes, options);
        EXPECT_LE(check(bvh, boxes, options), kMaxBvhDepth);
    }
}

TEST(Bvh, of_nothing_is_empty) {
    EXPECT_TRUE(build_bvh({}).nodes.empty());
    EXPECT_TRUE(widen<8>(build_bvh({})).nodes.empty());
}

TEST(Bvh, is_the_same_for_any_number_of_threads) {
    std::vector<Box3f> boxes = random_boxes(30000, 100, 1);
    auto build = [&](unsigned threads) {
        Job job;
        job.threads = threads;
        return build_bvh(boxes, {}, job);
    };
    Bvh one = build(1);
    for (unsigned threads : {2u, 3u, 7u, 16u}) {
        Bvh many = build(threads);
        EXPECT_EQ(many.order, one.order);
        ASSERT_EQ(many.nodes.size(), one.nodes.size());
        EXPECT_EQ(std::memcmp(many.nodes.data(), one.nodes.data(), one.nodes.size() * sizeof(BvhNode)), 0);
    }
}

// Cases that cannot be cut by position, or only one item at a time.
TEST(Bvh, stays_shallow_whatever_the_boxes) {
    BvhOptions options;
    options.leaf_size = 1;
    std::vector<Box3f> same(5000, Box3f{{0, 0, 0}, {1, 1, 1}});
    EXPECT_LE(check(build_bvh(same, options), same, options), kMaxBvhDepth);
    std::vector<Box3f> powers;
    for (int i = 0; i < 5000; ++i) {
        float x = std::ldexp(1.0f, i % 200 - 100);
        powers.push_back({{x, 0, 0}, {x * 1.5f, x, x}});
    }
    EXPECT_LE(check(build_bvh(powers, options), powers, options), kMaxBvhDepth);
    std::vector<Box3f> points(3000, Box3f{{5, 5, 5}, {5, 5, 5}});
    EXPECT_LE(check(build_bvh(points, options), points, options), kMaxBvhDepth);
}

template <int N>
void check_wide() {
    std::vector<Box3f> boxes = random_boxes(10000, 50, 3);
    WideBvh<N> wide = widen<N>(build_bvh(boxes));
    std::vector<int> seen(boxes.size());
    std::size_t full = 0;
    for (const WideNode<N>& node : wide.nodes)
        for (int i = 0; i < N; ++i) {
            Box3f box{{node.bounds[0][i], node.bounds[2][i], node.bounds[4][i]},
                      {node.bounds[1][i], node.bounds[3][i], node.bounds[5][i]}};
            full += !box.empty();
            for (std::uint32_t item = node.first[i]; item < node.first[i] + node.count[i]; ++item) {
                ++seen[wide.order[item]];
                EXPECT_TRUE(inside(boxes[wide.order[item]], box));
            }
        }
    for (int count : seen)
        EXPECT_EQ(count, 1);
    EXPECT_GT(double(full) / double(N) / double(wide.nodes.size()), 0.4);
}
TEST(WideBvh, of_four_holds_every_box_once) {
    check_wide<4>();
}
TEST(WideBvh, of_eight_holds_every_box_once) {
    check_wide<8>();
}

TEST(WideBvh, of_one_box_has_a_root_with_one_leaf) {
    std::vector<Box3f> one{{{0, 0, 0}, {1, 1, 1}}};
    WideBvh<8> wide = widen<8>(build_bvh(one));
    ASSERT_EQ(wide.nodes.size(), 1u);
    EXPECT_EQ(wide.nodes[0].count[0], 1u);
    EXPECT_EQ(wide.nodes[0].bounds[1][0], 1.0f);
    EXPECT_GT(wide.nodes[0].bounds[0][1], wide.nodes[0].bounds[1][1]); // empty
}

} // namespace
