// glTF 2.0 to RawScene: container, document, hierarchy, then one object per (node, primitive, instance).
#include "import/draco_mesh.hpp"
#include "import/findings.hpp"
#include "import/gltf_accessors.hpp"
#include "import/gltf_nodes.hpp"
#include "import/import_bytes.hpp"

#include <algorithm>
#include <map>

namespace antumbra {
namespace gltf {
namespace {

constexpr std::uint32_t kTriangles = 4, kStrip = 5; // and 6: a fan
constexpr std::size_t kLongestName = 4096;
constexpr std::size_t kAllocation = 32; ///< what the allocator adds to a name, "#123" included

/// A primitive's triangles in the node's own coordinates.
struct LocalMesh {
    std::vector<Vec3d> positions;
    std::vector<TriangleIndices> triangles;
};

/// What becomes of one primitive on one node.
struct Part {
    const PlacedNode& place;
    const Node& node;
    const Mesh& mesh;
    const Primitive& primitive;
    std::int32_t mesh_index, primitive_index;
    std::uint64_t instances = 1; ///< objects
    std::uint64_t vertices = 0, triangles = 0; ///< of each; vertices: an upper bound
};

std::uint64_t triangle_count(std::uint32_t mode, std::uint64_t corners) {
    return mode == kTriangles ? corners / 3 : corners < 3 ? 0 : corners - 2;
}

/// The corners of triangle `t`, as positions in the list of corners. Keeps the winding, see the specification's
/// section on topology types.
TriangleIndices corners_of(std::uint32_t mode, std::uint32_t t) {
    if (mode == kTriangles)
        return {3 * t, 3 * t + 1, 3 * t + 2};
    if (mode == kStrip)
        return {t, t + 1 + t % 2, t + 2 - t % 2};
    return {t + 1, t + 2, 0};
}

/// total += a * b, unless that exceeds `limit`.
bool add_product(std::uint64_t& total, std::uint64_t a, std::uint64_t b, std::uint64_t limit) {
    if (total > limit || (a > 0 && b > (limit - total) / a))
        return false;
    total += a * b;
    return true;
}

class Assembler {
  public:
    Assembler(const Document& document, Buffers& buffers, Accessors& accessors, const ImportLimits& limits)
        : document_(document), buffers_(buffers), accessors_(accessors), limits_(limits) {}

    Result<RawScene> assemble(const std::vector<PlacedNode>& placed) {
        if (Status status = count(placed); !status)
            return status;
        raw_.positions.reserve(static_cast<std::size_t>(vertices_));
        raw_.triangles.reserve(static_cast<std::size_t>(triangles_));
        raw_.objects.reserve(static_cast<std::size_t>(objects_));
        Status status = for_each_part(placed, false, [&](const Part& part) { return add(part); });
        if (!status)
            return status;
        return std::move(raw_);
    }

  private:
    /// Visits everything that gives objects, in order. `noting`: also record what is left out.
    template <class Visit>
    Status for_each_part(const std::vector<PlacedNode>& placed, bool noting, Visit&& visit) {
        for (const PlacedNode& place : placed) {
            const Node& node = document_.nodes[static_cast<std::size_t>(place.node)];
            if (node.mesh < 0)
                continue;
            const Mesh& mesh = document_.meshes[static_cast<std::size_t>(node.mesh)];
            for (std::size_t p = 0; p < mesh.primitives.size(); ++p) {
                Part part{place, node, mesh, mesh.primitives[p], node.mesh, static_cast<std::int32_t>(p)};
                if (const char* why = why_left_out(part)) {
                    if (noting)
                        add_finding(raw_.findings, why, [&] { return "'" + name_of(part) + "'"; });
                    continue;
                }
                if (Status status = measure(part); !status)
                    return status.in(place_of(part));
                if (Status status = visit(part); !status)
                    return status;
            }
        }
        return {};
    }

    const char* why_left_out(const Part& part) const {
        if (flags_of(part).ignore)
            return "ignored object";
        if (part.primitive.mode < kTriangles)
            return "points or lines left out";
        if (part.primitive.position < 0)
            return "primitive without positions left out";
        return nullptr;
    }

    Flags flags_of(const Part& part) const {
        Flags flags = part.place.flags | part.mesh.flags;
        if (part.primitive.material >= 0)
            flags = flags | document_.materials[static_cast<std::size_t>(part.primitive.material)].flags;
        return flags;
    }

    std::uint64_t accessor_count(std::int32_t accessor) const {
        return document_.accessors[static_cast<std::size_t>(accessor)].count;
    }

