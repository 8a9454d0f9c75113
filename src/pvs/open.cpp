// Opening: proves once that every range of every chunk lies inside the file, so that queries can trust them. The
// proof does not rely on checksums: a file made to deceive, with right checksums, is refused or answered safely.
#include "pvs/cluster_triangles.hpp"
#include "pvs/coding_archive.hpp"
#include "pvs/coding_references.hpp"
#include "pvs/coding_tree.hpp"
#include "pvs/format.hpp"
#include "pvs/grid.hpp"
#include "pvs/row_coding.hpp"

namespace antumbra {
namespace {

Status corrupt(ChunkId chunk, const std::string& what) {
    return {ErrorCode::corrupt, "chunk " + to_string(chunk) + ": " + what + "; the file is damaged, bake it again"};
}

std::string_view as_text(std::span<const std::byte> bytes) {
    return {reinterpret_cast<const char*>(bytes.data()), bytes.size()};
}

Vec3d load_vec3d(std::span<const std::byte> bytes, std::size_t at) {
    return {load_f64(bytes, at), load_f64(bytes, at + 8), load_f64(bytes, at + 16)};
}

Status check_known(std::span<const Section> sections) {
    for (const Section& section : sections)
        if ((section.flags & kRequired) && !is_chunk_of_bake(section.id))
            return {ErrorCode::unsupported, "chunk " + to_string(section.id) +
                                                ": this program does not know it, and it may not be skipped; use a "
                                                "later version of Antumbra"};
    return {};
}

Result<std::span<const std::byte>> find_section(std::span<const Section> sections, ChunkId id) {
    for (const Section& section : sections)
        if (section.id == id)
            return section.bytes;
    return corrupt(id, "it is missing");
}

/// The ends of names and of coded rows: `at(i)` never falls and the last is `size`.
template <class At>
bool are_ends(std::uint64_t count, std::uint64_t size, At at) {
    std::uint64_t end = 0;
    for (std::uint64_t i = 0; i < count; ++i) {
        std::uint64_t next = at(i);
        if (next < end || next > size)
            return false;
        end = next;
    }
    return end == size;
}

} // namespace

/// Fills a Pvs from its sections, one at a time; each step relies only on those before it.
class PvsOpener {
  public:
    PvsOpener(std::span<const Section> sections, Pvs& pvs) : sections_(sections), pvs_(pvs) {}

    Status run() {
        if (Status status = check_known(sections_); !status)
            return status;
        for (Status (PvsOpener::*step)() : {&PvsOpener::meta, &PvsOpener::options, &PvsOpener::objects,
                                            &PvsOpener::cells, &PvsOpener::tree, &PvsOpener::volumes,
                                            &PvsOpener::clusters, &PvsOpener::rows})
            if (Status status = (this->*step)(); !status)
                return status;
        for (const Section& section : sections_)
            if (!is_chunk_of_bake(section.id))
                pvs_.others_.push_back({std::uint32_t(section.id), section.bytes});
        return {};
    }

  private:
    Status get(ChunkId id, std::span<const std::byte>& bytes) {
        Result<std::span<const std::byte>> found = find_section(sections_, id);
        if (found)
            bytes = *found;
        return found.status();
    }

    bool has(ChunkId id) const { return find_section(sections_, id).ok(); }

