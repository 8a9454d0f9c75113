// Quake III maps (IBSP 46): a scene like any other, and the compiler's own visibility as an independent reference.
#pragma once

#include <antumbra/import.hpp>

#include <array>
#include <cstdint>
#include <string>
#include <vector>

namespace antumbra {

/// What the map compiler knew, for comparisons only: nothing in the toolkit decides by it. All indices were checked
/// when it was read, the tree is one. Coordinates are the scene's: (x, z, -y) of the map.
struct Quake3Reference {
    struct Plane {
        Vec3d normal;
        double distance = 0; ///< dot(normal, p) == distance on the plane
    };
    struct Node {
        std::int32_t plane = 0;
        std::array<std::int32_t, 2> children{}; ///< in front, behind; >= 0 a node, else leaf -1 - child
    };
    struct Leaf {
        std::int32_t cluster = -1; ///< -1: solid or outside
        std::int32_t area = -1;
        Box3d bounds;
        std::uint32_t first_surface = 0, surface_count = 0; ///< into leaf_surfaces
        std::uint32_t first_brush = 0, brush_count = 0;     ///< into leaf_brushes
    };
    struct Shader {
        std::string name;
        std::uint32_t surface_flags = 0, contents = 0;
    };
    struct Brush {
        std::uint32_t first_side = 0, side_count = 0; ///< into brush_sides; the brush is behind all of them
        std::int32_t shader = 0;
    };
    struct BrushSide {
        std::int32_t plane = 0, shader = 0;
    };
    struct Model {
        std::uint32_t first_surface = 0, surface_count = 0, first_brush = 0, brush_count = 0;
    };

    std::vector<Plane> planes;
    std::vector<Node> nodes;
    std::vector<Leaf> leaves;
    std::vector<std::uint32_t> leaf_surfaces, leaf_brushes;
    std::vector<Shader> shaders;
    std::vector<Brush> brushes;
    std::vector<BrushSide> brush_sides;
    std::vector<Model> models; ///< 0 is the world, the others move
    /// By draw surface: index of its object in the scene as read, -1 if it is not drawn.
    std::vector<std::int32_t> surface_objects;
    std::uint32_t clusters = 0, row_bytes = 0; ///< 0 clusters: the map has no visibility
    std::vector<std::uint8_t> visibility;      ///< clusters rows; bit c of row f (low bits first): c seen from f

    /// Leaf that holds a point of the scene; -1 if the map has no tree. At most as many steps as nodes.
    std::int32_t leaf_of(const Vec3d& point) const;
    /// As the game asks: without data everything sees everything, outside (-1) sees nothing.
    bool cluster_sees(std::int32_t from, std::int32_t to) const;
};

struct Quake3Map {
    RawScene scene;
    Quake3Reference reference;
};

/// Every draw surface is an object: node = index of the surface, primitive = its model, name "surface N SHADER".
/// Polygons and meshes as they are, Bezier patches cut into options.patch_levels squared quads per 3 x 3 control
/// points. Left out: flares and surfaces flagged NODRAW. Never occluding: fog, liquids, translucent and non-solid
/// surfaces (sky does: nothing can be behind it); models other than the world move. Shader scripts lie outside of the map: a surface that is
/// transparent by its script alone must be told with --never-occlude (the name holds the shader's). Faces are seen
/// from the front, see-through ones from both sides.
Result<Quake3Map> import_quake3(std::span<const std::byte> bytes, const std::string& name,
                                const ImportOptions& options = {});

} // namespace antumbra
