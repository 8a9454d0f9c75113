#include "bake/exact/certificate_parts.hpp"

#include "base/collect.hpp"
#include "base/crc32c.hpp"

namespace antumbra {
namespace {

using namespace certificates;

void put_proof(ByteWriter& out, const exact::SceneTree& tree, const GridBox& cell, const exact::PairProof& proof) {
    auto face_number = [&](const Polygon& from) {
        for (int face = 0; face < 6; ++face)
            if (cell_face(cell, face).corners == from.corners)
                return face;
        return 6;
    };
    if (proof.answer == exact::Answer::undecided) {
        out.u8(std::uint8_t(Kind::undecided));
    } else if (proof.answer == exact::Answer::visible && proof.by_definition) {
        out.u8(std::uint8_t(Kind::touches));
        put_number(out, proof.triangle);
    } else if (proof.answer == exact::Answer::visible) {
        out.u8(std::uint8_t(Kind::visible));
        put_number(out, proof.triangle);
        out.u8(std::uint8_t(face_number(proof.from)));
        out.u8(proof.to.corners != triangle_polygon(tree, proof.triangle, false).corners);
        put_rational_point(out, proof.witness.p);
        put_rational_point(out, proof.witness.q);
    } else {
        out.u8(std::uint8_t(Kind::hidden));
        put_number(out, proof.boxes.size());
        for (const GridBox& box : proof.boxes) {
            put_point(out, box.min);
            put_point(out, box.max);
        }
        put_number(out, proof.parts.size());
        for (const exact::HiddenPart& part : proof.parts) {
            out.u8(std::uint8_t(face_number(part.from)));
            out.u8(std::uint8_t(part.part.corners.size()));
            for (const GridPoint& corner : part.part.corners)
                put_point(out, corner);
            put_number(out, part.blockers.size());
            for (std::uint32_t blocker : part.blockers)
                put_number(out, blocker);
            put_tree(out, part.tree);
        }
    }
}

/// Header of the file: magic, version, reserved, scene fingerprint, length and CRC of the .pvs, CRC of what stands before,
/// number of blocks.
void put_header(ByteWriter& out, const Scene& scene, std::span<const std::byte> pvs_bytes, std::uint64_t blocks) {
    for (char c : kMagic)
        out.u8(std::uint8_t(c));
    out.u32(kVersion);
    out.u32(0);
    for (std::uint8_t byte : scene.fingerprint())
        out.u8(byte);
    out.u64(pvs_bytes.size());
    out.u32(crc32c(pvs_bytes));
    out.u32(std::uint32_t(blocks));
    out.u32(0);
    out.u32(crc32c(std::span<const std::byte>(out.bytes)));
}

void count(const exact::PairProof& proof, CertificateFileResult& counted) {
    ++counted.pairs;
    counted.undecided += proof.answer == exact::Answer::undecided;
    counted.hidden += proof.answer == exact::Answer::hidden;
    counted.visible += proof.answer == exact::Answer::visible && !proof.by_definition;
    counted.by_definition += proof.by_definition;
    for (const exact::HiddenPart& part : proof.parts) {
        ++counted.trees;
        counted.nodes += part.tree.nodes.size();
    }
}

} // namespace

Result<std::vector<std::byte>> make_certificates(const Scene& scene, const Pvs& pvs, std::span<const std::byte> pvs_bytes,
                                                 CertificateFileResult& result, const Job& job) {
    if (Status status = check_belongs(scene, pvs); !status)
        return status;
    Result<std::vector<exact::BakedCell>> found = exact::baked_cells(pvs);
    if (!found)
        return found.status();
    const std::vector<exact::BakedCell>& cells = *found;
    Result<exact::Units> units = exact::units_of(scene, pvs);
    if (!units)
        return units.status();
    exact::SceneTree tree = exact::SceneTree::build(scene, std::move(*units));
    std::vector<std::vector<std::byte>> blocks(cells.size());
    struct Part {
        ByteWriter out;
        CertificateFileResult counted;
    };
    auto prove = [&](std::size_t index, unsigned) {
        GridBox cell = grid_cell(tree, cells[index]);
        exact::ProofLimits limits;
        limits.cancelled = [&] { return job.cancelled(); };
        exact::Prover prover(tree, limits);
        Part part;
        for (std::uint32_t unit = 0; unit < tree.units().count(); ++unit) {
            if (exact::is_always_visible(scene, pvs, tree.units(), unit))
                continue;
            exact::PairProof proof = prover.prove(cell, unit);
            put_proof(part.out, tree, cell, proof);
            count(proof, part.counted);
        }
        return part;
    };
    auto take = [&](std::size_t index, Part part) {
        blocks[index] = std::move(part.out.bytes);
        add(result, part.counted);
    };
    if (Status status = collect(cells.size(), job, "prove", "cells", prove, take); !status)
        return status;
    ByteWriter file;
    put_header(file, scene, pvs_bytes, cells.size());
    for (std::size_t index = 0; index < cells.size(); ++index) {
        file.u64(cells[index].number);
        file.u64(blocks[index].size());
        file.u32(crc32c(std::span<const std::byte>(blocks[index])));
        file.u32(crc32c(std::span<const std::byte>(file.bytes).last(kBlockHeader - 4)));
        file.bytes.insert(file.bytes.end(), blocks[index].begin(), blocks[index].end());
    }
    result.cells = cells.size();
    result.bytes = file.bytes.size();
    return std::move(file.bytes);
}

} // namespace antumbra
