// The one thing that the entities of a Quake III map say about geometry.
#pragma once

#include <antumbra/math.hpp>

#include <cstddef>
#include <span>
#include <vector>

namespace antumbra {

/// Where the models 0 .. count - 1 stand, in map coordinates: the "origin" of the entity whose "model" is "*N", zero
/// without one. Reads `{ "key" "value" .. }` leniently; what makes no sense is passed over. Linear time.
std::vector<Vec3d> model_origins(std::span<const std::byte> entities, std::size_t count);

} // namespace antumbra
