#include "export/glb_container.hpp"

#include <antumbra/export.hpp>

#include <cstring>
#include <map>

namespace antumbra {
namespace {

using glb::Json, glb::append;
using glb::kArrayBuffer, glb::kElementArrayBuffer, glb::kUnsignedShort, glb::kUnsignedInt, glb::kFloat;

constexpr std::uint32_t kUnused = 0xFFFFFFFFu;

/// What the two kinds of scene have in common, seen by the writer.
struct SourceObject {
    std::string_view name;
    std::uint32_t flags = 0, first_triangle = 0, triangle_count = 0;
};

/// One object with its vertices in order of first use, relative to `translation`.
struct Mesh {
    Vec3d translation;
    std::vector<Vec3f> positions;
    std::vector<std::uint32_t> indices;
};

class GlbWriter {
  public:
    /// Appends one object: `position(v)` gives vertex v in world coordinates.
    template <class Position>
    Status add(const SourceObject& object, std::span<const TriangleIndices> triangles, Position&& position,
               std::vector<std::uint32_t>& vertex_map);
    Result<std::vector<std::byte>> finish();

  private:
    std::uint32_t mesh_of(const Mesh& mesh, std::uint32_t flags);
    std::uint32_t material_of(std::uint32_t flags);
    std::uint32_t write_positions(const Mesh& mesh);
    std::uint32_t write_indices(const Mesh& mesh);
    Json buffer_views();

