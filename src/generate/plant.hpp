// The pot plant that stands for "detail objects" (Bittner, Havran, Slavik 1998, section 7): 644 polygons.
#pragma once

#include "generate/modeller.hpp"

#include "base/random.hpp"

namespace antumbra::generation {

inline constexpr std::uint64_t kPlantTriangles = 644;

/// One object, seen from both sides: a pot, a stem and 295 leaves of two triangles; about 1.4 m high, 0.9 m
/// wide.
void plant(Modeller& modeller, const Frame& frame, const std::string& name, Random random);

} // namespace antumbra::generation
