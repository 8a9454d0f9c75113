#include "export/glb_container.hpp"

#include <antumbra/export.hpp>

namespace antumbra {
namespace {

using glb::Json;

/// What a part adds to the document's arrays and to the two views of the buffer.
struct DrawingWriter {
    Json nodes = Json::array(), meshes = Json::array(), accessors = Json::array(), materials = Json::array();
    std::vector<std::byte> positions, indices;

    Status add(const DrawingPart& part);
    std::size_t add_positions(const DrawingPart& part, const Vec3d& low);
    std::size_t add_indices(const DrawingPart& part);
    std::size_t add_material(const DrawingPart& part);
};

std::size_t DrawingWriter::add_positions(const DrawingPart& part, const Vec3d& low) {
    std::size_t offset = positions.size();
    Box3f bounds;
    for (const Vec3d& world : part.positions) {
        Vec3d p = world - low;
        Vec3f rounded{float(p.x) + 0.0f, float(p.y) + 0.0f, float(p.z) + 0.0f};
        bounds.extend(rounded);
        for (int k = 0; k < 3; ++k)
            glb::append(positions, rounded[k]);
    }
    accessors.push_back({{"bufferView", 0},
                         {"byteOffset", offset},
                         {"componentType", glb::kFloat},
                         {"count", part.positions.size()},
                         {"type", "VEC3"},
                         {"min", {bounds.min.x, bounds.min.y, bounds.min.z}},
                         {"max", {bounds.max.x, bounds.max.y, bounds.max.z}}});
    return accessors.size() - 1;
}

std::size_t DrawingWriter::add_indices(const DrawingPart& part) {
    std::size_t offset = indices.size();
    for (std::uint32_t i : part.indices)
        glb::append(indices, i);
    accessors.push_back({{"bufferView", 1},
                         {"byteOffset", offset},
                         {"componentType", glb::kUnsignedInt},
                         {"count", part.indices.size()},
                         {"type", "SCALAR"}});
    return accessors.size() - 1;
}

std::size_t DrawingWriter::add_material(const DrawingPart& part) {
    Json material;
    material["pbrMetallicRoughness"] = {{"baseColorFactor", part.colour}, {"metallicFactor", 0}};
    material["extensions"] = {{"KHR_materials_unlit", Json::object()}};
    material["doubleSided"] = true;
    if (part.colour[3] < 1)
        material["alphaMode"] = "BLEND";
    materials.push_back(std::move(material));
    return materials.size() - 1;
}

Status DrawingWriter::add(const DrawingPart& part) {
    if (part.indices.empty())
        return {};
    Box3d bounds;
    for (const Vec3d& p : part.positions) {
        if (!is_finite(p))
            return {ErrorCode::corrupt, "drawing '" + part.name + "': a position is not finite"};
        bounds.extend(p);
    }
    for (std::uint32_t i : part.indices)
        if (i >= part.positions.size())
            return {ErrorCode::corrupt, "drawing '" + part.name + "': an index is out of range"};
    if (part.indices.size() % (part.lines ? 2 : 3))
        return {ErrorCode::corrupt, "drawing '" + part.name + "': the last line or triangle is not whole"};
    Json primitive = {{"attributes", {{"POSITION", add_positions(part, bounds.min)}}}};
    primitive["indices"] = add_indices(part);
    primitive["material"] = add_material(part);
    if (part.lines)
        primitive["mode"] = int(glb::kLines);
    Json node = {{"name", part.name}, {"mesh", meshes.size()}};
    if (bounds.min != Vec3d{})
        node["translation"] = {bounds.min.x, bounds.min.y, bounds.min.z};
    meshes.push_back({{"primitives", Json::array({std::move(primitive)})}});
    nodes.push_back(std::move(node));
    return {};
}

} // namespace

Result<std::vector<std::byte>> export_drawing(std::span<const DrawingPart> parts) {
    DrawingWriter writer;
    for (const DrawingPart& part : parts)
        if (Status status = writer.add(part); !status)
            return status;
    Json document;
    document["asset"] = {{"version", "2.0"}, {"generator", "antumbra"}};
    document["scene"] = 0;
    Json roots = Json::array();
    for (std::size_t n = 0; n < writer.nodes.size(); ++n)
        roots.push_back(n);
    document["scenes"] = Json::array({{{"nodes", std::move(roots)}}});
    if (!writer.nodes.empty()) {
        document["extensionsUsed"] = {"KHR_materials_unlit"};
        document["nodes"] = std::move(writer.nodes);
        document["meshes"] = std::move(writer.meshes);
        document["materials"] = std::move(writer.materials);
        document["accessors"] = std::move(writer.accessors);
        std::size_t first = writer.positions.size(), second = writer.indices.size();
        document["bufferViews"] = Json::array({{{"buffer", 0},
                                                {"byteOffset", 0},
                                                {"byteLength", first},
                                                {"byteStride", 12},
                                                {"target", int(glb::kArrayBuffer)}},
                                               {{"buffer", 0},
                                                {"byteOffset", first},
                                                {"byteLength", second},
                                                {"target", int(glb::kElementArrayBuffer)}}});
        document["buffers"] = Json::array({{{"byteLength", first + second}}});
    }
    const std::vector<std::byte>* binary[] = {&writer.positions, &writer.indices};
    return glb::pack(document, binary);
}

} // namespace antumbra