    Status measure(Part& part) const {
        std::uint64_t positions = accessor_count(part.primitive.position);
        std::uint64_t corners = part.primitive.indices < 0 ? positions : accessor_count(part.primitive.indices);
        part.triangles = triangle_count(part.primitive.mode, corners);
        // Vertices that no triangle uses are not taken over: many primitives may share one long accessor.
        part.vertices = part.primitive.draco_view < 0 ? std::min(positions, corners) : positions;
        if (!part.node.instanced)
            return {};
        part.instances = 0;
        std::int32_t attributes[] = {part.node.instance_translation, part.node.instance_rotation,
                                     part.node.instance_scale};
        bool first = true;
        for (std::int32_t accessor : attributes) {
            if (accessor < 0)
                continue;
            if (!first && accessor_count(accessor) != part.instances)
                return {ErrorCode::corrupt, "EXT_mesh_gpu_instancing: attributes differ in length"};
            part.instances = accessor_count(accessor);
            first = false;
        }
        return {};
    }

    /// Sums what will be made, before anything is allocated for it.
    Status count(const std::vector<PlacedNode>& placed) {
        uses_.resize(document_.meshes.size());
        return for_each_part(placed, true, [&](const Part& part) {
            if (part.primitive_index == 0 || uses_[static_cast<std::size_t>(part.mesh_index)] == 0)
                ++uses_[static_cast<std::size_t>(part.mesh_index)];
            std::uint64_t bytes_each = part.vertices * sizeof(Vec3d) + part.triangles * sizeof(TriangleIndices) +
                                       sizeof(RawObject) + name_of(part).size() + kAllocation;
            if (!add_product(vertices_, part.instances, part.vertices, limits_.vertices))
                return exceeds(part, "vertices", limits_.vertices);
            if (!add_product(triangles_, part.instances, part.triangles, limits_.triangles))
                return exceeds(part, "triangles", limits_.triangles);
            if (!add_product(objects_, part.instances, 1, limits_.objects))
                return exceeds(part, "objects", limits_.objects);
            if (!add_product(memory_, part.instances, bytes_each, limits_.memory))
                return exceeds(part, "bytes", limits_.memory);
            return Status();
        });
    }

    static Status exceeds(const Part& part, const char* what, std::uint64_t limit) {
        return Status(ErrorCode::limit, std::string("the scene needs more ") + what + " than the limit of " +
                                            std::to_string(limit) + "; split it or raise the limit")
            .in(place_of(part));
    }

    Status add(const Part& part) {
        Result<std::vector<Transform>> placements = placements_of(part);
        if (!placements)
            return placements.status();
        bool shared = uses_[static_cast<std::size_t>(part.mesh_index)] > 1 || placements->size() > 1;
        const LocalMesh* local = nullptr;
        if (shared) {
            Result<const LocalMesh*> found = shared_mesh(part);
            if (!found)
                return found.status();
            local = *found;
        }
        for (std::size_t i = 0; i < placements->size(); ++i) {
            std::size_t first_vertex = raw_.positions.size(), first_triangle = raw_.triangles.size();
            if (local) {
                append(*local);
            } else if (Status status = decode(part, raw_.positions, raw_.triangles); !status) {
                return status;
            }
            place((*placements)[i], first_vertex, first_triangle);
            add_object(part, first_triangle, part.node.instanced ? static_cast<std::int32_t>(i) : -1);
        }
        return {};
    }

    Result<std::vector<Transform>> placements_of(const Part& part) {
        if (!part.node.instanced)
            return std::vector<Transform>{part.place.world};
        std::vector<double> translations, rotations, scales;
        auto read = [&](std::int32_t accessor, std::uint8_t components, std::vector<double>& values) {
            if (accessor < 0)
                return Status();
            Result<std::vector<double>> found = accessors_.tuples(accessor, components);
            if (found)
                values = std::move(*found);
            return found.status();
        };
        for (Status status : {read(part.node.instance_translation, 3, translations),
                              read(part.node.instance_rotation, 4, rotations),
                              read(part.node.instance_scale, 3, scales)})
            if (!status)
                return status.in(place_of(part) + ".EXT_mesh_gpu_instancing");
        std::vector<Transform> placements(static_cast<std::size_t>(part.instances));
        for (std::size_t i = 0; i < placements.size(); ++i) {
            Placement placement;
            if (!translations.empty())
                placement.translation = {translations[3 * i], translations[3 * i + 1], translations[3 * i + 2]};
            if (!rotations.empty())
                std::copy_n(rotations.begin() + static_cast<std::ptrdiff_t>(4 * i), 4, placement.rotation.begin());
            if (!scales.empty())
                placement.scale = {scales[3 * i], scales[3 * i + 1], scales[3 * i + 2]};
            placements[i] = part.place.world * placement.transform();
        }
        return placements;
    }

