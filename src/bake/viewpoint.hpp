// Where a viewer can be: not inside solid matter.
#pragma once

#include "rays/tracer.hpp"

namespace antumbra {

/// A point (local) is no viewpoint if, of six fixed directions spread over the sphere, at least four meet the back of
/// a single-sided occluder before anything else: that is what the inside of a solid looks like. Scenes drawn from
/// both sides have no inside. Pure function of the scene and the point; 3 to 6 rays; thread-safe.
bool is_viewpoint(const Tracer& tracer, const Vec3d& point);

} // namespace antumbra
