// Chunk OCCL: an OccluderSet as bytes and back. Byte layout: docs/format.md, section 6. What follows from other numbers
// (planes, areas, boxes) is not stored but computed again, so that a damaged file cannot contradict itself there.
#include <antumbra/occluders.hpp>

#include "base/bytes.hpp"

#include <algorithm>
#include <bit>
#include <cmath>
#include <string>

namespace antumbra {
namespace {

constexpr std::size_t kHeaderBytes = 32, kVertexBytes = 12, kCornerBytes = 8, kPolygonBytes = 16, kSolidBytes = 24,
                      kPatchBytes = 8, kPatchPolygonBytes = 4, kRestrictedBytes = 28;
/// Of one polygon: looking for shared edges takes time with its square.
constexpr std::uint32_t kMostCorners = 1024;
constexpr float kLargest = 1e17f;
enum PolygonFlag : std::uint32_t { kBlocksBothWays = 1, kIsSynthetic = 2 };

Status corrupt(const std::string& what) {
    return {ErrorCode::corrupt, "chunk 'OCCL': " + what + "; the file is damaged, prepare it again"};
}

struct Counts {
    std::uint64_t vertices, corners, polygons, solids, patches, patch_polygons, restricted;
    std::uint64_t bytes() const {
        return kHeaderBytes + vertices * kVertexBytes + corners * kCornerBytes + polygons * kPolygonBytes +
               solids * kSolidBytes + patches * kPatchBytes + patch_polygons * kPatchPolygonBytes +
               restricted * kRestrictedBytes;
    }
    std::uint64_t items() const { return vertices + corners + polygons + solids + patches + patch_polygons + restricted; }
};

/// Forms of the chunk: numbers of four bytes each, as written before; or small numbers in few bytes.
enum Form : std::uint32_t { kWide = 0, kCompact = 1 };

class Decoder {
  public:
    explicit Decoder(std::span<const std::byte> bytes) : bytes_(bytes) {}

    Result<OccluderSet> run() {
        if (const char* problem = read())
            return corrupt(problem);
        if (Status status = check_occluders(set_); !status)
            return corrupt(status.message());
        return finish();
    }

  private:
    /// What is wrong with the bytes, or nullptr.
    const char* read() {
        constexpr const char* kSize = "its size contradicts the numbers at its start";
        if (bytes_.size() < kHeaderBytes)
            return "it is too short";
        counts_ = {u32(), u32(), u32(), u32(), u32(), u32(), u32()};
        std::uint32_t form = u32();
        compact_ = form == kCompact;
        // Of a compact one every item takes a byte at least.
        if (form > kCompact || (compact_ ? counts_.items() > bytes_.size() : counts_.bytes() != bytes_.size()))
            return kSize;
        if (compact_)
            scale_ = f32();
        if (!(scale_ >= 0 && scale_ <= kLargest))
            return "the step of its grid makes no sense";
        if (!read_vertices())
            return "a vertex is not finite or beyond 1e17";
        if (!read_polygons())
            return "the corners of its polygons contradict their number";
        read_solids();
        if (!read_patches())
            return "its patches contradict their number";
        if (!read_restrictions())
            return "a solid is restricted that does not exist, or to no place";
        return failed_ || at_ != bytes_.size() ? kSize : nullptr;
    }

    /// Zero beyond the end, which the caller finds out at the end.
    std::uint32_t u32() {
        if (bytes_.size() - at_ < 4) {
            failed_ = true;
            return 0;
        }
        return load_u32(bytes_, (at_ += 4) - 4);
    }
    float f32() { return std::bit_cast<float>(u32()); }
    Vec3f vec3() {
        float x = f32(), y = f32(), z = f32();
        return {x, y, z};
    }
    /// Once in the code, for its size; below 2^35.
    [[gnu::noinline]] std::uint64_t number() {
        std::uint64_t value = 0;
        failed_ |= !read_varint(bytes_, at_, value);
        return value;
    }
    /// A small number, and one near that of its kind before.
    [[gnu::noinline]] std::uint32_t count() { return compact_ ? static_cast<std::uint32_t>(number()) : u32(); }
    [[gnu::noinline]] std::uint32_t near(std::uint32_t before) {
        return compact_ ? before + static_cast<std::uint32_t>(unzigzag(number())) : u32();
    }

