#include "bake/exact/cell_checker.hpp"

#include "base/collect.hpp"
#include "base/crc32c.hpp"

#include <cstring>

namespace antumbra {


namespace {

using namespace certificates;

Status damaged() {
    return {ErrorCode::corrupt, "is damaged or no file of certificates; write it again with bake --certificates"};
}

Status check_header(const Scene& scene, std::span<const std::byte> pvs_bytes, std::span<const std::byte> bytes) {
    if (bytes.size() < kHeader || std::memcmp(bytes.data(), kMagic, 8) != 0 ||
        crc32c(bytes.first(kHeader - 4)) != load_u32(bytes, kHeader - 4))
        return damaged();
    if (load_u32(bytes, 8) != kVersion)
        return {ErrorCode::unsupported, "is of another version of the certificate format"};
    if (std::memcmp(bytes.data() + 16, scene.fingerprint().data(), 16) != 0 || load_u64(bytes, 32) != pvs_bytes.size() ||
        load_u32(bytes, 40) != crc32c(pvs_bytes))
        return {ErrorCode::mismatch, "belongs to another .pvs file; write it again with bake --certificates"};
    return {};
}

using Blocks = std::vector<std::span<const std::byte>>;

/// The certificates of each cell.
Status cut_blocks(std::span<const std::byte> bytes, const std::vector<exact::BakedCell>& cells, Blocks& blocks) {
    if (load_u32(bytes, 44) != std::uint32_t(cells.size()))
        return damaged();
    std::size_t at = kHeader;
    for (const exact::BakedCell& cell : cells) {
        if (bytes.size() - at < kBlockHeader || crc32c(bytes.subspan(at, 20)) != load_u32(bytes, at + 20) ||
            load_u64(bytes, at) != cell.number || load_u64(bytes, at + 8) > bytes.size() - at - kBlockHeader)
            return damaged();
        auto size = std::size_t(load_u64(bytes, at + 8));
        blocks.push_back(bytes.subspan(at + kBlockHeader, size));
        if (crc32c(blocks.back()) != load_u32(bytes, at + 16))
            return damaged();
        at += kBlockHeader + size;
    }
    return at == bytes.size() ? Status() : damaged();
}

struct Judgement {
    CertificateFileResult counted;
    std::string problem; ///< the first
    bool broken = false; ///< the bytes make no sense
};

/// Are objects listed iff one of their clusters is proved visible?
void judge_objects(const Pvs& pvs, const std::vector<std::uint64_t>& row, const std::vector<bool>& seen, const std::string& cell,
                   Judgement& judgement) {
    for (std::uint32_t o = 0; o < pvs.object_count(); ++o)
        if (!(pvs.object(o).flags & kAlwaysVisible) && (row[o / 64] >> (o % 64) & 1) != seen[o]) {
            ++judgement.counted.disagree;
            if (judgement.problem.empty())
                judgement.problem = cell + "object " + std::to_string(o) + ": listed otherwise than its clusters";
        }
}

Judgement judge_cell(const exact::SceneTree& tree, const Pvs& pvs, const exact::BakedCell& cell,
                     std::span<const std::byte> block, const Job& job) {
    CellChecker checker(tree, grid_cell(tree, cell));
    Reader in(block);
    Judgement judgement;
    std::string where = "cell " + std::to_string(cell.number) + ", ";
    std::vector<std::uint64_t> row(pvs.words_per_row());
    pvs.decode_row(cell.row, row);
    std::vector<bool> seen(pvs.object_count(), false); // by what the certificates say of clusters
    for (std::uint32_t unit = 0; unit < tree.units().count() && in.ok() && !job.cancelled(); ++unit) {
        if (exact::is_always_visible(tree.scene(), pvs, tree.units(), unit))
            continue;
        std::string problem;
        Kind kind = checker.check(in, unit, judgement.counted, problem);
        ++judgement.counted.pairs;
        std::size_t bit = exact::bit_of(pvs, unit);
        bool listed = row[bit / 64] >> (bit % 64) & 1, says = kind != Kind::hidden;
        if (pvs.cluster_count() > 0 && says)
            seen[tree.scene().triangle_objects()[tree.units().triangles_of(unit)[0]]] = true;
        if (listed != says) {
            ++judgement.counted.disagree;
            problem = listed ? "listed, but its certificate says hidden" : "not listed, but its certificate says visible";
        }
        if (!problem.empty() && judgement.problem.empty())
            judgement.problem = where + exact::name_of_unit(pvs, unit) + ": " + problem;
    }
    if (pvs.cluster_count() > 0)
        judge_objects(pvs, row, seen, where, judgement);
    judgement.broken = !in.at_end();
    return judgement;
}

} // namespace

Result<CertificateFileResult> check_certificate_file(const Scene& scene, const Pvs& pvs,
                                                     std::span<const std::byte> pvs_bytes,
                                                     std::span<const std::byte> bytes, const Job& job) {
    if (Status status = certificates::check_belongs(scene, pvs); !status)
        return status;
    if (Status status = check_header(scene, pvs_bytes, bytes); !status)
        return status;
    Result<std::vector<exact::BakedCell>> cells = exact::baked_cells(pvs);
    if (!cells)
        return cells.status();
    Blocks blocks;
    if (Status status = cut_blocks(bytes, *cells, blocks); !status)
        return status;
    Result<exact::Units> units = exact::units_of(scene, pvs);
    if (!units)
        return units.status();
    exact::SceneTree tree = exact::SceneTree::build(scene, std::move(*units));
    CertificateFileResult result;
    std::vector<std::string> problems(cells->size());
    bool broken = false;
    auto judge = [&](std::size_t index, unsigned) { return judge_cell(tree, pvs, (*cells)[index], blocks[index], job); };
    auto take = [&](std::size_t index, Judgement judgement) {
        add(result, judgement.counted);
        problems[index] = std::move(judgement.problem);
        broken |= judgement.broken;
    };
    if (Status status = collect(cells->size(), job, "certify", "cells", judge, take); !status)
        return status;
    if (broken)
        return damaged();
    result.cells = cells->size();
    result.bytes = bytes.size();
    result.first_problem = first_problem(problems);
    return result;
}

} // namespace antumbra