    Status meta() {
        std::span<const std::byte> bytes;
        if (Status status = get(kMetaChunk, bytes); !status)
            return status;
        if (bytes.size() < kMetaBytes)
            return corrupt(kMetaChunk, "it is too short");
        std::uint8_t guarantee = std::to_integer<std::uint8_t>(bytes[0]);
        if (guarantee < std::uint8_t(Guarantee::exact) || guarantee > std::uint8_t(Guarantee::approximate))
            return corrupt(kMetaChunk, "the guarantee is none of the four");
        pvs_.coding_ = PvsCoding(load_u32(bytes, 4));
        if (pvs_.coding_ < PvsCoding::cheapest || pvs_.coding_ > PvsCoding::archive)
            return {ErrorCode::unsupported, "chunk 'META': this program does not know row coding " +
                                                std::to_string(load_u32(bytes, 4)) +
                                                "; use a later version of Antumbra"};
        pvs_.guarantee_ = Guarantee(guarantee);
        pvs_.sides_ = std::to_integer<std::uint8_t>(bytes[1]);
        pvs_.object_count_ = load_u32(bytes, 8);
        pvs_.row_count_ = load_u32(bytes, 12);
        pvs_.structure_fingerprint_ = load_u64(bytes, 16);
        for (std::size_t i = 0; i < 16; ++i)
            pvs_.scene_fingerprint_[i] = std::to_integer<std::uint8_t>(bytes[24 + i]);
        pvs_.origin_ = load_vec3d(bytes, 40);
        pvs_.grid_.bounds = {load_vec3d(bytes, 64), load_vec3d(bytes, 88)};
        for (std::size_t axis = 0; axis < 3; ++axis)
            pvs_.grid_.count[axis] = load_u32(bytes, 112 + 4 * axis);
        if (!is_usable(pvs_.grid_, cell_count_) || !is_finite(pvs_.origin_))
            return corrupt(kMetaChunk, "the cell grid is empty, too large or not finite");
        return meta_texts(bytes.subspan(kMetaBytes), load_u32(bytes, 124), load_u32(bytes, 128));
    }

    Status meta_texts(std::span<const std::byte> texts, std::uint64_t method, std::uint64_t tool_version) {
        if (method + tool_version != texts.size())
            return corrupt(kMetaChunk, "the lengths of its texts contradict its size");
        pvs_.method_ = as_text(texts.first(std::size_t(method)));
        pvs_.tool_version_ = as_text(texts.subspan(std::size_t(method)));
        return {};
    }

    Status options() {
        std::span<const std::byte> bytes;
        Status status = get(kOptionsChunk, bytes);
        pvs_.options_json_ = as_text(bytes);
        return status;
    }

    Status objects() {
        if (Status status = get(kObjectsChunk, pvs_.objects_); !status)
            return status;
        if (Status status = get(kNamesChunk, pvs_.names_); !status)
            return status;
        std::uint64_t count = pvs_.object_count_;
        if (pvs_.objects_.size() != count * kObjectBytes)
            return corrupt(kObjectsChunk, "its size contradicts the number of objects");
        auto name_end = [&](std::uint64_t i) { return load_u32(pvs_.objects_, std::size_t(i) * kObjectBytes + 20); };
        if (!are_ends(count, pvs_.names_.size(), name_end))
            return corrupt(kObjectsChunk, "the ends of the names are out of order");
        pvs_.always_visible_.assign(words_for(std::size_t(count)), 0);
        for (std::size_t o = 0; o < count; ++o)
            if (load_u32(pvs_.objects_, o * kObjectBytes + 12) & kAlwaysVisibleFlag)
                pvs_.always_visible_[o / 64] |= std::uint64_t(1) << (o % 64);
        return {};
    }

    Status cells() {
        if (Status status = get(kCellsChunk, pvs_.cells_); !status)
            return status;
        if (pvs_.cells_.size() % kCellBytes != 0 || pvs_.cells_.size() / kCellBytes != cell_count_)
            return corrupt(kCellsChunk, "its size contradicts the cell grid");
        for (std::uint64_t c = 0; c < cell_count_; ++c)
            if (std::uint32_t row = pvs_.cell_row(c); row >= pvs_.row_count_ && row < kCellSolid)
                return corrupt(kCellsChunk, "cell " + std::to_string(c) + " refers to a row that does not exist");
        return {};
    }

    Status tree() {
        if (!has(kTreeChunk))
            return {};
        std::span<const std::byte> bytes;
        (void)get(kTreeChunk, bytes);
        if (cell_count_ > 0 || bytes.size() < kTreeHeaderBytes)
            return corrupt(kTreeChunk, cell_count_ > 0 ? "there is a cell grid, too" : "it is too short");
        pvs_.tree_.bounds = {load_vec3d(bytes, 0), load_vec3d(bytes, 24)};
        if (!read_nodes(bytes.subspan(kTreeHeaderBytes), load_u32(bytes, 48)))
            return corrupt(kTreeChunk, "the number of its nodes contradicts its size");
        if (Status status = pvs_.tree_.check(pvs_.row_count_); !status)
            return corrupt(kTreeChunk, status.message());
        return {};
    }

