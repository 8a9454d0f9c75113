#include "occluder_finding/frames.hpp"

#include <algorithm>
#include <array>
#include <cmath>

namespace antumbra {
namespace {

using grid::Triangle;

constexpr double kSame = 0.9998; ///< cosine: one direction
constexpr std::size_t kMostDirections = 64, kMostFirst = 6;
constexpr double kGain = 1.2; ///< in area along the axes, over the grid's frame

struct Direction {
    Vec3d normal; ///< unit
    double area = 0;
};

/// Directions of the triangles, up to sign, the largest area first.
std::vector<Direction> directions_of(const GridMesh& mesh) {
    std::vector<Direction> list;
    for (const Triangle& t : mesh.triangles) {
        Vec3d a = to_vector(t[0]), normal = cross(to_vector(t[1]) - a, to_vector(t[2]) - a);
        double area = length(normal);
        if (!(area > 0))
            continue;
        normal = normal / area;
        auto same = std::find_if(list.begin(), list.end(),
                                 [&](const Direction& d) { return std::abs(dot(d.normal, normal)) > kSame; });
        if (same != list.end())
            same->area += area;
        else if (list.size() < kMostDirections)
            list.push_back({normal, area});
    }
    std::stable_sort(list.begin(), list.end(), [](const Direction& a, const Direction& b) { return a.area > b.area; });
    return list;
}

double area_along(const std::vector<Direction>& directions, const Frame& frame) {
    double sum = 0;
    for (const Direction& d : directions)
        for (const Vec3d& axis : frame.axis)
            if (std::abs(dot(d.normal, axis)) > kSame)
                sum += d.area;
    return sum;
}

/// Coordinates within `tolerance` of the one before become the first of their run.
std::vector<std::pair<double, std::int64_t>> cluster(std::vector<double> values, double tolerance) {
    std::sort(values.begin(), values.end());
    std::vector<std::pair<double, std::int64_t>> runs; // from here on, the whole number that stands for it
    double begin = 0;
    for (double value : values)
        if (runs.empty() || value - begin > tolerance) {
            begin = value;
            runs.push_back({value, std::llround(value)});
        }
    return runs;
}

} // namespace

std::vector<Frame> oriented_frames(const GridMesh& mesh) {
    std::vector<Direction> directions = directions_of(mesh);
    double best = std::max(kGain * area_along(directions, Frame{}), 1.0);
    std::vector<Frame> found;
    for (std::size_t i = 0; i < std::min(kMostFirst, directions.size()); ++i)
        for (std::size_t j = 0; j < directions.size(); ++j) {
            const Vec3d &first = directions[i].normal, &second = directions[j].normal;
            if (j == i || std::abs(dot(first, second)) > 0.01)
                continue;
            Frame frame;
            frame.axis[0] = first;
            frame.axis[1] = normalized(second - first * dot(first, second));
            frame.axis[2] = cross(frame.axis[0], frame.axis[1]);
            if (double area = area_along(directions, frame); area > best) {
                best = area;
                found.assign(1, frame);
            }
        }
    return found;
}

GridMesh turned(const GridMesh& mesh, const Frame& frame, const Vec3d& origin) {
    std::array<std::vector<double>, 3> values;
    std::vector<std::array<Vec3d, 3>> triangles;
    for (const Triangle& triangle : mesh.triangles) {
        triangles.emplace_back();
        for (std::size_t c = 0; c < 3; ++c) {
            triangles.back()[c] = frame.to_frame(to_vector(triangle[c]) - origin);
            for (std::size_t k = 0; k < 3; ++k)
                values[k].push_back(triangles.back()[c][int(k)]);
        }
    }
    GridMesh result;
    result.triangles.resize(triangles.size());
    for (std::size_t k = 0; k < 3; ++k) {
        auto [low, high] = std::minmax_element(values[k].begin(), values[k].end());
        double tolerance = std::max(2.0, 1e-4 * (*high - *low));
        auto runs = cluster(values[k], tolerance);
        for (std::size_t t = 0; t < triangles.size(); ++t)
            for (std::size_t c = 0; c < 3; ++c) {
                auto after = std::upper_bound(runs.begin(), runs.end(), triangles[t][c][int(k)],
                                              [](double value, const auto& run) { return value < run.first; });
                result.triangles[t][c][k] = std::prev(after)->second;
            }
        result.min[k] = runs.front().second;
        result.max[k] = runs.back().second;
    }
    return result;
}

} // namespace antumbra