    bool read_vertices() {
        set_.vertices.resize(std::size_t(counts_.vertices));
        std::uint32_t before[3] = {0, 0, 0};
        for (Vec3f& vertex : set_.vertices) {
            if (scale_ > 0) {
                for (int axis = 0; axis < 3; ++axis) {
                    before[axis] = near(before[axis]);
                    vertex[axis] = static_cast<float>(double(static_cast<std::int32_t>(before[axis])) * double(scale_));
                }
            } else {
                vertex = vec3();
            }
            for (int axis = 0; axis < 3; ++axis)
                if (!(std::abs(vertex[axis]) <= kLargest))
                    return false;
        }
        return true;
    }

    std::uint32_t neighbour(std::uint32_t polygon) {
        if (!compact_)
            return u32();
        std::uint64_t value = number();
        if (value == 0)
            return kNoPolygon;
        auto other = static_cast<std::uint32_t>(polygon + unzigzag((value - 1) >> 1));
        return (other & ~kSameDirection) | ((value - 1) & 1 ? kSameDirection : 0);
    }

    /// Wide: all corners, then the polygons; compact: all polygons, then the corners.
    bool read_polygons() {
        set_.loops.resize(std::size_t(counts_.corners));
        set_.neighbours.resize(std::size_t(counts_.corners));
        for (std::size_t i = 0; i < counts_.corners && !compact_; ++i) {
            set_.loops[i] = u32();
            set_.neighbours[i] = u32();
        }
        std::uint64_t first = 0;
        std::uint32_t object = 0, solid = 0;
        set_.polygons.resize(std::size_t(counts_.polygons));
        for (OccluderPolygon& polygon : set_.polygons) {
            polygon.first = static_cast<std::uint32_t>(first);
            std::uint32_t flags = 0;
            polygon.count = count();
            if (compact_) {
                flags = polygon.count & 3;
                polygon.count >>= 2;
            }
            polygon.object = object = near(object);
            flags = compact_ ? flags : u32();
            polygon.double_sided = flags & kBlocksBothWays;
            polygon.synthetic = flags & kIsSynthetic;
            polygon.solid = kNoPolygon;
            if (!compact_ || polygon.synthetic)
                polygon.solid = solid = near(solid);
            first += polygon.count;
            if (first > counts_.corners || polygon.count > kMostCorners || !(polygon.synthetic || polygon.solid == kNoPolygon))
                return false;
        }
        if (first != counts_.corners)
            return false;
        std::uint32_t vertex = 0;
        std::size_t corner = 0;
        for (std::uint32_t p = 0; p < set_.polygons.size() && compact_; ++p)
            for (std::uint32_t i = 0; i < set_.polygons[p].count; ++i, ++corner) {
                set_.loops[corner] = vertex = near(vertex);
                set_.neighbours[corner] = neighbour(p);
            }
        return true;
    }

    void read_solids() {
        set_.solids.resize(std::size_t(counts_.solids));
        for (OccluderSolid& solid : set_.solids) {
            solid.shell.min = vec3();
            solid.shell.max = vec3();
        }
    }

    bool read_restrictions() {
        for (std::uint64_t r = 0; r < counts_.restricted; ++r) {
            std::uint32_t solid = u32();
            Box3f viewers;
            viewers.min = vec3();
            viewers.max = vec3();
            if (solid >= set_.solids.size() || !is_finite(viewers.min) || !is_finite(viewers.max))
                return false;
            set_.solids[solid].viewers = viewers;
        }
        return true;
    }

