// Minimum occluder sets (Poon, Wang 1999, section 4): which occluders, taken together, hide most for least, found in
// preprocessing for the points of a grid and the six directions along the axes.
//
// A minimum occluder set (MOS) of an occludee is a set of occluder polygons that covers every pixel of the occludee's
// rectangle, and none of which can be left out.
#pragma once

#include <antumbra/job.hpp>
#include <antumbra/math.hpp>
#include <antumbra/occluder_database.hpp>
#include <antumbra/occluders.hpp>
#include <antumbra/scene.hpp>

#include <array>
#include <string>

namespace antumbra {

/// How the sets that are drawn are chosen among all that were found.
enum class MosSelection : std::uint8_t {
    published, ///< by their score, highest first
    /// By what a set hides and costs beyond those taken before: fewer occluders for the same share. When everything is
    /// hidden that can be, everything is hidden once more by other sets, and so on.
    marginal,
};

/// The criterion that fills a database. The others are what the paper compares with.
enum class OccluderCriterion : std::uint8_t {
    minimum_sets,   ///< MOS
    first_hit,      ///< most visible pixels first
    projected_size, ///< most covered pixels first, visible or not
};

struct MosOptions {
    OccluderCriterion criterion = OccluderCriterion::minimum_sets;
    MosSelection selection = MosSelection::marginal;
    std::uint32_t limit = 256;     ///< polygons in a list at most; what no set needs is filled up by first hit
    int resolution = 128;          ///< pixels along the side of a picture, 8..1024

    std::uint32_t least_primitives = 20;  ///< occludees must have more triangles than that
    std::uint32_t most_primitives = 256;  ///< small objects are taken together up to so many
    std::uint32_t least_pixels = 4;       ///< occluders that cover fewer are left out
    std::uint32_t layers = 48;            ///< of a pixel's stack, nearest first; deeper ones are left out

    std::uint32_t sets_per_occludee = 4;  ///< the cheapest are kept
    std::uint32_t work_per_occludee = 60000; ///< steps of the search; then what was found so far counts

    /// What a set is worth: occludees hidden, and triangles in them.
    double occludee_weight = 0, primitive_weight = 1;
    /// What it costs: polygons, and pixels covered by them (of the whole picture: 1).
    double polygon_weight = 1, size_weight = 1;

    /// Grid points, and the box (world) that they are spread over; empty: the scene's bounds.
    std::array<std::uint32_t, 3> grid{8, 1, 8};
    Box3d region;
    /// Where to keep finished points ("" = nowhere), and whether to take up what is there.
    std::string checkpoint;
    bool resume = false;
};

struct MosStatistics {
    std::uint64_t pictures = 0;            ///< grid points times directions
    std::uint64_t occludees = 0;           ///< in view, over all pictures
    std::uint64_t uncovered = 0;           ///< of these: seen, some pixel has nothing in front
    std::uint64_t sets = 0;                ///< found, verified and kept
    std::uint64_t searches_cut = 0;        ///< the bound on work ended the search: sets may not be the cheapest
    std::uint64_t points_resumed = 0;
    double seconds = 0, cpu_seconds = 0;
};

/// A pure function of (scene, occluders, options), for any job.threads, interrupted and resumed or not. `occluders` are
/// those of the CullScene that will use the database. ErrorCode::usage for options that make no sense; cancelled and io
/// as bake().
Result<OccluderDatabase> build_occluder_database(const Scene& scene, const OccluderSet& occluders,
                                                 const MosOptions& options = {}, const Job& job = {},
                                                 MosStatistics* statistics = nullptr);

} // namespace antumbra
