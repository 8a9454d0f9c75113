// Opacity maps: one overlap test by table, bits and pixels; queries as a frame asks them; minimum occluder sets of one
// picture. Each with what it decided beside the time.
#include "base/random.hpp"
#include "cull/opacity_occluders.hpp"
#include "cull/scene_data.hpp"
#include "evaluate/cull_scene.hpp"
#include "mos/choose_list.hpp"
#include "raster/depth_pyramid.hpp"
#include "raster/opacity_map.hpp"
#include "raster/opacity_rows.hpp"
#include "raster/sparse_depth_map.hpp"
#include "raster/tile_buffer.hpp"

#include <antumbra/generate.hpp>
#include <antumbra/occluder_finding.hpp>

#include <benchmark/benchmark.h>

#include <cmath>
#include <memory>

namespace antumbra {
namespace {

enum Form : int { kTable, kBits, kPixels };

/// Everything covered, at a depth that falls and rises along the rows.
struct Covered {
    OccluderImage image;
    OpacityMap table;
    SparseDepthMap sparse;
    OpacityRows rows;

    Covered() {
        Screen screen;
        screen.width = screen.height = 128;
        image.reset(screen);
        for (int y = 0; y < 128; ++y)
            for (int x = 0; x < 128; ++x) {
                image.bits[std::size_t(y * image.words + x / 64)] |= std::uint64_t(1) << (x % 64);
                image.nearness[std::size_t(y * image.stride + x)] = 2 + 0.01f * float((x + y) % 40);
                image.row_used[std::size_t(y)] = 1;
            }
        table.build(image);
        sparse.build(image);
        rows.build(image);
    }
};

/// Covered squares: pixel by pixel there is no way out early.
void overlap(benchmark::State& state) {
    Covered map;
    PixelRect rects[64];
    Random random(1);
    const int side = int(state.range(1));
    for (PixelRect& rect : rects) {
        rect.x0 = int(random.below(std::uint32_t(128 - side))), rect.y0 = int(random.below(std::uint32_t(128 - side)));
        rect.x1 = rect.x0 + side - 1, rect.y1 = rect.y0 + side - 1;
    }
    std::size_t at = 0;
    std::uint64_t covered = 0;
    for (auto _ : state) {
        const PixelRect& rect = rects[at++ % 64];
        bool hit = state.range(0) == kTable  ? map.table.overlaps(rect)
                   : state.range(0) == kBits ? map.rows.overlaps(rect)
                                             : overlaps_pixel_wise(map.image, rect);
        covered += hit;
        benchmark::DoNotOptimize(hit);
    }
    state.counters["covered"] = double(covered) / double(state.iterations());
}
BENCHMARK(overlap)->ArgNames({"form", "side"})->ArgsProduct({{kTable, kBits, kPixels}, {1, 2, 4, 8, 16, 32, 64}});

void depth_32x32(benchmark::State& state) {
    Covered map;
    PixelRect rect{17, 33, 48, 64};
    std::uint64_t behind = 0;
    for (auto _ : state) {
        bool hit = state.range(0) == kTable  ? map.sparse.is_behind(map.image, rect, 1.5f)
                   : state.range(0) == kBits ? map.rows.is_behind(map.image, rect, 1.5f)
                                             : is_behind_pixel_wise(map.image, rect, 1.5f);
        behind += hit;
        benchmark::DoNotOptimize(hit);
    }
    state.counters["behind"] = double(behind) / double(state.iterations());
}
BENCHMARK(depth_32x32)->ArgName("form")->Arg(kTable)->Arg(kBits)->Arg(kPixels);

/// A street corner of the downtown, with the occluders that the culler would draw.
struct Corner {
    Scene scene;
    OccluderSet occluders;
    CullScene cull_scene;
    Camera camera;

    static Corner& get() {
        static Corner corner;
        return corner;
    }

  private:
    Corner() : scene(*Scene::create(*generate("downtown"))), occluders(find_occluders(scene)) {
        cull_scene = cull_scene_of(scene, occluders);
        View view;
        view.eye = scene.to_local({440, 1.7, 400});
        view.target = view.eye + Vec3d{1, 0, 0.3};
        camera = camera_of(view);
    }
};

/// What a frame of the corner asks: its occluders drawn into every kind of map, and the nodes that it opens.
struct Asked {
    Screen screen;
    OccluderImage image;
    OpacityMap table;
    SparseDepthMap sparse;
    OpacityRows rows;
    TileBuffer tiles;
    DepthPyramid pyramid;
    ProjectEight project;
    std::vector<const CullNode*> nodes; ///< with a child on the screen
    double side = 0, boxes = 0;         ///< mean side of the rectangles, how many

    explicit Asked(int width, int height) {
        Corner& corner = Corner::get();
        const CullScene::Data& scene = corner.cull_scene.data();
        screen = height ? make_screen(corner.camera, width, height, 4000) : make_screen(corner.camera, width, 4000);
        image.reset(screen);
        tiles.reset(screen);
        pyramid.reset(screen);
        draw(scene, corner.camera);
        table.build(image);
        sparse.build(image);
        rows.build(image);
        pyramid.build();
        project = project_eight_avx512() ? project_eight_avx512()
                  : project_eight_avx2() ? project_eight_avx2()
                                         : project_eight_scalar;
        EightOnScreen eight;
        for (const CullNode& node : scene.wide) {
            project(screen, node.min, node.max, eight);
            if (std::uint32_t rest = eight.testable & node.mask()) {
                nodes.push_back(&node);
                for (; rest; rest &= rest - 1) {
                    side += std::sqrt(double(eight.rect(std::countr_zero(rest)).area()));
                    ++boxes;
                }
            }
        }
        side /= boxes;
    }

