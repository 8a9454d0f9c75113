// PvsData to the bytes of a file.
#include "pvs/cluster_triangles.hpp"
#include "pvs/coding_archive.hpp"
#include "pvs/coding_references.hpp"
#include "pvs/coding_tree.hpp"
#include "pvs/format.hpp"
#include "pvs/grid.hpp"
#include "pvs/row_coding.hpp"

#include <algorithm>
#include <map>
#include <utility>

namespace antumbra {
namespace {

using Row = std::span<const std::uint64_t>;

Status usage(const std::string& what) { return {ErrorCode::usage, "encode_pvs: " + what}; }

bool fits_u32(std::size_t value) { return value <= 0xFFFFFFFFu; }

bool has_bits_beyond(Row row, std::size_t objects) {
    return objects % 64 != 0 && !row.empty() && row.back() >> (objects % 64) != 0;
}

Status check_rows(const PvsData& data) {
    std::size_t words = data.words_per_row();
    if (data.rows.size() != std::size_t(data.row_count) * words)
        return usage("'rows' holds " + std::to_string(data.rows.size()) + " words instead of row_count * " +
                     std::to_string(words));
    for (std::size_t r = 0; r < data.row_count; ++r)
        if (has_bits_beyond(Row(data.rows).subspan(r * words, words), data.bits_per_row()))
            return usage("row " + std::to_string(r) + " has bits set beyond the objects");
    return {};
}

Status check_cells(const PvsData& data) {
    std::uint64_t cells = 0;
    if (!is_usable(data.grid, cells))
        return usage("the cell grid is empty, too large or not finite");
    if (cells > 0 && !data.tree.nodes.empty())
        return usage("there is both a cell grid and a view tree");
    if (Status status = data.tree.check(data.row_count); !status)
        return status.in("encode_pvs");
    if (data.cell_row.size() != cells)
        return usage("'cell_row' has " + std::to_string(data.cell_row.size()) + " entries for " +
                     std::to_string(cells) + " cells");
    for (std::size_t c = 0; c < data.cell_row.size(); ++c)
        if (std::uint32_t row = data.cell_row[c]; row >= data.row_count && row < kCellSolid)
            return usage("cell " + std::to_string(c) + " refers to row " + std::to_string(row) + " of " +
                         std::to_string(data.row_count));
    return {};
}

bool are_clusters(const PvsData& data) {
    const std::vector<std::uint32_t>& first = data.cluster_first;
    if (first.empty())
        return true;
    std::size_t c = 0; // each object begins with a cluster, which ends within it
    std::uint64_t triangles = 0;
    for (const PvsObject& object : data.objects) {
        if (object.triangle_count == 0)
            continue;
        if (c >= first.size() || first[c] != triangles)
            return false;
        triangles += object.triangle_count;
        for (++c; c < first.size() && first[c] < triangles; ++c)
            if (first[c] <= first[c - 1])
                return false;
    }
    return c + 1 == first.size() && first[c] == triangles;
}

/// Does each cluster have as many triangles as it says, and does each object have no others?
bool are_cluster_triangles(const PvsData& data) {
    if (data.triangles.empty())
        return true;
    if (data.cluster_first.empty() || data.triangles.size() != data.objects.size())
        return false;
    std::vector<std::uint32_t> counts(data.cluster_count(), 0);
    std::uint32_t first = 0;
    std::uint64_t end = 0;
    for (std::size_t o = 0; o < data.objects.size(); ++o) {
        std::uint32_t last = first;
        for (end += data.objects[o].triangle_count; last < counts.size() && data.cluster_first[last] < end;)
            ++last;
        const PvsTriangles& triangles = data.triangles[o];
        if (triangles.in_file > triangles.cluster.size() || !fits_u32(triangles.cluster.size()))
            return false;
        for (std::uint32_t c : triangles.cluster) {
            if (c != PvsTriangles::kNone && (c < first || c >= last))
                return false;
            if (c != PvsTriangles::kNone)
                ++counts[c];
        }
        first = last;
    }
    for (std::size_t c = 0; c < counts.size(); ++c)
        if (counts[c] != data.cluster_first[c + 1] - data.cluster_first[c])
            return false;
    return true;
}

Status check(const PvsData& data) {
    if (data.guarantee < Guarantee::exact || data.guarantee > Guarantee::approximate)
        return usage("the guarantee is none of the four");
    if (!is_finite(data.origin))
        return usage("the origin is not finite");
    if (!fits_u32(data.objects.size()) || !fits_u32(data.method.size()) || !fits_u32(data.tool_version.size()))
        return {ErrorCode::limit, "encode_pvs: more than 2^32 objects or letters"};
    std::uint64_t volumes = 0;
    if (!is_usable(data.volumes, volumes) || volumes > kMostVolumes)
        return usage("the grid of occludee volumes is empty, larger than 2^20 or not finite");
    if (!are_clusters(data))
        return usage("the clusters are not ascending ranges that hold all triangles, each within one object");
    if (!are_cluster_triangles(data))
        return usage("the triangles of objects are not those of their clusters");
    if (Status status = check_cells(data); !status)
        return status;
    return check_rows(data);
}

/// The distinct rows that are used, numbered in order of first use, always-visible objects set in each: what is
/// written depends on what the cells see, not on how the caller's rows happen to be arranged.
class RowTable {
  public:
    explicit RowTable(const PvsData& data)
        : data_(data), renumbered_(data.row_count, kUnknown), words_(data.words_per_row()), always_(words_) {
        for (std::size_t o = 0; o < data.objects.size(); ++o)
            if (data.objects[o].flags & kAlwaysVisibleFlag)
                always_[o / 64] |= std::uint64_t(1) << (o % 64);
    }

