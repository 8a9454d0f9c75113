#include "import/meshopt.hpp"

#include <meshoptimizer.h>

namespace antumbra::gltf {
namespace {

/// No stream of the codec unpacks to more than this many times its size: the best it can do is two bits for sixteen
/// equal bytes. Checked so that a tiny file cannot ask for a huge array.
constexpr std::uint64_t kMostExpansion = 64;
constexpr std::uint64_t kSlack = 4096;

Status check(const Meshopt& view, std::uint64_t packed, std::uint64_t max_bytes) {
    // What meshoptimizer asserts, or takes for granted.
    bool attributes = view.mode == MeshoptMode::attributes;
    if (attributes ? view.stride == 0 || view.stride % 4 != 0 : view.stride != 2 && view.stride != 4)
        return {ErrorCode::corrupt, "byteStride " + std::to_string(view.stride) + " does not suit the mode"};
    if (view.mode == MeshoptMode::triangles && view.count % 3 != 0)
        return {ErrorCode::corrupt, "count is not a multiple of 3"};
    bool filter_fits = view.filter == MeshoptFilter::none ||
                       (attributes && (view.filter == MeshoptFilter::exponential ||
                                       (view.filter == MeshoptFilter::quaternion && view.stride == 8) ||
                                       (view.filter == MeshoptFilter::octahedral &&
                                        (view.stride == 4 || view.stride == 8))));
    if (!filter_fits)
        return {ErrorCode::corrupt, "byteStride " + std::to_string(view.stride) + " does not suit the filter"};
    std::uint64_t bytes = view.count * view.stride; // below 2^32 * 2^8
    if (bytes > max_bytes || bytes > packed * kMostExpansion + kSlack)
        return {ErrorCode::limit, std::to_string(bytes) + " bytes are more than the view, the limit, or " +
                                      std::to_string(packed) + " packed bytes can give"};
    return {};
}

bool unpack(const Meshopt& view, std::span<const std::byte> packed, std::byte* destination) {
    const auto* source = reinterpret_cast<const unsigned char*>(packed.data());
    std::size_t count = static_cast<std::size_t>(view.count), stride = static_cast<std::size_t>(view.stride);
    switch (view.mode) {
    case MeshoptMode::attributes:
        return meshopt_decodeVertexBuffer(destination, count, stride, source, packed.size()) == 0;
    case MeshoptMode::triangles:
        return meshopt_decodeIndexBuffer(destination, count, stride, source, packed.size()) == 0;
    case MeshoptMode::indices:
        return meshopt_decodeIndexSequence(destination, count, stride, source, packed.size()) == 0;
    }
    return false;
}

void apply_filter(const Meshopt& view, std::byte* data) {
    std::size_t count = static_cast<std::size_t>(view.count), stride = static_cast<std::size_t>(view.stride);
    if (view.filter == MeshoptFilter::octahedral)
        meshopt_decodeFilterOct(data, count, stride);
    else if (view.filter == MeshoptFilter::quaternion)
        meshopt_decodeFilterQuat(data, count, stride);
    else if (view.filter == MeshoptFilter::exponential)
        meshopt_decodeFilterExp(data, count, stride);
}

} // namespace

Result<std::vector<std::byte>> decode_meshopt(const Meshopt& view, std::span<const std::byte> packed,
                                              std::uint64_t max_bytes) {
    if (Status status = check(view, packed.size(), max_bytes); !status)
        return status.in("meshopt compression");
    std::vector<std::byte> bytes(static_cast<std::size_t>(view.count * view.stride));
    if (view.count > 0 && !unpack(view, packed, bytes.data()))
        return Status(ErrorCode::corrupt, "the stream is damaged or of a newer codec; export the file anew")
            .in("meshopt compression");
    // The filters work in groups of four and handle any count.
    apply_filter(view, bytes.data());
    return bytes;
}

} // namespace antumbra::gltf