  private:
    void draw(const CullScene::Data& scene, const Camera& camera) {
        OpacityOccluders occluders(scene);
        occluders.choose(scene, nullptr, camera, frustum_planes(camera, scene.tree_box), 256);
        const PatchStore& store = occluders.patches(scene.occluders);
        OccluderBrush brush;
        brush.fit(screen, store);
        PatchCoverage coverage;
        coverage.fit(screen, store);
        for (std::uint32_t p = 0; p < store.patches.size(); ++p) {
            draw_occluder_scalar(store, p, screen, PixelCoverage::inner, brush, image);
            draw_patch_scalar(store, p, screen, coverage);
            tiles.merge(coverage);
            pyramid.merge(coverage);
            coverage.clear(screen);
        }
    }
};

/// Projection, overlap and depth together; time per box.
template <class IsHiddenBox>
void ask(benchmark::State& state, const Asked& asked, IsHiddenBox&& is_hidden) {
    EightOnScreen eight;
    std::uint64_t boxes = 0, hidden = 0;
    for (auto _ : state)
        for (const CullNode* node : asked.nodes) {
            asked.project(asked.screen, node->min, node->max, eight);
            for (std::uint32_t rest = eight.testable & node->mask(); rest; rest &= rest - 1) {
                int lane = std::countr_zero(rest);
                ++boxes;
                hidden += is_hidden(eight.rect(lane), eight.nearness[lane]);
            }
        }
    state.counters["side"] = asked.side;
    state.counters["hidden"] = double(hidden) / double(boxes);
    state.counters["per_box"] = benchmark::Counter(double(boxes), benchmark::Counter::kIsRate | benchmark::Counter::kInvert);
}

void query_published(benchmark::State& state) {
    static Asked a(128, 128);
    ask(state, a, [&](const PixelRect& rect, float nearness) {
        return a.table.overlaps(rect) && a.sparse.is_behind(a.image, rect, nearness);
    });
}
void query_pixel_wise(benchmark::State& state) {
    static Asked a(128, 128);
    ask(state, a, [&](const PixelRect& rect, float nearness) {
        return overlaps_pixel_wise(a.image, rect) && is_behind_pixel_wise(a.image, rect, nearness);
    });
}
void query_modern(benchmark::State& state) {
    static Asked a(256, 0);
    ask(state, a, [&](const PixelRect& rect, float nearness) {
        return a.rows.overlaps(rect) && a.rows.is_behind(a.image, rect, nearness);
    });
}
/// The maps of the other image-space methods, with the same occluders at the same resolution.
void query_masked(benchmark::State& state) {
    static Asked a(256, 0);
    IsHidden hidden = is_hidden_avx512() ? is_hidden_avx512() : is_hidden_avx2() ? is_hidden_avx2() : is_hidden_scalar;
    ask(state, a, [&](const PixelRect& rect, float nearness) {
        return hidden(a.tiles, rect, nearness);
    });
}
void query_hzb(benchmark::State& state) {
    static Asked a(256, 0);
    ask(state, a, [&](const PixelRect& rect, float nearness) {
        return a.pyramid.is_hidden(rect, nearness);
    });
}
BENCHMARK(query_published)->MinTime(0.3);
BENCHMARK(query_pixel_wise)->MinTime(0.3);
BENCHMARK(query_modern)->MinTime(0.3);
BENCHMARK(query_masked)->MinTime(0.3);
BENCHMARK(query_hzb)->MinTime(0.3);

/// All of one picture: stacks, search and choice, for the 1,000 occludees of the paper's size that are nearest.
void minimum_sets_of_1000(benchmark::State& state) {
    Corner& corner = Corner::get();
    MosOptions options;
    Screen screen = make_screen(corner.camera, 128, 128, 4000);
    std::vector<Occludee> occludees;
    for (const Occludee& occludee : find_occludees(corner.scene, options))
        if (!pixel_rect(screen, project_box(screen, occludee.box)).empty() && occludees.size() < 1000)
            occludees.push_back(occludee);
    MosStatistics statistics;
    std::size_t used = 0;
    for (auto _ : state)
        used = choose_list(corner.occluders, occludees, screen, options, &statistics).size();
    double pictures = double(statistics.pictures);
    state.counters["occludees"] = double(statistics.occludees) / pictures;
    state.counters["sets"] = double(statistics.sets) / pictures;
    state.counters["seen"] = double(statistics.uncovered) / pictures;
    state.counters["cut_short"] = double(statistics.searches_cut) / pictures;
    state.counters["occluders"] = double(used);
}
BENCHMARK(minimum_sets_of_1000)->Unit(benchmark::kMillisecond);

} // namespace
} // namespace antumbra

BENCHMARK_MAIN();