    Json nodes_ = Json::array(), meshes_ = Json::array(), accessors_ = Json::array(),
         materials_ = Json::array();
    // Three views of the one buffer: vertices, indices of two and of four bytes.
    std::vector<std::byte> positions_, shorts_, words_;
    struct Written {
        std::uint32_t mesh, flags;
        std::uint64_t position_offset, vertices, index_offset, indices;
        bool short_indices;
    };
    std::vector<Written> written_;
    std::multimap<std::uint64_t, std::uint32_t> by_hash_;
    std::map<std::uint32_t, std::uint32_t> material_by_flags_;
};

void pad(std::vector<std::byte>& bytes, std::byte filler) {
    while (bytes.size() % 4)
        bytes.push_back(filler);
}

std::uint64_t hash_of(std::span<const std::byte> bytes, std::uint64_t hash = 0xcbf29ce484222325u) {
    for (std::byte b : bytes)
        hash = (hash ^ std::to_integer<std::uint64_t>(b)) * 0x100000001b3u;
    return hash;
}

template <class Position>
Status GlbWriter::add(const SourceObject& object, std::span<const TriangleIndices> triangles,
                      Position&& position, std::vector<std::uint32_t>& vertex_map) {
    Json node;
    node["name"] = std::string(object.name);
    Mesh mesh;
    Box3d bounds;
    std::vector<std::uint32_t> used;
    for (const TriangleIndices& triangle : triangles)
        for (std::uint32_t v : triangle) {
            if (v >= vertex_map.size())
                return {ErrorCode::corrupt, "object '" + std::string(object.name) + "': vertex index " +
                                                std::to_string(v) + " out of range"};
            if (vertex_map[v] == kUnused) {
                if (!is_finite(position(v)))
                    return {ErrorCode::corrupt, "object '" + std::string(object.name) + "': vertex " +
                                                    std::to_string(v) +
                                                    " is not finite; repair or leave it out"};
                vertex_map[v] = static_cast<std::uint32_t>(used.size());
                used.push_back(v);
                bounds.extend(position(v));
            }
            mesh.indices.push_back(vertex_map[v]);
        }
    for (std::uint32_t v : used) {
        Vec3d relative = position(v) - bounds.min;
        mesh.positions.push_back({float(relative.x), float(relative.y), float(relative.z)});
        vertex_map[v] = kUnused; // ready for the next object
    }
    if (!used.empty()) {
        if (bounds.min != Vec3d{})
            node["translation"] = {bounds.min.x, bounds.min.y, bounds.min.z};
        node["mesh"] = mesh_of(mesh, object.flags);
    }
    nodes_.push_back(std::move(node));
    return {};
}

/// The mesh with exactly these vertices, indices and material, written now if it is new.
std::uint32_t GlbWriter::mesh_of(const Mesh& mesh, std::uint32_t flags) {
    flags &= kOccludes | kDoubleSided;
    std::size_t positions_before = positions_.size(), shorts_before = shorts_.size(),
                words_before = words_.size();
    bool short_indices = mesh.positions.size() < 0xFFFF; // 0xFFFF itself is forbidden
    std::vector<std::byte>& index_bytes = short_indices ? shorts_ : words_;
    std::size_t index_before = short_indices ? shorts_before : words_before;
    for (const Vec3f& p : mesh.positions)
        for (int k = 0; k < 3; ++k)
            append(positions_, p[k] + 0.0f); // no negative zero
    for (std::uint32_t i : mesh.indices)
        short_indices ? append(shorts_, static_cast<std::uint16_t>(i)) : append(words_, i);
    auto tail = [](const std::vector<std::byte>& bytes, std::size_t from, std::size_t size) {
        return std::span(bytes).subspan(from, size);
    };
    std::size_t position_size = positions_.size() - positions_before,
                index_size = index_bytes.size() - index_before;
    auto same = [&](const std::vector<std::byte>& bytes, std::size_t a, std::size_t b, std::size_t size) {
        return std::memcmp(bytes.data() + a, bytes.data() + b, size) == 0;
    };
    std::uint64_t hash = hash_of(tail(index_bytes, index_before, index_size),
                                 hash_of(tail(positions_, positions_before, position_size)));
    auto [first, last] = by_hash_.equal_range(hash);
    for (auto entry = first; entry != last; ++entry) {
        const Written& old = written_[entry->second];
        if (old.flags == flags && old.short_indices == short_indices &&
            old.vertices == mesh.positions.size() && old.indices == mesh.indices.size() &&
            same(positions_, old.position_offset, positions_before, position_size) &&
            same(index_bytes, old.index_offset, index_before, index_size)) {
            positions_.resize(positions_before);
            index_bytes.resize(index_before);
            return old.mesh;
        }
    }
    Written now{static_cast<std::uint32_t>(meshes_.size()),
                flags,
                positions_before,
                mesh.positions.size(),
                index_before,
                mesh.indices.size(),
                short_indices};
    by_hash_.emplace(hash, static_cast<std::uint32_t>(written_.size()));
    written_.push_back(now);
    Box3f bounds;
    for (const Vec3f& p : mesh.positions)
        bounds.extend(p);
    accessors_.push_back({{"bufferView", 0},
                          {"byteOffset", now.position_offset},
                          {"componentType", kFloat},
                          {"count", now.vertices},
                          {"type", "VEC3"},
                          {"min", {bounds.min.x, bounds.min.y, bounds.min.z}},
                          {"max", {bounds.max.x, bounds.max.y, bounds.max.z}}});
    accessors_.push_back({{"bufferView", short_indices ? 1 : 2},
                          {"byteOffset", now.index_offset},
                          {"componentType", short_indices ? kUnsignedShort : kUnsignedInt},
                          {"count", now.indices},
                          {"type", "SCALAR"}});
    Json primitive = {{"attributes", {{"POSITION", accessors_.size() - 2}}},
                      {"indices", accessors_.size() - 1},
                      {"material", material_of(flags)}};
    meshes_.push_back({{"primitives", Json::array({std::move(primitive)})}});
    return now.mesh;
}

std::uint32_t GlbWriter::material_of(std::uint32_t flags) {
    auto [entry, is_new] =
        material_by_flags_.try_emplace(flags, static_cast<std::uint32_t>(materials_.size()));
    if (is_new) {
        Json material = Json::object();
        material["pbrMetallicRoughness"] = {{"metallicFactor", 0}};
        if (!(flags & kOccludes)) {
            material["pbrMetallicRoughness"]["baseColorFactor"] = {0.75, 0.875, 1, 0.25};
            material["alphaMode"] = "BLEND";
        }
        if (flags & kDoubleSided)
            material["doubleSided"] = true;
        materials_.push_back(std::move(material));
    }
    return entry->second;
}

/// Every accessor names view 0, 1 or 2; empty views are not allowed, so they are left out and the names
/// mended.
Json GlbWriter::buffer_views() {
    Json views = Json::array();
    std::array<std::size_t, 3> number{};
    std::size_t offset = 0;
    auto view = [&](std::size_t index, const std::vector<std::byte>& bytes, int target) {
        number[index] = views.size();
        if (bytes.empty())
            return;
        Json entry = {{"buffer", 0}, {"byteOffset", offset}, {"byteLength", bytes.size()}};
        if (target == kArrayBuffer)
            entry["byteStride"] = 12;
        entry["target"] = target;
        views.push_back(std::move(entry));
        offset += bytes.size();
    };
    view(0, positions_, kArrayBuffer);
    view(1, shorts_, kElementArrayBuffer);
    view(2, words_, kElementArrayBuffer);
    for (Json& accessor : accessors_)
        accessor["bufferView"] = number[accessor["bufferView"].get<std::size_t>()];
    return views;
}

Result<std::vector<std::byte>> GlbWriter::finish() {
    pad(shorts_, std::byte{0});
    std::uint64_t binary_size = positions_.size() + shorts_.size() + words_.size();
    Json document;
    document["asset"] = {{"version", "2.0"}, {"generator", "antumbra"}};
    document["scene"] = 0;
    Json roots = Json::array();
    for (std::size_t n = 0; n < nodes_.size(); ++n)
        roots.push_back(n);
    document["scenes"] = Json::array({{{"nodes", std::move(roots)}}});
    document["nodes"] = std::move(nodes_);
    Json views = buffer_views();
    if (!meshes_.empty()) {
        document["meshes"] = std::move(meshes_);
        document["materials"] = std::move(materials_);
        document["accessors"] = std::move(accessors_);
        document["bufferViews"] = std::move(views);
        document["buffers"] = Json::array({{{"byteLength", binary_size}}});
    }
    const std::vector<std::byte>* binary[] = {&positions_, &shorts_, &words_};
    return glb::pack(document, binary);
}

} // namespace

Result<std::vector<std::byte>> export_glb(const RawScene& scene) {
    GlbWriter writer;
    std::vector<std::uint32_t> vertex_map(scene.positions.size(), kUnused);
    for (const RawObject& object : scene.objects) {
        if (std::uint64_t(object.first_triangle) + object.triangle_count > scene.triangles.size())
            return Status(ErrorCode::corrupt, "object '" + object.name + "': triangles out of range")
                .in(scene.source);
        auto triangles = std::span(scene.triangles).subspan(object.first_triangle, object.triangle_count);
        Status added = writer.add(
            {object.name, object.flags, object.first_triangle, object.triangle_count}, triangles,
            [&](std::uint32_t v) { return scene.positions[v]; }, vertex_map);
        if (!added)
            return added.in(scene.source);
    }
    return writer.finish();
}

Result<std::vector<std::byte>> export_glb(const Scene& scene) {
    GlbWriter writer;
    std::vector<std::uint32_t> vertex_map(scene.positions().size(), kUnused);
    for (std::uint32_t o = 0; o < scene.objects().size(); ++o) {
        const Object& object = scene.objects()[o];
        auto triangles = scene.triangles().subspan(object.first_triangle, object.triangle_count);
        Status added = writer.add(
            {scene.name(o), object.flags, object.first_triangle, object.triangle_count}, triangles,
            [&](std::uint32_t v) { return scene.to_world(to_double(scene.positions()[v])); }, vertex_map);
        if (!added)
            return added.in(scene.source());
    }
    return writer.finish();
}

} // namespace antumbra
