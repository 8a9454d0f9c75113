#include "import/draco_mesh.hpp"

#include "import/gltf_accessors.hpp"

#include <draco/compression/decode.h>

#include <cstring>
#include <exception>

namespace antumbra::gltf {
namespace {

constexpr std::uint8_t kMesh = 1, kSequential = 0, kEdgebreaker = 1;
constexpr std::uint16_t kHasMetadata = 0x8000;

Status damaged(const std::string& text) { return {ErrorCode::corrupt, text + "; export the file anew"}; }

/// The first bytes of a Draco stream, as its specification (version 2.2) lays them out.
class Header {
  public:
    explicit Header(std::span<const std::byte> bytes) : bytes_(bytes) {}

    Status check(std::uint64_t points, std::uint64_t triangles) {
        if (bytes_.size() < 11 || std::memcmp(bytes_.data(), "DRACO", 5) != 0)
            return damaged("not a Draco stream");
        at_ = 5;
        std::uint32_t major = byte(), minor = byte(), geometry = byte(), method = byte();
        std::uint32_t flags = byte();
        flags |= byte() << 8;
        if (major != 2 || minor != 2)
            return {ErrorCode::unsupported, "Draco version " + std::to_string(major) + "." + std::to_string(minor) +
                                                " is not read; export with 2.2"};
        if (geometry != kMesh || method > kEdgebreaker)
            return damaged("not a Draco mesh");
        if (flags & kHasMetadata)
            return {ErrorCode::unsupported, "Draco metadata is not read; export without it"};
        if (method == kEdgebreaker)
            byte(); // kind of traversal
        std::uint64_t first = varint(), second = varint();
        std::uint64_t faces = method == kSequential ? first : second;
        std::uint64_t vertices = method == kSequential ? second : first;
        if (faces != triangles)
            return damaged("the stream has " + std::to_string(faces) + " triangles, but the file says " +
                           std::to_string(triangles));
        // Edgebreaker counts vertices before it splits them along seams: those are fewer.
        if (vertices > points)
            return damaged("the stream has " + std::to_string(vertices) + " vertices, but the file says " +
                           std::to_string(points));
        return {};
    }

  private:
    std::uint32_t byte() { return at_ < bytes_.size() ? static_cast<std::uint32_t>(bytes_[at_++]) : 0; }
    std::uint64_t varint() {
        std::uint64_t value = 0;
        for (int shift = 0; shift < 35; shift += 7) {
            std::uint32_t next = byte();
            value |= std::uint64_t(next & 0x7F) << shift;
            if (!(next & 0x80))
                return value;
        }
        return UINT64_MAX;
    }

    std::span<const std::byte> bytes_;
    std::size_t at_ = 0;
};

class Positions {
  public:
    Positions(const draco::PointAttribute& attribute, const Accessor& accessor)
        : attribute_(attribute), plain_(attribute), accessor_(accessor) {
        // libdraco scales what the stream calls normalised; glTF's accessor decides, so we scale ourselves.
        plain_.set_normalized(false);
    }

    Status check() const {
        bool is_float = attribute_.data_type() == draco::DT_FLOAT32;
        if (attribute_.num_components() != 3 || is_float != (accessor_.type == ComponentType::f32))
            return damaged("the positions' type is not that of the accessor");
        return {};
    }

    Status append(std::uint32_t count, std::vector<Vec3d>& positions) const {
        for (std::uint32_t i = 0; i < count; ++i) {
            draco::AttributeValueIndex value = attribute_.mapped_index(draco::PointIndex(i));
            if (value.value() >= attribute_.size())
                return damaged("point " + std::to_string(i) + " has no position");
            Vec3d p;
            if (!read(value, p))
                return damaged("point " + std::to_string(i) + " is not finite");
            positions.push_back(p);
        }
        return {};
    }

  private:
    bool read(draco::AttributeValueIndex value, Vec3d& p) const {
        if (attribute_.data_type() == draco::DT_FLOAT32) {
            float v[3];
            attribute_.GetValue(value, v);
            p = to_double(Vec3f{v[0], v[1], v[2]});
            return is_finite(p);
        }
        std::int32_t v[3];
        if (!plain_.ConvertValue<std::int32_t>(value, 3, v))
            return false;
        for (int k = 0; k < 3; ++k)
            p[k] = integer_value(accessor_.type, accessor_.normalized, v[k]);
        return true;
    }

    const draco::PointAttribute& attribute_;
    draco::GeometryAttribute plain_;
    const Accessor& accessor_;
};

Status append_mesh(const draco::Mesh& mesh, std::uint32_t position_id, const Accessor& accessor,
                   std::uint64_t triangle_count, std::vector<Vec3d>& positions,
                   std::vector<TriangleIndices>& triangles) {
    const draco::PointAttribute* attribute = mesh.GetAttributeByUniqueId(position_id);
    if (!attribute)
        return damaged("no attribute has the id " + std::to_string(position_id));
    if (mesh.num_faces() != triangle_count || mesh.num_points() > accessor.count)
        return damaged("the stream gave " + std::to_string(mesh.num_faces()) + " triangles and " +
                       std::to_string(mesh.num_points()) + " points, the file says " +
                       std::to_string(triangle_count) + " and " + std::to_string(accessor.count));
    Positions reader(*attribute, accessor);
    if (Status status = reader.check(); !status)
        return status;
    std::uint32_t base = static_cast<std::uint32_t>(positions.size());
    if (Status status = reader.append(mesh.num_points(), positions); !status)
        return status;
    for (std::uint32_t f = 0; f < mesh.num_faces(); ++f) {
        const draco::Mesh::Face& face = mesh.face(draco::FaceIndex(f));
        TriangleIndices triangle;
        for (std::size_t c = 0; c < 3; ++c) {
            if (face[c].value() >= mesh.num_points())
                return damaged("triangle " + std::to_string(f) + " names a point that does not exist");
            triangle[c] = base + face[c].value();
        }
        triangles.push_back(triangle);
    }
    return {};
}

} // namespace

Status decode_draco(std::span<const std::byte> bytes, std::uint32_t position_id, const Accessor& accessor,
                    std::uint64_t triangle_count, std::vector<Vec3d>& positions,
                    std::vector<TriangleIndices>& triangles) {
    if (Status status = Header(bytes).check(accessor.count, triangle_count); !status)
        return status;
    try {
        draco::DecoderBuffer buffer;
        buffer.Init(reinterpret_cast<const char*>(bytes.data()), bytes.size());
        draco::Decoder decoder;
        auto mesh = decoder.DecodeMeshFromBuffer(&buffer);
        if (!mesh.ok() || !mesh.value())
            return damaged(std::string("libdraco: ") + mesh.status().error_msg());
        return append_mesh(*mesh.value(), position_id, accessor, triangle_count, positions, triangles);
    } catch (const std::exception&) {
        // bad_alloc and length_error from counts that only libdraco sees.
        return damaged("libdraco gave up");
    }
}

} // namespace antumbra::gltf
