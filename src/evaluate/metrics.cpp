#include "evaluate/metrics.hpp"

#include <algorithm>
#include <cmath>

namespace antumbra {
namespace {

/// Median over the frames of what `value` gives, without what was not measured.
template <class Value>
double median_over(const WalkResult& result, Value&& value) {
    std::vector<double> values;
    for (const WalkFrame& frame : result.frames)
        if (double v = value(frame); v >= 0)
            values.push_back(v);
    return median(std::move(values));
}

template <class Value>
double mean_over(const WalkResult& result, Value&& value) {
    double sum = 0;
    for (const WalkFrame& frame : result.frames)
        sum += double(value(frame));
    return result.frames.empty() ? 0 : sum / double(result.frames.size());
}

void summarise_method(const WalkResult& result, std::size_t m, WalkMethod& method) {
    auto sample = [m](const WalkFrame& frame) -> const WalkSample& { return frame.methods[m]; };
    std::vector<double> cull;
    for (const WalkFrame& frame : result.frames)
        if (sample(frame).cull_ms >= 0)
            cull.push_back(sample(frame).cull_ms);
    method.cull_ms_median = median(cull);
    method.cull_ms_p99 = percentile(cull, 0.99);
    method.draw_ms_median = median_over(result, [&](const WalkFrame& f) { return sample(f).draw_ms; });
    method.frame_ms_median = median_over(result, [&](const WalkFrame& f) { return sample(f).frame_ms(); });
    method.objects_reported = mean_over(result, [&](const WalkFrame& f) { return sample(f).objects_reported; });
    method.triangles_drawn = mean_over(result, [&](const WalkFrame& f) { return sample(f).triangles_drawn; });
    method.false_visible_objects =
        mean_over(result, [&](const WalkFrame& f) { return sample(f).false_visible_objects; });
    method.culled_of_frustum = mean_over(result, [&](const WalkFrame& f) {
        return f.objects_in_frustum ? double(sample(f).culled_of_frustum) / f.objects_in_frustum : 0.0;
    });
    method.false_invisible_objects = method.false_invisible_pixels = 0;
    method.grazing_pixels = method.unconfirmed_pixels = 0;
    for (const WalkFrame& frame : result.frames) {
        if (method.from_region && frame.in_matter)
            continue;
        method.false_invisible_objects += sample(frame).false_invisible_objects;
        method.false_invisible_pixels += sample(frame).false_invisible_pixels;
        method.grazing_pixels += sample(frame).grazing_pixels;
        method.unconfirmed_pixels += sample(frame).unconfirmed_pixels;
    }
}

} // namespace

double median(std::vector<double> values) {
    if (values.empty())
        return -1;
    std::sort(values.begin(), values.end());
    std::size_t half = values.size() / 2;
    return values.size() % 2 ? values[half] : (values[half - 1] + values[half]) / 2;
}

double percentile(std::vector<double> values, double share) {
    if (values.empty())
        return -1;
    std::sort(values.begin(), values.end());
    double rank = std::ceil(share * double(values.size()));
    return values[std::size_t(std::clamp(rank, 1.0, double(values.size()))) - 1];
}

void summarise(WalkResult& result) {
    double frustum_ms = -1;
    for (std::size_t m = 0; m < result.methods.size(); ++m) {
        summarise_method(result, m, result.methods[m]);
        if (result.methods[m].name == "frustum")
            frustum_ms = result.methods[m].frame_ms_median;
    }
    auto ratio = [&](double ms) { return frustum_ms > 0 && ms > 0 ? frustum_ms / ms : -1; };
    for (WalkMethod& method : result.methods)
        method.speedup_over_frustum = ratio(method.frame_ms_median);
    result.objects_true = mean_over(result, [](const WalkFrame& f) { return f.objects_true; });
    result.triangles_true = mean_over(result, [](const WalkFrame& f) { return f.triangles_true; });
    result.empty_ms_median = median_over(result, [](const WalkFrame& f) { return f.empty_ms; });
    result.ceiling_ms_median = median_over(result, [](const WalkFrame& f) { return f.ceiling_ms; });
    result.ceiling_speedup = ratio(result.ceiling_ms_median);
    result.frames_in_matter = std::uint32_t(
        std::count_if(result.frames.begin(), result.frames.end(), [](const WalkFrame& f) { return f.in_matter; }));
}

const WalkMethod* find_broken_promise(const WalkResult& result) {
    for (const WalkMethod& method : result.methods)
        if (!may_lose_pixels(method.guarantee) && method.false_invisible_pixels > 0)
            return &method;
    return nullptr;
}

} // namespace antumbra
