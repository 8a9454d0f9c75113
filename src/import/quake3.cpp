// Quake III maps. The file is a directory of 17 lumps, arrays of fixed-size little-endian records; every index in
// them is checked before it is followed.
#include <antumbra/quake3.hpp>

#include "import/findings.hpp"
#include "import/quake3_entities.hpp"

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstring>
#include <new>

namespace antumbra {
namespace {

enum Lump : std::size_t {
    kEntities = 0, kShaders = 1, kPlanes = 2, kNodes = 3, kLeaves = 4, kLeafSurfaces = 5, kLeafBrushes = 6, kModels = 7,
    kBrushes = 8, kBrushSides = 9, kVertices = 10, kIndices = 11, kSurfaces = 13, kVisibility = 16, kLumpCount = 17
};
constexpr std::size_t kRecordBytes[kLumpCount] = {1, 72, 16, 36, 48, 4, 4, 40, 12, 8, 44, 4, 72, 104, 1, 8, 1};
constexpr const char* kLumpNames[kLumpCount] = {
    "entities", "shaders", "planes", "nodes", "leaves", "leaf surfaces", "leaf brushes", "models", "brushes",
    "brush sides", "vertices", "indices", "fogs", "surfaces", "lightmaps", "light grid", "visibility"};

// surfaceflags.h of the game.
constexpr std::uint32_t kSurfaceNoDraw = 0x80, kSurfaceNonSolid = 0x4000;
constexpr std::uint32_t kContentsSolid = 0x1, kContentsLava = 0x8, kContentsSlime = 0x10, kContentsWater = 0x20,
                        kContentsFog = 0x40, kContentsTranslucent = 0x20000000;
enum SurfaceType : std::int32_t { kPolygon = 1, kPatch = 2, kMesh = 3, kFlare = 4 };

constexpr std::int32_t kLargestPatch = 1025; ///< control points along a side; the game's own limit is 31

Status damaged(const std::string& text) { return {ErrorCode::corrupt, text}; }

/// One lump: a counted array of records.
class Records {
  public:
    Records() = default;
    Records(std::span<const std::byte> bytes, std::size_t lump) : bytes_(bytes), lump_(lump) {}

    std::uint32_t count() const { return static_cast<std::uint32_t>(bytes_.size() / kRecordBytes[lump_]); }
    std::int32_t i32(std::size_t record, std::size_t field) const { return std::bit_cast<std::int32_t>(u32(record, field)); }
    float f32(std::size_t record, std::size_t field) const { return std::bit_cast<float>(u32(record, field)); }
    /// `field` counts words of 4 bytes.
    std::uint32_t u32(std::size_t record, std::size_t field) const {
        std::size_t at = record * kRecordBytes[lump_] + field * 4;
        std::uint32_t value = 0;
        for (std::size_t i = 0; i < 4; ++i)
            value |= static_cast<std::uint32_t>(bytes_[at + i]) << (8 * i);
        return value;
    }
    std::string text(std::size_t record, std::size_t length) const {
        const char* begin = reinterpret_cast<const char*>(bytes_.data()) + record * kRecordBytes[lump_];
        return std::string(begin, std::find(begin, begin + length, '\0'));
    }
    std::span<const std::byte> bytes() const { return bytes_; }
    std::string place(std::size_t record) const {
        return std::string(kLumpNames[lump_]) + "[" + std::to_string(record) + "]";
    }

  private:
    std::span<const std::byte> bytes_;
    std::size_t lump_ = 0;
};

/// The map's z points up.
Vec3d turned(double x, double y, double z) { return {x, z, -y}; }

class MapReader {
  public:
    MapReader(std::span<const std::byte> bytes, const ImportOptions& options) : bytes_(bytes), options_(options) {}

    Result<Quake3Map> read() {
        for (auto step : {&MapReader::read_directory, &MapReader::read_shaders, &MapReader::read_planes,
                          &MapReader::read_brushes, &MapReader::read_leaves, &MapReader::read_nodes,
                          &MapReader::read_models, &MapReader::read_visibility, &MapReader::read_surfaces})
            if (Status status = (this->*step)(); !status)
                return status;
        return std::move(map_);
    }

