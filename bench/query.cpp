// Time of a query, with the bytes that the answers take beside it. ns per 4,000 objects is the figure of antumbra.h.
#include "base/random.hpp"

#include <antumbra/pvs.hpp>

#include <benchmark/benchmark.h>

namespace antumbra {
namespace {

constexpr std::uint32_t kObjects = 4000;

/// Rows as coherent as those of real scenes: runs of visible objects of about eight, `percent` of all visible.
PvsData make_data(std::uint32_t percent) {
    PvsData data;
    data.objects.resize(kObjects);
    data.grid = {{{0, 0, 0}, {16, 16, 16}}, {16, 16, 16}};
    data.row_count = 4096;
    data.rows.resize(data.row_count * data.words_per_row());
    Random random(1);
    for (std::uint32_t r = 0; r < data.row_count; ++r) {
        bool value = false;
        for (std::uint32_t o = 0; o < kObjects; ++o) {
            if (random.below(800) < (value ? 100 - percent : percent))
                value = !value;
            data.rows[r * data.words_per_row() + o / 64] |= std::uint64_t(value) << (o % 64);
        }
        data.cell_row.push_back(r);
    }
    return data;
}

void new_cell(benchmark::State& state) {
    PvsData data = make_data(static_cast<std::uint32_t>(state.range(0)));
    std::vector<std::byte> bytes = *encode_pvs(data);
    Pvs pvs = *Pvs::open(bytes);
    PvsCursor cursor;
    std::uint64_t cell = 0, visible = 0, queries = 0;
    for (auto _ : state) {
        cell = (cell + 1021) % 4096;
        Vec3d eye{double(cell % 16) + 0.5, double(cell / 16 % 16) + 0.5, double(cell / 256) + 0.5};
        benchmark::DoNotOptimize(pvs.query(eye, cursor));
        visible += cursor.visible_count;
        ++queries;
    }
    state.counters["visible"] = double(visible) / double(queries);
    state.counters["bits_per_pair"] = double(pvs.visibility_bytes()) * 8 / (4096.0 * kObjects);
    state.counters["bytes"] = double(bytes.size());
}
BENCHMARK(new_cell)->ArgName("percent_visible")->Arg(1)->Arg(5)->Arg(10)->Arg(25)->Arg(50);

void same_cell(benchmark::State& state) {
    std::vector<std::byte> bytes = *encode_pvs(make_data(10));
    Pvs pvs = *Pvs::open(bytes);
    PvsCursor cursor;
    Vec3d eye{3.5, 4.5, 5.5};
    for (auto _ : state) {
        benchmark::DoNotOptimize(eye);
        benchmark::DoNotOptimize(pvs.query(eye, cursor));
    }
}
BENCHMARK(same_cell);

void open_file(benchmark::State& state) {
    std::vector<std::byte> bytes = *encode_pvs(make_data(10));
    for (auto _ : state)
        benchmark::DoNotOptimize(Pvs::open(bytes).ok());
    state.SetBytesProcessed(std::int64_t(state.iterations()) * std::int64_t(bytes.size()));
}
BENCHMARK(open_file);

} // namespace
} // namespace antumbra

BENCHMARK_MAIN();