    /// A node takes a byte at least, so that memory stays in proportion to the file.
    bool read_nodes(std::span<const std::byte> bytes, std::uint32_t count) {
        if (count == 0 || count > bytes.size())
            return false;
        pvs_.tree_.nodes.reserve(count);
        std::uint32_t next_row = 0;
        while (!bytes.empty()) {
            auto kind = std::to_integer<std::uint8_t>(bytes[0]);
            std::size_t size = kind < ViewNode::kLeaf ? 3 : kind == kLeafOfNextRow ? 1 : 5;
            if (kind > kLeafOfGivenRow || size > bytes.size() || pvs_.tree_.nodes.size() == count)
                return false;
            if (kind < ViewNode::kLeaf)
                pvs_.tree_.nodes.push_back({kind, load_u16(bytes, 1), 0});
            else
                pvs_.tree_.nodes.push_back(
                    {ViewNode::kLeaf, 0, kind == kLeafOfNextRow ? next_row++ : load_u32(bytes, 1)});
            bytes = bytes.subspan(size);
        }
        return pvs_.tree_.nodes.size() == count && link_nodes();
    }

    /// Preorder needs no links in the file: the child above a split follows the last node of the child below it.
    bool link_nodes() {
        std::vector<std::uint32_t> open; // inner nodes whose child above is still to come
        std::vector<ViewNode>& nodes = pvs_.tree_.nodes;
        for (std::uint32_t n = 0; n < nodes.size(); ++n) {
            if (nodes[n].axis != ViewNode::kLeaf) {
                open.push_back(n);
                continue;
            }
            if (n + 1 == nodes.size())
                return open.empty();
            if (open.empty())
                return false;
            nodes[open.back()].link = n + 1;
            open.pop_back();
        }
        return false;
    }

    Status volumes() {
        if (!has(kVolumesChunk))
            return {};
        std::span<const std::byte> bytes;
        (void)get(kVolumesChunk, bytes);
        if (bytes.size() != kVolumesBytes)
            return corrupt(kVolumesChunk, "its size is wrong");
        pvs_.volumes_.bounds = {load_vec3d(bytes, 0), load_vec3d(bytes, 24)};
        for (std::size_t axis = 0; axis < 3; ++axis)
            pvs_.volumes_.count[axis] = load_u32(bytes, 48 + 4 * axis);
        std::uint64_t count = 0;
        if (!is_usable(pvs_.volumes_, count) || count > kMostVolumes)
            return corrupt(kVolumesChunk, "the grid is empty, too large or not finite");
        return {};
    }

    Status clusters() {
        if (!has(kClustersChunk))
            return {};
        (void)get(kClustersChunk, pvs_.clusters_);
#ifdef ANTUMBRA_WITHOUT_CLUSTERS // who only asks for objects needs to know how many bits a row has
        std::size_t size = pvs_.clusters_.size();
        if (size % 4 != 0 || size < 8)
            return corrupt(kClustersChunk, "its size is wrong");
        pvs_.cluster_count_ = static_cast<std::uint32_t>(size / 4 - 1);
#else
        bool tells = has(kTrianglesChunk);
        if (tells)
            (void)get(kTrianglesChunk, pvs_.triangles_);
        ClusterIndex index;
        if (const char* problem = index_clusters(pvs_.clusters_, tells ? &pvs_.triangles_ : nullptr, pvs_.objects_, index))
            return corrupt(kClustersChunk, problem);
        pvs_.cluster_index_ = std::move(index.first);
        pvs_.triangle_index_ = std::move(index.triangles);
        pvs_.cluster_count_ = pvs_.cluster_index_.back();
#endif
        return {};
    }

    Status rows() {
        if (Status status = get(kRowIndexChunk, pvs_.row_index_); !status)
            return status;
        if (Status status = get(kRowsChunk, pvs_.row_bytes_); !status)
            return status;
        pvs_.visibility_bytes_ = pvs_.row_index_.size() + pvs_.row_bytes_.size();
        if (pvs_.coding_ == PvsCoding::cheapest)
            return cheapest_rows();
        if (pvs_.coding_ == PvsCoding::references)
            return reference_rows();
        return unpack_rows();
    }