  private:
    Status read_directory() {
        if (bytes_.empty())
            return damaged("the file is empty");
        if (bytes_.size() < 8 + 8 * kLumpCount || std::memcmp(bytes_.data(), "IBSP", 4) != 0)
            return damaged("is not a Quake III map: it does not begin with IBSP and a directory");
        Records header(bytes_.first(8 + 8 * kLumpCount), kIndices); // words
        if (header.u32(1, 0) != 46)
            return {ErrorCode::unsupported, "IBSP version " + std::to_string(header.u32(1, 0)) +
                                                " is not read, only 46"};
        for (std::size_t lump = 0; lump < kLumpCount; ++lump) {
            std::uint64_t offset = header.u32(2 + 2 * lump, 0), size = header.u32(3 + 2 * lump, 0);
            if (offset > bytes_.size() || size > bytes_.size() - offset)
                return damaged(std::string(kLumpNames[lump]) + ": the lump reaches beyond the file");
            if (lump != kLightGrid && size % kRecordBytes[lump] != 0)
                return damaged(std::string(kLumpNames[lump]) + ": the lump is not a whole number of records");
            lumps_[lump] = Records(bytes_.subspan(static_cast<std::size_t>(offset), static_cast<std::size_t>(size)),
                                   lump);
        }
        return {};
    }

    /// Is first .. first + count within `available`? Negative numbers are not.
    static bool in_range(std::int32_t first, std::int32_t count, std::uint32_t available) {
        return first >= 0 && count >= 0 && static_cast<std::uint32_t>(first) <= available &&
               static_cast<std::uint32_t>(count) <= available - static_cast<std::uint32_t>(first);
    }
    static bool in_range(std::int32_t index, std::uint32_t available) { return in_range(index, 1, available); }

    Status read_shaders() {
        const Records& lump = lumps_[kShaders];
        for (std::size_t i = 0; i < lump.count(); ++i)
            reference_.shaders.push_back({lump.text(i, 64), lump.u32(i, 16), lump.u32(i, 17)});
        return {};
    }

    Status read_planes() {
        const Records& lump = lumps_[kPlanes];
        for (std::size_t i = 0; i < lump.count(); ++i) {
            Quake3Reference::Plane plane{turned(lump.f32(i, 0), lump.f32(i, 1), lump.f32(i, 2)), lump.f32(i, 3)};
            if (!is_finite(plane.normal) || !std::isfinite(plane.distance))
                return damaged(lump.place(i) + ": is not finite");
            reference_.planes.push_back(plane);
        }
        return {};
    }

    Status read_brushes() {
        const Records& sides = lumps_[kBrushSides];
        for (std::size_t i = 0; i < sides.count(); ++i) {
            if (!in_range(sides.i32(i, 0), lumps_[kPlanes].count()) ||
                !in_range(sides.i32(i, 1), lumps_[kShaders].count()))
                return damaged(sides.place(i) + ": names a plane or shader that does not exist");
            reference_.brush_sides.push_back({sides.i32(i, 0), sides.i32(i, 1)});
        }
        const Records& lump = lumps_[kBrushes];
        for (std::size_t i = 0; i < lump.count(); ++i) {
            if (!in_range(lump.i32(i, 0), lump.i32(i, 1), sides.count()) ||
                !in_range(lump.i32(i, 2), lumps_[kShaders].count()))
                return damaged(lump.place(i) + ": names sides or a shader that do not exist");
            reference_.brushes.push_back({lump.u32(i, 0), lump.u32(i, 1), lump.i32(i, 2)});
        }
        return {};
    }

    Status read_references(Lump lump, Lump target, std::vector<std::uint32_t>& out) {
        for (std::size_t i = 0; i < lumps_[lump].count(); ++i) {
            if (!in_range(lumps_[lump].i32(i, 0), lumps_[target].count()))
                return damaged(lumps_[lump].place(i) + ": does not exist");
            out.push_back(lumps_[lump].u32(i, 0));
        }
        return {};
    }

