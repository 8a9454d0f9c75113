#include "bake/sampled/sampling_region.hpp"

#include <algorithm>
#include <cmath>

namespace antumbra {
namespace {

/// The heading turned by `quarters` quarter turns.
Vec3d turned(const Vec3d& d, int quarters) {
    switch (quarters & 3) {
    case 1:
        return {-d.z, d.y, d.x};
    case 2:
        return {-d.x, d.y, -d.z};
    case 3:
        return {d.z, d.y, -d.x};
    default:
        return d;
    }
}

/// Range of headings from any point of a to any point of b, as start and length (below 4), or all of them.
struct Headings {
    double start = 0, extent = 4;
};

Headings headings(const Box3d& a, const Box3d& b) {
    // The differences fill a rectangle in (x, z). If it holds zero, every heading occurs.
    double x0 = b.min.x - a.max.x, x1 = b.max.x - a.min.x, z0 = b.min.z - a.max.z, z1 = b.max.z - a.min.z;
    if (x0 <= 0 && x1 >= 0 && z0 <= 0 && z1 >= 0)
        return {};
    double first = view_angles({(x0 + x1) / 2, 0, (z0 + z1) / 2})[0], low = 0, high = 0;
    for (double x : {x0, x1})
        for (double z : {z0, z1}) {
            // A rectangle without the origin spans less than half a turn: offsets lie in (-2, 2).
            double offset = view_angles({x, 0, z})[0] - first;
            offset = offset > 2 ? offset - 4 : offset < -2 ? offset + 4 : offset;
            low = std::min(low, offset);
            high = std::max(high, offset);
        }
    constexpr double kSlack = 1e-9;
    return {first + low - kSlack, high - low + 2 * kSlack};
}

} // namespace

Vec3d uniform_direction(const SamplingRegion& box, Random& random) {
    if (box.whole_sphere())
        return uniform_direction(random);
    double quarter = std::floor(box.min[3]);
    bool one_quarter = box.max[3] <= quarter + 1;
    for (;;) {
        Vec3d d = uniform_direction(random);
        if ((box.min[4] >= 0 && d.y < 0) || (box.max[4] <= 0 && d.y > 0))
            d.y = -d.y;
        if (one_quarter)
            d = turned(d, int(quarter) - int(view_angles(d)[0]));
        if (box.holds_direction(d))
            return d;
    }
}

bool may_look_at(const SamplingRegion& box, const Box3d& target) {
    if (box.whole_sphere())
        return true;
    Box3d space = box.space();
    Headings range = headings(space, target);
    if (range.extent < 4 && box.extent(kAxisTheta) < 4) {
        bool meets = false;
        for (double turn : {-4.0, 0.0, 4.0})
            meets = meets || (range.start + turn <= box.max[3] && range.start + range.extent + turn >= box.min[3]);
        if (!meets)
            return false;
    }
    // Elevation: the steepest line has the largest rise over the shortest run (|x| + |z|).
    double near = std::max({0.0, target.min.x - space.max.x, space.min.x - target.max.x}) +
                  std::max({0.0, target.min.z - space.max.z, space.min.z - target.max.z});
    double far = std::max(std::abs(target.max.x - space.min.x), std::abs(space.max.x - target.min.x)) +
                 std::max(std::abs(target.max.z - space.min.z), std::abs(space.max.z - target.min.z));
    auto elevation = [](double rise, double run) { return rise == 0 ? 0.0 : rise / (std::abs(rise) + run); };
    double rise_low = target.min.y - space.max.y, rise_high = target.max.y - space.min.y;
    double low = elevation(rise_low, rise_low < 0 ? near : far), high = elevation(rise_high, rise_high > 0 ? near : far);
    constexpr double kSlack = 1e-9;
    return low - kSlack <= box.max[4] && high + kSlack >= box.min[4];
}

} // namespace antumbra
