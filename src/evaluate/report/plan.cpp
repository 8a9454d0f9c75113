#include "evaluate/report/plan.hpp"

#include "base/parallel.hpp"

#include <algorithm>
#include <cmath>

namespace antumbra {
namespace {

constexpr std::uint32_t kCutMatter = 7, kLevel = 6;
constexpr std::uint32_t kMostPlans = 6, kNoPlan = 0xFFFFFFFFu;

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

/// Height of the eyes above what is below them: the middle one of the frames.
double head_height(const Tracer& tracer, const WalkResult& result) {
    std::vector<double> heights;
    for (const WalkFrame& frame : result.frames) {
        bool back = false;
        if (Hit hit = tracer.nearest_surface({frame.view.eye, {0, -1, 0}}, back))
            heights.push_back(hit.t);
    }
    std::sort(heights.begin(), heights.end());
    return heights.empty() ? 0 : heights[heights.size() / 2];
}

/// Heights to cut at, ascending: frames whose eyes differ by less than a part of a head's height share a cut, at the
/// highest of them, so that no cut runs above the ceiling of the room that a frame is in.
std::vector<double> storeys(const WalkResult& result, double head_height) {
    std::vector<double> eyes;
    for (const WalkFrame& frame : result.frames)
        eyes.push_back(frame.view.eye.y);
    std::sort(eyes.begin(), eyes.end());
    double apart = std::max(0.3 * head_height, (eyes.back() - eyes.front()) / kMostPlans);
    std::vector<double> tops;
    for (std::size_t first = 0; first < eyes.size();) {
        std::size_t end = first;
        while (end < eyes.size() && eyes[end] - eyes[first] <= apart)
            ++end;
        tops.push_back(eyes[end - 1]);
        first = end;
    }
    return tops;
}

/// Is most of the walk under the open sky? Then the scene is shown whole: buildings are known by their roofs.
bool is_outdoors(const Tracer& tracer, const WalkResult& result) {
    std::size_t covered = 0;
    for (const WalkFrame& frame : result.frames) {
        bool back = false;
        covered += bool(tracer.nearest_surface({frame.view.eye, {0, 1, 0}}, back));
    }
    return covered * 2 < result.frames.size();
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
            picture[i + plan.width * j] =
                pixel_of(tracer, plan.x0 + (i + 0.5) * plan.scale, cut, plan.z0 + (double(j) + 0.5) * plan.scale);
    });
    plan.runs = encode_runs(picture);
    return plan;
}

} // namespace

Plans make_plans(const Tracer& tracer, const WalkResult& result, std::uint32_t pixels, const Job& job) {
    Box3d region = region_of(tracer.scene(), result);
    bool outdoors = is_outdoors(tracer, result);
    std::vector<double> tops = outdoors ? std::vector<double>{double(tracer.scene().local_bounds().max.y)}
                                        : storeys(result, head_height(tracer, result));
    tops.back() = std::max(tops.back(), region.max.y);
    Plans plans;
    plans.outdoors = outdoors;
    std::vector<std::uint32_t> plan_of_storey(tops.size(), kNoPlan);
    for (const WalkFrame& frame : result.frames) {
        auto storey = std::size_t(std::lower_bound(tops.begin(), tops.end(), frame.view.eye.y) - tops.begin());
        if (plan_of_storey[storey] == kNoPlan) {
            plan_of_storey[storey] = std::uint32_t(plans.plans.size());
            plans.plans.push_back(draw_plan(tracer, region, tops[storey] + 2 * tracer.scene().step(), pixels, job));
        }
        plans.of_frame.push_back(plan_of_storey[storey]);
    }
    return plans;
}

} // namespace antumbra
