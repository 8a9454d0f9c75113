// A timber house of the town, furnished on both floors.
#pragma once

#include "generate/furniture.hpp"

namespace antumbra::generation {

inline constexpr double kTownHouseDepth = 8;
/// No house has more triangles.
inline constexpr std::size_t kTownHouseTriangles = 6000;

/// About 90 objects. The ground floor's front is the plane z = 0, x from -width/2 to width/2, the street lies
/// toward +z; the upper storey juts out over it by 0.4 m.
void town_house(Modeller& modeller, const Frame& frame, const std::string& name, double width, Random random);

/// One object, 116 triangles: a jug of the given height, standing on the frame's origin.
void jug(Modeller& modeller, const Frame& frame, const std::string& name, double height);
/// One object, 96 triangles.
void barrel(Modeller& modeller, const Frame& frame, const std::string& name, double height);

} // namespace antumbra::generation
