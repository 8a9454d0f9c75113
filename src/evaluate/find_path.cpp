// A walk for scenes that come without one. Three steps: where one can stand (walkable.cpp), a tour over those places
// that keeps to the middle of rooms and prefers new ground, and its smoothing into a camera's way.
#include "base/random.hpp"
#include "evaluate/pixel_rays.hpp"
#include "evaluate/walkable.hpp"

#include <antumbra/evaluate.hpp>

#include <algorithm>
#include <cstdio>
#include <queue>

namespace antumbra {
namespace {

constexpr std::uint32_t kFewestPlaces = 40; ///< less is no walk
constexpr int kProbes = 24;                 ///< places per component that tell how enclosed it is
constexpr int kCandidates = 24;             ///< goals that a leg chooses from
constexpr double kAhead = 2.5;              ///< how far ahead the camera looks, in eye heights
constexpr double kMostLengths = 4;          ///< of the scene, that a walk is long
constexpr double kRise = 0.35;              ///< height of an orbit over the scene's middle, in radii
constexpr double kRoom = 0.12;              ///< radius kept free around the camera, in eye heights

/// Share of level and rising directions in which something is to be seen: high in rooms and streets, low on roofs
/// and at the rim of a terrain.
double enclosure(const Tracer& tracer, const Vec3d& eye) {
    int hits = 0, rays = 0;
    for (int x = -2; x <= 2; ++x)
        for (int z = -2; z <= 2; ++z) {
            if (std::max(std::abs(x), std::abs(z)) != 2)
                continue;
            for (double rise : {0.13, 1.1}) {
                ++rays;
                hits += bool(tracer.first_hit({eye, {x + 0.01, rise, z - 0.013}}));
            }
        }
    return double(hits) / rays;
}

/// The component where a walk shows most: large and enclosed. kNoPlace if none is large enough.
std::uint32_t best_component(const Tracer& tracer, const Walkable& walkable) {
    std::vector<std::vector<std::uint32_t>> members(walkable.component_sizes.size());
    for (std::uint32_t p = 0; p < walkable.places.size(); ++p)
        members[walkable.places[p].component].push_back(p);
    std::uint32_t best = kNoPlace;
    double best_score = 0;
    for (std::uint32_t c = 0; c < members.size(); ++c) {
        if (members[c].size() < kFewestPlaces)
            continue;
        double sum = 0;
        for (int k = 0; k < kProbes; ++k)
            sum += enclosure(tracer, walkable.places[members[c][members[c].size() * std::size_t(k) / kProbes]].eye);
        double share = sum / kProbes, score = double(members[c].size()) * share * share;
        if (score > best_score) {
            best_score = score;
            best = c;
        }
    }
    return best;
}

/// Shortest ways from one place, where walls are dear and trodden ground is dearer.
struct Ways {
    std::vector<double> cost;
    std::vector<std::uint32_t> from;
    std::vector<std::uint32_t> length; ///< in steps
};

Ways find_ways(const Walkable& walkable, std::uint32_t start, const std::vector<std::uint32_t>& visits) {
    constexpr double kFar = std::numeric_limits<double>::infinity();
    Ways ways{std::vector<double>(walkable.places.size(), kFar),
              std::vector<std::uint32_t>(walkable.places.size(), kNoPlace),
              std::vector<std::uint32_t>(walkable.places.size(), 0)};
    using Entry = std::pair<double, std::uint32_t>;
    std::priority_queue<Entry, std::vector<Entry>, std::greater<>> queue;
    ways.cost[start] = 0;
    queue.push({0, start});
    while (!queue.empty()) {
        auto [cost, at] = queue.top();
        queue.pop();
        if (cost > ways.cost[at])
            continue;
        for (std::uint32_t next : walkable.places[at].neighbours) {
            if (next == kNoPlace)
                continue;
            double step = 1 + 6.0 / walkable.places[next].clearance + 2.0 * visits[next];
            if (cost + step < ways.cost[next]) {
                ways.cost[next] = cost + step;
                ways.from[next] = at;
                ways.length[next] = ways.length[at] + 1;
                queue.push({cost + step, next});
            }
        }
    }
    return ways;
}

/// Counts the places near a way as visited.
void tread(const Walkable& walkable, std::uint32_t place, int reach, std::vector<std::uint32_t>& visits) {
    ++visits[place];
    for (std::size_t side = 0; side < 4; ++side) {
        std::uint32_t at = place;
        for (int k = 0; k < reach && at != kNoPlace; ++k) {
            at = walkable.places[at].neighbours[side];
            if (at != kNoPlace)
                visits[at] = std::max(visits[at], 1u);
        }
    }
}

/// Legs from goal to goal until there are `steps` steps.
std::vector<std::uint32_t> make_tour(const Tracer& tracer, const Walkable& walkable, std::uint32_t component,
                                     std::uint32_t steps, std::uint64_t seed) {
    std::vector<std::uint32_t> members;
    for (std::uint32_t p = 0; p < walkable.places.size(); ++p)
        if (walkable.places[p].component == component)
            members.push_back(p);
    Random random(seed, 0x70617468);
    auto pick = [&] { return members[random.below(std::uint32_t(members.size()))]; };
    std::uint32_t at = pick();
    // Where much is to be seen, and not right at a wall.
    auto appeal = [&](std::uint32_t place) {
        double share = enclosure(tracer, walkable.places[place].eye);
        return share * share * (walkable.places[place].clearance > 1 ? 1 : 0.3);
    };
    for (int k = 0; k < kCandidates; ++k)
        if (std::uint32_t other = pick(); appeal(other) > appeal(at))
            at = other;
    std::vector<std::uint32_t> visits(walkable.places.size(), 0), tour{at};
    while (tour.size() <= steps) {
        Ways ways = find_ways(walkable, at, visits);
        std::uint32_t goal = kNoPlace;
        double best = -1;
        for (int k = 0; k < kCandidates; ++k) {
            std::uint32_t other = pick();
            double length = std::min<double>(ways.length[other], steps / 5.0 + 8);
            double worth = length / (1 + visits[other]) * appeal(other);
            if (worth > best) {
                best = worth;
                goal = other;
            }
        }
        std::vector<std::uint32_t> leg;
        for (std::uint32_t p = goal; p != at; p = ways.from[p])
            leg.push_back(p);
        std::reverse(leg.begin(), leg.end());
        if (leg.empty())
            leg.push_back(at); // a component of one step: stand
        for (std::uint32_t p : leg)
            tread(walkable, p, 4, visits);
        tour.insert(tour.end(), leg.begin(), leg.end());
        at = goal;
    }
    tour.resize(steps + 1);
    return tour;
}

/// Pulls each point towards the middle of its neighbours as long as the way stays free and roomy.
void smooth(const Tracer& tracer, std::vector<Vec3d>& points, double radius) {
    constexpr int kRounds = 24;
    for (int round = 0; round < kRounds; ++round)
        for (std::size_t k = 1; k + 1 < points.size(); ++k) {
            Vec3d moved = points[k] * 0.5 + (points[k - 1] + points[k + 1]) * 0.25;
            // The costly look for room at the end only: it decides which moves were too bold.
            if (!is_free(tracer, points[k - 1], moved) || !is_free(tracer, moved, points[k + 1]))
                continue;
            if (round % 4 == 3 && !is_roomy(tracer, moved, radius))
                continue;
            points[k] = moved;
        }
}

/// `count` points at equal distances along a way.
std::vector<Vec3d> resample(const std::vector<Vec3d>& points, std::size_t count, double spacing) {
    std::vector<Vec3d> result;
    std::size_t segment = 0;
    double done = 0; // length of the segments before `segment`
    for (std::size_t k = 0; k < count; ++k) {
        double wanted = spacing * double(k);
        while (segment + 1 < points.size()) {
            double piece = length(points[segment + 1] - points[segment]);
            if (done + piece >= wanted && piece > 0) {
                double share = (wanted - done) / piece;
                result.push_back(points[segment] * (1 - share) + points[segment + 1] * share);
                break;
            }
            done += piece;
            ++segment;
        }
        if (result.size() <= k)
            result.push_back(points.back());
    }
    return result;
}

double way_length(const std::vector<Vec3d>& points) {
    double sum = 0;
    for (std::size_t k = 1; k < points.size(); ++k)
        sum += length(points[k] - points[k - 1]);
    return sum;
}

/// Looks ahead along the way; turns are spread over some frames, and heads stay nearly level.
std::vector<View> look_ahead(const std::vector<Vec3d>& eyes, double spacing, double ahead, double fov) {
    std::size_t n = eyes.size();
    std::size_t reach = std::max<std::size_t>(1, std::size_t(ahead / std::max(spacing, 1e-300)));
    std::vector<Vec3d> directions(n);
    Vec3d last{0, 0, -1};
    for (std::size_t k = 0; k < n; ++k) {
        Vec3d direction = eyes[std::min(k + reach, n - 1)] - eyes[k];
        direction.y *= 0.4;
        double size = length(direction);
        // Near the end there is nothing ahead: keep looking where one looked.
        last = directions[k] = size > spacing * 0.5 && k + reach / 2 < n ? direction / size : last;
    }
    std::vector<View> views(n);
    const std::size_t window = std::max<std::size_t>(2, reach / 2);
    for (std::size_t k = 0; k < n; ++k) {
        Vec3d sum;
        for (std::size_t m = k > window ? k - window : 0; m <= std::min(n - 1, k + window); ++m)
            sum += directions[m];
        if (!(length(sum) > 0.2))
            sum = directions[k];
        View& view = views[k];
        view.eye = eyes[k];
        view.target = eyes[k] + normalized(sum) * std::max(ahead, spacing);
        view.up = {0, 1, 0};
        view.near_plane = 0;
        view.fov_y_deg = fov;
    }
    return views;
}

std::string sentence(const char* format, double a, double b) {
    char text[200];
    std::snprintf(text, sizeof text, format, a, b);
    return text;
}

/// Once around the scene, looking at its middle from outside.
FoundPath orbit(const Scene& scene, const PathOptions& options) {
    Box3d bounds = to_double(scene.local_bounds());
    Vec3d centre = bounds.centre(), size = bounds.size();
    double radius = 0.9 * length(size);
    FoundPath path;
    path.description = sentence("orbits the scene at a distance of %.4g units, %.4g above its middle", radius,
                                kRise * radius);
    for (std::uint32_t k = 0; k < options.frames; ++k) {
        // The point at the angle a on the circle from tan(a/2), a quadrant at a time.
        double turn = 4.0 * k / options.frames;
        int quadrant = int(turn);
        double t = turn > quadrant ? half_tangent((turn - quadrant) * 90) : 0;
        double x = (1 - t * t) / (1 + t * t), z = 2 * t / (1 + t * t);
        for (int q = 0; q < quadrant; ++q) {
            double old = x;
            x = -z;
            z = old;
        }
        View view;
        view.eye = centre + Vec3d{x * radius, kRise * radius, z * radius};
        view.target = centre;
        view.near_plane = 0;
        view.fov_y_deg = options.fov_y_deg;
        path.views.push_back(view);
    }
    return path;
}

} // namespace

Result<FoundPath> find_path(const Scene& scene, const PathOptions& options, const Job& job) {
    if (options.frames == 0 || options.frames > 1'000'000 || !(options.fov_y_deg > 0 && options.fov_y_deg < 180) ||
        options.eye_height < 0 || options.step < 0)
        return Status(ErrorCode::usage, "a path needs 1 to 1000000 frames, a field of view between 0 and 180 degrees "
                                        "and lengths that are not negative");
    if (options.kind == PathKind::orbit)
        return orbit(scene, options);
    Tracer tracer = Tracer::build(scene, job);
    WalkableOptions walkable_options;
    walkable_options.eye_height = options.eye_height;
    Walkable walkable = find_walkable(tracer, walkable_options, job);
    if (job.cancelled())
        return Status(ErrorCode::cancelled, "stopped while looking for a path");
    std::uint32_t component = best_component(tracer, walkable);
    if (component == kNoPlace)
        return orbit(scene, options);
    // A small flat is walked slowly rather than many times over.
    Vec3d size = to_double(scene.local_bounds()).size();
    double step = options.step > 0
                      ? options.step
                      : std::min(walkable.eye_height * 0.5, kMostLengths * std::max(size.x, size.z) / options.frames);
    // Smoothing shortens a way: ask for more steps than that.
    double wanted = step * options.frames + walkable.eye_height * kAhead;
    auto steps = std::uint32_t(std::clamp(1.5 * wanted / walkable.spacing + 8, 8.0, 100'000.0));
    std::vector<Vec3d> points;
    for (std::uint32_t place : make_tour(tracer, walkable, component, steps, options.seed))
        points.push_back(walkable.places[place].eye);
    smooth(tracer, points, walkable.eye_height * kRoom);
    double ahead = walkable.eye_height * kAhead;
    double spacing = std::min(step, std::max(0.5 * way_length(points), way_length(points) - ahead) / options.frames);
    if (!(spacing > 0))
        spacing = tracer.scene().step();
    // The way goes on beyond the last frame, so that it too has something to look towards.
    std::size_t beyond = std::min<std::size_t>(std::size_t(ahead / spacing) + 1, options.frames);
    FoundPath path;
    path.views = look_ahead(resample(points, options.frames + beyond, spacing), spacing, ahead, options.fov_y_deg);
    path.views.resize(options.frames);
    path.description = sentence("walks %.4g units at an eye height of %.4g above the floor", spacing * options.frames,
                                walkable.eye_height);
    return path;
}

} // namespace antumbra
