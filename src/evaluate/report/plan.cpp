#include "evaluate/report/plan.hpp"

#include "base/parallel.hpp"

#include <algorithm>
#include <cmath>

namespace antumbra {
namespace {

constexpr std::uint32_t kCutMatter = 7, kLevel = 6;

/// Where the walk is, with as much again around it, within the scene.
Box3d region_of(const Scene& scene, const WalkResult& result) {
    Box3d eyes, bounds = to_double(scene.local_bounds());
    for (const WalkFrame& frame : result.frames)
        eyes.extend(frame.view.eye);
    Vec3d size = eyes.size();
    double margin = std::max({size.x, size.z, 0.3 * std::max(bounds.size().x, bounds.size().z)});
    Box3d region = eyes;
    for (int axis : {0, 2}) {
        region.min[axis] = std::min(eyes.min[axis], std::max(bounds.min[axis], eyes.min[axis] - margin));
        region.max[axis] = std::max(eyes.max[axis], std::min(bounds.max[axis], eyes.max[axis] + margin));
    }
    return region;
}

std::uint32_t pixel_of(const Tracer& tracer, double x, double cut, double z) {
    bool back = false;
    Hit hit = tracer.nearest_surface({{x, cut, z}, {0, -1, 0}}, back);
    if (!hit)
        return 0;
    const Scene& scene = tracer.scene();
    Vec3d a = scene.vertex(hit.triangle, 0), b = scene.vertex(hit.triangle, 1), c = scene.vertex(hit.triangle, 2);
    double level = std::abs(normalized(cross(b - a, c - a)).y);
    auto shade = back ? kCutMatter : std::uint32_t(level * kLevel + 0.5);
    return 1 + 8 * scene.triangle_objects()[hit.triangle] + shade;
}

void append_number(std::vector<std::byte>& bytes, std::uint64_t number) {
    for (; number >= 128; number >>= 7)
        bytes.push_back(std::byte((number & 127) | 128));
    bytes.push_back(std::byte(number));
}

std::vector<std::byte> encode_runs(const std::vector<std::uint32_t>& pixels) {
    std::vector<std::byte> bytes;
    for (std::size_t at = 0; at < pixels.size();) {
        std::size_t end = at;
        while (end < pixels.size() && pixels[end] == pixels[at])
            ++end;
        append_number(bytes, pixels[at]);
        append_number(bytes, end - at);
        at = end;
    }
    return bytes;
}

Plan draw_plan(const Tracer& tracer, const Box3d& region, double cut, std::uint32_t pixels, const Job& job) {
    Vec3d size = region.size();
    Plan plan;
    plan.cut = cut;
    plan.x0 = region.min.x;
    plan.z0 = region.min.z;
    plan.scale = std::max({size.x, size.z, tracer.scene().step()}) / pixels;
    plan.width = std::max(1u, std::uint32_t(std::ceil(size.x / plan.scale)));
    plan.height = std::max(1u, std::uint32_t(std::ceil(size.z / plan.scale)));
    std::vector<std::uint32_t> picture(std::size_t(plan.width) * plan.height);
    parallel_for(plan.height, job, [&](std::size_t j, unsigned) {
        for (std::uint32_t i = 0; i < plan.width; ++i)
            picture[i + plan.width * j] = pixel_of(tracer, plan.x0 + (i + 0.5) * plan.scale, cut,
                                                   plan.z0 + (double(j) + 0.5) * plan.scale);
    });
    plan.runs = encode_runs(picture);
    return plan;
}

} // namespace

Plans make_plans(const Tracer& tracer, const WalkResult& result, std::uint32_t pixels, const Job& job) {
    Box3d region = region_of(tracer.scene(), result);
    Vec3d size = region.size();
    double across = std::max(size.x, size.z);
    // A walk that climbs gets a cut per storey: slices of its heights, each cut above its highest eye.
    double low = region.min.y, high = region.max.y;
    auto slices = std::uint32_t(std::clamp(std::ceil((high - low) / std::max(0.08 * across, 1e-300)), 1.0, 3.0));
    Plans plans;
    std::vector<std::uint32_t> plan_of_slice(slices, 0xFFFFFFFFu);
    std::vector<double> tops(slices, low);
    std::vector<std::uint32_t> slice_of_frame;
    for (const WalkFrame& frame : result.frames) {
        double height = frame.view.eye.y;
        double share = high > low ? (height - low) / (high - low) : 0;
        std::uint32_t slice = std::min(slices - 1, std::uint32_t(share * slices));
        tops[slice] = std::max(tops[slice], height);
        slice_of_frame.push_back(slice);
    }
    for (std::uint32_t slice : slice_of_frame) {
        if (plan_of_slice[slice] == 0xFFFFFFFFu) {
            plan_of_slice[slice] = std::uint32_t(plans.plans.size());
            plans.plans.push_back(draw_plan(tracer, region, tops[slice] + 0.003 * across, pixels, job));
        }
        plans.of_frame.push_back(plan_of_slice[slice]);
    }
    return plans;
}

} // namespace antumbra
