#include "base/bytes.hpp"
#include "pvs/cluster_triangles.hpp"

namespace antumbra {
namespace {

void encode_object(const PvsTriangles& triangles, std::uint32_t first, const std::vector<std::uint32_t>& cluster_first,
                   ByteWriter& out) {
    const std::vector<std::uint32_t>& cluster = triangles.cluster;
    out.varint(triangles.in_file);
    out.varint(cluster.size() - triangles.in_file);
    auto is_single = [&](std::uint32_t c) { return cluster_first[c + 1] - cluster_first[c] == 1; };
    std::int64_t last = std::int64_t(first) - 1;
    for (std::size_t t = 0, end = 0; t < cluster.size(); t = end) {
        std::uint32_t c = cluster[t];
        bool next = c != PvsTriangles::kNone && c == last + 1 && is_single(c);
        for (end = t + 1; end < cluster.size(); ++end)
            if (next ? !(cluster[end] == cluster[end - 1] + 1 && is_single(cluster[end])) : cluster[end] != c)
                break;
        std::uint64_t count = end - t;
        if (c == PvsTriangles::kNone) {
            out.varint(4 * count + 2);
        } else if (next) {
            out.varint(4 * count + 1);
            last = cluster[end - 1];
        } else {
            std::int64_t step = std::int64_t(c) - last;
            out.varint(4 * count);
            out.varint(std::uint64_t(step) << 1 ^ std::uint64_t(step >> 63));
            last = c;
        }
    }
}

} // namespace

std::vector<std::byte> encode_triangles(const PvsData& data) {
    ByteWriter out;
    std::uint32_t c = 0;
    std::uint64_t end = 0;
    for (std::size_t o = 0; o < data.triangles.size(); ++o) {
        encode_object(data.triangles[o], c, data.cluster_first, out);
        end += data.objects[o].triangle_count;
        while (c + 1 < data.cluster_first.size() && data.cluster_first[c] < end)
            ++c;
    }
    return std::move(out.bytes);
}

} // namespace antumbra