    Status reference_rows() {
        Status status =
            ReferenceRows::open(pvs_.row_index_, pvs_.row_bytes_, pvs_.row_count_, pvs_.bits_per_row()).status();
        return status.ok() ? Status() : corrupt(kRowsChunk, status.message());
    }

    Status cheapest_rows() {
        std::uint64_t count = pvs_.row_count_;
        if (pvs_.row_index_.size() != count * kRowIndexBytes)
            return corrupt(kRowIndexChunk, "its size contradicts the number of rows");
        auto row_end = [&](std::uint64_t r) { return load_u32(pvs_.row_index_, std::size_t(r) * kRowIndexBytes); };
        if (!are_ends(count, pvs_.row_bytes_.size(), row_end))
            return corrupt(kRowIndexChunk, "the ends of the rows are out of order");
        for (std::uint32_t r = 0; r < count; ++r)
            if (!is_row(pvs_.coded_row(r), pvs_.bits_per_row()))
                return corrupt(kRowsChunk, "row " + std::to_string(r) + " cannot be decoded");
        return {};
    }

    Status unpack_rows() {
        if (!pvs_.row_index_.empty())
            return corrupt(kRowIndexChunk, "the row coding has no index");
        if (!may_unpack(pvs_.row_count_, pvs_.bits_per_row(), pvs_.row_bytes_.size()))
            return {ErrorCode::limit, "chunk 'ROWS': it would unpack to more than its size allows; the file was not "
                                      "written by Antumbra"};
        Result<std::vector<std::uint64_t>> bits =
            pvs_.coding_ == PvsCoding::archive
                ? decode_archive(pvs_.row_bytes_, pvs_.row_count_, pvs_.bits_per_row())
                : decode_by_tree();
        if (!bits)
            return corrupt(kRowsChunk, bits.status().message());
        repack(*bits);
        return {};
    }

    Result<std::vector<std::uint64_t>> decode_by_tree() {
        std::vector<std::uint32_t> cell_row(std::size_t(cell_count_), kCellNotBaked);
        for (std::size_t c = 0; c < cell_row.size(); ++c)
            cell_row[c] = pvs_.cell_row(c);
        CodingTree tree = cell_row.empty() ? coding_tree_of(pvs_.tree_) : coding_tree_of(pvs_.grid_, cell_row);
        std::size_t words = pvs_.words_per_row(), rows = (tree.nodes.size() + 1) / 2;
        std::vector<std::uint64_t> bits(pvs_.row_count_ * words);
        auto keep = [&](std::uint32_t row, std::span<const std::uint64_t> set) {
            std::copy(set.begin(), set.end(), bits.begin() + std::ptrdiff_t(row * words));
        };
        if (rows != pvs_.row_count_ || !decode_tree_rows(tree, TreeCoding(std::uint32_t(pvs_.coding_) - 1),
                                                         pvs_.row_bytes_, pvs_.bits_per_row(), keep))
            return Status(ErrorCode::corrupt, "it does not hold the rows that the cells refer to");
        return bits;
    }

    /// Keeps the rows in a coding that has random access and takes little memory.
    void repack(std::span<const std::uint64_t> bits) {
        ByteWriter index, rows;
        std::size_t words = pvs_.words_per_row();
        for (std::size_t r = 0; r < pvs_.row_count_; ++r) {
            encode_row(bits.subspan(r * words, words), pvs_.bits_per_row(), rows);
            index.u32(static_cast<std::uint32_t>(rows.bytes.size()));
        }
        auto unpacked = std::make_shared<std::array<std::vector<std::byte>, 2>>();
        (*unpacked)[0] = std::move(index.bytes);
        (*unpacked)[1] = std::move(rows.bytes);
        pvs_.row_index_ = (*unpacked)[0];
        pvs_.row_bytes_ = (*unpacked)[1];
        pvs_.unpacked_ = std::move(unpacked);
    }

    std::span<const Section> sections_;
    Pvs& pvs_;
    std::uint64_t cell_count_ = 0;
};

Result<Pvs> Pvs::open(std::span<const std::byte> bytes) {
    Result<std::vector<Section>> sections = read_chunks(bytes);
    if (!sections)
        return sections.status();
    Pvs pvs;
    pvs.bytes_ = bytes;
    if (Status status = PvsOpener(*sections, pvs).run(); !status)
        return status;
    return pvs;
}

} // namespace antumbra
