// PvsData for tests, drawn from a seed.
#pragma once

#include "base/random.hpp"

#include <antumbra/pvs.hpp>

#include <algorithm>
#include <span>

namespace antumbra::test {

inline std::string random_text(Random& random, std::uint32_t most) {
    std::string text(random.below(most + 1), ' ');
    for (char& c : text)
        c = static_cast<char>(random.below(256));
    return text;
}

/// A row of one of the shapes that the coding distinguishes: empty, sparse, in runs, dense, full.
inline void random_row(Random& random, std::uint32_t objects, std::span<std::uint64_t> words) {
    std::uint32_t shape = random.below(5);
    bool value = false;
    for (std::uint32_t o = 0; o < objects; ++o) {
        if (shape == 2 && random.below(20) == 0)
            value = !value;
        bool bit = shape == 1 ? random.below(30) == 0 : shape == 2 ? value : shape == 3 ? random.below(2) == 0 : shape == 4;
        if (bit)
            words[o / 64] |= std::uint64_t(1) << (o % 64);
    }
}

/// Gives the objects few triangles, each of some cluster or of none.
inline void random_clusters(Random& random, PvsData& data) {
    data.cluster_first = {0};
    for (PvsObject& object : data.objects) {
        PvsTriangles triangles;
        std::uint32_t first = static_cast<std::uint32_t>(data.cluster_first.size()) - 1, clusters = random.below(9);
        bool each = random.below(4) == 0; // a triangle each
        for (std::uint32_t c = 0; c < clusters; ++c)
            triangles.cluster.insert(triangles.cluster.end(), each ? 1 : 1 + random.below(6), first + c);
        for (std::uint32_t k = random.below(4); k > 0; --k)
            triangles.cluster.push_back(PvsTriangles::kNone);
        for (std::uint32_t k = 0; k < triangles.cluster.size() && random.below(3) > 0; ++k) // swaps, or the order as it is
            std::swap(triangles.cluster[k], triangles.cluster[random.below(static_cast<std::uint32_t>(triangles.cluster.size()))]);
        triangles.in_file = random.below(static_cast<std::uint32_t>(triangles.cluster.size()) + 1);
        object.triangle_count = 0;
        for (std::uint32_t c = 0; c < clusters; ++c) {
            auto size = static_cast<std::uint32_t>(std::count(triangles.cluster.begin(), triangles.cluster.end(), first + c));
            object.triangle_count += size;
            data.cluster_first.push_back(data.cluster_first.back() + size);
        }
        data.triangles.push_back(std::move(triangles));
    }
    if (data.cluster_first.size() == 1) {
        data.cluster_first.clear();
        data.triangles.clear();
    }
}

/// Up to `most_objects` objects, 6^3 cells and 40 rows, some of them equal, some of them unused.
inline PvsData random_pvs(std::uint64_t seed, std::uint32_t most_objects = 300, bool with_clusters = false) {
    Random random(seed);
    PvsData data;
    data.guarantee = Guarantee(1 + random.below(4));
    data.method = random_text(random, 12);
    data.tool_version = random_text(random, 12);
    data.options_json = random_text(random, 60);
    for (std::uint8_t& byte : data.scene_fingerprint)
        byte = static_cast<std::uint8_t>(random.below(256));
    data.structure_fingerprint = random.next_u64();
    data.sides = static_cast<std::uint8_t>(random.below(2));
    for (int k = 0; k < 3; ++k) {
        data.origin[k] = random.uniform(-1000, 1000);
        data.grid.bounds.min[k] = random.uniform(-100, 100);
        data.grid.bounds.max[k] = data.grid.bounds.min[k] + random.uniform(0.1, 100);
        data.grid.count[static_cast<std::size_t>(k)] = 1 + random.below(6);
    }
    data.objects.resize(random.below(most_objects + 1));
    for (PvsObject& object : data.objects) {
        object.node = static_cast<std::int32_t>(random.next_u32());
        object.primitive = static_cast<std::int32_t>(random.below(5)) - 1;
        object.instance = static_cast<std::int32_t>(random.below(5)) - 1;
        object.flags = random.below(40) == 0 ? 7 : random.below(4);
        object.triangle_count = random.next_u32();
        object.name = random_text(random, 10);
        for (int k = 0; k < 3; ++k) {
            object.bounds.min[k] = static_cast<float>(random.uniform(-50, 50));
            object.bounds.max[k] = object.bounds.min[k] + static_cast<float>(random.uniform(0, 5));
        }
    }
    if (with_clusters)
        random_clusters(random, data);
    data.row_count = random.below(41);
    data.rows.resize(data.row_count * data.words_per_row());
    for (std::uint32_t r = 0; r < data.row_count; ++r) {
        auto words = std::span(data.rows).subspan(r * data.words_per_row(), data.words_per_row());
        if (r > 0 && random.below(4) == 0)
            std::copy_n(data.rows.begin(), words.size(), words.begin());
        else
            random_row(random, static_cast<std::uint32_t>(data.bits_per_row()), words);
    }
    data.cell_row.resize(data.grid.cells());
    for (std::uint32_t& row : data.cell_row) {
        std::uint32_t kind = random.below(10);
        row = kind == 0 || data.row_count == 0 ? kCellNotBaked : kind == 1 ? kCellSolid : random.below(data.row_count);
    }
    return data;
}

/// Adds occludee volumes around the cells, and draws all rows anew.
inline void add_volumes(Random& random, PvsData& data) {
    Box3d bounds = data.tree.nodes.empty() ? data.grid.bounds : data.tree.bounds;
    data.volumes = {{bounds.min - Vec3d{1, 2, 3}, bounds.max + Vec3d{3, 2, 1}}, {3, 2, 1 + random.below(4)}};
    data.rows.assign(data.row_count * data.words_per_row(), 0);
    for (std::uint32_t r = 0; r < data.row_count; ++r)
        random_row(random, static_cast<std::uint32_t>(data.bits_per_row()),
                   std::span(data.rows).subspan(r * data.words_per_row(), data.words_per_row()));
}

/// What row `row` of the data must answer: its bits and the objects that are always visible.
inline std::vector<std::uint64_t> expected_row(const PvsData& data, std::uint32_t row) {
    auto words = std::span(data.rows).subspan(row * data.words_per_row(), data.words_per_row());
    std::vector<std::uint64_t> bits(words.begin(), words.end());
    for (std::size_t o = 0; o < data.objects.size(); ++o)
        if (data.objects[o].flags & 4)
            bits[o / 64] |= std::uint64_t(1) << (o % 64);
    return bits;
}

} // namespace antumbra::test