    Status read_leaves() {
        if (Status status = read_references(kLeafSurfaces, kSurfaces, reference_.leaf_surfaces); !status)
            return status;
        if (Status status = read_references(kLeafBrushes, kBrushes, reference_.leaf_brushes); !status)
            return status;
        const Records& lump = lumps_[kLeaves];
        for (std::size_t i = 0; i < lump.count(); ++i) {
            if (!in_range(lump.i32(i, 8), lump.i32(i, 9), lumps_[kLeafSurfaces].count()) ||
                !in_range(lump.i32(i, 10), lump.i32(i, 11), lumps_[kLeafBrushes].count()))
                return damaged(lump.place(i) + ": names surfaces or brushes that do not exist");
            Quake3Reference::Leaf leaf;
            leaf.cluster = std::max(-1, lump.i32(i, 0));
            leaf.area = lump.i32(i, 1);
            leaf.bounds.extend(turned(lump.i32(i, 2), lump.i32(i, 3), lump.i32(i, 4)));
            leaf.bounds.extend(turned(lump.i32(i, 5), lump.i32(i, 6), lump.i32(i, 7)));
            leaf.first_surface = lump.u32(i, 8);
            leaf.surface_count = lump.u32(i, 9);
            leaf.first_brush = lump.u32(i, 10);
            leaf.brush_count = lump.u32(i, 11);
            reference_.leaves.push_back(leaf);
        }
        return {};
    }

    /// The compiler writes children after their parents, so a child that does not come later would make a circle.
    Status read_nodes() {
        const Records& lump = lumps_[kNodes];
        for (std::size_t i = 0; i < lump.count(); ++i) {
            Quake3Reference::Node node{lump.i32(i, 0), {lump.i32(i, 1), lump.i32(i, 2)}};
            if (!in_range(node.plane, lumps_[kPlanes].count()))
                return damaged(lump.place(i) + ": names a plane that does not exist");
            for (std::int32_t child : node.children) {
                bool good = child >= 0 ? in_range(child, lump.count()) && static_cast<std::size_t>(child) > i
                                       : in_range(-(child + 1), lumps_[kLeaves].count());
                if (!good)
                    return damaged(lump.place(i) + ": names a child that does not exist or comes before it");
            }
            reference_.nodes.push_back(node);
        }
        return {};
    }

    Status read_models() {
        const Records& lump = lumps_[kModels];
        surface_models_.assign(lumps_[kSurfaces].count(), 0);
        for (std::size_t i = 0; i < lump.count(); ++i) {
            if (!in_range(lump.i32(i, 6), lump.i32(i, 7), lumps_[kSurfaces].count()) ||
                !in_range(lump.i32(i, 8), lump.i32(i, 9), lumps_[kBrushes].count()))
                return damaged(lump.place(i) + ": names surfaces or brushes that do not exist");
            reference_.models.push_back({lump.u32(i, 6), lump.u32(i, 7), lump.u32(i, 8), lump.u32(i, 9)});
        }
        model_origins_ = model_origins(lumps_[kEntities].bytes(), lump.count());
        for (Vec3d& origin : model_origins_)
            origin = turned(origin.x, origin.y, origin.z);
        // A surface of several models moves: the later ones win over the world. Ranges may overlap in a hostile
        // file, so each surface is written once only.
        std::uint32_t next = 0;
        std::vector<std::uint32_t> order;
        for (std::uint32_t m = 1; m < reference_.models.size(); ++m)
            order.push_back(m);
        std::stable_sort(order.begin(), order.end(), [&](std::uint32_t a, std::uint32_t b) {
            return reference_.models[a].first_surface < reference_.models[b].first_surface;
        });
        for (std::uint32_t m : order) {
            const Quake3Reference::Model& model = reference_.models[m];
            for (next = std::max(next, model.first_surface); next < model.first_surface + model.surface_count; ++next)
                surface_models_[next] = static_cast<std::int32_t>(m);
        }
        return {};
    }

