#include "evaluate/walkable.hpp"

#include "bake/viewpoint.hpp"
#include "base/parallel.hpp"

#include <algorithm>

namespace antumbra {
namespace {

constexpr int kMostSurfaces = 64;     ///< of one column
constexpr double kFlat = 0.7;         ///< least upward part of a floor's unit normal
constexpr double kKnee = 0.4;         ///< of the eye height
constexpr double kHeadroom = 1.1;     ///< of the eye height
constexpr double kHighestStep = 0.45; ///< of the eye height

struct Floor {
    double height = 0, gap = 0; ///< gap: up to the next surface, infinite under the sky
};

/// What a vertical line through the scene meets, from above.
std::vector<Floor> floors_of_column(const Tracer& tracer, double x, double z) {
    const Scene& scene = tracer.scene();
    Box3f bounds = scene.local_bounds();
    std::vector<Floor> floors;
    double height = double(bounds.max.y) + 4 * scene.step(), ceiling = std::numeric_limits<double>::infinity();
    bool open_below = true; // is the space under the last surface air?
    for (int k = 0; k < kMostSurfaces; ++k) {
        bool back = false;
        Hit hit = tracer.nearest_surface({{x, height, z}, {0, -1, 0}}, back);
        if (!hit)
            break;
        double at = height - hit.t;
        const Object& object = scene.object_of(hit.triangle);
        Vec3d a = scene.vertex(hit.triangle, 0), b = scene.vertex(hit.triangle, 1), c = scene.vertex(hit.triangle, 2);
        Vec3d normal = normalized(cross(b - a, c - a));
        bool both = object.has(kDoubleSided);
        if (object.has(kOccludes)) {
            if ((both ? std::abs(normal.y) : normal.y) >= kFlat && open_below)
                floors.push_back({at, ceiling - at});
            ceiling = at;
            open_below = both || normal.y < 0;
        }
        height = at - 2 * scene.step();
    }
    return floors;
}

/// People build rooms a little less than twice as high as their eyes. Without ceilings: the size of a person if the
/// units can be metres, else a share of the scene.
double guess_eye_height(const Tracer& tracer, const std::vector<std::vector<Floor>>& columns) {
    std::vector<double> gaps;
    std::size_t floors = 0;
    Vec3d size = to_double(tracer.scene().local_bounds()).size();
    double extent = std::max(size.x, size.z);
    for (const auto& column : columns)
        for (const Floor& floor : column) {
            ++floors;
            if (floor.gap > extent * 1e-3 && std::isfinite(floor.gap))
                gaps.push_back(floor.gap);
        }
    if (gaps.size() * 4 >= floors && gaps.size() >= 16) {
        std::sort(gaps.begin(), gaps.end());
        // Shelves, table tops and the layers of a floor make many low gaps. Half of the air is under ceilings lower
        // than this one:
        double air = 0, below = 0;
        for (double gap : gaps)
            air += gap;
        std::size_t k = 0;
        while (k + 1 < gaps.size() && (below += gaps[k]) < 0.5 * air)
            ++k;
        return std::min(0.6 * gaps[k], 0.2 * extent);
    }
    return extent > 15 && extent < 20000 ? 1.7 : extent / 100;
}

/// Places by column, so that neighbours are found.
struct Columns {
    std::uint32_t nx = 1, nz = 1;
    double spacing = 1;
    Vec3d origin;
    double x(std::uint32_t i) const { return origin.x + (i + 0.5) * spacing; }
    double z(std::uint32_t j) const { return origin.z + (j + 0.5) * spacing; }
};

/// Where all but the outermost objects are: backdrops and far scenery would make the columns too wide.
Box3d busy_region(const Scene& scene) {
    constexpr std::size_t kLeaveOut = 40; // one object of so many at each end
    Box3d region = to_double(scene.local_bounds());
    for (int axis : {0, 2}) {
        std::vector<float> centres;
        for (const Object& object : scene.objects())
            if (object.triangle_count > 0)
                centres.push_back(object.bounds.centre()[axis]);
        std::sort(centres.begin(), centres.end());
        std::size_t skip = centres.size() / kLeaveOut;
        if (skip == 0)
            continue;
        double low = centres[skip], high = centres[centres.size() - 1 - skip], margin = 0.05 * (high - low);
        if (high > low) {
            region.min[axis] = std::max(region.min[axis], low - margin);
            region.max[axis] = std::min(region.max[axis], high + margin);
        }
    }
    return region;
}

Columns lay_columns(const Scene& scene, std::uint32_t wanted) {
    Box3d region = busy_region(scene);
    Vec3d size = region.size();
    Columns columns;
    columns.spacing = std::max(size.x, size.z) / wanted;
    if (!(columns.spacing > 0))
        columns.spacing = scene.step();
    columns.origin = region.min;
    columns.nx = std::max(1u, std::uint32_t(size.x / columns.spacing));
    columns.nz = std::max(1u, std::uint32_t(size.z / columns.spacing));
    return columns;
}

bool can_step(const Tracer& tracer, const Place& from, const Place& to, double eye_height, double highest_step) {
    if (std::abs(from.eye.y - to.eye.y) > highest_step || !is_free(tracer, from.eye, to.eye))
        return false;
    Vec3d down{0, -eye_height * (1 - kKnee), 0};
    return is_free(tracer, from.eye + down, to.eye + down);
}

void join_neighbours(const Tracer& tracer, const Columns& columns,
                     const std::vector<std::vector<std::uint32_t>>& by_column, Walkable& walkable, const Job& job) {
    double highest_step = std::max(kHighestStep * walkable.eye_height, std::min(columns.spacing, walkable.eye_height));
    // Each place looks for its +x and +z neighbours; who is found learns of it afterwards.
    parallel_for(walkable.places.size(), job, [&](std::size_t p, unsigned) {
        Place& place = walkable.places[p];
        for (int side : {1, 3}) {
            std::uint32_t i = place.column_x + (side == 1), j = place.column_z + (side == 3);
            if (i >= columns.nx || j >= columns.nz)
                continue;
            for (std::uint32_t other : by_column[i + std::size_t(columns.nx) * j])
                if (can_step(tracer, place, walkable.places[other], walkable.eye_height, highest_step)) {
                    place.neighbours[std::size_t(side)] = other;
                    break;
                }
        }
    });
    for (std::uint32_t p = 0; p < walkable.places.size(); ++p)
        for (std::size_t side : {1u, 3u})
            if (std::uint32_t other = walkable.places[p].neighbours[side]; other != kNoPlace)
                walkable.places[other].neighbours[side - 1] = p;
}

void mark_components(Walkable& walkable) {
    std::vector<bool> reached(walkable.places.size(), false);
    std::vector<std::uint32_t> queue;
    for (std::uint32_t start = 0; start < walkable.places.size(); ++start) {
        if (reached[start])
            continue;
        auto component = std::uint32_t(walkable.component_sizes.size());
        queue.assign(1, start);
        reached[start] = true;
        for (std::size_t at = 0; at < queue.size(); ++at) {
            Place& place = walkable.places[queue[at]];
            place.component = component;
            for (std::uint32_t next : place.neighbours)
                if (next != kNoPlace && !reached[next]) {
                    reached[next] = true;
                    queue.push_back(next);
                }
        }
        walkable.component_sizes.push_back(std::uint32_t(queue.size()));
    }
}

void measure_clearance(Walkable& walkable) {
    std::vector<std::uint32_t> queue;
    for (std::uint32_t p = 0; p < walkable.places.size(); ++p) {
        Place& place = walkable.places[p];
        bool edge = std::count(place.neighbours.begin(), place.neighbours.end(), kNoPlace) > 0;
        place.clearance = edge ? 1 : 0;
        if (edge)
            queue.push_back(p);
    }
    for (std::size_t at = 0; at < queue.size(); ++at) {
        const Place& place = walkable.places[queue[at]];
        for (std::uint32_t next : place.neighbours)
            if (next != kNoPlace && walkable.places[next].clearance == 0) {
                walkable.places[next].clearance = place.clearance + 1;
                queue.push_back(next);
            }
    }
}

} // namespace

bool is_free(const Tracer& tracer, const Vec3d& from, const Vec3d& to) {
    bool back = false;
    if (from == to)
        return true;
    Hit hit = tracer.nearest_surface({from, to - from}, back);
    return !hit || hit.t > 1;
}

bool is_roomy(const Tracer& tracer, const Vec3d& point, double radius) {
    for (int x = -1; x <= 1; ++x)
        for (int y = -1; y <= 1; ++y)
            for (int z = -1; z <= 1; ++z) {
                int parts = std::abs(x) + std::abs(y) + std::abs(z);
                if (parts != 1 && parts != 3)
                    continue;
                double reach = parts == 1 ? radius : radius * 0.577;
                if (!is_free(tracer, point, point + Vec3d{x * reach, y * reach, z * reach}))
                    return false;
            }
    return true;
}

namespace {

Walkable stand_at(const Tracer& tracer, const Columns& columns, const std::vector<std::vector<Floor>>& floors,
                  double eye_height, const Job& job) {
    Walkable walkable;
    walkable.spacing = columns.spacing;
    walkable.eye_height = eye_height;
    std::vector<std::vector<Place>> standing(floors.size());
    parallel_for(floors.size(), job, [&](std::size_t c, unsigned) {
        for (const Floor& floor : floors[c]) {
            Place place;
            place.column_x = std::uint32_t(c % columns.nx);
            place.column_z = std::uint32_t(c / columns.nx);
            place.eye = {columns.x(place.column_x), floor.height + eye_height, columns.z(place.column_z)};
            if (floor.gap >= kHeadroom * eye_height && is_viewpoint(tracer, place.eye))
                standing[c].push_back(place);
        }
    });
    std::vector<std::vector<std::uint32_t>> by_column(floors.size());
    for (std::size_t c = 0; c < floors.size(); ++c)
        for (const Place& place : standing[c]) {
            by_column[c].push_back(std::uint32_t(walkable.places.size()));
            walkable.places.push_back(place);
        }
    join_neighbours(tracer, columns, by_column, walkable, job);
    mark_components(walkable);
    measure_clearance(walkable);
    return walkable;
}

std::uint32_t largest(const Walkable& walkable) {
    return walkable.component_sizes.empty()
               ? 0
               : *std::max_element(walkable.component_sizes.begin(), walkable.component_sizes.end());
}

} // namespace

Walkable find_walkable(const Tracer& tracer, const WalkableOptions& options, const Job& job) {
    Columns columns = lay_columns(tracer.scene(), options.columns);
    std::vector<std::vector<Floor>> floors(std::size_t(columns.nx) * columns.nz);
    parallel_for(floors.size(), job, [&](std::size_t c, unsigned) {
        floors[c] = floors_of_column(tracer, columns.x(std::uint32_t(c % columns.nx)),
                                     columns.z(std::uint32_t(c / columns.nx)));
    });
    if (options.eye_height > 0)
        return stand_at(tracer, columns, floors, options.eye_height, job);
    // The tallest viewer that still gets nearly everywhere: one as tall as the rooms does not pass the doors.
    double guess = guess_eye_height(tracer, floors);
    Walkable best;
    for (double share : {0.3, 0.4, 0.55, 0.75, 1.0}) {
        Walkable walkable = stand_at(tracer, columns, floors, guess * share, job);
        if (!best.places.empty() && double(largest(walkable)) < 0.75 * double(largest(best)))
            break;
        best = std::move(walkable);
    }
    return best;
}

} // namespace antumbra
