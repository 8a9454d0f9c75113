// Two files about one scene: what each sees that the other does not, where, how much of the picture that is, and whether
// their guarantees allow it.
#pragma once

#include <antumbra/job.hpp>
#include <antumbra/pvs.hpp>
#include <antumbra/scene.hpp>

namespace antumbra {

struct CompareOptions {
    std::uint32_t viewpoints = 64; ///< for the weight in pixels; 0: none
    std::uint32_t face_size = 32;  ///< pixels along each of the six square pictures around a viewpoint
    std::uint32_t listed = 10;     ///< of objects in only_a and only_b
    std::uint64_t seed = 1;
};

/// One file's side of it. A pair is (a piece of space, a unit that is not always visible): see CompareResult::units.
struct ComparedFile {
    std::uint64_t cells = 0;   ///< baked, in the file; of a view tree: pieces of space with the same leaves
    std::uint64_t pairs = 0;   ///< that it lists
    std::uint64_t pairs_only = 0; ///< that the other does not
    double mean_objects = 0, mean_only = 0; ///< the same per viewpoint: pairs weighted by the volume of their piece
    std::uint64_t objects = 0, objects_only = 0; ///< units listed somewhere; listed nowhere by the other
    std::uint64_t pixels_only = 0; ///< pixels that see units which only this file lists there
    std::uint64_t clusters = 0;    ///< that the file knows; 0: it lists objects alone
    double mean_triangles = 0;     ///< triangles of what it lists, as finely as it does, per viewpoint
};

struct ComparedObject {
    std::uint32_t object = 0;
    std::uint32_t unit = 0; ///< its own number, or that of the object
    std::uint64_t pairs = 0;  ///< that only one file lists
    double volume = 0;        ///< of these, as a share of the common space
    std::uint64_t pixels = 0; ///< of these
};

/// What guarantees forbid: an object that one file proves visible and the other, complete one calls hidden.
struct Contradiction {
    std::uint32_t object = 0, unit = 0;
    std::uint64_t cell_a = 0, cell_b = 0;
    bool a_sees = false; ///< else b
    Box3d piece;         ///< where both cells meet (world)
};

/// What is compared.
enum class CompareUnits : std::uint8_t {
    objects,  ///< at least one file lists nothing finer, or the files are of scenes with different crack widths
    clusters, ///< both list the same clusters (or triangles)
    groups,   ///< both list clusters, but different ones: those that share triangles are one unit together
};

struct CompareResult {
    ComparedFile a, b;
    CompareUnits units = CompareUnits::objects;
    std::uint64_t unit_count = 0;
    std::uint64_t pieces = 0;  ///< of space that a cell of both covers, with a volume
    bool same_cells = false;   ///< both are the same grid
    double common_of_a = 0, common_of_b = 0; ///< share of the baked space of each that the other covers
    std::uint64_t pairs_both = 0;
    std::uint64_t viewpoints = 0, pixels = 0, pixels_neither = 0; ///< the last: they see what neither file lists
    std::vector<ComparedObject> only_a, only_b; ///< most pixels first, then most volume, then lowest id
    /// Of the pieces where the cell of the one that only lists what is visible lies within the cell of the one that lists
    /// all that is: only there one set must hold the other.
    std::uint64_t pieces_bound = 0, contradictions = 0;
    std::vector<Contradiction> first; ///< at most ten
    std::vector<std::string> words;   ///< what the guarantees imply here, a sentence each
};

/// Only cells that both files have baked count; different grids are cut into pieces, each answered by the one cell of
/// either file that holds it. Leaves of a view tree are united over all directions. A unit counts as listed by a file that lists
/// some cluster within it: so files of any granularity can be compared, at the finest that both tell. One of the files may
/// be of the same scene with another crack width. ErrorCode::mismatch if a file belongs to another scene, usage if they have
/// no space in common. A pure function of its arguments.
Result<CompareResult> compare(const Scene& scene, const Pvs& a, const Pvs& b, const CompareOptions& options = {},
                              const Job& job = {});

} // namespace antumbra