    Status read_visibility() {
        std::span<const std::byte> bytes = lumps_[kVisibility].bytes();
        if (bytes.empty())
            return {};
        if (bytes.size() < 8)
            return damaged("visibility: the lump is cut off");
        Records header(bytes.first(8), kIndices);
        std::uint64_t clusters = header.u32(0, 0), row_bytes = header.u32(1, 0);
        if (row_bytes * 8 < clusters || clusters * row_bytes > bytes.size() - 8)
            return damaged("visibility: " + std::to_string(clusters) + " rows of " + std::to_string(row_bytes) +
                           " bytes do not fit");
        reference_.clusters = static_cast<std::uint32_t>(clusters);
        reference_.row_bytes = static_cast<std::uint32_t>(row_bytes);
        for (std::byte byte : bytes.subspan(8, static_cast<std::size_t>(clusters * row_bytes)))
            reference_.visibility.push_back(static_cast<std::uint8_t>(byte));
        for (std::size_t i = 0; i < reference_.leaves.size(); ++i)
            if (reference_.leaves[i].cluster >= static_cast<std::int64_t>(clusters))
                return damaged(lumps_[kLeaves].place(i) + ": names a cluster that does not exist");
        return {};
    }

    Status read_surfaces() {
        std::uint32_t count = lumps_[kSurfaces].count();
        reference_.surface_objects.assign(count, -1);
        for (std::uint32_t s = 0; s < count; ++s)
            if (Status status = read_surface(s); !status)
                return status.in(lumps_[kSurfaces].place(s));
        return {};
    }

    Status read_surface(std::uint32_t s) {
        const Records& lump = lumps_[kSurfaces];
        if (!in_range(lump.i32(s, 0), lumps_[kShaders].count()))
            return damaged("names a shader that does not exist");
        const Quake3Reference::Shader& shader = reference_.shaders[lump.u32(s, 0)];
        std::int32_t type = lump.i32(s, 2);
        const char* left_out = type == kFlare                           ? "flare left out"
                               : shader.surface_flags & kSurfaceNoDraw ? "surface that is not drawn left out"
                                                                        : nullptr;
        std::string name = "surface " + std::to_string(s) + " " + shader.name;
        if (left_out) {
            add_finding(raw().findings, left_out, [&] { return "'" + name + "'"; });
            return {};
        }
        if (!in_range(lump.i32(s, 3), lump.i32(s, 4), lumps_[kVertices].count()) ||
            !in_range(lump.i32(s, 5), lump.i32(s, 6), lumps_[kIndices].count()))
            return damaged("names vertices or indices that do not exist");
        std::uint32_t first = static_cast<std::uint32_t>(raw().triangles.size());
        std::size_t first_vertex = raw().positions.size();
        Status status = type == kPatch                       ? add_patch(s)
                        : type == kPolygon || type == kMesh ? add_mesh(s)
                                                             : damaged("type " + std::to_string(type) + " is unknown");
        if (!status)
            return status;
        std::size_t model = static_cast<std::size_t>(surface_models_[s]);
        for (std::size_t v = first_vertex; model < model_origins_.size() && v < raw().positions.size(); ++v)
            raw().positions[v] += model_origins_[model];
        add_object(s, shader, std::move(name), first);
        return {};
    }

    void add_object(std::uint32_t s, const Quake3Reference::Shader& shader, std::string name, std::uint32_t first) {
        RawObject object;
        object.id = {static_cast<std::int32_t>(s), surface_models_[s], -1};
        object.first_triangle = first;
        object.triangle_count = static_cast<std::uint32_t>(raw().triangles.size()) - first;
        bool see_through = (shader.surface_flags & kSurfaceNonSolid) ||
                           (shader.contents & (kContentsTranslucent | kContentsFog | kContentsWater |
                                               kContentsSlime | kContentsLava)) ||
                           !(shader.contents & kContentsSolid);
        object.flags = see_through ? kDoubleSided : kOccludes;
        if (see_through)
            add_finding(raw().findings, "see-through object", [&] { return "'" + name + "'"; });
        if (surface_models_[s] > 0)
            object.flags = (object.flags & ~std::uint32_t(kOccludes)) | kMoves | kAlwaysVisible;
        object.name = std::move(name);
        reference_.surface_objects[s] = static_cast<std::int32_t>(raw().objects.size());
        raw().objects.push_back(std::move(object));
    }

