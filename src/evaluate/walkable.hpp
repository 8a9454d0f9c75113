// Where a person could walk in a scene of unknown units: floors on a grid of columns, joined where one can step from
// one to the next.
#pragma once

#include "rays/tracer.hpp"

#include <antumbra/job.hpp>

#include <array>
#include <vector>

namespace antumbra {

struct WalkableOptions {
    std::uint32_t columns = 176; ///< along the longer horizontal side of the region where the objects are
    double eye_height = 0;       ///< scene units above the floor; 0: guessed from the heights of the rooms
};

inline constexpr std::uint32_t kNoPlace = 0xFFFFFFFFu;

/// One standing place. Neighbours: along -x, +x, -z, +z.
struct Place {
    Vec3d eye; ///< local
    std::uint32_t column_x = 0, column_z = 0;
    std::array<std::uint32_t, 4> neighbours{kNoPlace, kNoPlace, kNoPlace, kNoPlace};
    std::uint32_t component = 0;
    std::uint32_t clearance = 0; ///< places to the nearest edge of where one can stand, 1: at the edge
};

struct Walkable {
    double eye_height = 0, spacing = 0;
    std::vector<Place> places;
    std::vector<std::uint32_t> component_sizes;
};

/// A floor is an occluding surface that is drawn from above, no steeper than 45 degrees, with room for a head and,
/// by the rule of the bake, outside solid matter. Two places are neighbours if the step between them is low and
/// nothing crosses the way at eye or knee height. A guessed eye height is lowered until doors can be passed. A pure
/// function of the scene and the options.
Walkable find_walkable(const Tracer& tracer, const WalkableOptions& options, const Job& job);

/// Is the ball of `radius` around `point` (local) free of surfaces, as far as 14 rays tell?
bool is_roomy(const Tracer& tracer, const Vec3d& point, double radius);

/// Does no surface of any kind cross the segment?
bool is_free(const Tracer& tracer, const Vec3d& from, const Vec3d& to);

} // namespace antumbra