    Result<const LocalMesh*> shared_mesh(const Part& part) {
        auto [found, is_new] = shared_.try_emplace({part.mesh_index, part.primitive_index});
        if (is_new)
            if (Status status = decode(part, found->second.positions, found->second.triangles); !status)
                return status;
        return &found->second;
    }

    /// Appends the primitive's vertices and triangles in the node's coordinates.
    Status decode(const Part& part, std::vector<Vec3d>& positions, std::vector<TriangleIndices>& triangles) {
        const Primitive& primitive = part.primitive;
        if (primitive.draco_view >= 0)
            return decode_draco_part(part, positions, triangles).in(place_of(part) + ".KHR_draco_mesh_compression");
        Result<Elements> points = accessors_.points(primitive.position);
        if (!points)
            return points.status().in(place_of(part));
        std::vector<std::uint32_t> corners;
        if (primitive.indices >= 0) {
            Result<std::vector<std::uint32_t>> indices = accessors_.indices(primitive.indices, points->count);
            if (!indices)
                return indices.status().in(place_of(part));
            corners = std::move(*indices);
            if (primitive.mode == kTriangles && corners.size() % 3 != 0)
                add_finding(raw_.findings, "incomplete triangle", [&] { return "'" + name_of(part) + "'"; });
        }
        std::size_t base = positions.size();
        Status status = primitive.indices >= 0 && points->count > corners.size()
                            ? append_used(*points, corners, positions)
                            : append_all(*points, positions);
        if (!status)
            return status.in(Accessors::place(primitive.position)).in(place_of(part));
        for (std::uint32_t t = 0; t < part.triangles; ++t) {
            TriangleIndices triangle = corners_of(primitive.mode, t);
            for (std::uint32_t& corner : triangle)
                corner = static_cast<std::uint32_t>(base) + (primitive.indices >= 0 ? corners[corner] : corner);
            triangles.push_back(triangle);
        }
        return {};
    }

    Status decode_draco_part(const Part& part, std::vector<Vec3d>& positions,
                             std::vector<TriangleIndices>& triangles) {
        Result<std::span<const std::byte>> bytes = buffers_.view(part.primitive.draco_view);
        if (!bytes)
            return bytes.status();
        const Accessor& accessor = document_.accessors[static_cast<std::size_t>(part.primitive.position)];
        return decode_draco(*bytes, part.primitive.draco_position, accessor, part.triangles, positions, triangles);
    }

    static Status append_all(const Elements& points, std::vector<Vec3d>& positions) {
        std::size_t base = positions.size();
        positions.resize(base + static_cast<std::size_t>(points.count));
        return read_points(points, positions.data() + base);
    }

    /// Only the vertices that `corners` names, which are renumbered.
    static Status append_used(const Elements& points, std::vector<std::uint32_t>& corners,
                              std::vector<Vec3d>& positions) {
        std::vector<std::uint32_t> used = corners;
        std::sort(used.begin(), used.end());
        used.erase(std::unique(used.begin(), used.end()), used.end());
        for (std::uint32_t vertex : used) {
            positions.emplace_back();
            if (Status status = read_point(points, vertex, positions.back()); !status)
                return status;
        }
        for (std::uint32_t& corner : corners)
            corner = static_cast<std::uint32_t>(std::lower_bound(used.begin(), used.end(), corner) - used.begin());
        return {};
    }

    void append(const LocalMesh& local) {
        std::uint32_t base = static_cast<std::uint32_t>(raw_.positions.size());
        raw_.positions.insert(raw_.positions.end(), local.positions.begin(), local.positions.end());
        for (TriangleIndices triangle : local.triangles) {
            for (std::uint32_t& corner : triangle)
                corner += base;
            raw_.triangles.push_back(triangle);
        }
    }

    void place(const Transform& world, std::size_t first_vertex, std::size_t first_triangle) {
        for (std::size_t v = first_vertex; v < raw_.positions.size(); ++v)
            raw_.positions[v] = world.point(raw_.positions[v]);
        // A mirrored mesh would show its back: renderers turn the winding, and so do we.
        if (world.determinant() < 0)
            for (std::size_t t = first_triangle; t < raw_.triangles.size(); ++t)
                std::swap(raw_.triangles[t][1], raw_.triangles[t][2]);
    }