    Status make_room(std::uint64_t vertices, std::uint64_t triangles) {
        const ImportLimits& limits = options_.limits;
        std::uint64_t all_vertices = raw().positions.size() + vertices;
        std::uint64_t all_triangles = raw().triangles.size() + triangles;
        std::uint64_t memory = all_vertices * sizeof(Vec3d) + all_triangles * sizeof(TriangleIndices);
        if (all_vertices > limits.vertices || all_triangles > limits.triangles || memory > limits.memory ||
            raw().objects.size() >= limits.objects)
            return {ErrorCode::limit, "more vertices, triangles, objects or memory than the limit"};
        return {};
    }

    Result<Vec3d> vertex(std::size_t v) const {
        const Records& lump = lumps_[kVertices];
        Vec3d p = turned(lump.f32(v, 0), lump.f32(v, 1), lump.f32(v, 2));
        if (!is_finite(p))
            return damaged(lump.place(v) + ": is not finite");
        return p;
    }

    Status add_mesh(std::uint32_t s) {
        const Records& surfaces = lumps_[kSurfaces];
        std::uint32_t first_vertex = surfaces.u32(s, 3), vertices = surfaces.u32(s, 4);
        std::uint32_t first_index = surfaces.u32(s, 5), indices = surfaces.u32(s, 6);
        if (Status status = make_room(vertices, indices / 3); !status)
            return status;
        std::uint32_t base = static_cast<std::uint32_t>(raw().positions.size());
        for (std::uint32_t v = 0; v < vertices; ++v) {
            Result<Vec3d> p = vertex(first_vertex + v);
            if (!p)
                return p.status();
            raw().positions.push_back(*p);
        }
        for (std::uint32_t i = 0; i + 3 <= indices; i += 3) {
            TriangleIndices triangle;
            for (std::uint32_t c = 0; c < 3; ++c) {
                std::uint32_t corner = lumps_[kIndices].u32(first_index + i + c, 0);
                if (corner >= vertices)
                    return damaged("indices[" + std::to_string(first_index + i + c) + "]: is beyond the surface's " +
                                   std::to_string(vertices) + " vertices");
                triangle[c] = base + corner;
            }
            // The game's front faces are clockwise.
            std::swap(triangle[1], triangle[2]);
            raw().triangles.push_back(triangle);
        }
        return {};
    }

    /// A net of quadratic Bezier patches: odd numbers of control points, neighbours share a row.
    Status add_patch(std::uint32_t s) {
        const Records& surfaces = lumps_[kSurfaces];
        std::int32_t width = surfaces.i32(s, 24), height = surfaces.i32(s, 25);
        bool sizes_fit = width >= 3 && height >= 3 && width % 2 == 1 && height % 2 == 1 && width <= kLargestPatch &&
                         height <= kLargestPatch;
        if (!sizes_fit || width * height > surfaces.i32(s, 4))
            return damaged("a patch of " + std::to_string(width) + " x " + std::to_string(height) +
                           " control points does not fit its " + std::to_string(surfaces.i32(s, 4)) + " vertices");
        std::uint32_t levels = options_.patch_levels;
        std::uint32_t columns = static_cast<std::uint32_t>(width - 1) / 2 * levels + 1;
        std::uint32_t rows = static_cast<std::uint32_t>(height - 1) / 2 * levels + 1;
        std::uint64_t quads = std::uint64_t(columns - 1) * (rows - 1);
        if (Status status = make_room(std::uint64_t(columns) * rows, 2 * quads); !status)
            return status;
        std::uint32_t base = static_cast<std::uint32_t>(raw().positions.size());
        std::uint32_t first = surfaces.u32(s, 3), stride = static_cast<std::uint32_t>(width);
        for (std::uint32_t y = 0; y < rows; ++y)
            for (std::uint32_t x = 0; x < columns; ++x) {
                Result<Vec3d> p = patch_point(first, stride, static_cast<std::uint32_t>(height), x, y);
                if (!p)
                    return p.status();
                raw().positions.push_back(*p);
            }
        for (std::uint32_t y = 0; y + 1 < rows; ++y)
            for (std::uint32_t x = 0; x + 1 < columns; ++x) {
                std::uint32_t a = base + y * columns + x;
                add_unless_collapsed({a, a + 1, a + columns});
                add_unless_collapsed({a + 1, a + columns + 1, a + columns});
            }
        return {};
    }

