// The exact method as a bake knows it: rays first, then CellSolver for what they did not find.
#pragma once

#include "bake/exact/cell.hpp"
#include "bake/sampled/sample_payload.hpp"

namespace antumbra {

struct ExactCell {
    RegionSample sample; ///< `visible` holds every visible object and no other, but for the undecided
    ExactStatistics work;
    bool finished = true; ///< false: it was cancelled
};

/// Immutable and thread-safe; refers to the sampling scene.
class ExactCells {
  public:
    explicit ExactCells(const SamplingScene& shared);

    /// ErrorCode::usage for a cell whose corners lie 2^24 or more grid steps from the scene's origin.
    Status check(const Box3d& cell) const;
    /// A pure function of scene, options and cell (world, on the scene's grid). A cell without a viewpoint is solid.
    /// The answer speaks of every point of the closed cell, be it in free space or not.
    /// `hidden`: what hide(), or solve() by `proved`, gave for a box around the cell. It changes the cost and the
    /// counts; not the rows, but for undecided pairs. `proved`: if given, becomes what no line from
    /// the cell reaches, `hidden` among them.
    ExactCell solve(const Box3d& cell, const std::atomic<bool>* cancel = nullptr, const exact::HiddenParts& hidden = {},
                    exact::HiddenParts* proved = nullptr) const;
    /// What no line from a box around several cells reaches, `hidden` among them:
    /// hidden from the box, hidden from all cells inside. Adds to `work`. False: cancelled.
    bool hide(const Box3d& box, const exact::HiddenParts& hidden, exact::HiddenParts& proved, ExactStatistics& work,
              const std::atomic<bool>* cancel = nullptr) const;
    /// Words of a row: bits of objects, then of clusters.
    std::size_t words() const { return (bits() + 63) / 64; }
    /// PvsData::cluster_first: empty if objects are what is listed.
    std::vector<std::uint32_t> cluster_first() const;
    /// PvsData::triangles: empty likewise.
    std::vector<PvsTriangles> triangles() const;

    const Scene& scene() const { return shared_.scene(); }
    const BakeOptions& options() const { return shared_.options(); }

  private:
    exact::CellOptions cell_options(const Box3d& cell) const;
    exact::GridBox to_grid(const Box3d& cell) const;
    void check_with_rays(const Box3d& cell, std::uint64_t key, RegionSample& sample) const;
    bool lists_clusters() const { return shared_.options().exact.granularity != Granularity::object; }
    std::size_t bits() const;
    void set_rows(const std::vector<std::uint64_t>& units, RegionSample& sample) const;
    const SamplingScene& shared_;
    exact::SceneTree tree_;
};

/// Sums, and the greatest of what is called most_.
void add(ExactStatistics& total, const ExactStatistics& more);

void put(PayloadWriter& writer, const ExactStatistics& work);
ExactStatistics get_exact_statistics(PayloadReader& reader);
void put(PayloadWriter& writer, const ExactCell& cell);
ExactCell get_exact_cell(PayloadReader& reader, std::size_t words);

} // namespace antumbra
