// Occluders out of arbitrary meshes, without hints from their author.
#pragma once

#include <antumbra/job.hpp>
#include <antumbra/occluders.hpp>
#include <antumbra/scene.hpp>

namespace antumbra {

struct OccluderOptions {
    /// Merge coplanar neighbours into larger convex polygons.
    bool merge = true;
    /// Boxes inside closed meshes: in objects of at least `inner_box_triangles` triangles per face that the box would have,
    /// and in the union of several closed objects, such as a row of houses.
    bool inner_boxes = true;
    /// Boxes at an angle to the axes and convex solids where they hide a fifth more than those boxes.
    bool inner_solids = true;
    std::uint32_t most_solids = 4096;    ///< closed objects that are looked into, the largest
    std::uint32_t boxes_per_solid = 4;
    std::uint32_t most_joined_boxes = 1024;
    std::uint32_t inner_box_triangles = 24;
    /// Simplified shells inside closed objects of at least `inner_shell_least` triangles, of about
    /// `inner_shell_triangles` each. Made by meshoptimizer: the same bytes on one machine, but not on every one.
    bool inner_shells = false;
    std::uint32_t inner_shell_least = 512;
    std::uint32_t inner_shell_triangles = 128;
    std::uint32_t inner_box_resolution = 12; ///< cells along the longest side of an object
    std::uint32_t most_corners = 24;         ///< of one polygon
    std::uint32_t patch_polygons = 8;        ///< owned by one patch
};

struct OccluderStatistics {
    std::uint64_t triangles = 0;        ///< of objects that occlude
    std::uint64_t polygons = 0;         ///< after merging, inner solids apart
    std::uint64_t inner_boxes = 0;      ///< joined ones included
    std::uint64_t inner_shells = 0, inner_shell_triangles = 0; ///< certified
    std::uint64_t inner_shell_dropped = 0;                     ///< triangles that could not be certified
    std::uint64_t joined_boxes = 0;     ///< inside of several objects together
    std::uint64_t inner_solids = 0;     ///< convex solids, oriented boxes included
    std::uint64_t oriented_boxes = 0;   ///< at an angle to the axes
    std::uint64_t restricted_solids = 0; ///< boxes and solids of shells with an opening: see OccluderSolid::viewers
    std::uint64_t enclosures = 0;       ///< closed objects, and groups that are closed together, or but for one side
    std::uint64_t closed_objects = 0;   ///< whose every edge has one triangle on either side
    std::uint64_t patches = 0;
    double largest_area = 0;
};

/// Every triangle of every object with kOccludes is in exactly one polygon; a polygon covers nothing that its
/// triangles did not: they are merged only where they lie in one plane exactly (integer arithmetic on the snapped
/// grid), share a whole edge, show the same side, and are convex together. Inner solids lie inside of closed meshes, by
/// exact tests (docs/methods/occluders.md). A pure function of (scene, options); inner shells depend on the machine's
/// meshoptimizer, too.
OccluderSet find_occluders(const Scene& scene, const OccluderOptions& options = {},
                           OccluderStatistics* statistics = nullptr);

} // namespace antumbra
