// Writers. The bytes are a pure function of the scene.
#pragma once

#include <antumbra/scene.hpp>

#include <array>

namespace antumbra {

/// glTF 2.0 as GLB: one node with one mesh primitive per object, in the objects' order, so that object i
/// comes back as node i, primitive 0. Kept: names (broken UTF-8 replaced), order, triangles, winding,
/// kDoubleSided and kOccludes (absent: alphaMode BLEND). Lost: kMoves, kAlwaysVisible, instance numbers, and
/// objects without triangles, which glTF cannot express (a node without mesh keeps their name and place).
/// Objects that are copies of each other up to a translation share one mesh.
///
/// Each node is translated to its object's lowest corner and its vertices are floats relative to that: scenes
/// far from the origin survive. Positions are exact if they are multiples of a power of two of which the
/// object measures less than 2^24 (as in every Scene and every generated scene); else they are rounded to 24
/// bits of the object's size.
///
/// ErrorCode::corrupt: a position is not finite or an index out of range; limit: the file would exceed 4 GiB.
Result<std::vector<std::byte>> export_glb(const RawScene& scene);
Result<std::vector<std::byte>> export_glb(const Scene& scene);

/// Part of a drawing: triangles or line segments of one colour.
struct DrawingPart {
    std::string name;
    std::array<float, 4> colour{1, 1, 1, 1}; ///< linear red, green, blue, opacity, each 0..1
    bool lines = false;                      ///< pairs of indices, else triples
    std::vector<Vec3d> positions;            ///< world
    std::vector<std::uint32_t> indices;
};

/// A drawing to look at, as GLB: a node for each part that has indices, seen from both sides, without shading
/// (KHR_materials_unlit) and see-through where the opacity is below 1. Vertices are floats relative to the part's lowest
/// corner. Errors as export_glb.
Result<std::vector<std::byte>> export_drawing(std::span<const DrawingPart> parts);

} // namespace antumbra