    bool read_patches() {
        std::uint64_t first = 0;
        set_.patches.resize(std::size_t(counts_.patches));
        for (OccluderPatch& patch : set_.patches) {
            patch.first = static_cast<std::uint32_t>(first);
            patch.core = count();
            patch.count = count();
            first += patch.count;
            if (first > counts_.patch_polygons)
                return false;
        }
        set_.patch_polygons.resize(std::size_t(counts_.patch_polygons));
        std::uint32_t before = 0;
        for (std::uint32_t& polygon : set_.patch_polygons)
            polygon = before = near(before);
        return first == counts_.patch_polygons;
    }

    /// What relies on indices that check_occluders() has proved to be in range.
    Result<OccluderSet> finish() {
        for (std::size_t p = 0; p < set_.polygons.size(); ++p) {
            OccluderPolygon& polygon = set_.polygons[p];
            measure_occluder(set_, polygon);
            if (!(polygon.area > 0) || !is_finite(polygon.normal) || !std::isfinite(polygon.offset))
                return corrupt("polygon " + std::to_string(p) + " has no area");
            for (std::uint32_t i = 0; i < polygon.count; ++i)
                if (!is_shared(polygon, i))
                    return corrupt("polygon " + std::to_string(p) + " shares no edge with its neighbour");
        }
        for (std::size_t s = 0; s < set_.solids.size(); ++s)
            if (const Box3f& shell = set_.solids[s].shell; !is_finite(shell.min) || !is_finite(shell.max))
                return corrupt("solid " + std::to_string(s) + " is not finite");
        for (OccluderPatch& patch : set_.patches)
            for (std::uint32_t i = patch.first; i < patch.first + patch.core; ++i)
                for (std::uint32_t v : set_.loop(set_.polygons[set_.patch_polygons[i]]))
                    patch.box.extend(set_.vertices[v]);
        return std::move(set_);
    }

    /// An edge is left out of silhouettes because its neighbour is there: that must be true.
    bool is_shared(const OccluderPolygon& polygon, std::uint32_t corner) const {
        std::uint32_t neighbour = set_.neighbours[polygon.first + corner];
        if ((neighbour & ~kSameDirection) == kNoPolygon)
            return true;
        std::span<const std::uint32_t> loop = set_.loop(polygon);
        std::uint32_t a = loop[corner], b = loop[(corner + 1) % loop.size()];
        if (!(neighbour & kSameDirection))
            std::swap(a, b);
        std::span<const std::uint32_t> other = set_.loop(set_.polygons[neighbour & ~kSameDirection]);
        for (std::size_t i = 0; i < other.size(); ++i)
            if (other[i] == a && other[(i + 1) % other.size()] == b)
                return true;
        return false;
    }