    /// Patches are often pinched to a point or an edge, where cells collapse.
    void add_unless_collapsed(const TriangleIndices& t) {
        auto point = [&](std::uint32_t v) {
            const Vec3d& p = raw().positions[v];
            return Vec3f{float(p.x), float(p.y), float(p.z)};
        };
        Vec3f a = point(t[0]), b = point(t[1]), c = point(t[2]);
        if (!(a == b || b == c || c == a))
            raw().triangles.push_back(t);
    }

    Result<Vec3d> patch_point(std::uint32_t first, std::uint32_t width, std::uint32_t height, std::uint32_t x,
                              std::uint32_t y) const {
        std::uint32_t levels = options_.patch_levels;
        // The last row and column belong to the patch before them, at its end.
        std::uint32_t px = std::min(x / levels, (width - 3) / 2), py = std::min(y / levels, (height - 3) / 2);
        auto weights = [&](std::uint32_t at) {
            double t = double(at) / levels;
            return std::array<double, 3>{(1 - t) * (1 - t), 2 * t * (1 - t), t * t};
        };
        std::array<double, 3> u = weights(x - px * levels), v = weights(y - py * levels);
        Vec3d sum;
        for (std::uint32_t j = 0; j < 3; ++j)
            for (std::uint32_t i = 0; i < 3; ++i) {
                Result<Vec3d> p = vertex(first + (2 * py + j) * width + 2 * px + i);
                if (!p)
                    return p;
                sum += *p * (u[i] * v[j]);
            }
        return sum;
    }

    RawScene& raw() { return map_.scene; }

    static constexpr std::size_t kLightGrid = 15; // of no fixed record size in later tools; not read

    std::span<const std::byte> bytes_;
    const ImportOptions& options_;
    std::array<Records, kLumpCount> lumps_;
    Quake3Map map_;
    Quake3Reference& reference_ = map_.reference;
    std::vector<std::int32_t> surface_models_;
    std::vector<Vec3d> model_origins_; ///< movers with an origin are stored around it
};

} // namespace

std::int32_t Quake3Reference::leaf_of(const Vec3d& point) const {
    if (nodes.empty())
        return leaves.empty() ? -1 : 0;
    std::int32_t at = 0;
    // Children come after their parents, so this ends.
    while (at >= 0) {
        const Node& node = nodes[static_cast<std::size_t>(at)];
        const Plane& plane = planes[static_cast<std::size_t>(node.plane)];
        at = node.children[dot(plane.normal, point) >= plane.distance ? 0 : 1];
    }
    return -1 - at;
}

bool Quake3Reference::cluster_sees(std::int32_t from, std::int32_t to) const {
    if (clusters == 0)
        return true;
    auto exists = [&](std::int32_t c) { return c >= 0 && static_cast<std::uint32_t>(c) < clusters; };
    if (!exists(from) || !exists(to))
        return false;
    std::size_t row = static_cast<std::size_t>(from) * row_bytes;
    return visibility[row + static_cast<std::size_t>(to) / 8] >> (to % 8) & 1;
}

Result<Quake3Map> import_quake3(std::span<const std::byte> bytes, const std::string& name,
                                const ImportOptions& options) try {
    if (bytes.size() > options.limits.bytes)
        return Status(ErrorCode::limit, name + ": has " + std::to_string(bytes.size()) +
                                            " bytes, more than the limit of " + std::to_string(options.limits.bytes));
    if (options.patch_levels < 1 || options.patch_levels > 32)
        return Status(ErrorCode::usage, "patch levels must lie between 1 and 32");
    Result<Quake3Map> map = MapReader(bytes, options).read();
    if (!map)
        return map.status().in(name);
    map->scene.source = name;
    return map;
} catch (const std::bad_alloc&) {
    return Status(ErrorCode::limit, name + ": not enough memory");
}

} // namespace antumbra