    /// Number in the file of row `row` of the data.
    std::uint32_t use(std::uint32_t row) {
        if (renumbered_[row] != kUnknown)
            return renumbered_[row];
        std::vector<std::uint64_t> words(always_);
        for (std::size_t w = 0; w < words_; ++w)
            words[w] |= data_.rows[row * words_ + w];
        auto [at, is_new] = numbers_.try_emplace(std::move(words), std::uint32_t(numbers_.size()));
        if (is_new)
            bits.insert(bits.end(), at->first.begin(), at->first.end());
        return renumbered_[row] = at->second;
    }

    std::uint32_t count() const { return static_cast<std::uint32_t>(numbers_.size()); }
    std::vector<std::uint64_t> bits; ///< of all rows in the file's order

  private:
    static constexpr std::uint32_t kUnknown = 0xFFFFFFFFu;
    const PvsData& data_;
    std::vector<std::uint32_t> renumbered_;
    std::size_t words_;
    std::vector<std::uint64_t> always_;
    std::map<std::vector<std::uint64_t>, std::uint32_t> numbers_;
};

struct CodedRows {
    std::vector<std::byte> index, rows;
};

CodedRows encode_cheapest(Row bits, std::size_t row_count, std::size_t objects) {
    ByteWriter index, rows;
    for (std::size_t r = 0; r < row_count; ++r) {
        encode_row(bits.subspan(r * words_for(objects), words_for(objects)), objects, rows);
        index.u32(static_cast<std::uint32_t>(rows.bytes.size()));
    }
    return {std::move(index.bytes), std::move(rows.bytes)};
}

/// `data` with the rows of `table`, which the tree codings follow.
std::vector<std::byte> encode_by_tree(const PvsData& data, RowTable& table, PvsCoding coding) {
    auto scheme = TreeCoding(std::uint32_t(coding) - 1);
    CodingTree shape;
    if (data.tree.nodes.empty()) {
        std::vector<std::uint32_t> cell_row = data.cell_row;
        for (std::uint32_t& row : cell_row)
            row = row >= kCellSolid ? row : table.use(row);
        shape = coding_tree_of(data.grid, cell_row);
    } else {
        ViewTree tree = data.tree;
        for (ViewNode& node : tree.nodes)
            if (node.axis == ViewNode::kLeaf && node.link < kCellSolid)
                node.link = table.use(node.link);
        shape = coding_tree_of(tree);
    }
    return encode_tree_rows(shape, scheme, table.bits, data.bits_per_row());
}

Result<CodedRows> encode_rows(const PvsData& data, RowTable& table, PvsCoding coding) {
    CodedRows coded;
    switch (coding) {
    case PvsCoding::cheapest:
        coded = encode_cheapest(table.bits, table.count(), data.bits_per_row());
        break;
    case PvsCoding::tree_leaves:
    case PvsCoding::tree_parent:
    case PvsCoding::tree_sibling:
        coded.rows = encode_by_tree(data, table, coding);
        break;
    case PvsCoding::references: {
        CodedReferences references = encode_references(table.bits, table.count(), data.bits_per_row());
        coded = {std::move(references.index), std::move(references.rows)};
        break;
    }
    case PvsCoding::archive:
        coded.rows = encode_archive(table.bits, table.count(), data.bits_per_row());
        break;
    default:
        return usage("there is no row coding " + std::to_string(std::uint32_t(coding)));
    }
    bool is_unpacked = coding != PvsCoding::cheapest && coding != PvsCoding::references;
    if (is_unpacked && !may_unpack(table.count(), data.bits_per_row(), coded.rows.size()))
        return Status(ErrorCode::limit, std::string("encode_pvs: the rows are too uniform for the coding '") +
                                            to_string(coding) + "'; choose 'references'");
    if (!fits_u32(coded.rows.size()))
        return Status(ErrorCode::limit, "encode_pvs: more than 4 GiB of coded rows; bake fewer cells");
    return coded;
}

ByteWriter encode_meta(const PvsData& data, PvsCoding coding, std::uint32_t row_count) {
    ByteWriter out;
    out.u8(std::uint8_t(data.guarantee));
    out.u8(data.sides);
    out.u16(0);
    out.u32(std::uint32_t(coding));
    out.u32(static_cast<std::uint32_t>(data.objects.size()));
    out.u32(row_count);
    out.u64(data.structure_fingerprint);
    out.raw(std::as_bytes(std::span(data.scene_fingerprint)));
    for (const Vec3d& corner : {data.origin, data.grid.bounds.min, data.grid.bounds.max})
        for (int axis = 0; axis < 3; ++axis)
            out.f64(corner[axis]);
    for (std::uint32_t count : data.grid.count)
        out.u32(count);
    out.u32(static_cast<std::uint32_t>(data.method.size()));
    out.u32(static_cast<std::uint32_t>(data.tool_version.size()));
    for (int i = 0; i < 3; ++i)
        out.u32(0);
    out.text(data.method);
    out.text(data.tool_version);
    return out;
}

void put_box(const Box3d& box, ByteWriter& out) {
    for (const Vec3d& corner : {box.min, box.max})
        for (int axis = 0; axis < 3; ++axis)
            out.f64(corner[axis]);
}

ByteWriter encode_tree(const ViewTree& tree, RowTable& table) {
    ByteWriter out;
    put_box(tree.bounds, out);
    out.u32(static_cast<std::uint32_t>(tree.nodes.size()));
    for (int i = 0; i < 3; ++i)
        out.u32(0);
    std::uint32_t next = 0;
    for (const ViewNode& node : tree.nodes) {
        if (node.axis != ViewNode::kLeaf) {
            out.u8(node.axis);
            out.u16(node.split);
            continue;
        }
        std::uint32_t row = node.link >= kCellSolid ? node.link : table.use(node.link);
        out.u8(row == next ? kLeafOfNextRow : kLeafOfGivenRow);
        if (row == next)
            ++next;
        else
            out.u32(row);
    }
    return out;
}

ByteWriter encode_volumes(const CellGrid& volumes) {
    ByteWriter out;
    put_box(volumes.bounds, out);
    for (std::uint32_t count : volumes.count)
        out.u32(count);
    out.u32(0);
    return out;
}

ByteWriter encode_objects(const PvsData& data) {
    ByteWriter out;
    std::uint32_t name_end = 0;
    for (const PvsObject& object : data.objects) {
        name_end += static_cast<std::uint32_t>(object.name.size());
        out.i32(object.node);
        out.i32(object.primitive);
        out.i32(object.instance);
        out.u32(object.flags);
        out.u32(object.triangle_count);
        out.u32(name_end);
        for (const Vec3f& corner : {object.bounds.min, object.bounds.max})
            for (int axis = 0; axis < 3; ++axis)
                out.f32(corner[axis]);
    }
    return out;
}

} // namespace

Result<std::vector<std::byte>> encode_pvs(const PvsData& data, PvsCoding coding) {
    if (Status status = check(data); !status)
        return status;
    ByteWriter names, cells, tree;
    for (const PvsObject& object : data.objects)
        names.text(object.name);
    RowTable table(data);
    for (std::uint32_t row : data.cell_row)
        cells.u32(row >= kCellSolid ? row : table.use(row));
    if (!data.tree.nodes.empty())
        tree = encode_tree(data.tree, table);
    if (!fits_u32(names.bytes.size()))
        return Status(ErrorCode::limit, "encode_pvs: more than 4 GiB of names; shorten them");
    Result<CodedRows> coded = encode_rows(data, table, coding);
    if (!coded)
        return coded.status();
    ByteWriter meta = encode_meta(data, coding, table.count()), objects = encode_objects(data),
               volumes = encode_volumes(data.volumes), clusters;
    for (std::uint32_t first : data.cluster_first)
        clusters.u32(first);
    std::vector<Section> sections{
        {kMetaChunk, kRequired, meta.bytes},
        {kOptionsChunk, kRequired, std::as_bytes(std::span(data.options_json.data(), data.options_json.size()))},
        {kObjectsChunk, kRequired, objects.bytes},
        {kNamesChunk, kRequired, names.bytes},
        {kCellsChunk, kRequired, cells.bytes},
    };
    if (!data.tree.nodes.empty())
        sections.push_back({kTreeChunk, kRequired, tree.bytes});
    if (data.volumes.cells() > 0)
        sections.push_back({kVolumesChunk, kRequired, volumes.bytes});
    if (!data.cluster_first.empty())
        sections.push_back({kClustersChunk, kRequired, clusters.bytes});
    std::vector<std::byte> triangles = encode_triangles(data);
    if (!data.triangles.empty())
        sections.push_back({kTrianglesChunk, kRequired, triangles});
    sections.push_back({kRowIndexChunk, kRequired, coded->index});
    sections.push_back({kRowsChunk, kRequired, coded->rows});
    return write_chunks(sections);
}

} // namespace antumbra
