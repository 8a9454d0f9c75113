// Runs of triangles by cluster: read here for checking and for use, by one walk.
#include "pvs/cluster_triangles.hpp"

#include "base/bytes.hpp"
#include "pvs/format.hpp"

namespace antumbra {
namespace {

enum Run : std::uint32_t { kSame = 0, kEachNext = 1, kNone = 2 };

/// Reads what is told of one object: `run(kind, cluster, triangles)` for each run, `cluster` relative to the object's first.
/// False: the bytes make no sense, or `run` said so.
template <class Begin, class OnRun>
bool read_object(std::span<const std::byte> bytes, std::size_t& at, const Begin& begin, const OnRun& on_run) {
    std::uint64_t in_file = 0, added = 0;
    if (!read_varint(bytes, at, in_file) || !read_varint(bytes, at, added) || in_file + added > 0xFFFFFFFFu ||
        !begin(std::uint32_t(in_file), std::uint32_t(in_file + added)))
        return false;
    std::int64_t last = -1;
    for (std::uint64_t told = 0; told < in_file + added;) {
        std::uint64_t head = 0, step = 0;
        if (!read_varint(bytes, at, head))
            return false;
        auto kind = std::uint32_t(head & 3);
        std::uint64_t count = head >> 2;
        if (kind > kNone || count == 0 || count > in_file + added - told ||
            (kind == kSame && !read_varint(bytes, at, step)))
            return false;
        std::int64_t cluster = last + 1;
        if (kind == kSame)
            cluster = last + (std::int64_t(step >> 1) ^ -std::int64_t(step & 1));
        if (!on_run(Run(kind), cluster, count))
            return false;
        if (kind != kNone)
            last = kind == kSame ? cluster : last + std::int64_t(count);
        told += count;
    }
    return true;
}

bool check_triangles(std::span<const std::byte> first, std::span<const std::byte> bytes, ClusterIndex& index) {
    std::size_t clusters = first.size() / 4 - 1, at = 0;
    std::vector<std::uint32_t> left(clusters); // triangles of each cluster that are still to be told
    for (std::size_t c = 0; c < clusters; ++c)
        left[c] = load_u32(first, 4 * c + 4) - load_u32(first, 4 * c);
    for (std::size_t o = 0; o + 1 < index.first.size(); ++o) {
        index.triangles.push_back(at);
        std::uint32_t own = index.first[o], count = index.first[o + 1] - own;
        bool ok = read_object(bytes, at, [](auto, auto) { return true; }, [&](Run kind, std::int64_t cluster, std::uint64_t n) {
            if (kind == kNone)
                return true;
            std::uint64_t touched = kind == kSame ? 1 : n; // each of which loses one: at most as many runs as triangles
            if (cluster < 0 || std::uint64_t(cluster) + touched > count)
                return false;
            for (std::uint64_t k = 0; k < touched; ++k) {
                std::uint32_t& rest = left[own + std::size_t(cluster) + k];
                std::uint64_t taken = kind == kSame ? n : 1;
                if (taken > rest || (kind == kEachNext && rest > 1))
                    return false; // clusters of one triangle alone, so that the time is bounded by the clusters
                rest -= std::uint32_t(taken);
            }
            return true;
        });
        if (!ok)
            return false;
        for (std::uint32_t c = own; c < own + count; ++c)
            if (left[c] != 0)
                return false;
    }
    return at == bytes.size();
}

} // namespace

const char* index_clusters(std::span<const std::byte> first, const std::span<const std::byte>* triangles,
                           std::span<const std::byte> objects, ClusterIndex& index) {
    std::size_t entries = first.size() / 4, c = 0;
    auto at = [&](std::size_t k) { return load_u32(first, 4 * k); };
    if (first.size() % 4 != 0 || entries < 2 || at(0) != 0)
        return "its size or its first entry is wrong";
    for (std::size_t k = 1; k < entries; ++k)
        if (at(k) <= at(k - 1))
            return "its entries do not ascend";
    std::uint64_t end = 0;
    for (std::size_t o = 0; o < objects.size() / kObjectBytes; ++o) {
        index.first.push_back(std::uint32_t(c));
        end += load_u32(objects, o * kObjectBytes + 16);
        while (c + 1 < entries && at(c) < end)
            ++c;
        if (at(c) != end)
            return "a cluster is not within one object";
    }
    index.first.push_back(std::uint32_t(c));
    if (c + 1 != entries)
        return "it has other triangles than the objects";
    return triangles && !check_triangles(first, *triangles, index) ? "the triangles of clusters contradict CLUS" : nullptr;
}

void decode_triangles(std::span<const std::byte> bytes, std::size_t at, std::uint32_t first_cluster, std::uint32_t most,
                      PvsTriangles& triangles) {
    std::size_t next = 0;
    (void)read_object(
        bytes, at,
        [&](std::uint32_t in_file, std::uint32_t all) {
            triangles.in_file = in_file;
            if (all <= most)
                triangles.cluster.assign(all, PvsTriangles::kNone);
            return all <= most;
        },
        [&](Run kind, std::int64_t cluster, std::uint64_t count) {
            for (std::uint64_t k = 0; kind != kNone && k < count; ++k)
                triangles.cluster[next + k] = first_cluster + std::uint32_t(cluster) + std::uint32_t(kind == kEachNext ? k : 0);
            next += count;
            return true;
        });
}

} // namespace antumbra
