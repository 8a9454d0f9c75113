// Certificates stored beside a bake: a witness for every listed pair of cell and object (of files that list clusters: cell
// and cluster), a subdivision of line space with
// its blockers for every other. Byte layout: docs/methods/exact.md.
#pragma once

#include "bake/exact/proof.hpp"

#include <string>

namespace antumbra {

/// What a file of certificates holds, or what its check found.
struct CertificateFileResult {
    std::uint64_t cells = 0, pairs = 0, visible = 0, by_definition = 0, hidden = 0, undecided = 0;
    std::uint64_t trees = 0, nodes = 0, bytes = 0;
    std::uint64_t rejected = 0;  ///< certificates that the verifier refuses
    std::uint64_t disagree = 0;  ///< pairs whose certificate says otherwise than the .pvs
    std::string first_problem;   ///< in words, "" if there is none
};

/// Proves every pair of every baked cell, of a grid or a tree over space (but what is always visible), and gives the file. `pvs_bytes`:
/// the .pvs file itself, to which it is bound by length and CRC. Statuses as check_certificates. Cost: as the bake without
/// its sampling, patches and virtual occluders. The bytes do not depend on the threads.
Result<std::vector<std::byte>> make_certificates(const Scene& scene, const Pvs& pvs, std::span<const std::byte> pvs_bytes,
                                                 CertificateFileResult& result, const Job& job = {});

/// Checks a file without the solver: every certificate goes to the verifier of certify/, and for hidden pairs every
/// triangle of the object must be covered by the boxes and triangles that are proved hidden, from all faces of the cell
/// that look towards it. ErrorCode::corrupt for a damaged file, mismatch if it belongs to another .pvs.
Result<CertificateFileResult> check_certificate_file(const Scene& scene, const Pvs& pvs,
                                                     std::span<const std::byte> pvs_bytes,
                                                     std::span<const std::byte> bytes, const Job& job = {});

} // namespace antumbra
