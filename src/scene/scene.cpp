#include <antumbra/scene.hpp>

#include "scene/cracks.hpp"

#include <cmath>
#include <fnmatch.h>
#include <new>
#include <xxhash.h>

namespace antumbra {
namespace {

constexpr double kLargestCoordinate = 1e15;
constexpr double kSmallestExtent = 1e-15;
constexpr std::uint32_t kUnused = 0xFFFFFFFFu;

struct Grid {
    Vec3d origin;
    double step = 1;
    Vec3f snap(const Vec3d& world) const {
        Vec3f local;
        for (int k = 0; k < 3; ++k)
            local[k] = static_cast<float>(std::floor((world[k] - origin[k]) / step + 0.5) * step);
        return local;
    }
};

Status error_in(const RawScene& raw, ErrorCode code, const std::string& text) {
    return Status(code, text).in(raw.source);
}

Status check_ranges(const RawScene& raw) {
    if (raw.positions.size() >= kUnused || raw.triangles.size() >= kUnused || raw.objects.size() >= kUnused)
        return error_in(raw, ErrorCode::limit, "more than 2^32 vertices, triangles or objects; split the scene");
    std::uint64_t next = 0;
    for (const RawObject& object : raw.objects) {
        if (object.first_triangle != next)
            return error_in(raw, ErrorCode::internal, "object '" + object.name + "': triangles out of order");
        next += object.triangle_count;
    }
    if (next != raw.triangles.size())
        return error_in(raw, ErrorCode::internal, "triangles without an object");
    for (std::size_t t = 0; t < raw.triangles.size(); ++t)
        for (std::uint32_t v : raw.triangles[t])
            if (v >= raw.positions.size())
                return error_in(raw, ErrorCode::corrupt,
                                "triangle " + std::to_string(t) + ": vertex index " + std::to_string(v) +
                                    " is beyond the " + std::to_string(raw.positions.size()) + " vertices");
    return {};
}

bool matches(const std::vector<std::string>& patterns, const std::string& name) {
    for (const std::string& pattern : patterns)
        if (::fnmatch(pattern.c_str(), name.c_str(), 0) == 0)
            return true;
    return false;
}

std::uint32_t final_flags(const RawObject& object, const SceneOptions& options) {
    std::uint32_t flags = object.flags;
    if (options.sides == SidesOption::both)
        flags |= kDoubleSided;
    if (matches(options.never_occlude, object.name))
        flags &= ~std::uint32_t(kOccludes);
    if (matches(options.never_cull, object.name))
        flags |= kAlwaysVisible;
    if (flags & kMoves)
        flags = (flags | kAlwaysVisible) & ~std::uint32_t(kOccludes);
    return flags;
}

/// Bounds of everything that is kept; an error for what no grid can represent.
Result<Box3d> measure(const RawScene& raw, const std::vector<bool>& kept) {
    Box3d bounds;
    for (std::size_t o = 0; o < raw.objects.size(); ++o) {
        if (!kept[o])
            continue;
        const RawObject& object = raw.objects[o];
        for (std::uint32_t t = 0; t < object.triangle_count; ++t)
            for (std::uint32_t v : raw.triangles[object.first_triangle + t]) {
                const Vec3d& p = raw.positions[v];
                for (int k = 0; k < 3; ++k)
                    if (!(std::abs(p[k]) <= kLargestCoordinate)) // also NaN
                        return error_in(raw, ErrorCode::corrupt,
                                        "object '" + object.name + "': a vertex is not finite or beyond 1e15 units; "
                                        "repair or leave out the object");
                bounds.extend(p);
            }
    }
    if (bounds.empty())
        return error_in(raw, ErrorCode::corrupt, "the scene has no triangles; nothing can be seen in it");
    Vec3d size = bounds.size();
    if (std::max({size.x, size.y, size.z}) < kSmallestExtent)
        return error_in(raw, ErrorCode::corrupt, "the scene is smaller than 1e-15 units; scale it up");
    return bounds;
}

/// The finest power-of-two step such that locals stay below 2^23 steps and origin + local below 2^52.
Grid choose_grid(const Box3d& bounds) {
    Vec3d size = bounds.size();
    double extent = std::max({size.x, size.y, size.z});
    double magnitude = 0;
    for (int k = 0; k < 3; ++k)
        magnitude = std::max({magnitude, std::abs(bounds.min[k]), std::abs(bounds.max[k])});
    double wanted = std::max(extent / 0x1.fffff0p23, magnitude * 0x1p-52);
    int exponent = 0;
    double fraction = std::frexp(wanted, &exponent); // wanted = fraction * 2^exponent, fraction in [0.5, 1)
    Grid grid;
    grid.step = std::ldexp(1.0, fraction == 0.5 ? exponent - 1 : exponent);
    for (int k = 0; k < 3; ++k)
        grid.origin[k] = std::floor(bounds.centre()[k] / grid.step + 0.5) * grid.step;
    return grid;
}

bool has_area(const Vec3f& a, const Vec3f& b, const Vec3f& c, double step) {
    std::int64_t u[3], v[3];
    for (int k = 0; k < 3; ++k) {
        u[k] = static_cast<std::int64_t>((double(b[k]) - a[k]) / step);
        v[k] = static_cast<std::int64_t>((double(c[k]) - a[k]) / step);
    }
    return u[1] * v[2] != u[2] * v[1] || u[2] * v[0] != u[0] * v[2] || u[0] * v[1] != u[1] * v[0];
}

bool has_area(const Vec3d& a, const Vec3d& b, const Vec3d& c) {
    Vec3d n = cross(b - a, c - a);
    return n.x != 0 || n.y != 0 || n.z != 0;
}

Box3f outward(const Box3d& world, const Grid& grid) {
    Box3f box;
    for (int k = 0; k < 3; ++k) {
        box.min[k] = std::nextafter(static_cast<float>(world.min[k] - grid.origin[k] - grid.step), -INFINITY);
        box.max[k] = std::nextafter(static_cast<float>(world.max[k] - grid.origin[k] + grid.step), INFINITY);
    }
    return box;
}

void note(std::vector<Finding>& findings, const char* kind, const std::string& example) {
    for (Finding& finding : findings)
        if (finding.kind == kind) {
            ++finding.count;
            return;
        }
    findings.push_back({kind, 1, example});
}

std::uint64_t structure_hash(std::span<const Object> objects) {
    std::uint64_t hash = 0xcbf29ce484222325u;
    auto mix = [&](std::uint32_t value) {
        for (int byte = 0; byte < 4; ++byte)
            hash = (hash ^ (value >> (8 * byte) & 0xFF)) * 0x100000001b3u;
    };
    for (const Object& object : objects) {
        mix(static_cast<std::uint32_t>(object.id.node));
        mix(static_cast<std::uint32_t>(object.id.primitive));
        mix(static_cast<std::uint32_t>(object.id.instance));
        mix(object.source_triangles);
    }
    return hash;
}

} // namespace

std::string to_hex(const Fingerprint& fingerprint) {
    static const char digits[] = "0123456789abcdef";
    std::string text;
    for (std::uint8_t byte : fingerprint) {
        text += digits[byte >> 4];
        text += digits[byte & 15];
    }
    return text;
}

Box3d Scene::world_bounds() const {
    return {to_world(to_double(bounds_.min)), to_world(to_double(bounds_.max))};
}

/// Moves and adds triangles so that nothing gapes by less than `width`, and tells of it.
Status Scene::close_cracks(double width) {
    GridMesh mesh;
    for (const Vec3f& p : positions_)
        mesh.positions.push_back(to_double(p) * (1 / step_)); // exact: a power of two
    mesh.triangles = triangles_;
    mesh.object_of = triangle_objects_;
    std::vector<bool> occludes;
    for (const Object& object : objects_)
        occludes.push_back(object.has(kOccludes));
    Result<CrackClosing> closed = antumbra::close_cracks(mesh, occludes, width / step_);
    if (!closed)
        return closed.status();
    for (std::size_t v = 0; v < positions_.size(); ++v)
        for (int k = 0; k < 3; ++k)
            positions_[v][k] = static_cast<float>(mesh.positions[v][k] * step_);
    std::vector<std::uint32_t> sources; // what is added to an object stands behind what it had
    for (std::size_t t = 0, old = 0; t < mesh.triangles.size(); ++t) {
        std::uint32_t o = mesh.object_of[t];
        bool first_added = sources.empty() || mesh.object_of[t - 1] != o || sources.back() < objects_[o].source_triangles;
        if (old < triangle_objects_.size() && triangle_objects_[old] == o)
            sources.push_back(triangle_sources_[old++]);
        else
            sources.push_back(first_added ? objects_[o].source_triangles : sources.back() + 1);
    }
    triangle_sources_ = std::move(sources);
    triangles_ = std::move(mesh.triangles);
    triangle_objects_ = std::move(mesh.object_of);
    for (Object& object : objects_)
        object.triangle_count = 0;
    for (std::size_t t = 0; t < triangles_.size(); ++t) {
        Object& object = objects_[triangle_objects_[t]];
        ++object.triangle_count;
        for (std::uint32_t corner : triangles_[t])
            object.bounds.extend(positions_[corner]);
    }
    std::uint32_t next = 0;
    for (Object& object : objects_) {
        object.first_triangle = next;
        next += object.triangle_count;
    }
    if (closed->moved > 0)
        findings_.push_back({"corner moved to close a crack", closed->moved, ""});
    if (closed->seals > 0)
        findings_.push_back({"triangle added to close a crack", closed->seals, ""});
    return {};
}

Result<Scene> Scene::create(RawScene raw, const SceneOptions& options) try {
    if (Status status = check_ranges(raw); !status)
        return status;
    if (!(options.crack_width >= 0 && std::isfinite(options.crack_width)))
        return error_in(raw, ErrorCode::usage, "--crack-width wants a number of scene units, 0 or more");
    std::vector<bool> kept(raw.objects.size());
    for (std::size_t o = 0; o < raw.objects.size(); ++o)
        kept[o] = !matches(options.ignore, raw.objects[o].name);
    Result<Box3d> bounds = measure(raw, kept);
    if (!bounds)
        return bounds.status();
    Grid grid = choose_grid(*bounds);

    Scene scene;
    scene.source_ = raw.source;
    scene.origin_ = grid.origin;
    scene.step_ = grid.step;
    scene.sides_ = options.sides;
    scene.findings_ = std::move(raw.findings);
    scene.triangles_.reserve(raw.triangles.size());
    scene.triangle_objects_.reserve(raw.triangles.size());
    scene.crack_width_ = options.crack_width;
    std::vector<std::uint32_t> vertex_map(raw.positions.size(), kUnused);
    std::vector<SnappedPoint> snapped;
    for (std::size_t o = 0; o < raw.objects.size(); ++o) {
        RawObject& source = raw.objects[o];
        if (!kept[o]) {
            note(scene.findings_, "ignored object", source.name);
            continue;
        }
        Object object;
        object.id = source.id;
        object.flags = final_flags(source, options);
        object.first_triangle = static_cast<std::uint32_t>(scene.triangles_.size());
        object.source_triangles = source.triangle_count;
        Box3d world;
        for (std::uint32_t t = 0; t < source.triangle_count; ++t) {
            const TriangleIndices& raw_triangle = raw.triangles[source.first_triangle + t];
            Vec3f corners[3];
            for (std::size_t c = 0; c < 3; ++c) {
                world.extend(raw.positions[raw_triangle[c]]);
                corners[c] = grid.snap(raw.positions[raw_triangle[c]]);
            }
            if (!has_area(corners[0], corners[1], corners[2], grid.step)) {
                bool had = has_area(raw.positions[raw_triangle[0]], raw.positions[raw_triangle[1]],
                                    raw.positions[raw_triangle[2]]);
                note(scene.findings_, had ? "triangle collapsed by snapping" : "degenerate triangle",
                     "triangle " + std::to_string(t) + " of '" + source.name + "'");
                continue;
            }
            TriangleIndices triangle;
            for (std::size_t c = 0; c < 3; ++c) {
                if (options.count_cracks)
                    snapped.push_back({(raw.positions[raw_triangle[c]] - grid.origin) * (1 / grid.step),
                                       to_double(corners[c]) * (1 / grid.step),
                                       static_cast<std::uint32_t>(scene.objects_.size())});
                std::uint32_t& mapped = vertex_map[raw_triangle[c]];
                if (mapped == kUnused) {
                    mapped = static_cast<std::uint32_t>(scene.positions_.size());
                    scene.positions_.push_back(corners[c]);
                    scene.bounds_.extend(corners[c]);
                }
                triangle[c] = mapped;
            }
            scene.triangles_.push_back(triangle);
            scene.triangle_objects_.push_back(static_cast<std::uint32_t>(scene.objects_.size()));
            scene.triangle_sources_.push_back(t);
        }
        object.triangle_count = static_cast<std::uint32_t>(scene.triangles_.size()) - object.first_triangle;
        if (world.empty())
            world.extend(bounds->centre());
        object.bounds = outward(world, grid);
        if (object.triangle_count == 0) {
            object.flags |= kAlwaysVisible;
            note(scene.findings_, "object without area", "'" + source.name + "'");
        }
        if (object.has(kMoves))
            note(scene.findings_, "moving object", "'" + source.name + "'");
        scene.objects_.push_back(object);
        scene.names_.push_back(std::move(source.name));
    }
    if (scene.triangles_.empty())
        return error_in(raw, ErrorCode::corrupt, "no triangle of the scene has an area; nothing can be seen in it");

    if (options.count_cracks)
        if (OpenedCracks cracks = count_opened_cracks(std::move(snapped)); cracks.count > 0)
            scene.findings_.push_back({kCrackOpened, cracks.count,
                                       "between '" + scene.names_[cracks.a] + "' and '" + scene.names_[cracks.b] + "'"});
    if (options.crack_width > 0)
        if (Status status = scene.close_cracks(options.crack_width); !status)
            return status.in(raw.source);

    XXH3_state_t* state = XXH3_createState();
    XXH3_128bits_reset(state);
    auto update = [&](const void* data, std::size_t bytes) { XXH3_128bits_update(state, data, bytes); };
    update(&scene.origin_, sizeof scene.origin_);
    update(&scene.step_, sizeof scene.step_);
    update(scene.positions_.data(), scene.positions_.size() * sizeof(Vec3f));
    update(scene.triangles_.data(), scene.triangles_.size() * sizeof(TriangleIndices));
    for (std::size_t o = 0; o < scene.objects_.size(); ++o) {
        const Object& object = scene.objects_[o];
        update(&object.id, sizeof object.id);
        update(&object.flags, sizeof object.flags);
        update(&object.triangle_count, sizeof object.triangle_count);
        update(scene.names_[o].data(), scene.names_[o].size() + 1);
    }
    XXH128_canonical_t canonical;
    XXH128_canonicalFromHash(&canonical, XXH3_128bits_digest(state));
    XXH3_freeState(state);
    std::copy(std::begin(canonical.digest), std::end(canonical.digest), scene.fingerprint_.begin());
    scene.structure_fingerprint_ = structure_hash(scene.objects_);
    return scene;
} catch (const std::bad_alloc&) {
    return Status(ErrorCode::limit, "not enough memory for the scene; split it");
}

} // namespace antumbra