    std::span<const std::byte> bytes_;
    std::size_t at_ = 0;
    Counts counts_{};
    bool compact_ = false, failed_ = false;
    float scale_ = 0; ///< of the grid that the vertices lie on; 0: written as they are
    OccluderSet set_;
};

/// The file has no room for gaps: corners follow one another as the polygons do, and so on.
bool is_in_order(const OccluderSet& set) {
    std::size_t corners = 0, members = 0;
    for (const OccluderPolygon& polygon : set.polygons) {
        if (polygon.first != corners || polygon.count > kMostCorners)
            return false;
        corners += polygon.count;
    }
    for (const OccluderPatch& patch : set.patches) {
        if (patch.first != members)
            return false;
        members += patch.count;
    }
    return corners == set.loops.size() && members == set.patch_polygons.size();
}

void put(ByteWriter& out, const Vec3f& v) {
    for (int axis = 0; axis < 3; ++axis)
        out.f32(v[axis]);
}

/// The widest grid, with a power of two as its step, that all vertices lie on; 0 if 32 bits cannot number its places.
float grid_of(const OccluderSet& set) {
    int finest = 127, farthest = -200;
    for (const Vec3f& vertex : set.vertices)
        for (int axis = 0; axis < 3; ++axis) {
            int exponent = 0;
            float part = std::frexp(vertex[axis], &exponent);
            if (part == 0)
                continue;
            auto digits = static_cast<std::uint32_t>(std::abs(std::ldexp(part, 24)));
            finest = std::min(finest, exponent - 24 + std::countr_zero(digits));
            farthest = std::max(farthest, exponent);
        }
    if (farthest == -200)
        return 1; // all of it zero
    return finest >= -126 && finest <= 56 && farthest - finest <= 30 ? std::ldexp(1.0f, finest) : 0;
}

void put_vertices(ByteWriter& out, const OccluderSet& set) {
    float scale = grid_of(set);
    out.f32(scale);
    std::int32_t before[3] = {0, 0, 0};
    for (const Vec3f& vertex : set.vertices) {
        if (scale == 0) {
            put(out, vertex);
            continue;
        }
        for (int axis = 0; axis < 3; ++axis) {
            auto place = static_cast<std::int32_t>(double(vertex[axis]) / double(scale));
            out.varint(zigzag(std::int64_t(place) - before[axis]));
            before[axis] = place;
        }
    }
}

/// The distance from the number before, which it then is.
void put_near(ByteWriter& out, std::uint32_t value, std::uint32_t& before) {
    out.varint(zigzag(std::int64_t(value) - std::int64_t(before)));
    before = value;
}

void put_polygons(ByteWriter& out, const OccluderSet& set) {
    std::uint32_t object = 0, solid = 0, vertex = 0;
    for (const OccluderPolygon& polygon : set.polygons) {
        out.varint(std::uint64_t(polygon.count) << 2 | (polygon.double_sided ? kBlocksBothWays : 0u) |
                   (polygon.synthetic ? kIsSynthetic : 0u));
        put_near(out, polygon.object, object);
        if (polygon.synthetic)
            put_near(out, polygon.solid, solid);
    }
    for (std::uint32_t p = 0; p < set.polygons.size(); ++p)
        for (std::uint32_t i = set.polygons[p].first; i < set.polygons[p].first + set.polygons[p].count; ++i) {
            put_near(out, set.loops[i], vertex);
            std::uint32_t other = set.neighbours[i] & ~kSameDirection;
            out.varint(other == kNoPolygon ? 0
                                           : 1 + (zigzag(std::int64_t(other) - p) << 1 | (set.neighbours[i] & kSameDirection ? 1u : 0u)));
        }
}

} // namespace

Result<OccluderSet> decode_occluders(std::span<const std::byte> bytes) { return Decoder(bytes).run(); }

Result<std::vector<std::byte>> encode_occluders(const OccluderSet& set) {
    if (Status status = check_occluders(set); !status)
        return Status(ErrorCode::usage, status.message());
    if (!is_in_order(set))
        return Status(ErrorCode::usage, "encode_occluders: the corners of the polygons, or the polygons of the patches, "
                                        "are not in their order, belong to none, or are more than 1024");
    ByteWriter out;
    auto restricted = static_cast<std::size_t>(
        std::count_if(set.solids.begin(), set.solids.end(), [](const OccluderSolid& solid) { return solid.is_restricted(); }));
    for (std::size_t count : {set.vertices.size(), set.loops.size(), set.polygons.size(), set.solids.size(),
                              set.patches.size(), set.patch_polygons.size(), restricted}) {
        if (count > 0xFFFFFFFFu)
            return Status(ErrorCode::limit, "encode_occluders: more than 2^32 corners");
        out.u32(static_cast<std::uint32_t>(count));
    }
    out.u32(kCompact);
    put_vertices(out, set);
    put_polygons(out, set);
    for (const OccluderSolid& solid : set.solids) {
        put(out, solid.shell.min);
        put(out, solid.shell.max);
    }
    for (const OccluderPatch& patch : set.patches) {
        out.varint(patch.core);
        out.varint(patch.count);
    }
    std::uint32_t before = 0;
    for (std::uint32_t polygon : set.patch_polygons)
        put_near(out, polygon, before);
    for (std::size_t s = 0; s < set.solids.size(); ++s)
        if (set.solids[s].is_restricted()) {
            out.u32(static_cast<std::uint32_t>(s));
            put(out, set.solids[s].viewers.min);
            put(out, set.solids[s].viewers.max);
        }
    return std::move(out.bytes);
}

} // namespace antumbra
