// Chunk OCCL: an OccluderSet as bytes and back. Byte layout: docs/format.md, section 6. What follows from other numbers
// (planes, areas, boxes) is not stored but computed again, so that a damaged file cannot contradict itself there.
#include <antumbra/occluders.hpp>

#include "base/bytes.hpp"

#include <algorithm>
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
};

class Decoder {
  public:
    explicit Decoder(std::span<const std::byte> bytes) : bytes_(bytes) {}

    Result<OccluderSet> run() {
        if (bytes_.size() < kHeaderBytes)
            return corrupt("it is too short");
        counts_ = {u32(), u32(), u32(), u32(), u32(), u32(), u32()};
        at_ = kHeaderBytes;
        if (counts_.bytes() != bytes_.size())
            return corrupt("its size contradicts the numbers at its start");
        if (!read_vertices())
            return corrupt("a vertex is not finite or beyond 1e17");
        if (!read_polygons())
            return corrupt("the corners of its polygons contradict their number");
        read_solids();
        if (!read_patches())
            return corrupt("its patches contradict their number");
        if (!read_restrictions())
            return corrupt("a solid is restricted that does not exist, or to no place");
        if (Status status = check_occluders(set_); !status)
            return corrupt(status.message());
        return finish();
    }

  private:
    std::uint32_t u32() { return load_u32(bytes_, (at_ += 4) - 4); }
    float f32() { return load_f32(bytes_, (at_ += 4) - 4); }
    Vec3f vec3() {
        float x = f32(), y = f32(), z = f32();
        return {x, y, z};
    }

    bool read_vertices() {
        set_.vertices.reserve(std::size_t(counts_.vertices));
        for (std::uint64_t v = 0; v < counts_.vertices; ++v) {
            set_.vertices.push_back(vec3());
            for (int axis = 0; axis < 3; ++axis)
                if (!(std::abs(set_.vertices.back()[axis]) <= kLargest))
                    return false;
        }
        set_.loops.reserve(std::size_t(counts_.corners));
        set_.neighbours.reserve(std::size_t(counts_.corners));
        for (std::uint64_t i = 0; i < counts_.corners; ++i) {
            set_.loops.push_back(u32());
            set_.neighbours.push_back(u32());
        }
        return true;
    }

    bool read_polygons() {
        std::uint64_t first = 0;
        set_.polygons.resize(std::size_t(counts_.polygons));
        for (OccluderPolygon& polygon : set_.polygons) {
            polygon.first = static_cast<std::uint32_t>(first);
            polygon.count = u32();
            polygon.object = u32();
            std::uint32_t flags = u32();
            polygon.double_sided = flags & kBlocksBothWays;
            polygon.synthetic = flags & kIsSynthetic;
            polygon.solid = u32();
            first += polygon.count;
            if (first > counts_.corners || polygon.count > kMostCorners || !(polygon.synthetic || polygon.solid == kNoPolygon))
                return false;
        }
        return first == counts_.corners;
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
            patch.core = u32();
            patch.count = u32();
            first += patch.count;
            if (first > counts_.patch_polygons)
                return false;
        }
        set_.patch_polygons.reserve(std::size_t(counts_.patch_polygons));
        for (std::uint64_t i = 0; i < counts_.patch_polygons; ++i)
            set_.patch_polygons.push_back(u32());
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
                              set.patches.size(), set.patch_polygons.size(), restricted, std::size_t(0)}) {
        if (count > 0xFFFFFFFFu)
            return Status(ErrorCode::limit, "encode_occluders: more than 2^32 corners");
        out.u32(static_cast<std::uint32_t>(count));
    }
    for (const Vec3f& vertex : set.vertices)
        put(out, vertex);
    for (std::size_t i = 0; i < set.loops.size(); ++i) {
        out.u32(set.loops[i]);
        out.u32(set.neighbours[i]);
    }
    for (const OccluderPolygon& polygon : set.polygons) {
        out.u32(polygon.count);
        out.u32(polygon.object);
        out.u32((polygon.double_sided ? kBlocksBothWays : 0u) | (polygon.synthetic ? kIsSynthetic : 0u));
        out.u32(polygon.solid);
    }
    for (const OccluderSolid& solid : set.solids) {
        put(out, solid.shell.min);
        put(out, solid.shell.max);
    }
    for (const OccluderPatch& patch : set.patches) {
        out.u32(patch.core);
        out.u32(patch.count);
    }
    for (std::uint32_t polygon : set.patch_polygons)
        out.u32(polygon);
    for (std::size_t s = 0; s < set.solids.size(); ++s)
        if (set.solids[s].is_restricted()) {
            out.u32(static_cast<std::uint32_t>(s));
            put(out, set.solids[s].viewers.min);
            put(out, set.solids[s].viewers.max);
        }
    return std::move(out.bytes);
}

} // namespace antumbra