    void add_object(const Part& part, std::size_t first_triangle, std::int32_t instance) {
        RawObject object;
        object.id = {part.place.node, part.primitive_index, instance};
        object.name = name_of(part);
        if (instance >= 0)
            object.name += "#" + std::to_string(instance);
        object.flags = object_flags(part, object.name);
        object.first_triangle = static_cast<std::uint32_t>(first_triangle);
        object.triangle_count = static_cast<std::uint32_t>(raw_.triangles.size() - first_triangle);
        raw_.objects.push_back(std::move(object));
    }

    std::uint32_t object_flags(const Part& part, const std::string& name) {
        static const Material kPlain;
        auto material = [&](std::int32_t index) -> const Material& {
            return index < 0 ? kPlain : document_.materials[static_cast<std::size_t>(index)];
        };
        auto note = [&](const char* kind) { add_finding(raw_.findings, kind, [&] { return "'" + name + "'"; }); };
        const Material& own = material(part.primitive.material);
        bool see_through = own.see_through, double_sided = own.double_sided, variants_differ = false;
        for (std::int32_t variant : part.primitive.variant_materials) {
            see_through = see_through || material(variant).see_through;
            variants_differ = variants_differ || material(variant).double_sided != own.double_sided;
            double_sided = double_sided || material(variant).double_sided;
        }
        Flags flags = flags_of(part);
        bool moves = part.place.moves || part.node.skinned || part.node.weights_animated || part.primitive.morphed;
        std::uint32_t bits = kOccludes;
        if (see_through) {
            note("see-through object");
            bits = 0;
        }
        if (part.place.hidden) {
            // The viewer may show it at any time, but while it does not, it hides nothing.
            note("hidden object");
            bits = 0;
        }
        if (flags.never_occlude || variants_differ)
            bits = 0;
        if (double_sided)
            bits |= kDoubleSided;
        if (flags.never_cull)
            bits |= kAlwaysVisible;
        if (moves)
            bits = (bits & ~std::uint32_t(kOccludes)) | kMoves | kAlwaysVisible;
        return bits;
    }

    static std::string name_of(const Part& part) {
        std::string name = !part.node.name.empty()   ? part.node.name
                           : !part.mesh.name.empty() ? part.mesh.name
                                                     : "node " + std::to_string(part.place.node);
        name.resize(std::min(name.size(), kLongestName));
        if (part.mesh.primitives.size() > 1)
            name += "/primitive " + std::to_string(part.primitive_index);
        return name;
    }

    static std::string place_of(const Part& part) {
        return "nodes[" + std::to_string(part.place.node) + "]: meshes[" + std::to_string(part.mesh_index) +
               "].primitives[" + std::to_string(part.primitive_index) + "]";
    }

    const Document& document_;
    Buffers& buffers_;
    Accessors& accessors_;
    const ImportLimits& limits_;
    RawScene raw_;
    std::vector<std::uint32_t> uses_; ///< by mesh: 1 means that decoding straight into the scene saves a copy
    std::map<std::pair<std::int32_t, std::int32_t>, LocalMesh> shared_;
    std::uint64_t vertices_ = 0, triangles_ = 0, objects_ = 0, memory_ = 0;
};

Result<RawScene> import(std::span<const std::byte> bytes, const std::string& folder, const ImportOptions& options) {
    Result<Container> container = open_container(bytes);
    if (!container)
        return container.status();
    Result<Document> document = Status(ErrorCode::internal, "unread");
    {
        Result<Json> json = parse_json(container->json, options.limits.memory);
        if (!json)
            return json.status();
        document = read_document(*json);
    }
    if (!document)
        return document.status();
    Transform root;
    if (options.up_axis == UpAxis::z)
        root.rows = {{{1, 0, 0}, {0, 0, 1}, {0, -1, 0}}};
    Result<std::vector<PlacedNode>> placed = place_nodes(*document, root, options.limits.node_depth);
    if (!placed)
        return placed.status();
    Buffers buffers(*document, *container, folder, options.limits.bytes - bytes.size(), options.limits.memory);
    Accessors accessors(*document, buffers, bytes.size());
    return Assembler(*document, buffers, accessors, options.limits).assemble(*placed);
}

} // namespace
} // namespace gltf

Result<RawScene> import_gltf(std::span<const std::byte> bytes, const std::string& name, const std::string& folder,
                             const ImportOptions& options) {
    return import_bytes(bytes, name, options, [&] { return gltf::import(bytes, folder, options); });
}

} // namespace antumbra
